"""Which columns of contacts, coils and a motor belong to a travel: by phase, number and time.

A contact is a column of a contact, of the resistance across it, or of an auxiliary switch, whose
reading changes. A current is never a contact.
"""

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from breaker.model.parameters import MOTIONS
from breaker.records.channels import FAINT, Travel, smooth_range, stated_contacts
from breaker.records.settings import TO_MM
from breaker.records.sheet import Sheet
from breaker.records.words import COLUMN_PHASE, amperes_of, holds, motion_of

_COIL = 20.0  # A: coils take less, and tests of resistance more
_KINDS = ("contact", "resistance", "52a", "52b")  # the first of these counts
_PHASES = re.compile(rf"(?<![a-z])({COLUMN_PHASE})(?![a-z])")
# Not a number or phase: units, C1 and T1 of coils, and the device numbers 52a and 52b.
_NO_MARKS = re.compile(r"[\[(].*?[\])]|\b[cCtT](?=\d)|\b52[abAB]\b")


class _Pole(NamedTuple):
    """A travel, the phases and numbers of its name, its order, and phases of all ``count``."""

    travel: Travel
    phases: set[str]
    numbers: set[str]
    order: int
    known: set[str]
    count: int


def columns_beside(
    sheet: Sheet, travels: Sequence[Travel], sign: int = 1
) -> list[dict[str, dict[str, str | int]]]:
    """Return the columns that belong to each travel, by motion and key of ``endurance.format``.

    Rows above the columns state the contacts of a travel. Without them a contact belongs to a
    travel of the same phase or number, or where either has none. Arcing contacts count before main
    ones, and resistor contacts never; of breaks in series the one that touches last or parts first
    (IEC 62271-100). Auxiliary switches count last. The sign is 1 if readings grow towards closed.
    """
    places = {travel.place for travel in travels}
    marks = [_marks(sheet.names[t.place]) for t in travels]
    phases = [own | _marks(t.phase)[0] for t, (own, _) in zip(travels, marks, strict=True)]
    ranks, known, found = list(range(len(travels))), set().union(*phases), []
    if all(len(numbers) == 1 for _, numbers in marks):
        ranks.sort(key=lambda i: int(*marks[i][1]))
    contacts, stated = _contacts(sheet, places), stated_contacts(sheet, places)
    for i, travel in enumerate(travels):
        pole = _Pole(travel, phases[i], marks[i][1], 1 + ranks.index(i), known, len(ranks))
        numbers = pole.numbers or {str(pole.order)}
        fits = [k for k in contacts if stated and k in stated and stated[k][0] in numbers]
        if stated is None:
            fits = [k for k in contacts if _belongs(sheet, k, contacts, pole)]
        kinds = [[k for k in fits if _kind(sheet, k) == kind] for kind in _KINDS]
        own = next(filter(None, kinds), [])
        found.append({motion: _beside(sheet, pole, motion, sign, own) for motion in MOTIONS})
    return found


def _belongs(sheet: Sheet, contact: int, contacts: Sequence[int], pole: _Pole) -> bool:
    """Whether a contact belongs to a pole by its name; of several resistances by phase alone."""
    phases, numbers = _marks(sheet.names[contact])
    resistances = [i for i in contacts if _kind(sheet, i) == "resistance"]
    if phases & pole.known or (contact in resistances and len(resistances) > 1):
        return bool(phases & pole.phases)
    if numbers and pole.numbers:
        return bool(numbers & pole.numbers)
    return not (phases or numbers) or not (pole.phases or pole.numbers)


def _beside(
    sheet: Sheet, pole: _Pole, motion: str, sign: int, contacts: Sequence[int]
) -> dict[str, str | int]:
    """The columns that belong to a pole in a motion."""
    own = pole.travel.rises == ((motion == "closing") == (sign > 0))
    k = int(own.argmax())
    counted = _counted(sheet, contacts, pole.travel, motion, k)[:1]
    motors = [
        i for i, name in enumerate(sheet.names) if holds(name, "motor") and _amperes(sheet, i)
    ]
    taken = {
        "contact_column": counted,
        "current_column": current_of(sheet, counted[0]) if counted else [],
        "trigger_column": _coil(sheet, pole, motion, k) if own.any() else [],
        "motor_column": motors if motion == "closing" and len(motors) == 1 else [],
    }
    return {key: sheet.column(places[0]) for key, places in taken.items() if places}


def _marks(name: str) -> tuple[set[str], set[str]]:
    """Phases and numbers in the name of a column."""
    bare = _NO_MARKS.sub(" ", name)
    return set(_PHASES.findall(bare.lower())), set(re.findall(r"(?<![lL\d])\d+", bare))


def _amperes(sheet: Sheet, place: int) -> float:
    """The largest current of a column, A; 0 where it is not a current."""
    size = amperes_of(sheet.names[place], sheet.units[place] or "")
    return float(np.nan_to_num(size * np.abs(sheet.columns[place])).max(initial=0.0))


