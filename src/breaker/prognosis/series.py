"""Records of a life: shapes in common units, measured quantities, maintenance events, inspections.

A drive is monitored if the median step of the operation number is at most 10 and nothing separates
its operations; then new are the first 50. Else it is inspected: an inspection ends where the number
of the operation or the date makes a jump, and new is the first one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta

import numpy as np
import xarray as xr

from breaker.family.inputs import NormalisedRecords, network_record
from breaker.family.shape import SHAPE_TIMES, median_units, shape_of
from breaker.records.dates import instant
from breaker.records.operations import EVENTS, event_words

_TRANSDUCER = "transducer"
_STEP = {"temperature": 10.0, "voltage": 0.1}  # of a condition: K; share of that of the new ones
_SIMILAR = 0.5  # steps, within which new operations are compared
_FIRST = 50  # operations that are new under monitoring; more inspections than these are monitoring
_COUNTED = 4.0  # inspections, as which the usual scatter counts
_STEPS = 10  # operations from one record to the next, at most, under monitoring
_DAYS = 30.0  # an inspection takes days, and the next one is months later


@dataclass(frozen=True)
class Event:
    """Maintenance before an operation.

    Attributes:
        renews: Whether anything becomes as new.
        transducer: Whether it is the transducer alone.

    Example:
        >>> Event.from_text("Greased, inspected")
        Event(renews=True, transducer=False)
    """

    renews: bool = False
    transducer: bool = False

    @classmethod
    def from_text(cls, text: str, more: Mapping[str, Sequence[str]] | None = None) -> "Event":
        """Build from a cell of the table.

        Args:
            more: Section ``endurance.events`` of the configuration: what starts anew, by event.

        Raises:
            ValueError: If an event has no meaning.
        """
        every = [*EVENTS.items(), *(more or {}).items()]
        known = {word: meaning for key, meaning in every for word in event_words(key)}
        if unknown := [word for word in event_words(text) if word not in known]:
            raise ValueError(f"endurance.events has no {', '.join(unknown)}; add what starts anew")
        affected = {name for word in event_words(text) for name in known[word]}
        return cls(bool(affected), affected == {_TRANSDUCER})

    @classmethod
    def by_operation(
        cls, texts: Mapping[int, str], more: Mapping[str, Sequence[str]]
    ) -> dict[int, "Event"]:
        """Build those of several operations, from cells by their numbers."""
        return {number: cls.from_text(text, more) for number, text in texts.items()}


@dataclass(frozen=True, eq=False)
class MotionRecords:
    """Records of one motion, in the units of its new ones.

    Attributes:
        way, present: Shapes, ``(o, g)``; nothing is present of an operation without a record.
        noise: Of a record, share of the stroke, ``(o,)``; nan without one.
        stroke, duration: Units, mm and ms.
        measured: Quantities that are followed, ``(o,)`` each, by name; nan where one is not shown.
        stated: Standard deviations that are stated with them, likewise.
    """

    way: np.ndarray
    present: np.ndarray
    noise: np.ndarray
    stroke: float
    duration: float
    measured: Mapping[str, np.ndarray]
    stated: Mapping[str, np.ndarray]

    @property
    def there(self) -> np.ndarray:
        """Which operations have a record, ``(o,)`` of bool."""
        return self.present.any(axis=1)

    def seen(self, way: np.ndarray, noise: np.ndarray | float) -> NormalisedRecords:
        """Return shapes in these units as networks see them, ``(n, g)``, and their noise."""
        n = len(way)
        one, there = np.ones(n), np.isfinite(way)
        numbers = (self.stroke * one, self.duration * one, noise * one, 0.0 * one, 0.05 * one)
        return NormalisedRecords(there.any(axis=1), np.where(there, way, 0.0), there, *numbers)


@dataclass(frozen=True, eq=False)
class Series:
    """Records of a life.

    Attributes:
        operations: Their numbers, rising, ``(o,)``.
        motions: Records, by motion.
        new: Which operations are new, indices.
        events: Maintenance before operations, by index.
        conditions: By name of ``CONDITIONS``, ``(o,)``, nan where one is not known.
        inspections: Number of the inspection of each operation, ``(o,)``; None under monitoring.
    """

    operations: np.ndarray
    motions: Mapping[str, MotionRecords]
    new: np.ndarray
    events: Mapping[int, Event]
    conditions: Mapping[str, np.ndarray] = field(default_factory=dict)
    inspections: np.ndarray | None = None

    @property
    def relative(self) -> dict[str, np.ndarray]:
        """Conditions relative to those of the new operations, ``(o,)`` each, in 10 K and in 10 % of
        the voltage; 0 where one is not known.
        """
        found = {}
        for name, values in self.conditions.items():
            known = values[self.new]
            of = known if np.isfinite(known).any() else values
            found[name] = np.nan_to_num(_steps(name, values, float(np.nanmean(of))))
        return found

    @property
    def settle(self) -> int:
        """Operations after the new ones, or after a change, in which no change is noticed."""
        if self.inspections is None:
            return _FIRST
        return int(np.count_nonzero(self.inspections == self.inspections[self.new[-1]]))

    @property
    def counted(self) -> float:
        """Records for which the scatter of the new ones counts: few readings do not show it."""
        return 2.0 * _FIRST if self.inspections is None else _COUNTED

    def gathered(self, values: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the means of each inspection, at its last record, and the usual number of records.

        Args:
            values: ``(o, k)``, rows of nan where there is no record; so are other rows returned.
        """
        if self.inspections is None:
            return values, 1.0
        found, counts = np.full_like(values, np.nan), []
        there = np.isfinite(values).all(axis=1)
        for number in np.unique(self.inspections[there]):
            rows = np.flatnonzero(there & (self.inspections == number))
            found[rows[-1]] = values[rows].mean(axis=0)
            counts.append(rows.size)
        return found, float(np.median(counts)) if counts else 1.0


