"""Rows of a family's bank for training: what networks see and infer, and of levels all of it."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import xarray as xr

from breaker.family.family_bank import shapes
from breaker.family.family_records import record_shapes
from breaker.family.level_network import EVENTS, Levels, level_outputs, outputs_there
from breaker.family.mechanisms import MECHANISMS, mechanism_outputs
from breaker.family.network_inputs import Basis, level_inputs, units_of
from breaker.family.normalised_shape import SHAPE_TIMES
from breaker.family.rich_drive import CONTACTS, ELEMENTS
from breaker.model.parameters import FORCE, GAP, MOTIONS, NAMES

MOST = 8000
"""Drives that components are of."""

CLEAN = (1e-6, 1.1e-6)
"""Noise as good as none, share of the stroke."""

_COMPONENTS = 64
_TOLD = 0.6  # share of the drives whose size is given
_STROKE = 10.0  # mm, to which the fall of the force refers
_WAY = 0.4  # of the stroke, made in a duration
_LEAST = 1e-6  # scale of a mechanism that no drive has


@dataclass
class BankRows:
    """Drives of a bank, and records of them made anew for each batch.

    Attributes:
        bank: Drives: see ``family_bank.simulate_family``.
        frozen: What inputs and outputs are scaled by, as ``Levels`` and ``Changes`` have it: set
            by ``freeze``, or that of the training.
    """

    kind: ClassVar[str]
    """"levels" or "changes"."""
    atoms: ClassVar[tuple[bool, ...]]
    """Which outputs may be exactly 0."""
    names: ClassVar[tuple[str, ...]]
    """Of the outputs."""

    bank: xr.Dataset
    frozen: dict = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.curves = self.bank["shape"].values  # (drive, condition, motion, u), as stored
        self.theta = self.bank.parameters.values
        self.stroke = self.bank.stroke.values
        self.duration = self.bank.duration.values
        self.elements = self.bank.elements.values
        self.events = np.stack([self.bank.release.values, self.bank.switching.values], axis=-1)

    def __len__(self) -> int:
        return len(self.theta)

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of inputs and outputs."""
        x, y, _ = self.rows(np.arange(1), np.random.default_rng(1))
        return x.shape[1], y.shape[1]

    def rows(self, drives: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
        """Return inputs ``(n, i)``, outputs ``(n, q)`` and which are there, of drives ``(n,)``."""
        x, y, there, _ = self.unscaled(drives, rng)
        return x, (y - self.frozen["centre"]) / self.frozen["scale"], there

    def physical(self, outputs: np.ndarray) -> np.ndarray:
        """Return outputs ``(..., q)`` with parameters in their units, or changes in percent."""
        found = outputs.copy()
        found[..., : len(NAMES)] = np.exp(found[..., : len(NAMES)])
        return found

    def _motions(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Which motions there are, ``(n, 2)`` of bool: closing, opening or both."""
        return np.array([[True, False], [False, True], [True, True]])[rng.integers(0, 3, n)]

    def _bases(self, drives: np.ndarray, rng: np.random.Generator) -> dict[str, Basis]:
        """Components of the shapes of drives."""
        found = {}
        for m, motion in enumerate(MOTIONS):
            seen, *_ = record_shapes(self._curves(drives, 0, m), rng, noise=CLEAN)
            whole = seen.way[seen.present.mean(axis=1) > 0.9]
            found[motion] = Basis.of(whole, _COMPONENTS)
        return found

    def _usual(self) -> np.ndarray:
        sizes = [np.log(self.stroke[:, 0]), np.log(self.duration[:, 0])]
        return np.array([[each.mean(), each.std()] for each in sizes])

    def _mechanisms(
        self, drives: np.ndarray, condition: np.ndarray, elements: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Sizes of mechanisms of drives in a condition, with the elements of that or another."""
        return _mechanism_sizes(
            self.theta[drives, condition],
            self.elements[drives, elements],
            self.bank.contact.values[drives],
            self.stroke[drives, condition],
            self.duration[drives, condition, MOTIONS.index("closing")],
        )

    def _curves(self, drives: np.ndarray, condition: np.ndarray | int, motion: int) -> np.ndarray:
        return shapes(self.curves[drives, condition, motion])


class LevelRows(BankRows):
    """Records of one operation, and the state of the drive."""

    kind, names, atoms = "levels", (*NAMES, *EVENTS, *MECHANISMS), Levels.atoms

    def freeze(self, rng: np.random.Generator) -> None:
        """Set the scales."""
        drives = rng.permutation(len(self))[:MOST]
        self.frozen = {"bases": self._bases(drives, rng), "usual": self._usual()}
        _, y, there, _ = self.unscaled(drives, rng)
        y = np.where(there, y, np.nan)
        centre, scale = np.nanmean(y, axis=0), np.nanstd(y, axis=0)
        first = len(NAMES) + len(EVENTS)
        centre[first:] = 0.0  # which is where a mechanism is that is not there
        scale[first:] = np.sqrt(np.nanmean(np.square(y[:, first:]), axis=0)) + _LEAST
        self.frozen |= {"centre": centre, "scale": scale}

    def unscaled(
        self,
        drives: np.ndarray,
        rng: np.random.Generator,
        *,
        condition: np.ndarray | None = None,
        motions: np.ndarray | None = None,
        told: np.ndarray | None = None,
        **sensor,
    ) -> tuple[np.ndarray, ...]:
        """Return inputs, outputs before their scales, and which are there, of drives ``(n,)``.

        The last of four is what makes of each output the logarithm of a parameter in its unit.

        Args:
            condition: New 0 or worn 1, ``(n,)``; drawn if None, as are the ``motions`` that there
                are, ``(n, 2)``, and whether the size is ``told``, ``(n,)``.
            sensor: As for ``record_shapes``.
        """
        n = len(drives)
        condition = rng.integers(0, 2, n) if condition is None else condition
        motions = self._motions(n, rng) if motions is None else motions
        told = rng.random(n) < _TOLD if told is None else told
        records, events = self._records(drives, condition, motions, rng, **sensor)
        x = level_inputs(records, told, self.frozen["bases"], self.frozen["usual"])
        theta = self.theta[drives, condition]
        stroke, duration = units_of(records)
        sizes = self._mechanisms(drives, condition, condition)
        sizes = mechanism_outputs(sizes, duration)
        y = np.hstack([level_outputs(theta, events, stroke, duration), sizes])
        units = np.zeros_like(y)
        units[:, : len(NAMES)] = np.log(theta) - y[:, : len(NAMES)]
        motions = np.column_stack([each.there for each in records.values()])
        return x, y, outputs_there(motions) & motions.any(axis=1)[:, None], units

    def _records(self, drives, condition, motions, rng, **sensor):
        """Records in mm and ms by motion, and all events as they show them, ``(n, 4)``."""
        records, events = {}, []
        for m, motion in enumerate(MOTIONS):
            curves = self._curves(drives, condition, m)
            wanted = motions[:, m]
            seen, origin, duration = record_shapes(curves, rng, wanted=wanted, **sensor)
            unit = self.duration[drives, condition, m]
            stroke = self.stroke[drives, condition]
            records[motion] = seen._replace(stroke=seen.stroke * stroke, duration=duration * unit)
            found = self.events[drives, condition, m]
            events.append((found - origin[:, None]) / duration[:, None])
        events = np.hstack(events)
        return records, np.where(np.isfinite(events), events, SHAPE_TIMES[-1])


def _mechanism_sizes(
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
