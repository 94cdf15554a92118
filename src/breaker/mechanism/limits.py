"""Limits on the state of the drive: in words, exceeded or not, and how probably.

A limit has parts, each a quantity above or below a value; it is exceeded where all of them hold.
The probability that it is comes from draws of the full posterior. Beside it stands the product
over its quantities of the probability of each, which is what marginals alone would say.

Shapes: ``d`` draws.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from breaker.mechanism.parameters import MOTIONS
from breaker.mechanism.quantities import QUANTITIES, check_quantity

__all__ = [
    "Exceedance",
    "Limit",
    "complaint",
    "complaint_of_list",
    "from_list",
]

_SIDES = {"upper": "above", "lower": "below"}


class Exceedance(NamedTuple):
    """Probabilities that a limit is exceeded, ``(...)``.

    Attributes:
        joint: Share of the draws in which all parts hold.
        marginal: Product over the quantities of the share of draws in which the parts of each hold.
        undefined: Share of the draws in which a quantity of the limit does not exist; they
            count as beyond it.
    """

    joint: np.ndarray
    marginal: np.ndarray
    undefined: np.ndarray


@dataclass(frozen=True)
class Limit:
    """A named condition on the state of the drive.

    Attributes:
        name: Its name in the configuration.
        motion: Motion whose quantities it is about.
        parts: (quantity, value, whether it holds above the value rather than below), at least one.
    """

    name: str
    motion: str
    parts: tuple[tuple[str, float, bool], ...]

    @classmethod
    def from_settings(cls, name: str, settings: Mapping[str, Any]) -> "Limit":
        """Build a limit from an entry of the section ``limits`` of the configuration.

        Raises:
            ValueError: If the entry cannot be used.
        """
        if wrong := complaint({name: settings}, MOTIONS):
            raise ValueError(f"limits {wrong}")
        parts = ((quantity, float(value), upper) for quantity, value, upper in _parts(settings))
        return cls(name, settings["motion"], tuple(parts))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the parts, in their order."""
        return tuple(quantity for quantity, _, _ in self.parts)

    @property
    def words(self) -> str:
        """The condition in words, such as "touch_time above 10 ms"."""
        return " and ".join(
            f"{quantity} {_SIDES['upper' if is_upper else 'lower']} {_with_unit(quantity, value)}"
            for quantity, value, is_upper in self.parts
        )

    def excess(self, values: ArrayLike) -> np.ndarray:
        """Return how far values are beyond the limit, ``(..., parts) -> (..., parts)``.

        In the units of the quantities: positive where a part holds, nan where a value is nan.
        """
        values = np.asarray(values, dtype=np.float64)
        if values.shape[-1:] != (len(self.parts),):
            raise ValueError(f"{self.name} needs values (..., {len(self.parts)}): {self.words}")
        bounds = np.array([value for _, value, _ in self.parts])
        signs = np.array([1.0 if is_upper else -1.0 for _, _, is_upper in self.parts])
        return signs * (values - bounds)

    def exceeded(self, values: ArrayLike) -> np.ndarray:
        """Say where all parts hold, ``(..., parts) -> (...)``.

        A quantity that does not exist, nan, is beyond any limit: the contact does not touch.
        """
        return np.all(~(self.excess(values) <= 0), axis=-1)

    def exceedance(self, values: ArrayLike) -> Exceedance:
        """Return how probably the limit is exceeded, ``(..., d, parts) -> (...)``.

        Args:
            values: The quantities of the limit in draws of a posterior, nan where they do not
                exist, which is beyond any limit.

        Raises:
            ValueError: If there is no draw, or a shape does not fit.
        """
        excess = self.excess(values)
        if excess.ndim < 2 or excess.shape[-2] == 0:
            raise ValueError(f"{self.name}: a probability needs draws")
        holds = ~(excess <= 0)
        undefined = np.isnan(excess).any(axis=-1).mean(axis=-1)
        names = np.array(self.quantities)
        shares = [
            holds[..., names == name].all(axis=-1).mean(axis=-1)
            for name in dict.fromkeys(self.quantities)
        ]
        return Exceedance(holds.all(axis=-1).mean(axis=-1), np.prod(shares, axis=0), undefined)


