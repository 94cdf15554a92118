"""Find the clock, the travels, and the contacts and coils of each travel in the columns.

The unit or the name of a column shows a clock or a travel. Without both, a column that rises in
even steps is a clock, and a column that moves between rests is a travel. A contact is a column of a
contact, or of the resistance across it, whose reading changes; a current or an auxiliary switch is
not. Rows above the columns, phase or number assign a contact to a travel; a coil also its time.
"""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.parameters import MOTIONS
from breaker.records import words
from breaker.records.contacts import LEAST
from breaker.records.files import RejectedCurveError
from breaker.records.motion import Course
from breaker.records.rejections import FEWEST
from breaker.records.settings import RATES, TO_MM, TO_MS
from breaker.records.sheet import Sheet
from breaker.records.words import holds

FAINT = 0.25
"""Share of the largest range of its kind below which a signal is cross-talk."""

_UNEVEN = 0.2  # largest variation of even steps, as a share of a step: from rounding of times
_OSCILLATES = 6  # largest number of motions of a drive: no sequence of IEC 62271-100 has more
_COIL = 20.0  # A, largest current of a coil; tests of resistance use more
_LENGTHS = (*TO_MM, "deg", "rad")  # units that only travels have
_READINGS = (None, *_LENGTHS, "V", "counts", "%")  # units that a travel may have
_KINDS = ("contact", "resistance")  # kinds of contact columns, the preferred one first

_LABELS = {key: words.any_of(spelt) for key, spelt in words.WORDS["labels"].items()}
_OF_CONTACT = re.compile(
    rf"(?P<none>{_LABELS['not connected']})|{_LABELS['transducer']}\W{{0,2}}0*(?P<number>\d+)"
    rf"|(?P<phase>{words.PHASE})?\W{{0,2}}{_LABELS['break']}\W{{0,2}}\d*",
    re.I,
)
_LETTER = r"[^\W\d_]"
_PHASES = re.compile(rf"(?<!{_LETTER})({words.COLUMN_PHASE})(?!{_LETTER})")
# Not a number or phase: units, and C1 and T1 of coils.
_NO_MARKS = re.compile(r"[\[(].*?[\])]|\b[cCtT](?=\d)")


class Clock(NamedTuple):
    """Column or rate of the time of a record; the rate, kHz, is NaN where it is not known."""

    place: int | None
    unit: str | None
    rate: float
    remarks: tuple[str, ...] = ()

    @property
    def likely_rate(self) -> float:
        """Rate, kHz; a usual one where the rate is not known."""
        return float(np.sqrt(np.prod(RATES))) if np.isnan(self.rate) else self.rate


def find_clock(sheet: Sheet) -> Clock:
    """Find the column of the time, or the rate that replaces it; reject times that decrease."""
    clocks = {}  # by evidence: even steps, a unit, a name
    for place in reversed(range(len(sheet.columns))):
        clocks |= _clock_in(sheet, place)
    if not clocks:
        return Clock(None, None, sheet.stated.rate)
    clock = clocks[max(clocks)]
    times = sheet.columns[clock.place]
    falls = np.flatnonzero(np.diff(times[np.isfinite(times)]) < 0.0)
    if falls.size:
        reason = f"its time, column {sheet.column(clock.place)!r}, falls or begins again after "
        remedy = "sort its lines by time, and export a column a channel and a file a record"
        raise RejectedCurveError(sheet.file, f"{reason}{falls[0] + 1} samples; {remedy}")
    return clock


