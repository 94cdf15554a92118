"""Limits on the state of the drive: in words, exceeded or not, and how probably.

A limit has parts, each a quantity above or below a value; it is exceeded where all of them hold.
An entry of a reference and a tolerance is two limits, one on either side.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from breaker.common.lazy_numpy import np
from breaker.common.numerals import in_digits
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.quantities import SPEEDS, Speed, check_quantity, quantities

if TYPE_CHECKING:
    from breaker.model.limits import Limit
if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_DIGITS = 6  # of a bound in words


class Reader(Protocol):
    """What tells quantities of limits, by their source."""

    def of_model(self, limit: Limit, *about: Any) -> Any:
        """Tell quantities of the model at inferred parameters."""

    def of_record(self, limit: Limit, *about: Any) -> Any:
        """Tell quantities that records show."""

    def of_change(self, limit: Limit, *about: Any) -> Any:
        """Tell changes of parameters, in percent."""


@dataclass(frozen=True)
class Source:
    """Where quantities of limits are read.

    Attributes:
        name: Its name in the configuration.
        word: Word in front of a quantity of a limit; ``title`` that in a table of limits.
        inferred: Whether networks infer its quantities, which err alike all along a life.
        single: Whether a single record has them; if not, they are changes in percent.
        least: Value below which none of them is.
    """

    name: str
    word: str = ""
    title: str = ""
    inferred: bool = True
    single: bool = True
    least: float = -math.inf

    def complaint(self, quantity: str, motion: str, speeds: Sequence[Speed]) -> str | None:
        """Return why a motion has no such quantity, with a remedy; None if it has it."""
        if self.single:
            return check_quantity(quantity, motion, speeds, self.name)
        if quantity in NAMES:
            return None
        return f"{quantity} has no change: parameters alone have, {', '.join(NAMES)}."

    def units(self, names: Sequence[str], speeds: Sequence[Speed]) -> tuple[str, ...]:
        """Return the units of quantities."""
        if not self.single:
            return ("%",) * len(names)
        every = quantities(speeds)
        return tuple(every[name].unit for name in names)

    def digits(self, value: float) -> str:
        """Return a bound in words."""
        return in_digits(value, _DIGITS, sign=not self.single)

    def amount(self, limit: str, value: float | str) -> float:
        """Return a bound as it is written in a limit of a name.

        Raises:
            ValueError: If it is in percent of what is no change.
        """
        text = str(value)
        if self.single and text.endswith("%"):
            raise ValueError(
                f"{limit}: {text} is of no change. Write the value in its unit, or reference and "
                "tolerance."
            )
        return float(text.removesuffix("%"))

    def tolerance(self, text: str, middle: float) -> float:
        """Return how far a tolerance goes to either side of a reference."""
        share = abs(middle) / 100.0 if self.single and text.endswith("%") else 1.0
        return share * float(text.removesuffix("%"))


# No record shows a way or a time below 0.
RECORD = Source("record", "measured ", inferred=False, least=0.0)
"""The source of what instruments print."""

_CHANGE = Source("change", "change of ", "change of ", single=False)
SOURCES = {each.name: each for each in (Source("model"), RECORD, _CHANGE)}
"""The sources by their names."""


# ---- limits ----


_LEAST = 1e-12  # least error of a measured value, in its unit
_BAND = ("quantity", "reference", "tolerance")


@dataclass(frozen=True)
class Limit:
    """A named condition on the state of the drive.

    Attributes:
        name: Its name in the configuration.
        motion: Motion whose quantities it is about.
        parts: (quantity, value, whether it holds above the value rather than below), at least one.
        speeds: How speeds are defined.
        of: Name of its ``source``, what its quantities are read from: "model", inferred parameters,
            "record", the record itself, or "change", changes of parameters in percent.
        since: What changes are from: "new", or the last known "event".
        pair: Name of the entry of which another limit is the other side; empty if there is none.
        reference: The value that its bound is a tolerance away from; None if there is none.

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
    since: str = "new"
    pair: str = ""
    reference: float | None = None

    def __post_init__(self) -> None:
        names, source = dict.fromkeys(self.quantities), _source(self.name, self.of)
        if not self.motion and source.single:
            wrong = ["it has no motion. Set it to closing or opening."]
        else:
            about = ((name, self.motion, self.speeds) for name in names)
            wrong = [text for each in about if (text := source.complaint(*each))]
        bounds = {(name, is_upper): value for name, value, is_upper in self.parts}
        for name in names:
            above, below = bounds.get((name, True), -math.inf), bounds.get((name, False), math.inf)
            if above >= below:
                wrong.append(
                    f"{name} cannot be above {above:g} and below {below:g} at once. "
                    "Make two limits, or swap the values."
                )
        if not names:
            wrong.append("it has no quantity. Name one under upper or lower, with a value.")
        if self.since != "new" and source.single:
            wrong.append(f"since: {self.since} is of changes. Take of: change, or leave it out.")
        if wrong:
            raise ValueError(f"{self.name}: {' '.join(wrong)}")

    @classmethod
    def from_settings(cls, entry: Mapping[str, Any], speeds: tuple[Speed, ...] = SPEEDS) -> Limit:
        """Build a limit from an entry of upper and lower of the list ``limits``.

        Raises:
            ValueError: If its name, quantities or bounds are missing or wrong.
        """
        if "name" not in entry:
            raise ValueError("a limit has no name. Give it one.")
        name, of = entry["name"], entry.get("of", "model")
        source = _source(name, of)
        parts = tuple(
            (quantity, source.amount(name, value), side == "upper")
            for side in ("upper", "lower")
            for quantity, value in entry.get(side, {}).items()
        )
        about = of, entry.get("since", "new"), entry.get("pair", ""), entry.get("reference")
        return cls(name, entry.get("motion", ""), parts, speeds, *about)

    @property
    def source(self) -> Source:
        """What its quantities are read from."""
        return SOURCES[self.of]

    def read(self, reader: Reader, *about: Any) -> Any:
        """Return what a reader of quantities tells of the limit, by the source of these."""
        return getattr(reader, f"of_{self.of}")(self, *about)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the parts, in their order."""
        return tuple(quantity for quantity, _, _ in self.parts)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of ``quantities``."""
        return self.source.units(self.quantities, self.speeds)

    def evaluate(self, theta: np.ndarray) -> np.ndarray:
        """Return the quantities of the parts of parameter sets, ``(n, p) -> (n, parts)``.

        Raises:
            ValueError: If the limit is about measured quantities, which parameters do not give.
        """
        if self.of != "model":
            raise ValueError(f"{self.name} is about what records show, not about parameters")
        from breaker.model.evaluation import evaluate  # compiled code

        return evaluate(self.quantities, theta, self.motion, self.speeds)

    @property
    def words(self) -> str:
        """The condition in words: "touch_time above 10 ms", "measured stroke below 9 mm"."""
        words = " and ".join(
            f"{self.source.word}{name} {'above' if is_upper else 'below'} "
            + self.source.digits(value)
            + (f" {unit}" if unit != "1" else "")
            for (name, value, is_upper), unit in zip(self.parts, self.units, strict=True)
        )
        return f"{words} since the last event" if self.since == "event" else words

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

    def measured_exceedance(self, values: ArrayLike, sds: ArrayLike) -> np.ndarray:
        """Return how probably measured values are beyond the limit, ``(..., parts) -> (...)``.

        Args:
            values: Measured quantities of the parts; the result is nan where one is.
            sds: Standard deviations of their errors, which are normal and independent.
        """
        from scipy.special import ndtr

        values, sds = (np.asarray(each, dtype=np.float64) for each in (values, sds))
        holds = ndtr(self.excess(values) / np.maximum(sds, _LEAST))
        # Two bounds of one quantity: it is between them, or beyond one of them, never beyond both.
        names = np.array(self.quantities)
        shares = [
            holds[..., names == name].sum(axis=-1) - (np.sum(names == name) - 1)
            for name in dict.fromkeys(self.quantities)
        ]
        return np.prod(shares, axis=0)


