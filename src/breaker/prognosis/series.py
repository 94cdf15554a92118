"""Records of a life: shapes in common units, measured quantities, maintenance events, inspections.

A drive is monitored if the median step of the operation number is at most 10 and no gap separates
its operations; then the first 50 operations are new. Otherwise it is inspected: an inspection ends
at a jump of the operation number or the date, and the operations of the first one are new.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np
import xarray as xr

from breaker.family.inputs import NormalisedRecords, network_record
from breaker.family.shape import SHAPE_TIMES, median_units, shape_of
from breaker.records.dates import instant
from breaker.records.operations import event_words, renewed_by

_STEP = {"temperature": 10.0, "voltage": 0.1}  # unit of a condition: K; share of the new voltage
_FIRST = 50  # new operations under monitoring; with more inspections a drive counts as monitored
_COUNTED = 4.0  # weight of the usual scatter, in inspections
_STEPS = 10  # largest usual step between records under monitoring, in operations
_DAYS = 30.0  # gap between inspections: one takes days, and the next is months later


def events_of(texts: Mapping[int, str], more: Mapping[str, Sequence[str]]) -> dict[int, bool]:
    """Return the operations before which a part was renewed, and whether this was maintenance of
    the drive, not of its transducer alone; ``more`` is the section ``endurance.events``.

    >>> events_of({200: "Greased, inspected", 300: "transducer remounted"}, {})
    {200: True, 300: False}

    Raises:
        ValueError: If an event has no meaning.
    """
    known, events = renewed_by(more), {}
    for number, text in texts.items():
        if unknown := [word for word in event_words(text) if word not in known]:
            raise ValueError(f"endurance.events has no {', '.join(unknown)}; add the renewed parts")
        if renewed := {name for word in event_words(text) for name in known[word]}:
            events[number] = renewed != {"transducer"}
    return events


@dataclass(frozen=True, eq=False)
class MotionRecords:
    """Records of one motion, in the units of its new records.

    Attributes:
        way, present: Shapes, ``(o, g)``, and whether they have samples; none without a record.
        noise: Noise of a record, share of the stroke, ``(o,)``; nan without a record.
        stroke, duration: Units, mm and ms.
        measured, stated: Followed quantities and their stated sds, ``(o,)`` each, by name; nan if
            the record does not show a quantity.
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
        """Return records for networks from shapes in these units, ``(n, g)``, and their noise."""
        ones, there = np.ones(len(way)), np.isfinite(way)
        numbers = self.stroke * ones, self.duration * ones, noise * ones, 0.0 * ones, 0.05 * ones
        return NormalisedRecords(there.any(axis=1), np.where(there, way, 0.0), there, *numbers)


