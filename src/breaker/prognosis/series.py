"""Records of a life: shapes in common units, measured quantities, maintenance events, inspections.

A drive is monitored if the median step of the operation number is at most 10 and nothing separates
its operations; then new are the first 50. Else it is inspected: an inspection ends where the number
of the operation or the date makes a jump, and new is the first one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import NamedTuple

import numpy as np
import xarray as xr

from breaker.family.inputs import NormalisedRecords, network_record
from breaker.family.shape import SHAPE_TIMES, median_units, shape_of
from breaker.records.dates import instant
from breaker.records.operations import EVENTS, event_words

_TRANSDUCER = "transducer"
_STEP = {"temperature": 10.0, "voltage": 0.1}  # of a condition: K; share of that of the new ones
_FIRST = 50  # operations that are new under monitoring; more inspections than these are monitoring
_COUNTED = 4.0  # inspections, as which the usual scatter counts
_STEPS = 10  # operations from one record to the next, at most, under monitoring
_DAYS = 30.0  # an inspection takes days, and the next one is months later


class Event(NamedTuple):
    """Maintenance before an operation.

    Attributes:
        renews: Whether anything becomes as new.
        transducer: Whether it is the transducer alone.
    """

    renews: bool = False
    transducer: bool = False


def events_of(
    texts: Mapping[int, str], more: Mapping[str, Sequence[str]] | None = None
) -> dict[int, Event]:
    """Return what cells of the table mean, by operation.

    >>> events_of({200: "Greased, inspected"})
    {200: Event(renews=True, transducer=False)}

    Args:
        more: Section ``endurance.events`` of the configuration: what starts anew, by event.

    Raises:
        ValueError: If an event has no meaning.
    """
    every = [*EVENTS.items(), *(more or {}).items()]
    known = {word: meaning for key, meaning in every for word in event_words(key)}
    found = {}
    for number, text in texts.items():
        if unknown := [word for word in event_words(text) if word not in known]:
            raise ValueError(f"endurance.events has no {', '.join(unknown)}; add what starts anew")
        affected = {name for word in event_words(text) for name in known[word]}
        found[number] = Event(bool(affected), affected == {_TRANSDUCER})
    return found


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
        conditions: Relative to those of the new operations, ``(o,)`` each, in 10 K and in 10 % of
            the voltage; 0 where one is not known.
        inspections: Number of the inspection of each operation, ``(o,)``; None under monitoring.
    """

    operations: np.ndarray
    motions: Mapping[str, MotionRecords]
    new: np.ndarray
    events: Mapping[int, Event]
    conditions: Sequence[np.ndarray] = ()
    inspections: np.ndarray | None = None

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
    every = {m: each.reindex(operation=operations, copy=False) for m, each in data.items()}
    usable = {m: each.accepted.values == True for m, each in every.items()}  # noqa: E712, nan is not
    place = {int(o): i for i, o in enumerate(operations)}
    done = {place[o]: each for o, each in events.items() if o in place}
    dates = [each.date.values for each in every.values() if "date" in each]
    inspections = inspections_of(operations, days_of(dates[0]) if dates else None, done)
    new = new_of(usable, inspections, done)
    motions = {m: _motion(m, every[m], usable[m], new, followed.get(m, ())) for m in every}
    motions = {motion: each for motion, each in motions.items() if each is not None}
    if not motions:
        raise ValueError("no new operation has a usable record. Start with the first inspection")
    known = [
        _relative(name, np.array([values.get(o, np.nan) for o in place]), new)
        for name, values in conditions.items()
        if not place.keys().isdisjoint(values)
    ]
    return Series(operations, motions, new, done, known, inspections)


def _relative(name: str, values: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Conditions relative to those of the new operations, as of ``Series``."""
    usual = float(np.nanmean(values[new] if np.isfinite(values[new]).any() else values))
    return np.nan_to_num((values - usual) / (_STEP[name] * (usual if name == "voltage" else 1.0)))


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


def days_of(dates: Sequence[str]) -> np.ndarray:
    """Return days since year 1 of dates, ``(o,)``; nan where one is not known."""
    found = np.full(len(dates), np.nan)
    for i, each in enumerate(dates):
        if isinstance(each, str) and each:
            found[i] = (instant(each) - datetime.min) / timedelta(days=1)
    return found


def new_of(
    usable: Mapping[str, np.ndarray],
    inspections: np.ndarray | None,
    events: Mapping[int, Event] | None = None,
) -> np.ndarray:
    """Indices of the new operations: with all motions if any has, and before any maintenance."""
    every = np.array(list(usable.values()))
    there = np.flatnonzero(every.all(axis=0) if every.all(axis=0).any() else every.any(axis=0))
    if inspections is not None:
        return there[inspections[there] == inspections[there[:1]]] if there.size else there
    first = there[:_FIRST]
    work = [i for i, each in (events or {}).items() if each.renews and (i > first[:1]).any()]
    return first[first < min(work, default=np.inf)]


def _motion(
    motion: str, data: xr.Dataset, usable: np.ndarray, new: np.ndarray, names: Sequence[str]
) -> MotionRecords | None:
    """Records of a motion in the units of the new ones; None if none of these has a record."""
    n, sign = len(usable), 1.0 if motion == "closing" else -1.0
    records, step = sign * data.record.values, 1.0 / data.rate.values
    sd, colour = data.record_noise.values, data.record_colour.values
    own = [each for i in new if usable[i] and (each := shape_of(records[i], step[i]))]
    if not own:
        return None
    units, noise = median_units(own), np.full(n, np.nan)
    way, present = np.zeros((n, SHAPE_TIMES.size)), np.zeros((n, SHAPE_TIMES.size), dtype=bool)
    for i in np.flatnonzero(usable):
        if (shape := shape_of(records[i], step[i], units)) is not None:
            way[i], present[i] = shape.way, shape.present
            noise[i] = network_record(shape, sd[i], colour[i], step[i], units).noise[0]
    measured, stated = (
        {name: data[each].sel(quantity=name).values for name in names}
        for each in ("measured", "measured_sd")
    )
    return MotionRecords(way, present, noise, units.stroke, units.duration, measured, stated)