# ---- configuration ---------------------------------------------------------------------------


def from_list(entries: Sequence[Mapping[str, Any]], motions: Sequence[str]) -> list[Limit]:
    """Return the limits of the section ``limits`` that are of these motions, in its order."""
    return [
        Limit.from_settings(entry["name"], {key: entry[key] for key in entry if key != "name"})
        for entry in entries
        if entry["motion"] in motions
    ]


def complaint_of_list(entries: Sequence[Any], motions: Sequence[str]) -> str | None:
    """Say what is wrong with the section ``limits``, a list of named limits; None if nothing.

    There may be limits of motions that are not worked on, but not only such.
    """
    names = [entry.get("name") if isinstance(entry, Mapping) else None for entry in entries]
    for name in names:
        if not isinstance(name, str) or not name:
            return "has an entry without a name. Each needs a name, motion, and upper or lower."
        if names.count(name) > 1:
            return f"has two entries with the name {name}. Name one of them otherwise."
    limits = {
        entry["name"]: {key: entry[key] for key in entry if key != "name"} for entry in entries
    }
    if wrong := complaint(limits, MOTIONS):
        return wrong
    if any(entry["motion"] in motions for entry in entries):
        return None
    return f"has no limit of {' or '.join(motions)} (motions). Add one."


def complaint(limits: Mapping[str, Any], motions: Sequence[str]) -> str | None:
    """Say what is wrong with limits by name, and the remedy; None if nothing.

    Args:
        limits: ``{name: {"motion": ..., "upper": {quantity: value}, "lower": ...}}``.
        motions: Motions that are worked on.
    """
    wrong = [f"{name}: {text}" for name, entry in limits.items() for text in _wrong(entry, motions)]
    return f"cannot be used. {' '.join(wrong)}" if wrong else None


def _parts(settings: Mapping[str, Any]) -> list[tuple[str, float, bool]]:
    return [
        (quantity, value, side == "upper")
        for side in _SIDES
        for quantity, value in (settings.get(side) or {}).items()
    ]


def _wrong(settings: Any, motions: Sequence[str]) -> list[str]:
    """List what is wrong with one limit; what comes later presumes what came before."""
    shape = "it must be a section with motion, and upper or lower with quantities."
    if not isinstance(settings, Mapping):
        return [shape]
    if not all(isinstance(settings.get(side) or {}, Mapping) for side in _SIDES):
        return [shape]
    if unknown := [str(key) for key in settings if key not in ("motion", *_SIDES)]:
        return [f"{', '.join(unknown)} is not known. Known here: motion, {', '.join(_SIDES)}."]
    motion = settings.get("motion")
    if motion not in motions:
        return [f"motion is {motion}, but must be one of motions ({', '.join(motions)})."]
    parts = _parts(settings)
    if not parts:
        return ["it has no quantity. Name one under upper or lower, with a value."]
    found = [text for name, _, _ in parts if (text := check_quantity(name, motion))]
    numbers = [(name, value) for name, value, _ in parts if not _is_number(value)]
    found += [f"{name} is {value}, but must be a finite number." for name, value in numbers]
    return list(dict.fromkeys(found)) or _contradictions(settings)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _contradictions(settings: Mapping[str, Any]) -> list[str]:
    above, below = (settings.get(side) or {} for side in _SIDES)
    return [
        f"{name} cannot be above {_with_unit(name, above[name])} and below "
        f"{_with_unit(name, below[name])} at once. Make two limits, or swap the values."
        for name in above
        if name in below and above[name] >= below[name]
    ]


def _with_unit(quantity: str, value: float) -> str:
    unit = QUANTITIES[quantity].unit
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"
