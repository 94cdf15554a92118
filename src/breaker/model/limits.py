"""Limits: bounds on quantities, read from the section ``limits`` of the configuration.

Each part of a limit is a quantity above or below a value. A limit is exceeded where all its parts
are true (the thresholds of the paper, Sec. 8). A reference with a tolerance gives two limits.

Quantities of a limit have one source (``SOURCES``): the *model* at inferred parameters, a measured
*record*, or the *change* of parameters since an earlier state, in percent.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import SPEEDS, Speed, check_quantity, quantities

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

SOURCES = {"model": "", "record": "measured ", "change": "change of "}
"""Words before a quantity in texts, by the name of its source in the configuration."""

UNRESOLVED = ("k_b", "gamma_b")
"""Parameters of the contact spring: records hardly resolve their changes along a life."""

_BAND = ("quantity", "reference", "tolerance")


@dataclass(frozen=True)
class Limit:
    """A named condition on the state of the drive.

    Attributes:
        name: Name in the configuration.
        motion: Motion of its quantities; empty for changes.
        parts: (quantity, value, whether above the value rather than below), at least one.
        speeds: Definitions of speeds.
        of: Source of its quantities, one of ``SOURCES``.
        pair: Name of the two-sided entry that this limit is one side of; empty for other limits.

    Example:
        >>> entry = {"name": "slow", "motion": "closing", "upper": {"touch_time": 10}}
        >>> limit = Limit.from_settings(entry)
        >>> limit.words
        'touch_time above 10 ms'
        >>> limit.exceeded([[9.9], [10.1]])
        array([False,  True])
    """

    name: str
    motion: str
    parts: tuple[tuple[str, float, bool], ...]
    speeds: tuple[Speed, ...] = SPEEDS
    of: str = "model"
    pair: str = ""

    def __post_init__(self) -> None:
        if wrong := " ".join(self._complaints()):
            raise ValueError(f"{self.name}: {wrong}")

    def _complaints(self) -> Iterator[str]:
        if self.of not in SOURCES:
            yield f"of is {self.of}. Set it to {' or '.join(SOURCES)}."
        if not self.parts:
            yield "it has no quantity. Name one under upper or lower, with a value."
        for name in dict.fromkeys(self.quantities):
            if complaint := check_quantity(name, self.motion, self.speeds, self.of):
                yield complaint
            if self.quantities.count(name) > 1:
                yield f"{name} has two bounds, but all parts of a limit must hold. Make two limits."

    @classmethod
    def from_settings(cls, entry: Mapping[str, Any], speeds: tuple[Speed, ...] = SPEEDS) -> Limit:
        """Build a limit from an entry of the list ``limits`` with ``upper`` or ``lower``.

        Raises:
            ValueError: If its name, quantities or bounds are missing or wrong.
        """
        if "name" not in entry:
            raise ValueError("a limit has no name. Give it one.")
        parts = tuple(
            (name, _number(name, value, _unit(entry.get("of"), name, speeds)), side == "upper")
            for side in ("upper", "lower")
            for name, value in entry.get(side, {}).items()
        )
        more = {key: entry[key] for key in ("of", "pair") if key in entry}
        return cls(entry["name"], entry.get("motion", ""), parts, speeds, **more)

    def read(self, reader: Any, *about: Any) -> Any:
        """Call the reader's method for the source of the limit, ``of_model``, ``of_record`` or
        ``of_change``, with the limit and the other arguments.
        """
        return getattr(reader, f"of_{self.of}")(self, *about)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the parts, in order of the parts."""
        return tuple(quantity for quantity, _, _ in self.parts)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of ``quantities``."""
        return tuple(_unit(self.of, name, self.speeds) for name in self.quantities)

    def evaluate(self, theta: np.ndarray) -> np.ndarray:
        """Return the quantities of a limit with the source "model", ``(n, p) -> (n, parts)``."""
        from breaker.model.evaluation import evaluate  # compiled code

        return evaluate(self.quantities, theta, self.motion, self.speeds)

    @property
    def words(self) -> str:
        """Condition in words: "touch_time above 10 ms", "measured stroke below 9 mm"."""
        return " and ".join(
            f"{SOURCES[self.of]}{name} {'above' if upper else 'below'} "
            + in_digits(value, 6, sign=self.of == "change")
            + (f" {unit}" if unit != "1" else "")
            for (name, value, upper), unit in zip(self.parts, self.units, strict=True)
        )

    def excess(self, values: ArrayLike) -> np.ndarray:
        """Return how far values exceed the bounds, ``(..., parts) -> (..., parts)``: positive where
        a part is true, nan where a value is nan.
        """
        values = np.asarray(values, dtype=np.float64)
        if values.shape[-1:] != (len(self.parts),):
            raise ValueError(f"{self.name} needs values (..., {len(self.parts)}): {self.words}")
        bounds = np.array([value for _, value, _ in self.parts])
        signs = np.array([1.0 if upper else -1.0 for _, _, upper in self.parts])
        return signs * (values - bounds)

    def exceeded(self, values: ArrayLike) -> np.ndarray:
        """Return where all parts are true, ``(..., parts) -> (...)`` of bool.

        A quantity that does not exist (nan) exceeds any bound, as its contact does not touch.
        """
        return np.all(~(self.excess(values) <= 0), axis=-1)

    def measured_exceedance(self, values: ArrayLike, sds: ArrayLike) -> np.ndarray:
        """Return the probability that the limit is exceeded, ``(..., parts) -> (...)``.

        Args:
            values: Measured quantities of the parts; the result is nan where a value is nan.
            sds: Standard deviations of the errors, which are normal and independent.
        """
        from scipy.special import ndtr

        values, sds = (np.asarray(given, dtype=np.float64) for given in (values, sds))
        # Round-off replaces an error of 0.
        p_parts = ndtr(self.excess(values) / np.maximum(sds, np.finfo(np.float64).eps))
        return np.prod(p_parts, axis=-1)


# ---- the section limits, and limits of a type -------------------------------------------------


def from_list(
    entries: Sequence[Mapping[str, Any]],
    motions: Sequence[str],
    speeds: tuple[Speed, ...] = SPEEDS,
) -> list[Limit]:
    """Return the limits of the section ``limits`` on ``motions`` and on changes, in its order.

    Raises:
        ValueError: If an entry cannot be a limit.

    Example:
        >>> entry = {"quantity": "stroke", "motion": "closing", "reference": 178}
        >>> for limit in from_list([entry | {"tolerance": "3 %"}], ["closing"]):
        ...     print(limit.name, limit.words, sep=": ")
        stroke high: measured stroke above 183.34 mm
        stroke low: measured stroke below 172.66 mm
    """
    limits = []
    for entry in entries:
        sides = _band(entry, speeds) if any(key in entry for key in _BAND) else [entry]
        kept = (side for side in sides if side.get("motion", "") in (*motions, ""))
        limits += [Limit.from_settings(side, speeds) for side in kept]
    return limits


def entries_of_type(
    ranges: Mapping[str, Sequence[float | str | None]], speeds: Sequence[Speed] = SPEEDS
) -> list[dict[str, Any]]:
    """Return the limits of a type of breaker as entries of the section ``limits``.

    Args:
        ranges: Lower and upper end of each measured quantity, as 178 or "178 mm", None for an open
            side; by the quantity's name, after a motion if for that motion only: "opening stroke".

    Raises:
        ValueError: If a name is not a measured quantity, a unit is not the quantity's, or a range
            allows nothing or all.

    Example:
        >>> ranges = {"closing stroke": ["178 mm", 184]}
        >>> for limit in from_list(entries_of_type(ranges), ["closing"]):
        ...     print(limit.pair, limit.words, sep=": ")
        closing stroke by type: measured stroke above 184 mm
        closing stroke by type: measured stroke below 178 mm
    """
    every, entries = quantities(speeds), []
    for key, ends in ranges.items():
        first, _, name = key.rpartition(" ")
        unit = _unit("record", name, speeds)
        low, high = (_number(key, end, unit) for end in ends)
        motions = [first] if first else every[name].motions if name in every else MOTIONS
        if (None not in (low, high) and not low < high) or low is high is None:
            raise ValueError(f"{key}: from {low} to {high} allows nothing or all. Correct an end.")
        for motion in motions:
            if wrong := check_quantity(name, motion, speeds, "record"):
                raise ValueError(f"{key}: {wrong}")
            alone = motion in name or not (first or len(motions) > 1)
            pair = f"{name if alone else f'{motion} {name}'} by type"
            about = {"of": "record", "motion": motion, "pair": pair}
            for side, bound, end in (("upper", high, "high"), ("lower", low, "low")):
                if bound is not None:
                    entries.append(about | {"name": f"{pair} {end}", side: {name: bound}})
    return entries


def _band(entry: Mapping[str, Any], speeds: Sequence[Speed]) -> Iterator[dict[str, Any]]:
    """Yield an entry with a reference and a tolerance as two entries with upper and lower."""
    name = entry.get("name", entry.get("quantity", "a limit"))
    if not all(key in entry for key in _BAND) or {"upper", "lower"} & entry.keys():
        raise ValueError(f"{name}: give all of {', '.join(_BAND)}, or else upper or lower.")
    quantity = entry["quantity"]
    known = quantities(speeds).get(quantity)
    about = {"of": "record" if known and "record" in known.of else "model", **entry}
    unit = _unit(about["of"], quantity, speeds)
    middle, text = _number(name, entry["reference"], unit), str(entry["tolerance"]).lstrip("±+/- ")
    of_middle = text.endswith("%") and about["of"] != "change"
    amount = _number(f"{name}: tolerance", text, "%" if of_middle else unit)
    width = amount * abs(middle) / 100.0 if of_middle else amount
    if not width > 0.0 or (of_middle and amount >= 100.0):
        raise ValueError(f"{name}: tolerance is {text}. Write one above 0 and below 100 %.")
    motions = known.motions if known else MOTIONS
    motions = [entry["motion"]] if "motion" in entry else motions
    for motion in [""] if about["of"] == "change" else motions:
        pair = f"{name} {motion}" if motion and len(motions) > 1 else name
        common = {"of": about["of"], "motion": motion, "pair": pair}
        yield common | {"name": f"{pair} high", "upper": {quantity: middle + width}}
        yield common | {"name": f"{pair} low", "lower": {quantity: middle - width}}


def _unit(of: str | None, name: str, speeds: Sequence[Speed]) -> str | None:
    """Return the unit of a quantity from a source; None if the quantity is not known."""
    known = quantities(speeds).get(name)
    return "%" if of == "change" else known and known.unit


def _number(key: str, value: float | str | None, unit: str | None) -> float | None:
    """Return a value, as 178 or "178 mm", as a number; raise a ValueError if it states a unit other
    than ``unit``.
    """
    if not isinstance(value, str):
        return value
    number = value.rstrip("%").partition(" ")[0]
    stated = value.removeprefix(number).strip()
    if unit is not None and stated not in ("", unit):
        remedy = "A percentage needs of: change" if stated == "%" else "Convert the number"
        raise ValueError(f"{key} is {value}, but its unit is {unit}. {remedy}.")
    return float(number)
