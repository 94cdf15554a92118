"""Which columns of an unknown record are times and travels: its clock, its channels, their phases.

A travel moves between rests as a drive does. Rows above the columns of an analyser may state which
travel and phase a contact belongs to: one names the transducer of each (``TR1``), one the phase and
the number of its break (``YBreak2``, or ``NA`` where nothing is connected). Such rows are aligned
with the columns of contacts.

Guessing, to propose settings: see ``file_contents``.
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

_USUAL = 10.0  # kHz
_OFF = 0.02  # share by which a stated rate may differ from that of the times

_TRAVEL_UNITS = frozenset([*TO_MM, "deg", "rad", "V", "counts", "%"])

# Of the way: the first of these takes longer than one of the others where a mass is set in motion.
# Than the next one even where a drive is fastest early, as in an opening with strong springs.
_BEGINS = (0.03, 0.12)
_LATER = ((0.12, 0.21), (0.4, 0.49))
_GENTLE = 1.2  # times
_UNUSED = 0.25  # of the largest stroke: poles of a breaker are alike, cross-talk is smaller
_LONGEST = 400.0  # mm, a stroke
_FEWEST = 40  # samples
_LEAST = 0.2  # of the range of a record, between two rests
_MOST = 6  # motions in a record; more are an oscillation
_BEGUN, _ARRIVED = 0.02, 0.05  # of the way

_TRANSDUCER = re.compile(rf"{any_of(WORDS['labels']['transducer'])}\W{{0,2}}0*(\d+)", re.I)
_BREAK = re.compile(rf"({PHASE})?\W{{0,2}}{any_of(WORDS['labels']['break'])}\W{{0,2}}\d*", re.I)
_NOT_CONNECTED = re.compile(any_of(WORDS["labels"]["not connected"]), re.I)


@dataclass(frozen=True)
class Clock:
    """When the samples of a record were taken.

    Attributes:
        place: Column of the time; None where there is none that can be read.
        unit: Of that column.
        rate: kHz; nan where neither a column nor the preamble states it.
        remarks: What has to be looked at, in words.
    """

    place: int | None
    unit: str | None
    rate: float
    remarks: tuple[str, ...] = ()

    @property
    def likely_rate(self) -> float:
        """The rate, kHz, or where there is none a usual one in its stead."""
        return _USUAL if np.isnan(self.rate) else self.rate


def find_clock(layout: Layout) -> Clock:
    """Find the column of the time, or the rate that stands for it."""
    stated = layout.stated
    found = [clock for i in range(len(layout.columns)) if (clock := _time_in(layout, i))]
    if not found:
        said = [f"the rate is doubtful: {stated.rate_doubt}"] if stated.rate_doubt else []
        said += _unread_times(layout)
        return Clock(None, None, stated.rate, tuple(said))
    clock = max(found, key=lambda clock: _likely_time(layout, clock))
    if not abs(stated.rate / clock.rate - 1.0) > _OFF:
        return clock
    said, seen = (in_digits(rate, 6) for rate in (stated.rate, clock.rate))
    both = f"the text states {said} kHz, but the times are those of {seen} kHz"
    return replace(clock, remarks=(*clock.remarks, both))


def _unread_times(layout: Layout) -> list[str]:
    """What to say of columns that are called times and do not rise as these do."""
    pairs = enumerate(zip(layout.names, layout.units, strict=True))
    named = [i for i, (name, unit) in pairs if unit in TO_MS or holds(name, "time")]
    columns = ", ".join(repr(layout.column(i)) for i in named)
    return [f"the times of {columns} do not rise in even steps: not read"] if named else []


def _likely_time(layout: Layout, clock: Clock) -> tuple[bool, bool]:
    """Whether a clock has a unit, and a name of the time: the more, the better."""
    return layout.units[clock.place] in TO_MS, holds(layout.names[clock.place], "time")


def _time_in(layout: Layout, place: int) -> Clock | None:
    """What a column says of the time, if it is one: it rises in even steps."""
    unit, name = layout.units[place], layout.names[place]
    values = layout.columns[place][np.isfinite(layout.columns[place])]
    if values.size < max(20, 0.5 * layout.columns[place].size) or (unit and unit not in TO_MS):
        return None
    steps = np.diff(values)
    step = float(np.median(steps))
    timely = unit is not None or holds(name, "time")
    if values[-1] <= values[0] or (steps < 0).mean() > 0.01:
        return None
    if not (step > 0 and (np.abs(steps - step) <= 0.2 * step).mean() > 0.9):
        return None
    units = [unit] if unit else _units_of(step)
    if not units or (step == 1 and not timely):  # it counts the samples
        return None
    how = f"the time's unit is not stated; steps of {in_digits(step, 4)} are those of {units[0]}"
    return Clock(place, units[0], 1.0 / (step * TO_MS[units[0]]), () if unit else (how,))


def falling_times(layout: Layout) -> str | int | None:
    """Return the column whose times fall from line to line; None if there is none."""
    back = replace(layout, columns=[each[::-1] for each in layout.columns])
    fall = (i for i in range(len(back.columns)) if _time_in(back, i))
    return next(map(layout.column, fall), None)


def _units_of(step: float) -> list[str]:
    """The unit of time in which a step is one of a recorder; one or none."""
    return [u for u, ms in TO_MS.items() if RATES[0] <= 1.0 / (step * ms) <= RATES[1]][:1]


class InspectionError(ValueError):
    """A file for which no settings can be proposed; the message has the reason."""


@dataclass(frozen=True)
class Travel:
    """A column that moves between rests.

    Attributes:
        place: Column.
        unit: As the settings call it; None where it is not stated.
        course: Its readings, and their motions ``(m,)``.
        phase: Its phase, empty where nothing says it.
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

    def goes_over(self, k: int) -> float:
        """Share of the way by which a motion goes beyond its rest."""
        return float(self.done(k)[self.course.middles[k] : self.part(k)[1]].max() - 1.0)

    def begins(self, k: int) -> int:
        """Sample at which a motion has begun."""
        first, middle = self.part(k)[0], self.course.middles[k]
        resting = np.abs(self.done(k)[first : middle + 1]) <= _BEGUN
        return int(first + np.flatnonzero(resting)[-1]) if resting.any() else first

    def room(self, k: int) -> int:
        """Samples from the begin of a motion to that of the next one, or to the end."""
        return self.course.motions[k].end - 1 - self.begins(k)

    def arrives(self, k: int, still: int) -> int:
        """Sample from which on the travel stays at rest, for as many samples as given, or to the
        end.
        """
        bounds = [*self.course.middles.tolist(), self.course.smooth.size]
        moving = np.abs(self.done(k)[bounds[k] : bounds[k + 1]] - 1.0) > _ARRIVED
        begins = np.flatnonzero(~moving & np.append(True, moving[:-1]))
        ends = np.flatnonzero(~moving & np.append(moving[1:], True)) + 1
        long = (ends - begins >= still) | (ends == moving.size)
        return int(bounds[k] + (begins[long][0] if long.any() else moving.size))


