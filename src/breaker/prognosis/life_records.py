"""Records of a life, shapes in common units and what is measured, and work on the drive."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from breaker.family.inputs import NormalisedRecords, network_record, stored_shape
from breaker.family.shape import SHAPE_TIMES, median_units
from breaker.records.operations import EVENTS, event_words

_TRANSDUCER = "transducer"
_STEP = {"temperature": 10.0, "voltage": 0.1}  # of a condition: K; share of that of the new ones
_ALIKE = 0.5  # steps, within which new operations are compared


@dataclass(frozen=True)
class Event:
    """Work that was done before an operation.

    Attributes:
        renews: Whether anything starts anew.
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
    """A life.

    Attributes:
        operations: Their numbers, rising, ``(o,)``.
        motions: Records, by motion.
        new: Which operations are new, indices.
        events: What was done before operations, by index.
        conditions: By name of ``CONDITIONS``, ``(o,)``, nan where one is not known.
    """

    operations: np.ndarray
    motions: Mapping[str, MotionRecords]
    new: np.ndarray
    events: Mapping[int, Event]
    conditions: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def apart(self) -> dict[str, np.ndarray]:
        """Conditions relative to those of the new operations, ``(o,)`` each, in 10 K and in 10 % of
        the voltage; 0 where one is not known.
        """
        found = {}
        for name, values in self.conditions.items():
            known = values[self.new]
            of = known if np.isfinite(known).any() else values
            found[name] = np.nan_to_num(_steps(name, values, float(np.nanmean(of))))
        return found


def series_of(
    data: Mapping[str, xr.Dataset],
    reference: int | Sequence[int],
    *,
    followed: Mapping[str, Sequence[str]],
    events: Mapping[int, Event],
    conditions: Mapping[str, Mapping[int, float]],
) -> Series:
    """Return the series of measured operations.

    Args:
        data: What ``read_curves`` returns of each motion.
        reference: How many of the first operations with a record are new; or the first and the last
            number of those that are.
        followed: Names of measured quantities that are followed, by motion.
        events, conditions: By the number of an operation; conditions by name of ``CONDITIONS``.

    Raises:
        ValueError: If no operation that is new has a record.
    """
    operations = np.unique(np.concatenate([each.operation.values for each in data.values()]))
    whole = {
        motion: each.reindex(operation=operations, copy=False) for motion, each in data.items()
    }
    usable = {m: each.accepted.values == True for m, each in whole.items()}  # noqa: E712, nan is not
    known = {
        name: np.array([values.get(int(o), np.nan) for o in operations])
        for name, values in conditions.items()
    }
    known = {name: values for name, values in known.items() if np.isfinite(values).any()}
    place = {int(o): i for i, o in enumerate(operations)}
    done = {place[o]: each for o, each in events.items() if o in place}
    new = _new(operations, usable, reference, done, known)
    motions = {m: _motion(m, whole[m], usable[m], new, followed.get(m, ())) for m in whole}
    motions = {motion: each for motion, each in motions.items() if each is not None}
    if not motions:
        raise ValueError("no operation that counts as new has a record: see trend.reference")
    return Series(operations, motions, new, done, known)


def _new(
    operations: np.ndarray,
    usable: Mapping[str, np.ndarray],
    reference: int | Sequence[int],
    events: Mapping[int, Event],
    conditions: Mapping[str, np.ndarray],
) -> np.ndarray:
    """Indices of the new operations: all motions, no work between, similar conditions."""
    there = np.flatnonzero(np.logical_and.reduce(list(usable.values())))
    if not there.size:
        there = np.flatnonzero(np.logical_or.reduce(list(usable.values())))
    if np.ndim(reference):
        low, high = reference
        return there[(operations[there] >= low) & (operations[there] <= high)]
    renewed = [i for i, event in events.items() if event.renews]
    spells = np.searchsorted(np.sort(renewed), there[:reference], side="right")
    first = there[:reference]
    if first.size:
        first = first[spells == np.bincount(spells).argmax()]
    for name, values in conditions.items():
        known = values[first]
        if np.isfinite(known).any():
            near = np.abs(_steps(name, known, float(np.nanmedian(known)))) <= _ALIKE
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
    told = zip(data.record_noise.values, data.record_colour.values, step, strict=True)
    own = [each for i in new if usable[i] and (each := stored_shape(sign * records[i], step[i]))]
    if not own:
        return None
    units = median_units(own)
    for i, (sd, colour, each) in enumerate(told):
        if usable[i] and (shape := stored_shape(sign * records[i], each, units)) is not None:
            way[i], present[i] = shape.way, shape.present
            noise[i] = network_record(shape, sd, colour, each, units).noise[0]
    measured, stated = (
        {name: data[each].sel(quantity=name).values for name in names}
        for each in ("measured", "measured_sd")
    )
    return MotionRecords(way, present, noise, units.stroke, units.duration, measured, stated)