def from_list(
    entries: Sequence[Mapping[str, Any]],
    motions: Sequence[str],
    speeds: tuple[Speed, ...] = SPEEDS,
    of: Collection[str] = SOURCES,
) -> list[Limit]:
    """Return the limits of the section ``limits`` that are of these motions and sources, in its
    order.

    Raises:
        ValueError: If an entry cannot be a limit.

    Example:
        >>> entry = {"quantity": "stroke", "motion": "closing", "reference": 178}
        >>> for limit in from_list([entry | {"tolerance": "3 %"}], ["closing"]):
        ...     print(limit.name, limit.words, sep=": ")
        stroke high: measured stroke above 183.34 mm
        stroke low: measured stroke below 172.66 mm
    """
    sides = (side for entry in entries for side in _sides(entry, speeds))
    limits = (
        Limit.from_settings(side, speeds)
        for side in sides
        if side.get("motion") in (*motions, None)
    )
    return [limit for limit in limits if limit.of in of]


def entries_of_type(
    ranges: Mapping[str, Sequence[float | None]], speeds: Sequence[Speed] = SPEEDS
) -> list[dict[str, Any]]:
    """Return the limits of a type of breaker as entries of the section ``limits``.

    Args:
        ranges: From and to of each quantity that records show, None where a side is open, by its
            name, with the motion before it where it is of one alone: "opening stroke".

    Raises:
        ValueError: If a name is of no such quantity, or a range leaves nothing or all.

    Example:
        >>> for limit in from_list(entries_of_type({"closing stroke": [178, 184]}), ["closing"]):
        ...     print(limit.pair, limit.words, sep=": ")
        closing stroke by type: measured stroke above 184 mm
        closing stroke by type: measured stroke below 178 mm
    """
    every, found = quantities(speeds), []
    for key, (low, high) in ranges.items():
        first, _, name = key.rpartition(" ")
        motions = [first] if first else every[name].motions if name in every else MOTIONS[:1]
        if first and first not in MOTIONS:
            raise ValueError(f"{key}: {first} is no motion. Write closing or opening there.")
        if (None not in (low, high) and not low < high) or low is high is None:
            raise ValueError(f"{key}: from {low} to {high} allows nothing or all. Mend an end.")
        for motion in motions:
            if wrong := RECORD.complaint(name, motion, speeds):
                raise ValueError(f"{key}: {wrong}")
            alone = motion in name or not (first or len(motions) > 1)
            pair = f"{name if alone else f'{motion} {name}'} by type"
            about = {"of": RECORD.name, "motion": motion, "pair": pair}
            for side, bound, end in (("upper", high, "high"), ("lower", low, "low")):
                if bound is not None:
                    found.append(about | {"name": f"{pair} {end}", side: {name: bound}})
    return found


