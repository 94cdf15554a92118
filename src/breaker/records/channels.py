"""Which columns of an unknown record are its clock and its travels, and the phases of these.

A column is a clock or a travel by its name or its unit. Without either, what rises in even steps is
a clock, and what moves between rests as a mass does is a travel.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.layout import Layout
from breaker.records.lexicon import WORDS
from breaker.records.motion import Course
from breaker.records.settings import RATES, TO_MM, TO_MS
from breaker.records.words import (
    PHASE,
    any_of,
    channel_of,
    holds,
    listed_in,
    phase_in,
    split_unit,
)

STROKES = (2.0, 300.0)
"""Strokes, mm, of contacts and drives: of vacuum interrupters up to those of 800 kV."""

FAINT = 0.25
"""Share of the largest range, or of a stroke, below which a signal is one of another channel: poles
of a breaker are alike."""

FEWEST = 40
"""Samples of a column, at least; with fewer it lists results."""

_FEW = 0.05  # share of samples that may be damaged, and of a stroke within which a drive is at rest
_UNEVEN = 0.2  # of a step, by which times are off that are printed with few digits
_OSCILLATES = 6  # motions: no operating sequence has more

_TRAVEL_UNITS = frozenset([*TO_MM, "deg", "rad", "V", "counts", "%"])
_TRANSDUCER = re.compile(rf"{any_of(WORDS['labels']['transducer'])}\W{{0,2}}0*(\d+)", re.I)
_BREAK = re.compile(rf"({PHASE})?\W{{0,2}}{any_of(WORDS['labels']['break'])}\W{{0,2}}\d*", re.I)
_NOT_CONNECTED = re.compile(any_of(WORDS["labels"]["not connected"]), re.I)


class InspectionError(ValueError):
    """A file for which no settings can be proposed; the message has the reason."""


@dataclass(frozen=True)
class Clock:
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
    rank: tuple[bool, bool, bool] = (False, False, False)

    @property
    def likely_rate(self) -> float:
        """The rate, kHz, or where there is none a usual one in its stead."""
        return float(np.sqrt(RATES[0] * RATES[1])) if np.isnan(self.rate) else self.rate


def find_clock(sheet: Layout) -> Clock:
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
    _check_order(sheet, clock.place)
    remarks = [*clock.remarks]
    rivals = (each for each in clocks if each.rank == clock.rank)
    if close := [each for each in rivals if not np.isclose(each.rate, clock.rate, equal_nan=True)]:
        lines = " or ".join(f"time_column: {sheet.column(each.place)}" for each in close)
        remarks.append(f"{sheet.column(clock.place)!r} is taken for the time; if not, set {lines}")
    return replace(clock, remarks=tuple(remarks))


def _clock_in(sheet: Layout, place: int) -> Clock | None:
    """The clock that a column is, if it is one."""
    unit, name, values = sheet.units[place], sheet.names[place], sheet.columns[place]
    times = values[np.isfinite(values)]
    if (unit and unit not in TO_MS) or times.size < max(FEWEST, values.size // 2):
        return None
    steps = np.diff(times)
    least, low, step, high, most = np.quantile(steps, (_FEW, 0.25, 0.5, 0.75, 1 - _FEW))
    called = holds(name, "time") and name.strip() != "T"  # which is a phase, as R and S are
    ordered = (least >= 0.0 or most <= 0.0) and times[-1] != times[0]
    even = bool(least > 0.0 and high - low <= _UNEVEN * step)
    is_clock = even and (called or step != 1.0)  # or else it counts the samples
    rises = place == 0 and least >= 0.0 < high and not even  # as where each time stands twice
    if not (unit or is_clock or (called and ordered) or rises):
        return None
    if not even:  # the first and the last time may be false
        step = abs(float(times[-2] - times[1])) / (times.size - 3) or np.nan
    rates = {each: 1.0 / (step * ms) for each, ms in TO_MS.items()}
    likely = [unit] if unit else [e for e, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
    if not (likely or called):
        return None
    remarks, unit = [], likely[0] if likely else None
    if not sheet.units[place]:
        of = f"those of {unit}" if unit else "of no recorder"
        remarks.append(f"the time's unit is not stated; steps of {in_digits(step, 4)} are {of}")
    if not even:
        ends = " to ".join(in_digits(float(each), 4) for each in (steps.min(), steps.max()))
        column = repr(sheet.column(place))
        remarks.append(f"the steps of the times in {column} are not even: {ends} {unit or ''}")
    rank = even, sheet.units[place] is not None, called
    return Clock(place, unit, rates.get(unit, np.nan), tuple(remarks), rank)


def _check_order(sheet: Layout, place: int) -> None:
    """Refuse times that fall, or begin anew."""
    time = sheet.columns[place][np.isfinite(sheet.columns[place])]
    steps = np.diff(time)
    if np.quantile(steps, 1.0 - _FEW) < 0.0:
        column = sheet.column(place)
        raise InspectionError(
            f"{sheet.file}: its times, column {column!r}, fall from line to line; sort its lines "
            "by time"
        )
    anew = (steps < 0) & (np.abs(time[1:] - time[0]) <= 2 * np.median(steps))
    if anew.any():
        raise InspectionError(
            f"{sheet.file}: its time begins anew after {anew.argmax() + 1} samples, so channels or "
            "records stand one below the other; export a column for each channel, and a file for "
            "each record"
        )


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


def find_travels(sheet: Layout, clock: Clock) -> list[Travel]:
    """Find the columns that move between rests: those named a travel, or else all that do so as a
    mass does.
    """
    named, shaped = [], []
    for place, values in enumerate(sheet.columns):
        unit, name = sheet.units[place], sheet.names[place]
        if place == clock.place or (unit and unit not in _TRAVEL_UNITS):
            continue
        is_named = unit in TO_MM or unit in ("deg", "rad") or holds(name, "travel")
        if holds(name, "of no travel") and not is_named:
            continue
        reading = np.where(np.isfinite(values), values, np.nan)
        travel = Travel(place, unit, Course(np.arange(values.size) / clock.likely_rate, reading))
        if _moves_between_rests(travel) and (is_named or _is_of_mass(travel)):
            (named if is_named else shaped).append(travel)
    return named or shaped


def _moves_between_rests(travel: Travel) -> bool:
    course = travel.course
    if np.isfinite(course.reading).sum() < FEWEST or not course.moves:
        return False
    leaves, reaches, _ = course.crossings
    # A running median keeps a jump, as of a contact, sharp.
    jumps = reaches - leaves < max(2, course.half // 2)
    if not 0 < leaves.size <= _OSCILLATES or jumps.any():
        return False
    return bool(travel.strokes.min() > FAINT * np.ptp(course.smooth))


def _is_of_mass(travel: Travel) -> bool:
    """Whether a motion takes longer for its first tenth than for one of the next: a mass starts
    slowly, and a current rises fastest at first. One motion is enough: before another, the drive
    may still creep to its rest.
    """
    for k, middle in enumerate(travel.course.middles.tolist()):
        back = travel.done(k)[travel.part(k)[0] : middle + 1][::-1]
        at = [-int((back <= share).argmax()) for share in np.arange(0.5 * _FEW, 0.5, 0.1)]
        first, *others = np.diff(at)
        if first > (1.0 + _UNEVEN) * min(others):
            return True
    return False


def chosen_travels(
    sheet: Layout, clock: Clock, channel: str
) -> tuple[list[Travel], list[Travel], list[str]]:
    """Return the columns of travel, those of them that are asked for, and remarks on the others.

    Raises:
        InspectionError: If none moves, or the channel is not one of them.
    """
    file = sheet.file
    travels = find_travels(sheet, clock)
    if not travels:
        raise InspectionError(
            f"{file}: none of {len(sheet.columns)} columns moves between two rests as a drive "
            "does; did the breaker move, and is the record longer than the motion?"
        )
    unused = _unused_among(travels)
    used = [each for each in travels if each not in unused]
    if not channel:
        used = _with_phases(sheet, used)
        return used, used, _remarks(sheet, unused, used)
    for each in travels:
        column = sheet.column(each.place)
        if channel in (sheet.names[each.place], str(column), str(each.place + 1)):
            every = _with_phases(sheet, used if each in used else [each])
            return every, [one for one in every if one.place == each.place], []
    listed = ", ".join(repr(sheet.column(travel.place)) for travel in travels)
    raise InspectionError(f"{file}: {channel!r} is no column of travel; there are {listed}")


def _unused_among(travels: Sequence[Travel]) -> list[Travel]:
    """Columns whose way is no stroke in any unit of length, or that of cross-talk, where others'
    are not.
    """
    unused = [each for each in travels if _is_other(each)]
    unused = unused if len(unused) < len(travels) else []
    left = [each for each in travels if each not in unused]
    ways = [(t.unit in TO_MM, np.median(t.strokes) * TO_MM.get(t.unit, 1.0)) for t in left]
    most = {kind: max(way for k, way in ways if k == kind) for kind, _ in ways}
    faint = (t for t, (k, way) in zip(left, ways, strict=True) if way < FAINT * most[k])
    return [*unused, *faint]


def _is_other(travel: Travel) -> bool:
    """Whether readings without a unit are neither whole counts nor of a stroke in mm."""
    whole = not np.nan_to_num(travel.course.reading % 1.0).any()
    return travel.unit is None and not whole and bool(np.median(travel.strokes) > STROKES[1])


def _remarks(sheet: Layout, unused: Sequence[Travel], used: Sequence[Travel]) -> list[str]:
    """What to look at: columns that are left out, and which to choose where none is named."""
    remarks = []
    if unused:
        names = ", ".join(repr(sheet.column(each.place)) for each in unused)
        ways = (max((each.strokes.max() for each in of), default=0.0) for of in (unused, used))
        least, most = (in_digits(float(way), 4) for way in ways)
        remarks.append(
            f"{names} moved by up to {least} beside {most}: not used, as by cross-talk or of "
            "another quantity; if one is a travel, choose it by --channel"
        )
    if len(used) > 1 and not any(t.unit or holds(sheet.names[t.place], "travel") for t in used):
        lines = " or ".join(f"travel_column: {sheet.column(each.place)}" for each in used)
        remarks.append(f"no column is named a travel, and {len(used)} move as one: set {lines}")
    return remarks


def _with_phases(sheet: Layout, travels: Sequence[Travel]) -> list[Travel]:
    """Travels with their phase: by their name, or else as stated for their number or order, or for
    their contacts; or else in their order where the name of the file lists as many.
    """
    phases, places = dict(sheet.stated.phases), {each.place for each in travels}
    names = ["" if i in places else name for i, name in enumerate(sheet.names)]
    for number, phase in (stated_contacts(sheet.preamble, names) or {}).values():
        if phase:
            phases.setdefault(int(number), phase)
    in_name = [] if phases else listed_in(sheet.file.stem)
    found = []
    for order, each in enumerate(travels, start=1):
        name = sheet.names[each.place]
        stated = phases.get(channel_of(name) or order, phases.get(0, ""))
        if len(in_name) == len(travels):
            stated = in_name[order - 1]
        found.append(replace(each, phase=phase_in(name) or stated))
    return found


def stated_contacts(
    rows: Iterable[Sequence[str]], names: Sequence[str]
) -> Mapping[int, tuple[str, str]] | None:
    """Return the number of the travel and the phase of each contact that is connected.

    One row names the transducer of each contact (``TR1``), one the phase and the number of its
    break (``YBreak2``, or ``NA`` where nothing is connected).

    Args:
        rows: Cells of the lines above the columns, in their order.
        names: Of the columns, empty where one is a travel.

    Returns:
        By column; the phase as it stands there, empty where it is not stated. None where no row
        states which travel a contact belongs to.
    """
    ways = [split_unit(name)[1] in TO_MM for name in names]  # as of `Contact Travel T2 (mm)`
    contacts = [i for i, name in enumerate(names) if holds(name, "contact") and not ways[i]]
    contacts = contacts or [i for i, name in enumerate(names) if holds(name, "resistance")]
    stated: dict[re.Pattern, dict[int, str]] = {_TRANSDUCER: {}, _BREAK: {}}
    apart: set[int] = set()
    for row in rows:
        cells = [cell.strip() for cell in row]
        for kind, known in stated.items():
            found = {i: m[1] or "" for i, cell in enumerate(cells) if (m := kind.fullmatch(cell))}
            nothing = [i for i, cell in enumerate(cells) if _NOT_CONNECTED.fullmatch(cell)]
            places = _placed([*found, *nothing], contacts) if found else {}
            known |= {places[i]: text for i, text in found.items() if i in places}
            apart |= {places[i] for i in nothing if i in places}
    travels, phases = stated.values()
    if not travels:
        return None
    return {place: (travels[place], phases.get(place, "")) for place in travels.keys() - apart}


def _placed(cells: Sequence[int], contacts: Sequence[int]) -> dict[int, int]:
    """Columns of contacts by the places of cells: where they stand, or else in their order where
    there are as many.
    """
    if set(cells) & set(contacts):
        return {i: i for i in cells if i in contacts}
    return dict(zip(sorted(cells), contacts, strict=True)) if len(cells) == len(contacts) else {}
