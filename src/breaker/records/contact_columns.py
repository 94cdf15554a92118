"""Which columns of contacts, coils and a motor go with a column of travel: by phase, number, time.

A contact is a column of a contact, of the resistance across it, or of an auxiliary switch, whose
reading changes; a current is none.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from breaker.model.parameters import MOTIONS
from breaker.records.channels import FAINT, FEWEST, Travel, stated_contacts
from breaker.records.motion import Course
from breaker.records.settings import TO_MM
from breaker.records.sheet import Sheet
from breaker.records.words import COLUMN_PHASE, amperes_of, holds, motion_of

_COIL = (20.0, 0.98)  # A, that no coil takes, and the share of its samples that has less

_PHASES = re.compile(rf"(?<![a-z])({COLUMN_PHASE})(?![a-z])")
_KINDS = ("contact", "resistance", "52a", "52b")  # the first of these counts
# Of no number or phase: units, C1 and T1 of coils, and the device numbers 52a and 52b.
_NO_MARKS = re.compile(r"[\[(].*?[\])]|\b[cCtT](?=\d)|\b52[abAB]\b")


class Beside(NamedTuple):
    """What goes with a travel in a motion.

    Attributes:
        settings: Columns by key of ``endurance.format``, such as ``contact_column``; a key is
            lacking where none is found.
        others: Columns of contacts of the same travel that are not taken.
        auxiliary: Column of the contact where that is an auxiliary switch; else empty.
    """

    settings: Mapping[str, str | int] = MappingProxyType({})
    others: tuple[str | int, ...] = ()
    auxiliary: str | int = ""


class _Pole(NamedTuple):
    """A travel: phases and numbers in its name, its place among so many, and those of all."""

    phases: set[str]
    numbers: set[str]
    order: int
    count: int
    known: set[str]
    numbered: set[str]


def columns_beside(
    sheet: Sheet, travels: Sequence[Travel], sign: int = 1
) -> list[dict[str, Beside]]:
    """Return what goes with each travel, by motion.

    A contact goes with the travel that rows above the columns state. Where none does, it goes with
    a travel of the same phase or number in its name, or where either has none; but of several
    resistances, which are numbered by channel, nobody knows what the channels belong to.
    As IEC 62271-100 counts the times of a pole, the arcing contacts go before the main ones,
    resistor contacts are left out, and of breaks in series that counts which touches last or parts
    first; an auxiliary switch counts where nothing else does, 52a before its opposite 52b. A
    coil goes with the motion that its name states, and without one with those that it is
    energised before. Its number is that of a pole where as many coils as poles are energised; else
    it is one of several for all poles, of which the first that is energised counts.

    Args:
        sheet: Of the file.
        travels: All of its columns of travel.
        sign: 1 if their reading grows towards closed, -1 if it falls.
    """
    marks = [_marks(sheet.names[each.place]) for each in travels]
    if len(marks) > 1 and all(phases == marks[0][0] for phases, _ in marks):
        marks = [(set(), numbers) for _, numbers in marks]  # a letter that all have is no phase
    marks = [(p | _marks(t.phase)[0], n) for t, (p, n) in zip(travels, marks, strict=True)]
    known, numbered = (set().union(*each) for each in zip(*marks, strict=True))
    places = {each.place for each in travels}
    contacts = _contacts(sheet, places)
    several = sum(holds(sheet.names[i], "resistance") for i in contacts) > 1
    stated = stated_contacts(
        sheet.preamble, ["" if i in places else name for i, name in enumerate(sheet.names)]
    )
    found = []
    for order, (travel, own) in enumerate(zip(travels, marks, strict=True), start=1):
        pole = _Pole(*own, order, len(travels), known, numbered)
        if stated is None:
            fits = [i for i in contacts if _go_together(sheet.names[i], pole, several)]
        else:
            number = pole.numbers or {str(order)}
            fits = [i for i in contacts if i in stated and stated[i][0] in number]
        kinds = [[i for i in fits if _kind(sheet, i) == kind] for kind in _KINDS]
        fits = next(filter(None, kinds), [])
        beside = {}
        for motion in MOTIONS:
            own = travel.rises == ((motion == "closing") == (sign > 0))
            beside[motion] = _beside(sheet, travel, pole, motion, own, fits)
        found.append(beside)
    return found


def _beside(
    sheet: Sheet,
    travel: Travel,
    pole: _Pole,
    motion: str,
    own: np.ndarray,
    contacts: Sequence[int],
) -> Beside:
    """What goes with a travel in a motion, of which some of its motions are."""
    k = int(own.argmax())
    counted = _counted(sheet, contacts, travel, motion, k)[:1]
    coils = coils_before(sheet, travel, k) if own.any() else {}
    taken = {
        "contact_column": counted,
        "current_column": [each for i in counted for each in current_of(sheet, i)],
        "trigger_column": _coil(sheet, coils, motion, pole),
        "motor_column": _motor(sheet) if motion == "closing" else [],
    }
    settings = {k: sheet.column(v[0]) for k, v in taken.items() if v}
    auxiliary = [sheet.column(i) for i in counted if _kind(sheet, i) in _KINDS[2:]]
    others = tuple(sheet.column(i) for i in contacts if i not in counted)
    return Beside(settings, others, *auxiliary)


def _kind(sheet: Sheet, place: int) -> str:
    """Kind of a column by which a contact is seen; empty of all others, currents among them."""
    name = sheet.names[place]
    if switch := next((kind for kind in _KINDS[2:] if holds(name, kind)), ""):
        return switch
    if holds(name, "coil") or holds(name, "of the drive") or sheet.units[place] in TO_MM:
        return ""
    if np.isfinite(amperes_of(name, sheet.units[place] or "")):
        return ""
    return next((kind for kind in _KINDS if holds(name, kind)), "")


def _contacts(sheet: Sheet, travels: Iterable[int]) -> list[int]:
    """Columns of contacts whose reading changes, none of them a travel."""
    places = (i for i in range(len(sheet.names)) if i not in travels and _kind(sheet, i))
    return _signals(sheet, places)


def _signals(sheet: Sheet, places: Iterable[int]) -> list[int]:
    """Columns with more than noise, and not faint beside others of their kind and unit."""
    ranges: dict[int, float] = {}
    for i in places:
        values = sheet.columns[i]
        if np.isfinite(values).sum() >= FEWEST:
            course = Course(np.arange(values.size, dtype=float), values)
            ranges[i] = float(np.ptp(course.smooth)) if course.moves else 0.0
    of = {i: (sheet.units[i], _kind(sheet, i)) for i in ranges}
    most = {kind: max(ranges[i] for i in ranges if of[i] == kind) for kind in of.values()}
    return [i for i, width in ranges.items() if width > 0.0 and width >= FAINT * most[of[i]]]


def coils_before(sheet: Sheet, travel: Travel, k: int) -> dict[int, int]:
    """Return the columns of coils, and the sample at which each is energised before a motion, k,
    of a travel; -1 where it is not.
    """
    named = [i for i in range(len(sheet.names)) if i != travel.place and _is_coil(sheet, i)]
    found = dict.fromkeys(named, -1)
    begin, end = travel.part(k)[0], int(travel.course.middles[k])
    for i in _signals(sheet, named):
        values = sheet.columns[i]
        on = np.abs(values - np.nanmedian(values)) > FAINT * (np.nanmax(values) - np.nanmin(values))
        edges = np.flatnonzero(on & ~np.append(False, on[:-1]))
        edges = edges[(edges >= begin) & (edges < end)]
        found[i] = int(edges[0]) if edges.size else -1
    return found


def _is_coil(sheet: Sheet, place: int) -> bool:
    """Whether a column may be of a coil, and not of a motor or of a resistance test."""
    name, values = sheet.names[place], sheet.columns[place]
    if not holds(name, "coil") or any(holds(name, k) for k in ("test current", "of the drive")):
        return False
    if np.isfinite(values).sum() < FEWEST or np.nanmin(values) == np.nanmax(values):
        return False
    before = sheet.names[place - 1] if place else ""
    if holds(before, "resistance") and _marks(before)[1] == _marks(name)[1]:
        return False
    amperes = amperes_of(name, sheet.units[place] or "")
    return not amperes * np.nanquantile(np.abs(values), _COIL[1]) > _COIL[0]


def current_of(sheet: Sheet, contact: int) -> list[int]:
    """Return the column of the test current of a contact's resistance, by place; none or one.

    It has the same number and phase, and stands behind the resistance where several have.
    """
    names, found = sheet.names, []
    for i, name in enumerate(names) if _kind(sheet, contact) == "resistance" else ():
        flows = np.isfinite(amperes_of(name, sheet.units[i] or "")) or holds(name, "current")
        alike = i != contact and _marks(name) == _marks(names[contact])
        if flows and alike and not (_kind(sheet, i) or _is_coil(sheet, i) or i in _motor(sheet)):
            found.append(i)
    return found if len(found) == 1 else [i for i in found if i == contact + 1]


def first_by_contacts(sheet: Sheet, travel: Travel) -> dict[str, str]:
    """Return what contacts show the first motion of a travel to be, by why: "closing" or "opening".

    A resistance and an auxiliary switch show it by their levels. Other contacts show it by when
    they switch, as the gap is most of the way: late in a closing, and early in an opening.
    """
    begin, end = travel.part(0)
    rests = min(travel.arrives(0), end - 1)
    closes: dict[str, bool] = {}
    for i in _contacts(sheet, {travel.place}):
        kind, values = _kind(sheet, i), np.abs(sheet.columns[i])
        at = begin + _switches(values, (begin, end))
        if at < travel.begins(0):
            continue
        before, after = map(np.nanmedian, (values[begin : at + 1], values[rests:end]))
        share = travel.done(0)[at]
        if kind == "contact" and abs(share - 0.5) > 0.5 * FAINT:
            late = bool(share > 0.5)
            closes[f"a contact that switches {'late' if late else 'early'} in it"] = late
        elif kind != "contact" and min(before, after) < FAINT * max(before, after):
            rises = bool(after > before)
            way = "rises" if rises else "falls"
            closes[f"a {kind} that {way} in it"] = rises == (kind == "52a")
    return {why: "closing" if each else "opening" for why, each in closes.items()}


def _coil(sheet: Sheet, at: Mapping[int, int], motion: str, pole: _Pole) -> list[int]:
    """The coil of a motion of a pole, of those that are energised at some samples; none or one."""
    marks = {i: _marks(sheet.names[i]) for i in at}
    own = [i for i in at if not marks[i][0] & pole.known or marks[i][0] & pole.phases]
    own = [i for i in own if motion_of(sheet.names[i]) in ("", motion)]
    energised = [i for i in own if at[i] >= 0]
    energised = [i for i in energised if motion_of(sheet.names[i])] or energised
    if not energised:
        return own if len(own) == 1 else []
    numbers = [marks[i][1] for i in energised]
    if len(energised) == pole.count > 1 and all(numbers):
        # Of channels 2, 4 and 6 and coils 1 to 3 the first go together.
        alike = pole.numbered <= set().union(*numbers)
        wanted = (pole.numbers or {str(pole.order)}) if alike else set()
        own = [i for i, each in zip(energised, numbers, strict=True) if each & wanted]
        # Coils of the other motion may have the first numbers.
        every = sorted(energised, key=lambda i: min(map(int, marks[i][1])))
        return (own or every[pole.order - 1 :])[:1]
    return [min(energised, key=at.__getitem__)]


def _counted(
    sheet: Sheet, contacts: Sequence[int], travel: Travel, motion: str, k: int
) -> list[int]:
    """Contacts of a travel that may count in a motion, k, the one that does first."""
    counted = [i for i in contacts if not holds(sheet.names[i], "resistor contact")]
    counted = _named(sheet, counted, "arcing") or counted
    if not any(_marks(sheet.names[travel.place])) and len(counted) > 1:
        # Of several numbers each may be a pole of its own.
        counted = _named(sheet, counted, "break")
    if len(counted) > 1:
        at = {i: _switches(sheet.columns[i], travel.part(k)) for i in counted}
        counted = [i for i in counted if at[i] >= 0]
        counted.sort(key=at.__getitem__, reverse=motion == "closing")
    return counted


def _switches(values: np.ndarray, part: tuple[int, int]) -> int:
    """Sample at which a contact first changes in a part of a record, -1 where it does not."""
    high = values[slice(*part)] > 0.5 * (np.nanmin(values) + np.nanmax(values))
    changes = np.flatnonzero(high[1:] != high[:-1])
    return int(changes[0]) if changes.size else -1


def _named(sheet: Sheet, places: Iterable[int], kind: str) -> list[int]:
    return [i for i in places if holds(sheet.names[i], kind)]


def _motor(sheet: Sheet) -> list[int]:
    """The column of a motor's current; of several, nobody knows whose each is."""
    named = _named(sheet, range(len(sheet.names)), "motor")
    found = [i for i in named if np.isfinite(amperes_of(sheet.names[i], sheet.units[i] or ""))]
    found = [i for i in found if np.isfinite(sheet.columns[i]).sum() >= FEWEST]
    return found if len(found) == 1 else []


def _go_together(name: str, pole: _Pole, several: bool) -> bool:
    """Whether a contact goes with a pole, by its name; of several resistances by phase alone."""
    phases, numbers = _marks(name)
    if phases & pole.known:
        return bool(phases & pole.phases)
    if several and holds(name, "resistance"):
        return False
    if numbers and pole.numbers:
        return bool(numbers & pole.numbers)
    return not (phases or numbers) or not (pole.phases or pole.numbers)


def _marks(name: str) -> tuple[set[str], set[str]]:
    """Phases and numbers in the name of a column."""
    bare = _NO_MARKS.sub(" ", name)
    return set(_PHASES.findall(bare.lower())), set(re.findall(r"(?<![lL\d])\d+", bare))
