"""How large the mechanisms of simulated drives are, as networks of a family tell it."""

import numpy as np

from breaker.drive.family.mechanisms import MECHANISMS
from breaker.drive.simulation.rich_drive import CONTACTS, ELEMENTS
from breaker.quantities.parameters import FORCE, GAP, NAMES

_STROKE = 10.0  # mm, to which the fall of the force refers
_WAY = 0.4  # of the stroke, made in a duration


def mechanism_sizes(
    theta: np.ndarray,
    elements: np.ndarray,
    contact: np.ndarray,
    stroke: np.ndarray,
    duration: np.ndarray,
) -> dict[str, np.ndarray]:
    """Return the size of each of ``MECHANISMS``, ``(n,)``.

    Args:
        theta: Parameters, ``(n, p)``.
        elements: In the order of ``rich_drive.ELEMENTS``, ``(n, e)``.
        contact: Number of the kind of contact in ``rich_drive.CONTACTS``, ``(n,)``.
        stroke, duration: Of closings, ``(n,)``, mm and ms.
    """
    has = dict(zip(ELEMENTS, elements.T, strict=True)) | dict(zip(NAMES, theta.T, strict=True))
    slides, force = contact == CONTACTS.index("sliding"), has[FORCE.name]
    speed = _WAY * stroke / duration

    def damper(stop: str) -> np.ndarray:
        return has[f"{stop}.damping"] * speed ** has[f"{stop}.power"] / force

    sizes = {
        "contact_preload": np.where(slides, 0.0, has["contact_preload"] / force),
        "sliding_contact": np.where(slides, has[GAP.name] / stroke, 0.0),
        "build_up": has["build_up"],
        "dry_friction": has["dry_friction"] / force,
        "opening_preload": has["opening_preload"] / force,
        "force_fall": has["force_fall"] * stroke / _STROKE,
        "drag": has["drag"] * speed ** has["drag_power"] / force,
        "train_mass": has["train_mass"],
        "closing_damper": damper("closing_stop"),
        "opening_damper": damper("opening_stop"),
    }
    return {name: sizes[name] for name in MECHANISMS}
