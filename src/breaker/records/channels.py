"""The clock and the travels among the columns of a file, and the phases of the travels.

A column is a clock or a travel by its unit or its name. Without both, a column that rises in even
steps is a clock, and a column that moves between rests as a mass does is a travel.
"""

import re
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records import words
from breaker.records.motion import Course
from breaker.records.settings import RATES, TO_MM, TO_MS
from breaker.records.sheet import Sheet

FAINT = 0.25
"""Share of the largest range of its kind below which a signal is cross-talk."""

FEWEST = 40
"""Least number of samples of a column; shorter columns list results."""

_AT_REST = 0.025  # of a stroke, within which a drive is at rest; after a motion it still settles
_UNEVEN = 0.2  # of a step: times that are printed with few digits differ by as much
_OSCILLATES = 6  # motions: no operating sequence of IEC 62271-100 has more
_LENGTHS = (*TO_MM, "deg", "rad")  # units of travels alone

_LABELS = {key: words.any_of(spelt) for key, spelt in words.WORDS["labels"].items()}
_OF_CONTACT = re.compile(
    rf"(?P<none>{_LABELS['not connected']})|{_LABELS['transducer']}\W{{0,2}}0*(?P<number>\d+)"
    rf"|(?P<phase>{words.PHASE})?\W{{0,2}}{_LABELS['break']}\W{{0,2}}\d*",
    re.I,
)


class InspectionError(ValueError):
    """A file for which no settings can be proposed; the message has the reason."""


class Clock(NamedTuple):
    """When the samples of a record were taken; the rate, kHz, is NaN where it is not known."""

    place: int | None
    unit: str | None
    rate: float
    remarks: tuple[str, ...] = ()
    rank: tuple[bool, ...] = ()  # how surely it is a clock: even steps, a unit, a name

    @property
    def likely_rate(self) -> float:
        """The rate, kHz, or a usual one where it is not known."""
        return float(np.sqrt(np.prod(RATES))) if np.isnan(self.rate) else self.rate


def find_clock(sheet: Sheet) -> Clock:
    """Find the column of the time, or the rate that replaces it; refuse times that fall."""
    clocks = [clock for i in range(len(sheet.columns)) if (clock := _clock_in(sheet, i))]
    if not clocks:
        return Clock(None, None, sheet.stated.rate)
    clock = max(clocks, key=lambda one: one.rank)
    times = sheet.columns[clock.place]
    falls = np.flatnonzero(np.diff(times[np.isfinite(times)]) < 0.0)
    if falls.size:
        raise InspectionError(
            f"{sheet.file}: its time, column {sheet.column(clock.place)!r}, falls or begins again "
            f"after {falls[0] + 1} samples; sort its lines by time, and export a column for each "
            "channel and a file for each record"
        )
    return clock