def _clock_in(sheet: Sheet, place: int) -> dict[tuple[bool, ...], Clock]:
    """Return a column as a clock by its evidence; empty if it is none, such as a count."""
    unit, name, values = sheet.units[place], sheet.names[place], sheet.columns[place]
    times = values[np.isfinite(values)]
    if (unit and unit not in TO_MS) or not _is_long(values) or times.size < values.size // 2:
        return {}
    low, step, high = np.quantile(np.diff(times), (0.25, 0.5, 0.75))
    named = holds(name, "time") and name.strip() != "T"  # T is a phase, as R and S are
    even = bool(low > 0.0 and high - low <= _UNEVEN * step)
    if not (unit or named or (even and step != 1.0)) or times[-1] == times[0]:
        return {}
    step = step if even else abs(times[-1] - times[0]) / (times.size - 1)
    rates = {known: float(1.0 / (step * ms)) for known, ms in TO_MS.items()}
    likely = [known for known, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
    evidence, remarks = (even, unit is not None, named), ()
    if not (unit or likely or named):
        return {}
    if not unit:
        unit = next(iter(likely), None)
        fit = unit or "no recorder"
        remarks = (f"the time's unit is not stated; steps of {in_digits(step, 4)} fit {fit}",)
    return {evidence: Clock(place, unit, rates.get(unit, np.nan), remarks)}


def _is_long(values: np.ndarray) -> bool:
    """Return whether a column has samples of two rests and a motion; shorter ones are results."""
    return bool(np.isfinite(values).sum() >= 3 * FEWEST)


@dataclass(frozen=True)
class Travel:
    """Column that moves between rests in m motions, with unit and phase where they are stated."""

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
        return np.array([motion.stroke for motion in self.course.motions])

    def part(self, k: int) -> tuple[int, int]:
        """Return the part that contains only motion k: its first sample, and the last plus one."""
        middles = self.course.middles
        ends = [0, *((middles[1:] + middles[:-1]) // 2).tolist(), self.course.smooth.size]
        return ends[k], ends[k + 1]

    def moves(self, k: int) -> tuple[int, int]:
        """Return the last sample at rest before motion k, and the first sample at rest after it."""
        (before, after), middle = self.rests[k], int(self.course.middles[k])
        done = (self.course.smooth - before) / (after - before)
        first, end = self.part(k)[0], self.course.motions[k].end
        resting = np.flatnonzero(np.abs(done[first:middle]) <= LEAST)
        moving = np.flatnonzero(np.abs(done[middle:end] - 1.0) > 2.0 * LEAST)
        return first + int(resting[-1:].sum()), middle + int(moving[-1:].sum()) + 1

    def is_of_drive(self) -> bool:
        """Return whether the column moves between rests, and neither jumps nor oscillates."""
        course = self.course
        if not (_is_long(course.reading) and course.moves):
            return False
        leaves, reaches, _ = course.crossings
        jumps = reaches - leaves < max(2, course.half // 2)  # a running median keeps them sharp
        few = 0 < leaves.size <= _OSCILLATES and not jumps.any()
        return few and bool(self.strokes.min() > FAINT * np.ptp(course.smooth))


def chosen_travels(
    sheet: Sheet, clock: Clock, channel: str
) -> tuple[list[Travel], list[Travel], list[str]]:
    """Return the columns of travel, the requested ones among them, and remarks on the others."""
    travels, named = _find_travels(sheet, clock)
    if not travels:
        reason = f"none of {len(sheet.columns)} columns moves between two rests as a drive does"
        remedy = "did the breaker move, and is the record longer than the motion?"
        raise RejectedCurveError(sheet.file, f"{reason}; {remedy}")
    place = sheet.place_of(channel) if channel else None
    asked = [travel for travel in travels if travel.place == place]
    listed = " or ".join(f"travel_column: {sheet.column(travel.place)}" for travel in travels)
    if channel and not asked:
        reason = f"{channel!r} is not a column of travel; set {listed}"
        raise RejectedCurveError(sheet.file, reason)
    clear = _clear({travel: (travel.unit, travel.strokes.max()) for travel in travels})
    used = clear if named else travels
    every = _with_phases(sheet, used if {*asked} <= {*used} else asked)
    if asked:
        return every, [travel for travel in every if travel.place == place], []
    faint = ", ".join(repr(sheet.column(t.place)) for t in travels if t not in used)
    remarks = [f"{faint}: far less than others, so not used; choose by --channel"] * bool(faint)
    if len(travels) > 1 and not named:
        remarks.append(f"no column is named a travel, and several move as one: set {listed}")
    return every, every, remarks


def _find_travels(sheet: Sheet, clock: Clock) -> tuple[list[Travel], bool]:
    """Return the columns that move as a drive does: those named a travel, or all if none is; and
    whether their names or units state that they are travels.
    """
    step, travels, others = 1.0 / min(clock.likely_rate, RATES[1]), [], []
    for place, (name, unit) in enumerate(zip(sheet.names, sheet.units, strict=True)):
        named, possible = _is_named(sheet, place), unit in _READINGS and place != clock.place
        if possible and (named or not holds(name, "of no travel")):
            reading = np.where(np.isfinite(sheet.columns[place]), sheet.columns[place], np.nan)
            course = Course(step * np.arange(reading.size), reading)
            travel = Travel(place, unit, course, words.phase_in(name))
            (travels if named else others).extend([travel] * travel.is_of_drive())
    return travels or others, bool(travels)


def _is_named(sheet: Sheet, place: int) -> bool:
    """Return whether the name or the unit of a column states that it is a travel."""
    unit = sheet.units[place]
    return unit in _LENGTHS or (unit in _READINGS and holds(sheet.names[place], "travel"))


def _clear(ranges: Mapping) -> list:
    """Return the keys of ranges (kind, size) that reach a share of the largest of their kind."""
    most = defaultdict(float)
    for kind, size in ranges.values():
        most[kind] = max(most[kind], size)
    return [key for key, (kind, size) in ranges.items() if size >= FAINT * most[kind]]


def _with_phases(sheet: Sheet, travels: Sequence[Travel]) -> list[Travel]:
    """Return travels with their phase: by name, or as stated for number, order or contacts."""
    stated = _stated_contacts(sheet) or {}
    phases = {int(number): phase for number, phase in stated.values() if phase}
    phases |= sheet.stated.phases
    numbers = [words.channel_of(sheet.names[travel.place]) for travel in travels]
    return [
        replace(travel, phase=travel.phase or phases.get(number or order, phases.get(0, "")))
        for order, (travel, number) in enumerate(zip(travels, numbers, strict=True), start=1)
    ]


def _stated_contacts(sheet: Sheet) -> Mapping[int, tuple[str, str]] | None:
    """Return the number of the travel and the phase of each connected contact, by column.

    Rows above the columns state the transducer (``TR1``), phase and break (``YBreak2``), or ``NA``,
    of each contact, above its column. Without such rows: None.
    """
    places = range(len(sheet.names))
    of_kinds = [[i for i in places if _kind(sheet, i) == kind] for kind in _KINDS]
    contacts = next(filter(None, of_kinds), [])
    stated = {place: {} for place in contacts}
    for row in sheet.preamble:
        for place in (place for place in contacts if place < len(row)):
            if cell := _OF_CONTACT.fullmatch(row[place].strip()):
                stated[place] |= {key: text for key, text in cell.groupdict().items() if text}
    numbered = {place: known for place, known in stated.items() if "number" in known}
    if not numbered:
        return None
    return {i: (s["number"], s.get("phase", "")) for i, s in numbered.items() if "none" not in s}


class Wiring:
    """Contacts and coils of a sheet, by place: columns that change and are not travels."""

    def __init__(self, sheet: Sheet, travels: Sequence[Travel]) -> None:
        self.sheet, self.travels = sheet, travels
        places = {*range(len(sheet.names))} - {travel.place for travel in travels}
        self._kinds = {i: _kind(sheet, i) for i in sorted(places)}
        self.contacts, self.coils = self._signals(*_KINDS), self._signals("coil")
        self._stated = _stated_contacts(sheet)
        self._marks = [_marks(name) for name in sheet.names]
        self._phases = [self._marks[t.place][0] | _marks(t.phase)[0] for t in travels]
        self._known = set().union(*self._phases)

    def _signals(self, *kinds: str) -> dict[int, Course]:
        """Return the columns whose changes exceed noise and cross-talk from others of the kind."""
        courses, ranges = {}, {}
        for i in (i for i, kind in self._kinds.items() if kind in kinds):
            values = self.sheet.columns[i]
            courses[i] = course = Course(np.arange(values.size, dtype=float), values)
            if _is_long(values) and course.moves:
                ranges[i] = (self.sheet.units[i], self._kinds[i]), np.ptp(course.smooth)
        return {i: courses[i] for i in _clear(ranges)}

    def paired(self, sign: int = 1) -> list[dict[str, dict[str, str | int]]]:
        """Return the columns that belong to each travel, by motion and key of the settings."""
        sheet, matched = self.sheet, []
        for order, travel in enumerate(self.travels):
            matched.append({})
            for motion in MOTIONS:
                closing = motion == "closing"
                same_motion = travel.rises == (closing == (sign > 0))
                k = int(same_motion.argmax())
                contact = self._contact(order, motion, k)
                taken = {
                    "contact_column": contact,
                    "current_column": current_of(sheet, contact[0]) if contact else [],
                    "trigger_column": self._coil(order, motion, k) if same_motion.any() else [],
                }
                columns = {key: sheet.column(places[0]) for key, places in taken.items() if places}
                matched[-1][motion] = columns
        return matched

    def still_poles(self, sign: int) -> list[tuple[Travel, Mapping]]:
        """Return the travels of other poles that stand still while their contacts switch, with the
        course of the first travel, and what ``paired`` gives. Without phases, a travel counts only
        beside two that move: others may be unused channels.
        """
        sheet, places = self.sheet, {travel.place for travel in self.travels}
        phases = {travel.phase for travel in self.travels}
        still = [
            replace(self.travels[0], place=i, phase=words.phase_in(name))
            for i, name in enumerate(sheet.names)
            if i not in places and _is_named(sheet, i) and _is_long(sheet.columns[i])
        ]
        every = _with_phases(sheet, sorted([*self.travels, *still], key=lambda e: e.place))
        known = set() if [*phases] == [""] and len(self.travels) == 2 else phases | {""}
        if all(e.place in places or e.phase in known for e in every):
            return []
        paired = zip(every, Wiring(sheet, every).paired(sign), strict=True)
        poles = [(e, of) for e, of in paired if e.place not in places and e.phase not in known]
        return [(e, of) for e, of in poles if any("contact_column" in p for p in of.values())]

    def _contact(self, order: int, motion: str, k: int) -> list[int]:
        """Return the contact of a travel in motion k; none where the choice is ambiguous.

        Arcing contacts are preferred to main contacts; resistor contacts never count. Among breaks
        in series, the last to touch or the first to separate counts (IEC 62271-100).
        """
        names, (begin, end) = self.sheet.names, self.travels[order].part(k)
        fits = {i: self._fits(i, order) for i in self.contacts}
        one_pole = any(fits.values())
        fit = [i for i in fits if fits[i] or (fits[i] is None and not one_pole)]
        kinds = [[i for i in fit if self._kinds[i] == kind] for kind in _KINDS]
        fit = [i for i in next(filter(None, kinds), []) if not holds(names[i], "resistor contact")]
        fit = [i for i in fit if holds(names[i], "arcing")] or fit
        if len(fit) < 2:
            return fit
        fit = [i for i in fit if one_pole or holds(names[i], "break")]
        changes = {i: self.contacts[i].crossings[0] for i in fit}
        first = {i: next((c for c in all_ if begin <= c < end), -1) for i, all_ in changes.items()}
        fit = [i for i in fit if first[i] >= 0]
        return sorted(fit, key=first.__getitem__, reverse=motion == "closing")[:1]

    def _fits(self, contact: int, order: int) -> bool | None:
        """Return whether rows above, phase or number assign a contact to a travel; None if unclear.

        The numbers of resistances are ignored: they count channels of resistance, not travels.
        """
        phases, numbers = self._marks[contact]
        of_travel = self._marks[self.travels[order].place][1]
        if self._stated is not None:
            return self._stated.get(contact, ("",))[0] in (of_travel or {str(order + 1)})
        if phases & self._known:
            return bool(phases & self._phases[order])
        numbers = set() if self._kinds[contact] == "resistance" else numbers
        if numbers & of_travel:
            return True
        marked = (phases or numbers) and (of_travel or self._phases[order])
        return False if marked or len(self.travels) > 1 else None

    def coils_before(self, travel: Travel, k: int) -> dict[int, int]:
        """Return the sample at which each coil is energised before motion k, by column."""
        begin, end, events_of = travel.part(k)[0], int(travel.course.middles[k]), {}
        for i in self.coils:
            values = np.abs(self.sheet.columns[i] - np.nanmedian(self.sheet.columns[i]))
            on = values > FAINT * np.nanmax(values)
            edges = np.flatnonzero(np.diff(on, prepend=True)[begin:end] & on[begin:end])
            if edges.size:
                events_of[i] = begin + int(edges[0])
        return events_of

    def _coil(self, order: int, motion: str, k: int) -> list[int]:
        """Return the coil of a travel before motion k; none or one.

        If there are as many numbered coils as travels, their order assigns them. Other coils serve
        all poles, and the first that is energised counts.
        """
        energised = self.coils_before(self.travels[order], k)
        coils = [i for i in energised if self._marks[i][0] & self._known <= self._phases[order]]
        named = {i: words.motion_of(self.sheet.names[i]) for i in coils}
        coils = [i for i in coils if named[i] == motion] or [i for i in coils if not named[i]]
        numbers = {i: min(map(int, self._marks[i][1]), default=0) for i in coils}
        if len(coils) == len(self.travels) > 1 and all(numbers.values()):
            return sorted(coils, key=numbers.__getitem__)[order : order + 1]
        return sorted(coils, key=energised.__getitem__)[:1]

    def first_motions(self, travel: Travel) -> set[str]:
        """Return the first motion according to resistances; both motions if resistances differ."""
        (begin, end), (begins, rests), motions = travel.part(0), travel.moves(0), set()
        for i in (i for i in self.contacts if self._kinds[i] == "resistance"):
            values = np.abs(self.sheet.columns[i])
            before, after = map(np.nanmedian, (values[begin : begins + 1], values[rests - 1 : end]))
            if min(before, after) < FAINT * max(before, after):
                motions.add("closing" if after < before else "opening")
        return motions


def current_of(sheet: Sheet, contact: int) -> list[int]:
    """Return the place of the test current of a contact's resistance; none or one."""
    if _kind(sheet, contact) != "resistance":
        return []
    marks = _marks(sheet.names[contact])
    alike = (i for i, name in enumerate(sheet.names) if _marks(name) == marks)
    currents = [i for i in alike if _kind(sheet, i) == "current"]
    return currents if len(currents) == 1 else []


def _marks(name: str) -> tuple[set[str], set[str]]:
    """Return the phases and the numbers in the name of a column."""
    bare = _NO_MARKS.sub(" ", name)
    return set(_PHASES.findall(bare.lower())), set(re.findall(r"(?<![lL\d])\d+", bare))


def _kind(sheet: Sheet, place: int) -> str:
    """Return the kind of a column: contact, resistance, coil, current (such as the test current of
    a resistance), or empty for other columns.
    """
    name, unit = sheet.names[place], sheet.units[place] or ""
    if unit in _LENGTHS or holds(name, "of the drive"):
        return ""
    size = words.amperes_of(name, unit)
    if np.isfinite(size) or holds(name, "coil"):
        amperes = np.nan_to_num(size * np.abs(sheet.columns[place])).max(initial=0.0)
        if holds(name, "coil") and not holds(name, "test current") and amperes <= _COIL:
            return "coil"
        return "current" if amperes or holds(name, "current") else ""
    other = holds(name, "52a") or holds(name, "52b")  # auxiliary switches
    return "" if other else next((kind for kind in _KINDS[::-1] if holds(name, kind)), "")