@dataclass(frozen=True, eq=False)
class Series:
    """Records of a life.

    Attributes:
        operations: Numbers of the operations, rising, ``(o,)``.
        motions: Records, by motion.
        new: Indices of the new operations.
        events: Result of ``events_of``, by index.
        conditions: Differences from the new operations, ``(o,)`` each, in 10 K and in 10 % of the
            voltage; 0 if unknown.
        inspections: Number of the inspection of each operation, ``(o,)``; None under monitoring.
    """

    operations: np.ndarray
    motions: Mapping[str, MotionRecords]
    new: np.ndarray
    events: Mapping[int, bool]
    conditions: Sequence[np.ndarray] = ()
    inspections: np.ndarray | None = None

    @property
    def settle(self) -> int:
        """Number of operations after the new ones, or after a change, without a further change."""
        number = self.inspections
        return _FIRST if number is None else int(np.sum(number == number[self.new[-1]]))

    @property
    def counted(self) -> float:
        """Weight of the scatter of the new records, in records: few records do not show it."""
        return 2.0 * _FIRST if self.inspections is None else _COUNTED

    def gathered(self, values: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the mean of each inspection, ``(o, k)``, at its last record, and the usual number
        of records; other rows are nan, like those of operations without a record.
        """
        if self.inspections is None:
            return values, 1.0
        smooth, counts = np.full_like(values, np.nan), []
        there = np.isfinite(values).all(axis=1)
        for number in np.unique(self.inspections[there]):
            rows = np.flatnonzero(there & (self.inspections == number))
            smooth[rows[-1]] = values[rows].mean(axis=0)
            counts.append(rows.size)
        return smooth, float(np.median(counts))


def series_of(
    data: Mapping[str, xr.Dataset], followed: Iterable, events: Mapping, conditions: Mapping
) -> Series:
    """Return the series of the results of ``read_curves``, by motion.

    Args:
        followed: Motions and names of the measured quantities that are followed.
        events, conditions: Values by operation; conditions also by name of ``CONDITIONS``.

    Raises:
        ValueError: If no new operation has a record.
    """
    operations = np.unique(np.concatenate([dataset.operation.values for dataset in data.values()]))
    every = {m: dataset.reindex(operation=operations, copy=False) for m, dataset in data.items()}
    usable = {m: dataset.accepted.values == True for m, dataset in every.items()}  # noqa: E712, nan is not
    place = {int(o): i for i, o in enumerate(operations)}
    done = {place[o]: event for o, event in events.items() if o in place}
    dates = [dataset.date.values for dataset in every.values() if "date" in dataset]
    inspections = inspections_of(operations, days_of(dates[0]) if dates else None, done)
    new = new_of(usable, inspections, done)
    names = {motion: [name for m, name in followed if m == motion] for motion in every}
    motions = {m: _motion(m, every[m], usable[m], new, names[m]) for m in every}
    motions = {motion: records for motion, records in motions.items() if records is not None}
    if not motions:
        raise ValueError("no new operation has a usable record. Start with the first inspection")
    relative = []
    for name, known in conditions.items():
        if not place.keys().isdisjoint(known):
            values = np.array([known.get(o, np.nan) for o in place])
            usual = float(np.nanmean(values[new] if np.isfinite(values[new]).any() else values))
            step = _STEP[name] * (usual if name == "voltage" else 1.0)
            relative.append(np.nan_to_num((values - usual) / step))
    return Series(operations, motions, new, done, relative, inspections)


def inspections_of(
    operations: np.ndarray, days: np.ndarray | None = None, events: Iterable[int] = ()
) -> np.ndarray | None:
    """Return the number of the inspection of each operation, ``(o,)``; None under monitoring.

    >>> inspections_of(np.array([1, 2, 201, 202, 401])).tolist()
    [0, 0, 1, 1, 2]
    >>> inspections_of(np.arange(5, 2000, 5)) is None
    True

    Operations have rising numbers, and unknown days are nan. ``events`` are indices of operations
    at which an inspection begins, because a part was renewed before.
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
    begins[[i - 1 for i in events if i > 0]] = True
    return np.append(0, np.cumsum(begins))


def days_of(dates: Sequence[str]) -> np.ndarray:
    """Return days since year 1 of dates, ``(o,)``; nan for unknown dates."""
    known = (instant(date) if isinstance(date, str) and date else None for date in dates)
    days = [(moment - datetime.min) / timedelta(days=1) if moment else np.nan for moment in known]
    return np.array(days, dtype=float)


def new_of(
    usable: Mapping[str, np.ndarray], inspections: np.ndarray | None, events: Iterable[int] = ()
) -> np.ndarray:
    """Return indices of the new operations, before any event; with all motions if any has all."""
    every = np.array(list(usable.values()))
    there = np.flatnonzero(every.all(axis=0) if every.all(axis=0).any() else every.any(axis=0))
    if inspections is not None:
        return there[inspections[there] == inspections[there[:1]]]
    first = there[:_FIRST]
    later = [i for i in events if (i > first[:1]).any()]
    return first[first < min(later, default=np.inf)]


def _motion(
    motion: str, data: xr.Dataset, usable: np.ndarray, new: np.ndarray, names: Sequence[str]
) -> MotionRecords | None:
    """Return records of a motion in units of the new ones; None if these have no record."""
    n, sign = len(usable), 1.0 if motion == "closing" else -1.0
    records, step = sign * data.record.values, 1.0 / data.rate.values
    sd, colour = data.record_noise.values, data.record_colour.values
    first = [own for i in new if usable[i] and (own := shape_of(records[i], step[i]))]
    if not first:
        return None
    units, noise = median_units(first), np.full(n, np.nan)
    way, present = np.zeros((n, SHAPE_TIMES.size)), np.zeros((n, SHAPE_TIMES.size), dtype=bool)
    for i in np.flatnonzero(usable):
        if (shape := shape_of(records[i], step[i], units)) is not None:
            way[i], present[i] = shape.way, shape.present
            noise[i] = network_record(shape, sd[i], colour[i], step[i], units).noise[0]
    measured, stated = (
        {name: data[variable].sel(quantity=name).values for name in names}
        for variable in ("measured", "measured_sd")
    )
    return MotionRecords(way, present, noise, units.stroke, units.duration, measured, stated)