def find_travels(layout: Layout, clock: Clock) -> list[Travel]:
    """Find the columns that move between rests as a drive does; currents do not."""
    rate = min(clock.likely_rate, RATES[1])
    named, shaped = [], []
    for place, values in enumerate(layout.columns):
        unit, name = layout.units[place], layout.names[place]
        if place == clock.place or (unit and unit not in _TRAVEL_UNITS):
            continue
        says = unit in TO_MM or unit in ("deg", "rad") or holds(name, "travel")
        if holds(name, "of no travel") and not says:
            continue
        reading = np.where(np.isfinite(values), values, np.nan)
        travel = Travel(place, unit, Course(np.arange(values.size) / rate, reading))
        if _moves_between_rests(travel) and (says or _is_gentle(travel)):
            (named if says else shaped).append(travel)
    return named or shaped


def chosen_travels(
    layout: Layout, clock: Clock, channel: str
) -> tuple[list[Travel], list[Travel], list[str]]:
    """Return the columns of travel, those of them that are asked for, and what is left out."""
    file = layout.file
    if clock.place is not None:
        time = layout.columns[clock.place]
        time = time[np.isfinite(time)]
        steps = np.diff(time)
        anew = (steps < 0) & (np.abs(time[1:] - time[0]) <= 2 * np.median(steps))
        if anew.any():
            raise InspectionError(
                f"{file}: its time begins anew after {anew.argmax() + 1} samples, so channels or "
                "records stand one below the other; export a column for each channel, and a file "
                "for each record"
            )
    elif (column := falling_times(layout)) is not None:
        raise InspectionError(
            f"{file}: its times, column {column!r}, fall from line to line; sort its lines by time"
        )
    travels = find_travels(layout, clock)
    if not travels:
        raise InspectionError(
            f"{file}: none of {len(layout.columns)} columns moves between two rests as a drive "
            "does; did the breaker move, and is the record longer than the motion?"
        )
    unused = _unused_among(travels)
    used = [each for each in travels if each not in unused]
    if not channel:
        used = _with_phases(layout, used)
        return used, used, _remarks(layout, unused, used)
    for each in travels:
        column = layout.column(each.place)
        if channel in (layout.names[each.place], str(column), str(each.place + 1)):
            every = _with_phases(layout, used if each in used else [each])
            return every, [one for one in every if one.place == each.place], []
    listed = ", ".join(repr(layout.column(travel.place)) for travel in travels)
    raise InspectionError(f"{file}: {channel!r} is no column of travel; there are {listed}")


def _remarks(layout: Layout, unused: Sequence[Travel], used: Sequence[Travel]) -> list[str]:
    """What to say of columns that are not used."""
    names = ", ".join(repr(layout.column(each.place)) for each in unused)
    ways = (max((each.strokes.max() for each in of), default=0.0) for of in (unused, used))
    least, most = (in_digits(float(way), 4) for way in ways)
    said = f"{names} moved by up to {least} beside {most}: not used, as by cross-talk or of another"
    said += " quantity; if one is a travel, choose it by --channel"
    return [said] if unused else []