def _sides(entry: Mapping[str, Any], speeds: Sequence[Speed]) -> list[Mapping[str, Any]]:
    """An entry of a reference and a tolerance as entries of upper and lower; another as it is."""
    own = [key for key in _BAND if key in entry]
    if not own:
        return [entry]
    name = entry.get("name", entry.get("quantity", "a limit"))
    if len(own) < len(_BAND) or {"upper", "lower"} & entry.keys():
        raise ValueError(
            f"{name}: a limit has all of {', '.join(_BAND)}, or else upper or lower. Add what is "
            "missing, or leave out what is of the other form."
        )
    quantity = entry["quantity"]
    known = quantities(speeds).get(quantity)
    usual = RECORD.name if known and RECORD.name in known.of else "model"
    of = entry.get("of", usual)
    source = _source(name, of)
    middle = source.amount(name, entry["reference"])
    text = str(entry["tolerance"]).lstrip("±+/- ")
    away = source.tolerance(text, middle)
    if not away > 0.0:
        raise ValueError(f"{name}: the tolerance allows nothing. Write one above 0.")
    if text.endswith("%") and away >= abs(middle) > 0.0:
        raise ValueError(
            f"{name}: a tolerance of {entry['tolerance']} allows nearly anything. Write less than "
            "100 %."
        )
    motions = [entry["motion"]] if "motion" in entry else known.motions if known else MOTIONS
    motions = motions if source.single else [""]
    rows = []
    for motion in motions:
        pair = name if len(motions) == 1 else f"{name} {motion}"
        about = {"of": of, "pair": pair, "reference": middle}
        about |= {"motion": motion} if motion else {}
        about |= {"since": entry["since"]} if "since" in entry else {}
        for side, key, end in (("high", "upper", away), ("low", "lower", -away)):
            rows.append(about | {"name": f"{pair} {side}", key: {quantity: middle + end}})
    return rows


def _source(limit: str, of: str) -> Source:
    """The source of a limit, by its name."""
    if of not in SOURCES:
        raise ValueError(f"{limit}: of is {of}. Set it to {' or '.join(SOURCES)}.")
    return SOURCES[of]