def series_of(
    data: Mapping[str, xr.Dataset],
    *,
    followed: Mapping[str, Sequence[str]],
    events: Mapping[int, Event],
    conditions: Mapping[str, Mapping[int, float]],
) -> Series:
    """Return the series of measured operations.

    Args:
        data: What ``read_curves`` returns of each motion.
        followed: Names of measured quantities that are followed, by motion.
        events, conditions: By the number of an operation; conditions by name of ``CONDITIONS``.

    Raises:
        ValueError: If no operation that is new has a record.
    """
    operations = np.unique(np.concatenate([each.operation.values for each in data.values()]))
    every = {
        motion: each.reindex(operation=operations, copy=False) for motion, each in data.items()
    }
    usable = {m: each.accepted.values == True for m, each in every.items()}  # noqa: E712, nan is not
    known = {
        name: np.array([values.get(int(o), np.nan) for o in operations])
        for name, values in conditions.items()
    }
    known = {name: values for name, values in known.items() if np.isfinite(values).any()}
    place = {int(o): i for i, o in enumerate(operations)}
    done = {place[o]: each for o, each in events.items() if o in place}
    dates = [each.date.values for each in every.values() if "date" in each]
    inspections = inspections_of(operations, _days(dates[0]) if dates else None, done)
    new = new_of(usable, inspections, done, known)
    motions = {m: _motion(m, every[m], usable[m], new, followed.get(m, ())) for m in every}
    motions = {motion: each for motion, each in motions.items() if each is not None}
    if not motions:
        raise ValueError("no new operation has a usable record. Start with the first inspection")
    return Series(operations, motions, new, done, known, inspections)