def _with_phases(layout: Layout, travels: Sequence[Travel]) -> list[Travel]:
    """Travels with their phase: by their name, or else as stated for their number or order, or for
    their contacts; or else in their order where the name of the file lists as many.
    """
    phases, places = dict(layout.stated.phases), {each.place for each in travels}
    names = ["" if i in places else name for i, name in enumerate(layout.names)]
    for number, phase in (stated_contacts(layout.preamble, names) or {}).values():
        if phase:
            phases.setdefault(int(number), phase)
    in_name = [] if phases else listed_in(layout.file.stem)
    found = []
    for order, each in enumerate(travels, start=1):
        name = layout.names[each.place]
        stated = phases.get(channel_of(name) or order, phases.get(0, ""))
        if len(in_name) == len(travels):
            stated = in_name[order - 1]
        found.append(replace(each, phase=phase_in(name) or stated))
    return found


def _unused_among(travels: Sequence[Travel]) -> list[Travel]:
    """Return the columns that are of another quantity than the others, or whose way is that of
    cross-talk beside them.
    """
    unused = [each for each in travels if _is_other(each)]
    unused = unused if len(unused) < len(travels) else []
    ways = [
        (each.unit in TO_MM, float(np.median(each.strokes)) * TO_MM.get(each.unit, 1.0))
        for each in travels
    ]
    for each, (kind, way) in zip(travels, ways, strict=True):
        pairs = zip(travels, ways, strict=True)
        others = [w for t, (k, w) in pairs if k == kind and t not in unused]
        if others and way < _UNUSED * max(others):
            unused.append(each)
    return unused


def _is_other(travel: Travel) -> bool:
    """Whether readings without a unit are neither whole counts nor of a stroke in mm."""
    whole = not np.nan_to_num(travel.course.reading % 1.0).any()
    return travel.unit is None and not whole and bool(np.median(travel.strokes) > _LONGEST)


def _moves_between_rests(travel: Travel) -> bool:
    course = travel.course
    if np.isfinite(course.reading).sum() < _FEWEST or not course.moves:
        return False
    leaves, reaches, _ = course.crossings
    # A running median keeps a jump, as of a contact, sharp.
    jumps = reaches - leaves < max(2, course.half // 2)
    if not 0 < leaves.size <= _MOST or jumps.any():
        return False
    return bool(travel.strokes.min() > _LEAST * np.ptp(course.smooth))


def _is_gentle(travel: Travel) -> bool:
    """Whether a motion begins as that of a mass, slowly; a current rises fastest at first.

    One is enough: before another, the drive may still creep to its rest.
    """
    for k, middle in enumerate(travel.course.middles.tolist()):
        back = travel.done(k)[travel.part(k)[0] : middle + 1][::-1]
        times = [
            int((back <= start).argmax()) - int((back <= end).argmax())
            for start, end in (_BEGINS, *_LATER)
        ]
        if times[0] >= _GENTLE * min(times[1:]):
            return True
    return False


def stated_contacts(
    rows: Iterable[Sequence[str]], names: Sequence[str]
) -> Mapping[int, tuple[str, str]] | None:
    """Return the number of the travel and the phase of each contact that is connected.

    Args:
        rows: Cells of the lines above the columns, in their order.
        names: Of the columns, empty where one is a travel.

    Returns:
        By column; the phase as it stands there, empty where it is not stated. None where no row
        says which travel a contact belongs to.
    """
    ways = [split_unit(name)[1] in TO_MM for name in names]  # as of `Contact Travel T2 (mm)`
    contacts = [i for i, name in enumerate(names) if holds(name, "contact") and not ways[i]]
    contacts = contacts or [i for i, name in enumerate(names) if holds(name, "resistance")]
    travels: dict[int, str] = {}
    phases: dict[int, str] = {}
    apart: set[int] = set()
    for row in rows:
        cells = {i: cell.strip() for i, cell in enumerate(row) if cell.strip()}
        of_travel = {i: m[1] for i, cell in cells.items() if (m := _TRANSDUCER.fullmatch(cell))}
        of_break = {i: m for i, cell in cells.items() if (m := _BREAK.fullmatch(cell))}
        nothing = {i for i, cell in cells.items() if _NOT_CONNECTED.fullmatch(cell)}
        if of_travel:
            places = _placed([*of_travel, *nothing], contacts)
            travels |= {places[i]: number for i, number in of_travel.items() if i in places}
        elif of_break:
            places = _placed([*of_break, *nothing], contacts)
            phases |= {places[i]: (m[1] or "") for i, m in of_break.items() if i in places}
        else:
            continue
        apart |= {places[i] for i in nothing if i in places}
    if not travels:
        return None
    there = travels.keys() - apart
    return {place: (travels[place], phases.get(place, "")) for place in there}


def _placed(cells: Sequence[int], contacts: Sequence[int]) -> dict[int, int]:
    """Columns of contacts by the places of cells: where they stand, or else in their order where
    there are as many.
    """
    if set(cells) & set(contacts):
        return {i: i for i in cells if i in contacts}
    return dict(zip(sorted(cells), contacts, strict=True)) if len(cells) == len(contacts) else {}
