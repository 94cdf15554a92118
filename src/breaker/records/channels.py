"""The clock and the travels among the columns of a file, and the phases of the travels.

A column is a clock or a travel by its unit or its name. Without both, a column that rises in even
steps is a clock, and a column that moves between rests as a mass does is a travel.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records import words
from breaker.records.lexicon import WORDS
from breaker.records.motion import Course
from breaker.records.settings import RATES, TO_MM, TO_MS
from breaker.records.sheet import Sheet

FAINT = 0.25
"""Share of the largest range of its kind below which a signal is cross-talk."""

FEWEST = 40
"""Least number of samples of a column; shorter columns list results."""

_FEW = 0.05  # share of samples that may be damaged, and of a stroke within which a drive is at rest
_UNEVEN = 0.2  # of a step: times that are printed with few digits differ by as much
_OSCILLATES = 6  # motions: no operating sequence of IEC 62271-100 has more

_LABELS = WORDS["labels"]
_TRANSDUCER = re.compile(rf"{words.any_of(_LABELS['transducer'])}\W{{0,2}}0*(\d+)", re.I)
_BREAK = re.compile(rf"({words.PHASE})?\W{{0,2}}{words.any_of(_LABELS['break'])}\W{{0,2}}\d*", re.I)
_NOT_CONNECTED = re.compile(words.any_of(_LABELS["not connected"]), re.I)


def smooth_range(values: np.ndarray) -> float:
    """Return the range of a column without noise; 0 where it changes by no more than noise."""
    course = Course(np.arange(values.size, dtype=float), values)
    moves = np.isfinite(values).sum() >= FEWEST and course.moves
    return float(np.ptp(course.smooth)) if moves else 0.0


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
        doubt = sheet.stated.rate_doubt
        remarks = (f"the rate is doubtful: {doubt}",) if doubt else ()
        return Clock(None, None, sheet.stated.rate, remarks)
    clock = max(clocks, key=lambda one: one.rank)
    column, times = sheet.column(clock.place), sheet.columns[clock.place]
    steps = np.diff(times := times[np.isfinite(times)])
    falls = steps < 0.0
    again = falls & (np.abs(times[1:] - times[0]) <= 2.0 * np.median(steps))
    if again.any() or falls.mean() > _FEW:
        raise InspectionError(
            f"{sheet.file}: its time, column {column!r}, falls or begins again after "
            f"{(again if again.any() else falls).argmax() + 1} samples; sort its lines by time, "
            "and export a column for each channel and a file for each record"
        )
    rivals = [one for one in clocks if one.rank == clock.rank and one is not clock]
    rivals = [one for one in rivals if not np.isclose(one.rate, clock.rate, equal_nan=True)]
    if not rivals:
        return clock
    lines = " or ".join(f"time_column: {sheet.column(one.place)}" for one in rivals)
    remark = f"{column!r} is taken as the time; if another column is the time, set {lines}"
    return clock._replace(remarks=(*clock.remarks, remark))


def _clock_in(sheet: Sheet, place: int) -> Clock | None:
    """The clock that a column is, if it is one; a column that counts samples is not."""
    unit, name, values = sheet.units[place], sheet.names[place], sheet.columns[place]
    times = values[np.isfinite(values)]
    if (unit and unit not in TO_MS) or times.size < max(FEWEST, values.size // 2):
        return None
    steps = np.diff(times)
    least, low, step, high, most = np.quantile(steps, (_FEW, 0.25, 0.5, 0.75, 1.0 - _FEW))
    named = words.holds(name, "time") and name.strip() != "T"  # T is a phase, as R and S are
    even = bool(least > 0.0 and high - low <= _UNEVEN * step)
    ordered = (least >= 0.0 or most <= 0.0) and times[-1] != times[0]
    first = place == 0 and least >= 0.0 < high
    if not (unit or (named and ordered) or (first and not even) or (even and step != 1.0)):
        return None
    if not even:  # the first and the last time may be false
        step = abs(float(times[-2] - times[1])) / (times.size - 3) or np.nan
    rates = {known: 1.0 / (step * ms) for known, ms in TO_MS.items()}
    likely = [known for known, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
    if not (unit or likely or named):
        return None
    rank, remarks = (even, unit is not None, named), []
    if not unit:
        unit, fit = (likely[0], likely[0]) if likely else (None, "no recorder")
        remarks.append(f"the time's unit is not stated; steps of {in_digits(step, 4)} fit {fit}")
    if not even:
        ends = " to ".join(in_digits(float(end), 4) for end in (steps.min(), steps.max()))
        column = repr(sheet.column(place))
        remarks.append(f"the steps of the times in {column} are not even: {ends} {unit or ''}")
    return Clock(place, unit, rates.get(unit, np.nan), tuple(remarks), rank)


@dataclass(frozen=True)
class Travel:
    """A column that moves between rests in m motions; unit and phase where they are stated."""

    place: int
    unit: str | None
    course: Course
    phase: str = ""

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
        return np.abs(np.diff(self.rests)[:, 0])

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
        """Return the samples at which motion k begins, and from which on it rests as long."""
        done, first, middle = self.done(k), self.part(k)[0], self.course.middles[k]
        resting = np.abs(done[first : middle + 1]) <= 0.5 * _FEW
        begins = int(first + np.flatnonzero(resting)[-1]) if resting.any() else first
        moving = np.flatnonzero(np.abs(done[middle : self.course.motions[k].end] - 1.0) > _FEW)
        rests = np.diff(np.append(moving, np.inf)) > 2 * (middle - begins)
        return begins, int(middle + moving[rests.argmax()] + 1)

    def is_of_drive(self) -> bool:
        """Return whether it moves between rests; contacts jump, and other signals oscillate."""
        course = self.course
        if np.isfinite(course.reading).sum() < FEWEST or not course.moves:
            return False
        leaves, reaches, _ = course.crossings
        jumps = reaches - leaves < max(2, course.half // 2)  # a running median keeps them sharp
        if not 0 < leaves.size <= _OSCILLATES or jumps.any():
            return False
        return bool(self.strokes.min() > FAINT * np.ptp(course.smooth))

    def is_of_mass(self) -> bool:
        """Return whether a motion begins slowly, by tenths; a current rises fastest at first."""
        for k, middle in enumerate(self.course.middles.tolist()):
            back = self.done(k)[self.part(k)[0] : middle + 1][::-1]
            at = [-int((back <= share).argmax()) for share in np.arange(0.5 * _FEW, 0.5, 0.1)]
            first, *others = np.diff(at)
            if first > (1.0 + _UNEVEN) * min(others):
                return True
        return False


def _is_named(sheet: Sheet, place: int) -> bool:
    """Whether name or unit of a column state that it is a travel."""
    return sheet.units[place] in (*TO_MM, "deg", "rad") or words.holds(sheet.names[place], "travel")


def find_travels(sheet: Sheet, clock: Clock) -> list[Travel]:
    """Find the columns that move as a drive does: those named a travel, or else all."""
    named, shaped = [], []
    for place, values in enumerate(sheet.columns):
        unit, is_named = sheet.units[place], _is_named(sheet, place)
        if place == clock.place or unit not in (None, *TO_MM, "deg", "rad", "V", "counts", "%"):
            continue
        if words.holds(sheet.names[place], "of no travel") and not is_named:
            continue
        reading = np.where(np.isfinite(values), values, np.nan)
        time = np.arange(values.size) / min(clock.likely_rate, RATES[1])
        travel = Travel(place, unit, Course(time, reading))
        if travel.is_of_drive() and (is_named or travel.is_of_mass()):
            (named if is_named else shaped).append(travel)
    return named or shaped


def chosen_travels(
    sheet: Sheet, clock: Clock, channel: str
) -> tuple[list[Travel], list[Travel], list[str]]:
    """Return the columns of travel, those that are asked for, and remarks on the others."""
    travels = find_travels(sheet, clock)
    if not travels:
        raise InspectionError(
            f"{sheet.file}: none of {len(sheet.columns)} columns moves between two rests as a "
            "drive does; did the breaker move, and is the record longer than the motion?"
        )
    named, most = any(_is_named(sheet, travel.place) for travel in travels), {}
    for travel in travels if named else ():
        most[travel.unit] = max(travel.strokes.max(), most.get(travel.unit, 0.0))
    kept = [t for t in travels if t.strokes.max() >= FAINT * most.get(t.unit, 0.0)]
    if channel:
        place = sheet.place_of(channel)
        asked = [travel for travel in travels if travel.place == place]
        if not asked:
            listed = ", ".join(repr(sheet.column(travel.place)) for travel in travels)
            reason = f"{channel!r} is not a column of travel; there are {listed}"
            raise InspectionError(f"{sheet.file}: {reason}")
        every = _with_phases(sheet, kept if asked[0] in kept else asked)
        return every, [travel for travel in every if travel.place == place], []
    remarks, used = [], _with_phases(sheet, kept)
    if faint := ", ".join(repr(sheet.column(t.place)) for t in travels if t not in kept):
        remarks.append(f"{faint}: far less than others, so not used; choose one by --channel")
    if len(used) > 1 and not named:
        lines = " or ".join(f"travel_column: {sheet.column(travel.place)}" for travel in used)
        remarks.append(f"no column is named a travel, and {len(used)} move as one: set {lines}")
    return used, used, remarks


def _with_phases(sheet: Sheet, travels: Sequence[Travel]) -> list[Travel]:
    """Travels with their phase: by name, or as stated for their number, order or contacts."""
    phases, places = dict(sheet.stated.phases), {travel.place for travel in travels}
    for number, phase in (stated_contacts(sheet, places) or {}).values():
        if phase:
            phases.setdefault(int(number), phase)
    found = []
    for order, travel in enumerate(travels, start=1):
        name = sheet.names[travel.place]
        stated = phases.get(words.channel_of(name) or order, phases.get(0, ""))
        found.append(replace(travel, phase=words.phase_in(name) or stated))
    return found


def stated_contacts(sheet: Sheet, travels: Iterable[int]) -> Mapping[int, tuple[str, str]] | None:
    """Return the number of the travel and the phase of each connected contact, by column.

    A row above the columns names the transducer of each contact (``TR1``), another one the phase
    and the number of its break (``YBreak2``, or ``NA`` where nothing is connected). Cells are above
    their columns, or as many as these, in the same order. None where no row states transducers.
    """
    names = {i: name for i, name in enumerate(sheet.names) if i not in travels}
    names = {i: name for i, name in names.items() if sheet.units[i] not in TO_MM}
    contacts = [i for i, name in names.items() if words.holds(name, "contact")]
    contacts = contacts or [i for i, name in names.items() if words.holds(name, "resistance")]
    stated: dict[re.Pattern, dict[int, str]] = {_TRANSDUCER: {}, _BREAK: {}}
    unused: set[int] = set()
    for row in sheet.preamble:
        cells = dict(enumerate(cell.strip() for cell in row))
        nothing = [i for i, cell in cells.items() if _NOT_CONNECTED.fullmatch(cell)]
        for kind, known in stated.items():
            found = {i: m[1] or "" for i, cell in cells.items() if (m := kind.fullmatch(cell))}
            there = sorted([*found, *nothing]) if found else []
            places = {i: i for i in contacts} if {*there} & {*contacts} else {}
            if not places and len(there) == len(contacts):
                places = dict(zip(there, contacts, strict=True))
            known |= {places[i]: text for i, text in found.items() if i in places}
            unused |= {places[i] for i in nothing if i in places}
    travels_of, phases = stated.values()
    connected = {i: (travels_of[i], phases.get(i, "")) for i in travels_of.keys() - unused}
    return connected if travels_of else None