def inspections_of(
    operations: np.ndarray,
    days: np.ndarray | None = None,
    events: Mapping[int, Event] | None = None,
) -> np.ndarray | None:
    """Return the number of the inspection of each operation, ``(o,)``; None under monitoring.

    >>> inspections_of(np.array([1, 2, 201, 202, 401])).tolist()
    [0, 0, 1, 1, 2]
    >>> inspections_of(np.arange(5, 2000, 5)) is None
    True

    Args:
        operations: Their numbers, rising, ``(o,)``.
        days: Dates in days, ``(o,)``, nan where one is not known.
        events: Maintenance by index: none is within an inspection.
    """
    steps = np.diff(operations)
    usual = np.median(steps) if steps.size else 1
    begins = steps > _STEPS * (usual if usual <= _STEPS else 1)
    if days is not None:
        known = np.isfinite(days)
        last = np.maximum.accumulate(np.where(known, np.arange(len(days)), 0))
        with np.errstate(invalid="ignore"):
            begins = begins | (np.diff(days[last]) > _DAYS)
    count = 1 + int(begins.sum())
    if (count == 1 and usual <= _STEPS) or count > _FIRST:
        return None
    for i, event in (events or {}).items():
        begins[i - 1] |= i > 0 and event.renews
    return np.append(0, np.cumsum(begins))


def _days(dates: np.ndarray) -> np.ndarray:
    """Days since year 1 of dates, nan where one is not known."""
    known = [bool(isinstance(each, str) and each) for each in dates]
    days = [(instant(each) - datetime.min) / timedelta(days=1) for each in dates[known]]
    found = np.full(len(dates), np.nan)
    found[known] = days
    return found


def new_of(
    usable: Mapping[str, np.ndarray],
    inspections: np.ndarray | None,
    events: Mapping[int, Event] | None = None,
    conditions: Mapping[str, np.ndarray] | None = None,
) -> np.ndarray:
    """Indices of the new operations: all motions, no maintenance between, similar conditions."""
    there = np.flatnonzero(np.logical_and.reduce(list(usable.values())))
    if not there.size:
        there = np.flatnonzero(np.logical_or.reduce(list(usable.values())))
    if inspections is not None:
        return there[inspections[there] == inspections[there[:1]]] if there.size else there
    first = there[:_FIRST]
    renewed = np.sort([i for i, event in (events or {}).items() if event.renews])
    spells = np.searchsorted(renewed, first, side="right")
    if first.size:
        first = first[spells == np.bincount(spells).argmax()]
    for name, values in (conditions or {}).items():
        known = values[first]
        if np.isfinite(known).any():
            near = np.abs(_steps(name, known, float(np.nanmedian(known)))) <= _SIMILAR
            first = first[near]
    return first


def _steps(name: str, values: np.ndarray, usual: float) -> np.ndarray:
    """How far a condition is from the usual one, in its steps."""
    return (values - usual) / (_STEP[name] * (usual if name == "voltage" else 1.0))


def _motion(
    motion: str, data: xr.Dataset, usable: np.ndarray, new: np.ndarray, names: Sequence[str]
) -> MotionRecords | None:
    """Records of a motion in the units of the new ones; None if none of these has a record."""
    n, sign = len(usable), 1.0 if motion == "closing" else -1.0
    records, step = data.record.values, 1.0 / data.rate.values
    way, present = np.zeros((n, SHAPE_TIMES.size)), np.zeros((n, SHAPE_TIMES.size), dtype=bool)
    noise = np.full(n, np.nan)
    rows = zip(data.record_noise.values, data.record_colour.values, step, strict=True)
    own = [each for i in new if usable[i] and (each := shape_of(sign * records[i], step[i]))]
    if not own:
        return None
    units = median_units(own)
    for i, (sd, colour, each) in enumerate(rows):
        if usable[i] and (shape := shape_of(sign * records[i], each, units)) is not None:
            way[i], present[i] = shape.way, shape.present
            noise[i] = network_record(shape, sd, colour, each, units).noise[0]
    measured, stated = (
        {name: data[each].sel(quantity=name).values for name in names}
        for each in ("measured", "measured_sd")
    )
    return MotionRecords(way, present, noise, units.stroke, units.duration, measured, stated)
