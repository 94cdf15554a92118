"""What drives of the family have beside the model, as networks tell it: by one size each.

A size is a share of the closing force, which needs no unit: of forces that go with the speed, at
the mean speed of a closing from 10 to 50 % of its way. Networks tell ``arsinh`` of it, which is
about the size where it is small and its logarithm where it is large; what is absent is exactly 0.
"""

from collections.abc import Iterable, Mapping

import numpy as np

EFFECTS = {
    "contact_preload": "preload of the contact spring, share of the closing force",
    "sliding_contact": "way to the touch of a contact that slides, share of the stroke",
    "build_up": "time in which the closing force builds up or is gone",
    "dry_friction": "dry friction, share of the closing force",
    "opening_preload": "preload of the opening spring, share of the closing force",
    "force_fall": "share of the closing force that is gone at the end of the way",
    "drag": "drag at the mean speed of a closing, share of the closing force",
    "train_mass": "mass that moves along in closing alone, share of the drive's",
    "closing_damper": "damper at the closed end at that speed, share of the closing force",
    "opening_damper": "damper at the open end at that speed, share of the closing force",
}
"""What the size of each mechanism is; that of ``build_up`` is in ms."""

CHANGE_OF = "the closing force (build_up: of the duration)"
"""What changes of mechanisms are shares of."""

WEARING = tuple(name for name in EFFECTS if name not in ("sliding_contact", "train_mass"))
"""Mechanisms that wear, whose change networks of changes tell."""


def effect_outputs(sizes: Mapping[str, np.ndarray], duration: np.ndarray) -> np.ndarray:
    """Return what networks infer of sizes of mechanisms or their changes, ``(n,)`` each, before
    their scale, ``(n, m)``; ``duration`` is that of the first motion that is there, ms,
    ``(n,)``.
    """
    units = {"build_up": duration}
    return np.arcsinh(np.column_stack([each / units.get(n, 1.0) for n, each in sizes.items()]))


def effect_draws(
    outputs: np.ndarray, names: Iterable[str], duration: float
) -> dict[str, np.ndarray]:
    """Return sizes of mechanisms, or their changes, by name, of draws ``(d, m)`` of outputs."""
    units = {"build_up": duration}
    return {n: units.get(n, 1.0) * np.sinh(each) for n, each in zip(names, outputs.T, strict=True)}