def _kind(sheet: Sheet, place: int) -> str:
    """Kind of a column by which a contact is seen; empty for others, such as currents."""
    name, unit = sheet.names[place], sheet.units[place] or ""
    if switch := next((kind for kind in _KINDS[2:] if holds(name, kind)), ""):
        return switch
    other = any(holds(name, kind) for kind in ("coil", "of the drive")) or unit in TO_MM
    if other or np.isfinite(amperes_of(name, unit)):
        return ""
    return next((kind for kind in _KINDS if holds(name, kind)), "")


def _contacts(sheet: Sheet, travels: Iterable[int]) -> list[int]:
    """Columns of contacts whose reading changes, none of them a travel."""
    places = [i for i in range(len(sheet.names)) if i not in travels and _kind(sheet, i)]
    return _signals(sheet, places)


def _signals(sheet: Sheet, places: Iterable[int]) -> list[int]:
    """Columns that change by more than noise, and by not far less than others of their kind."""
    ranges, most = {}, {}
    for i in places:
        kind, width = (sheet.units[i], _kind(sheet, i)), smooth_range(sheet.columns[i])
        ranges[i], most[kind] = (kind, width), max(width, most.get(kind, 0.0))
    return [i for i, (kind, width) in ranges.items() if width > 0 and width >= FAINT * most[kind]]


def _counted(
    sheet: Sheet, contacts: Sequence[int], travel: Travel, motion: str, k: int
) -> list[int]:
    """Contacts of a travel that may count in motion k, first the one that does."""
    names = sheet.names
    counted = [i for i in contacts if not holds(names[i], "resistor contact")]
    counted = [i for i in counted if holds(names[i], "arcing")] or counted
    if len(counted) > 1 and not any(_marks(names[travel.place])):  # they may be of several poles
        counted = [i for i in counted if holds(names[i], "break")]
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


def current_of(sheet: Sheet, contact: int) -> list[int]:
    """Return the column of the test current of a contact's resistance, by place; none or one.

    The current has the same number and phase; of several such currents the next column counts.
    """
    own, found = _marks(sheet.names[contact]), []
    for i, name in enumerate(sheet.names) if _kind(sheet, contact) == "resistance" else ():
        flows = (_amperes(sheet, i) or holds(name, "current")) and not _kind(sheet, i)
        other = i == contact or holds(name, "motor") or _is_coil(sheet, i)
        found += [i] if flows and not other and _marks(name) == own else []
    return found if len(found) == 1 else [i for i in found if i == contact + 1]


def first_by_contacts(sheet: Sheet, travel: Travel) -> set[str]:
    """Return the first motion, "closing" or "opening", by levels of resistances and switches."""
    (begin, end), (_, rests), closes = travel.part(0), travel.moves(0), set()
    for i in _contacts(sheet, {travel.place}):
        kind, values = _kind(sheet, i), np.abs(sheet.columns[i])
        at = begin + max(_switches(values, (begin, end)), 0) + 1
        before, after = map(np.nanmedian, (values[begin:at], values[min(rests, end - 1) : end]))
        if kind != "contact" and min(before, after) < FAINT * max(before, after):
            closes.add(bool(after > before) == (kind == "52a"))
    return {"closing" if each else "opening" for each in closes}


def _is_coil(sheet: Sheet, place: int) -> bool:
    """Whether a column may be of a coil, and not of a motor or of a test of resistance."""
    name = sheet.names[place]
    other = holds(name, "test current") or holds(name, "of the drive")
    return holds(name, "coil") and not other and _amperes(sheet, place) <= _COIL


def coils_before(sheet: Sheet, travel: Travel, k: int) -> dict[int, int]:
    """Return the sample at which coils are energised before motion k of a travel, by column."""
    coils = [i for i in range(len(sheet.names)) if i != travel.place and _is_coil(sheet, i)]
    begin, end, found = travel.part(k)[0], int(travel.course.middles[k]), {}
    for i in _signals(sheet, coils):
        values = sheet.columns[i]
        on = np.abs(values - np.nanmedian(values)) > FAINT * (np.nanmax(values) - np.nanmin(values))
        edges = np.flatnonzero(on & ~np.append(False, on[:-1]))
        if (edges := edges[(edges >= begin) & (edges < end)]).size:
            found[i] = int(edges[0])
    return found


def _coil(sheet: Sheet, pole: _Pole, motion: str, k: int) -> list[int]:
    """The coil of a pole in motion k; none or one.

    Of as many numbered coils as poles each belongs to the pole of its order. Other coils are of all
    poles, and the first that is energised counts.
    """
    at, names = coils_before(sheet, pole.travel, k), sheet.names
    marks = {i: _marks(names[i]) for i in at}
    own = [i for i in at if not marks[i][0] & pole.known or marks[i][0] & pole.phases]
    own = [i for i in own if motion_of(names[i]) in ("", motion)]
    own = [i for i in own if motion_of(names[i])] or own
    if len(own) == pole.count > 1 and all(marks[i][1] for i in own):
        return sorted(own, key=lambda i: min(map(int, marks[i][1])))[pole.order - 1 :][:1]
    return [min(own, key=at.__getitem__)] if own else []