def _clock_in(sheet: Sheet, place: int) -> Clock | None:
    """The clock that a column is, if it is one; a column that counts samples is not."""
    unit, name, values = sheet.units[place], sheet.names[place], sheet.columns[place]
    times = values[np.isfinite(values)]
    if (unit and unit not in TO_MS) or times.size < max(FEWEST, values.size // 2):
        return None
    low, step, high = np.quantile(np.diff(times), (0.25, 0.5, 0.75))
    named = words.holds(name, "time") and name.strip() != "T"  # T is a phase, as R and S are
    even = bool(low > 0.0 and high - low <= _UNEVEN * step)
    if not (unit or named or (even and step != 1.0)) or times[-1] == times[0]:
        return None
    step = step if even else abs(times[-1] - times[0]) / (times.size - 1)
    rates = {known: float(1.0 / (step * ms)) for known, ms in TO_MS.items()}
    likely = [known for known, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
    if not (unit or likely or named):
        return None
    rank, remarks = (even, unit is not None, named), ()
    if not unit:
        unit = next(iter(likely), None)
        fit = unit or "no recorder"
        remarks = (f"the time's unit is not stated; steps of {in_digits(step, 4)} fit {fit}",)
    return Clock(place, unit, rates.get(unit, np.nan), remarks, rank)


@dataclass(frozen=True)
class Travel:
    """A column that moves between rests in m motions; unit and phase where they are stated."""

    place: int
    unit: str | None
    course: Course
    phase: str = ""
    named: bool = True  # whether its name or its unit states that it is a travel

    @property
    def rises(self) -> np.ndarray:
        """Whether the reading rises in each motion, ``(m,)``."""
        return self.course.crossings[2]

    @property
    def rests(self) -> np.ndarray:
        """Readings at rest before and after each motion, ``(m, 2)``."""
        return np.array([(motion.before, motion.after) for motion in self.course.motions])

    @property
    def strokes(self) -> np.ndarray:
        """Distance between the rests of each motion, ``(m,)``, in the unit of the reading."""
        return np.array([motion.stroke for motion in self.course.motions])

    def part(self, k: int) -> tuple[int, int]:
        """Return the first sample, and the one after the last, of the part with motion k alone."""
        at = self.course.middles
        ends = [0, *((at[1:] + at[:-1]) // 2).tolist(), self.course.smooth.size]
        return ends[k], ends[k + 1]

    def done(self, k: int) -> np.ndarray:
        """Return the share of motion k that is done, ``(t,)``."""
        before, after = self.rests[k]
        return (self.course.smooth - before) / (after - before)

    def moves(self, k: int) -> tuple[int, int]:
        """Return the last sample at rest before motion k, and the first one after it."""
        done, middle = self.done(k), int(self.course.middles[k])
        first, end = self.part(k)[0], self.course.motions[k].end
        resting = np.flatnonzero(np.abs(done[first:middle]) <= _AT_REST)
        moving = np.flatnonzero(np.abs(done[middle:end] - 1.0) > 2.0 * _AT_REST)
        return first + int(resting[-1:].sum()), middle + int(moving[-1:].sum()) + 1

    def is_of_drive(self) -> bool:
        """Return whether it moves between rests; contacts jump, and other signals oscillate."""
        course = self.course
        if np.isfinite(course.reading).sum() < FEWEST or not course.moves:
            return False
        leaves, reaches, _ = course.crossings
        jumps = reaches - leaves < max(2, course.half // 2)  # a running median keeps them sharp
        few = 0 < leaves.size <= _OSCILLATES and not jumps.any()
        return few and bool(self.strokes.min() > FAINT * np.ptp(course.smooth))

    def is_of_mass(self) -> bool:
        """Return whether a motion begins slowly, by tenths; a current rises fastest at first."""
        slow = []
        for k, middle in enumerate(self.course.middles.tolist()):
            back = self.done(k)[self.part(k)[0] : middle + 1][::-1]
            at = [(back <= share).argmax() for share in np.arange(_AT_REST, 0.5, 0.1)]
            first, *others = -np.diff(at)
            slow.append(first > (1.0 + _UNEVEN) * min(others))
        return any(slow)


def _find_travels(sheet: Sheet, clock: Clock) -> list[Travel]:
    """Columns that move as a drive does: those named a travel, or else all."""
    step, found = 1.0 / min(clock.likely_rate, RATES[1]), []
    for place, values in enumerate(sheet.columns):
        unit, name = sheet.units[place], sheet.names[place]
        named = unit in _LENGTHS or words.holds(name, "travel")
        other = unit not in (None, *_LENGTHS, "V", "counts", "%") or place == clock.place
        if other or (words.holds(name, "of no travel") and not named):
            continue
        reading = np.where(np.isfinite(values), values, np.nan)
        course = Course(step * np.arange(values.size), reading)
        found.append(Travel(place, unit, course, words.phase_in(name), named))
    found = [travel for travel in found if travel.is_of_drive()]
    named = [travel for travel in found if travel.named]
    return named or [travel for travel in found if travel.is_of_mass()]


def chosen_travels(
    sheet: Sheet, clock: Clock, channel: str
) -> tuple[list[Travel], list[Travel], list[str]]:
    """Return the columns of travel, those that are asked for, and remarks on the others."""
    travels = _find_travels(sheet, clock)
    if not travels:
        raise InspectionError(
            f"{sheet.file}: none of {len(sheet.columns)} columns moves between two rests as a "
            "drive does; did the breaker move, and is the record longer than the motion?"
        )
    place = sheet.place_of(channel) if channel else None
    asked = [travel for travel in travels if travel.place == place]
    listed = " or ".join(f"travel_column: {sheet.column(travel.place)}" for travel in travels)
    if channel and not asked:
        raise InspectionError(f"{sheet.file}: {channel!r} is not a column of travel; set {listed}")
    most = defaultdict(float)
    for travel in travels if travels[0].named else ():
        most[travel.unit] = max(most[travel.unit], travel.strokes.max())
    faint = [travel for travel in travels if travel.strokes.max() < FAINT * most[travel.unit]]
    used = [travel for travel in travels if travel not in faint]
    every = _with_phases(sheet, asked if asked and asked[0] in faint else used)
    if asked:
        return every, [travel for travel in every if travel.place == place], []
    left = ", ".join(repr(sheet.column(travel.place)) for travel in faint)
    remarks = [f"{left}: far less than others, so not used; choose by --channel"] * bool(faint)
    if len(travels) > 1 and not travels[0].named:
        remarks.append(f"no column is named a travel, and several move as one: set {listed}")
    return every, every, remarks


def _with_phases(sheet: Sheet, travels: Sequence[Travel]) -> list[Travel]:
    """Travels with their phase: by name, or as stated for their number, order or contacts."""
    stated = stated_contacts(sheet, {travel.place for travel in travels}) or {}
    phases = {int(number): phase for number, phase in stated.values() if phase}
    phases |= sheet.stated.phases
    found = []
    for order, travel in enumerate(travels, start=1):
        number = words.channel_of(sheet.names[travel.place]) or order
        found.append(replace(travel, phase=travel.phase or phases.get(number, phases.get(0, ""))))
    return found


def stated_contacts(sheet: Sheet, travels: Collection[int]) -> Mapping[int, tuple[str, str]] | None:
    """Return the number of the travel and the phase of each connected contact, by column.

    Rows above the columns have for each contact its transducer (``TR1``), and its phase and break
    (``YBreak2``) or ``NA``, above its column or in the order of the contacts. None without one.
    """
    places = [i for i, unit in enumerate(sheet.units) if i not in travels and unit not in TO_MM]
    kinds = ("contact", "resistance")
    named = [[i for i in places if words.holds(sheet.names[i], kind)] for kind in kinds]
    contacts, stated = next(filter(None, named), []), {}
    for row in sheet.preamble:
        cells = {i: m for i, cell in enumerate(row) if (m := _OF_CONTACT.fullmatch(cell.strip()))}
        if all(cell["none"] for cell in cells.values()):
            continue
        to = cells if {*cells} & {*contacts} else contacts if len(cells) == len(contacts) else ()
        for place, cell in zip(to, cells.values(), strict=False):
            known = {key: text for key, text in cell.groupdict().items() if text}
            stated[place] = stated.get(place, {}) | known
    numbered = {i: stated[i] for i in contacts if "number" in stated.get(i, ())}
    connected = {
        i: (s["number"], s.get("phase", "")) for i, s in numbered.items() if "none" not in s
    }
    return connected if numbered else None
