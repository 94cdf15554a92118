"""Which columns of an unknown record are its clock and its travels, and the phases of these.

A column is a clock or a travel by its name or its unit. Without either, what rises in even steps is
a clock, and what moves between rests as a mass does is a travel.
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

STROKES = (2.0, 300.0)
"""Strokes, mm, of contacts and drives: of vacuum interrupters up to those of 800 kV."""

FAINT = 0.25
"""Share of the largest range, or of a stroke, below which a signal is that of another channel."""

FEWEST = 40
"""Samples of a column, at least; with fewer it lists results."""

_FEW = 0.05  # share of samples that may be damaged, and of a stroke within which a drive is at rest
_UNEVEN = 0.2  # of a step, by which times are off that are printed with few digits
_OSCILLATES = 6  # motions: no operating sequence has more

_LABELS = WORDS["labels"]
_TRANSDUCER = re.compile(rf"{words.any_of(_LABELS['transducer'])}\W{{0,2}}0*(\d+)", re.I)
_BREAK = re.compile(rf"({words.PHASE})?\W{{0,2}}{words.any_of(_LABELS['break'])}\W{{0,2}}\d*", re.I)
_NOT_CONNECTED = re.compile(words.any_of(_LABELS["not connected"]), re.I)


class InspectionError(ValueError):
    """A file for which no settings can be proposed; the message has the reason."""


class Clock(NamedTuple):
    """When the samples of a record were taken.

    Attributes:
        place: Column of the time; None where there is none.
        unit: Of that column; None where it is not known.
        rate: kHz; NaN where neither a column nor the header states it.
        remarks: What has to be looked at, in words.
        rank: How surely it is one: steps that are even, a unit, a name.
    """

    place: int | None
    unit: str | None
    rate: float
    remarks: tuple[str, ...] = ()
    rank: tuple[bool, ...] = ()

    @property
    def likely_rate(self) -> float:
        """The rate, kHz, or where there is none a usual one in its stead."""
        return float(np.sqrt(np.prod(RATES))) if np.isnan(self.rate) else self.rate


def find_clock(sheet: Sheet) -> Clock:
    """Find the column of the time, or the rate that stands for it.

    A column that is named a time is one, whether or not its steps are even.

    Raises:
        InspectionError: If the times fall, or begin anew.
    """
    stated = sheet.stated
    clocks = [clock for i in range(len(sheet.columns)) if (clock := _clock_in(sheet, i))]
    if not clocks:
        doubt = f"the rate is doubtful: {stated.rate_doubt}" if stated.rate_doubt else ""
        return Clock(None, None, stated.rate, (doubt,) if doubt else ())
    clock = max(clocks, key=lambda each: each.rank)
    column, times = sheet.column(clock.place), sheet.columns[clock.place]
    steps = np.diff(times := times[np.isfinite(times)])
    if np.quantile(steps, 1.0 - _FEW) < 0.0:
        raise InspectionError(
            f"{sheet.file}: its times, column {column!r}, fall from line to line; sort its lines "
            "by time"
        )
    if (anew := (steps < 0) & (np.abs(times[1:] - times[0]) <= 2 * np.median(steps))).any():
        raise InspectionError(
            f"{sheet.file}: its time begins anew after {anew.argmax() + 1} samples, so channels or "
            "records stand one below the other; export a column for each channel, and a file for "
            "each record"
        )
    rivals = [each for each in clocks if each.rank == clock.rank]
    if close := [each for each in rivals if not np.isclose(each.rate, clock.rate, equal_nan=True)]:
        lines = " or ".join(f"time_column: {sheet.column(each.place)}" for each in close)
        said = f"{column!r} is taken for the time; if it is another one, set {lines}"
        return clock._replace(remarks=(*clock.remarks, said))
    return clock


def _clock_in(sheet: Sheet, place: int) -> Clock | None:
    """The clock that a column is, if it is one."""
    unit, name, values = sheet.units[place], sheet.names[place], sheet.columns[place]
    times = values[np.isfinite(values)]
    if (unit and unit not in TO_MS) or times.size < max(FEWEST, values.size // 2):
        return None
    steps = np.diff(times)
    least, low, step, high, most = np.quantile(steps, (_FEW, 0.25, 0.5, 0.75, 1 - _FEW))
    called = words.holds(name, "time") and name.strip() != "T"  # which is a phase, as R and S are
    even = bool(least > 0.0 and high - low <= _UNEVEN * step)
    ordered = (least >= 0.0 or most <= 0.0) and times[-1] != times[0]
    first = place == 0 and least >= 0.0 < high  # as where each time stands twice
    counts = even and step == 1.0
    if not (unit or (called and ordered) or ((even or first) and not counts)):
        return None
    if not even:  # the first and the last time may be false
        step = abs(float(times[-2] - times[1])) / (times.size - 3) or np.nan
    rates = {each: 1.0 / (step * ms) for each, ms in TO_MS.items()}
    likely = [each for each, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
    remarks, rank = [], (even, unit is not None, called)
    if not unit:
        unit = next(iter(likely), None)
        of = f"those of {unit}" if unit else "of no recorder"
        remarks.append(f"the time's unit is not stated; steps of {in_digits(step, 4)} are {of}")
    if not even:
        ends = " to ".join(in_digits(float(each), 4) for each in (steps.min(), steps.max()))
        column = repr(sheet.column(place))
        remarks.append(f"the steps of the times in {column} are not even: {ends} {unit or ''}")
    clock = Clock(place, unit, rates.get(unit, np.nan), tuple(remarks), rank)
    return clock if unit or called else None


@dataclass(frozen=True)
class Travel:
    """A column that moves between rests.

    Attributes:
        place: Column.
        unit: As the settings call it; None where it is not stated.
        course: Its readings, and their motions ``(m,)``.
        phase: Its phase, empty where nothing states it.
    """

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
        return np.array([(each.before, each.after) for each in self.course.motions])

    @property
    def strokes(self) -> np.ndarray:
        """Way of each motion between the rests, ``(m,)``, in the unit of the reading."""
        return np.array([each.stroke for each in self.course.motions])

    @property
    def is_length(self) -> bool:
        """Whether strokes are possible: of whole counts, in a stated unit, or up to the longest."""
        whole = not np.nan_to_num(self.course.reading % 1.0).any()
        return bool(self.unit or whole or np.median(self.strokes) <= STROKES[1])

    @property
    def in_mm(self) -> float:
        """Usual stroke, mm of a length, or else in the unit of the reading."""
        return float(np.median(self.strokes)) * TO_MM.get(self.unit, 1.0)

    def part(self, k: int) -> tuple[int, int]:
        """First sample, and the one after the last, of the part with one motion alone."""
        at = self.course.middles
        ends = [0, *((at[1:] + at[:-1]) // 2).tolist(), self.course.smooth.size]
        return ends[k], ends[k + 1]

    def done(self, k: int) -> np.ndarray:
        """Shares of the way of a motion that are done, ``(t,)``."""
        before, after = self.rests[k]
        return (self.course.smooth - before) / (after - before)

    def begins(self, k: int) -> int:
        """Sample at which a motion has begun."""
        first, middle = self.part(k)[0], self.course.middles[k]
        resting = np.abs(self.done(k)[first : middle + 1]) <= 0.5 * _FEW
        return int(first + np.flatnonzero(resting)[-1]) if resting.any() else first

    def room(self, k: int) -> int:
        """Samples from the begin of a motion to that of the next one, or to the end."""
        return self.course.motions[k].end - 1 - self.begins(k)

    def arrives(self, k: int) -> int:
        """Sample from which on the travel is at rest for as long as it moved, or to the end."""
        begins, middle, end = self.begins(k), self.course.middles[k], self.course.motions[k].end
        moving = np.flatnonzero(np.abs(self.done(k)[middle:end] - 1.0) > _FEW)
        rests = np.diff(np.append(moving, np.inf)) > 2 * (middle - begins)
        return int(middle + moving[rests.argmax()] + 1)

    def is_of_drive(self) -> bool:
        """Return whether it moves between rests; what jumps is a contact, and what oscillates no
        operating sequence.
        """
        course = self.course
        if np.isfinite(course.reading).sum() < FEWEST or not course.moves:
            return False
        leaves, reaches, _ = course.crossings
        jumps = reaches - leaves < max(2, course.half // 2)  # a running median keeps them sharp
        if not 0 < leaves.size <= _OSCILLATES or jumps.any():
            return False
        return bool(self.strokes.min() > FAINT * np.ptp(course.smooth))

    def is_of_mass(self) -> bool:
        """Return whether a motion takes longer for its first tenth than for one of the next: a mass
        starts slowly, and a current rises fastest at first.
        """
        for k, middle in enumerate(self.course.middles.tolist()):
            back = self.done(k)[self.part(k)[0] : middle + 1][::-1]
            at = [-int((back <= share).argmax()) for share in np.arange(0.5 * _FEW, 0.5, 0.1)]
            first, *others = np.diff(at)
            if first > (1.0 + _UNEVEN) * min(others):
                return True
        return False


def find_travels(sheet: Sheet, clock: Clock) -> list[Travel]:
    """Find the columns that move between rests: those named a travel, or else all that do so as a
    mass does.
    """
    named, shaped = [], []
    for place, values in enumerate(sheet.columns):
        unit, name = sheet.units[place], sheet.names[place]
        if place == clock.place or unit not in (None, *TO_MM, "deg", "rad", "V", "counts", "%"):
            continue
        is_named = unit in (*TO_MM, "deg", "rad") or words.holds(name, "travel")
        if words.holds(name, "of no travel") and not is_named:
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
    """Return the columns of travel, those of them that are asked for, and remarks on the others.

    Poles of a breaker are alike: what moves by far less is left out, as by cross-talk.

    Raises:
        InspectionError: If none moves, or the channel is not one of them.
    """
    travels = find_travels(sheet, clock)
    if not travels:
        raise InspectionError(
            f"{sheet.file}: none of {len(sheet.columns)} columns moves between two rests as a "
            "drive does; did the breaker move, and is the record longer than the motion?"
        )
    likely = [each for each in travels if each.is_length] or travels
    most: dict[bool, float] = {}
    for each in likely:
        most[each.unit in TO_MM] = max(each.in_mm, most.get(each.unit in TO_MM, 0.0))
    kept = [each for each in likely if each.in_mm >= FAINT * most[each.unit in TO_MM]]
    columns = {each.place: sheet.column(each.place) for each in travels}
    if channel:
        asked = [t for t in travels if channel in (sheet.names[t.place], str(t.place + 1))]
        asked = asked or [t for t in travels if channel == str(columns[t.place])]
        if not asked:
            listed = ", ".join(map(repr, columns.values()))
            reason = f"{channel!r} is no column of travel; there are {listed}"
            raise InspectionError(f"{sheet.file}: {reason}")
        every = _with_phases(sheet, kept if asked[0] in kept else asked)
        return every, [each for each in every if each.place == asked[0].place], []
    remarks, used = [], _with_phases(sheet, kept)
    if unused := [f"{columns[t.place]!r}" for t in travels if t not in kept]:
        remarks.append(
            f"{', '.join(unused)} moved by no stroke, or by far less than the others: not used, as "
            "by cross-talk; if one is a travel, choose it by --channel"
        )
    named = any(t.unit or words.holds(sheet.names[t.place], "travel") for t in used)
    if len(used) > 1 and not named:
        lines = " or ".join(f"travel_column: {columns[each.place]}" for each in used)
        remarks.append(f"no column is named a travel, and {len(used)} move as one: set {lines}")
    return used, used, remarks


def _with_phases(sheet: Sheet, travels: Sequence[Travel]) -> list[Travel]:
    """Travels with their phase: by their name, or else as stated for their number or order, or for
    their contacts; or else in their order where the name of the file lists as many.
    """
    phases, places = dict(sheet.stated.phases), {each.place for each in travels}
    names = ["" if i in places else name for i, name in enumerate(sheet.names)]
    for number, phase in (stated_contacts(sheet.preamble, names) or {}).values():
        if phase:
            phases.setdefault(int(number), phase)
    in_name = [] if phases else words.listed_in(sheet.file.stem)
    found = []
    for order, each in enumerate(travels, start=1):
        name = sheet.names[each.place]
        stated = phases.get(words.channel_of(name) or order, phases.get(0, ""))
        if len(in_name) == len(travels):
            stated = in_name[order - 1]
        found.append(replace(each, phase=words.phase_in(name) or stated))
    return found


def stated_contacts(
    rows: Iterable[Sequence[str]], names: Sequence[str]
) -> Mapping[int, tuple[str, str]] | None:
    """Return the number of the travel and the phase of each contact that is connected, by column.

    One row names the transducer of each contact (``TR1``), one the phase and the number of its
    break (``YBreak2``, or ``NA`` where nothing is connected). Cells stand above their columns, or
    are as many as these, in the same order. None where no row states transducers.

    Args:
        rows: Cells of the lines above the columns, in their order.
        names: Of the columns, empty where one is a travel.
    """
    ways = [words.split_unit(name)[1] in TO_MM for name in names]  # `Contact Travel T2 (mm)`
    contacts = [i for i, name in enumerate(names) if words.holds(name, "contact") and not ways[i]]
    contacts = contacts or [i for i, name in enumerate(names) if words.holds(name, "resistance")]
    stated: dict[re.Pattern, dict[int, str]] = {_TRANSDUCER: {}, _BREAK: {}}
    apart: set[int] = set()
    for row in rows:
        cells = [cell.strip() for cell in row]
        nothing = [i for i, cell in enumerate(cells) if _NOT_CONNECTED.fullmatch(cell)]
        for kind, known in stated.items():
            found = {i: m[1] or "" for i, cell in enumerate(cells) if (m := kind.fullmatch(cell))}
            there = sorted([*found, *nothing]) if found else []
            places = {}
            if {*there} & {*contacts}:
                places = {i: i for i in contacts}
            elif len(there) == len(contacts):
                places = dict(zip(there, contacts, strict=True))
            known |= {places[i]: text for i, text in found.items() if i in places}
            apart |= {places[i] for i in nothing if i in places}
    travels, phases = stated.values()
    there = {i: (travels[i], phases.get(i, "")) for i in travels.keys() - apart}
    return there if travels else None
