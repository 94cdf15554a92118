"""Which columns of contacts, coils and a motor belong to a travel: by phase, number and time.

A contact is a column of a contact, of the resistance across it, or of an auxiliary switch, whose
reading changes. A current is never a contact.
"""

import re
from collections.abc import Iterable, Sequence

import numpy as np

from breaker.model.parameters import MOTIONS
from breaker.records.channels import FAINT, FEWEST, Travel, stated_contacts
from breaker.records.motion import Course
from breaker.records.settings import TO_MM
from breaker.records.sheet import Sheet
from breaker.records.words import COLUMN_PHASE, amperes_of, holds, motion_of

_COIL = 20.0  # A: coils take less, and tests of resistance more
_SWITCHES = ("52a", "52b")
_KINDS = ("contact", "resistance", *_SWITCHES)  # the first of these counts
_PHASES = re.compile(rf"(?<![a-z])({COLUMN_PHASE})(?![a-z])")
# Not a number or phase: units, C1 and T1 of coils, and the device numbers 52a and 52b.
_NO_MARKS = re.compile(r"[\[(].*?[\])]|\b[cCtT](?=\d)|\b52[abAB]\b")


class Wiring:
    """The contacts and coils of a sheet, by place: those that change, none of them a travel."""

    def __init__(self, sheet: Sheet, travels: Sequence[Travel]) -> None:
        self.sheet, self.travels = sheet, travels
        places = {travel.place for travel in travels}
        others = [i for i in range(len(sheet.names)) if i not in places]
        self.contacts = self._signals(i for i in others if _kind(sheet, i))
        self.coils = self._signals(i for i in others if _is_coil(sheet, i))
        self._stated = stated_contacts(sheet, places)
        self._marks = [_marks(name) for name in sheet.names]
        self._phases = [self._marks[t.place][0] | _marks(t.phase)[0] for t in travels]
        self._known = set().union(*self._phases)

    def _signals(self, places: Iterable[int]) -> list[int]:
        """Columns that change by more than noise, and by not far less than others of their kind."""
        ranges, most = {}, {}
        for i in places:
            values, kind = self.sheet.columns[i], (self.sheet.units[i], _kind(self.sheet, i))
            course = Course(np.arange(values.size, dtype=float), values)
            if np.isfinite(values).sum() >= FEWEST and course.moves:
                ranges[i] = kind, np.ptp(course.smooth)
                most[kind] = max(ranges[i][1], most.get(kind, 0.0))
        return [i for i, (kind, width) in ranges.items() if width >= FAINT * most[kind]]

    def beside(self, order: int, motion: str, sign: int) -> dict[str, str | int]:
        """Return the columns that belong to a travel, by its order, in a motion, by setting."""
        sheet = self.sheet
        own = self.travels[order].rises == ((motion == "closing") == (sign > 0))
        contact = self._contact(order, motion, int(own.argmax()))
        motors = [i for i, name in enumerate(sheet.names) if holds(name, "motor")]
        motors = [i for i in motors if motion == "closing" and _amperes(sheet, i)]
        taken = {
            "contact_column": contact,
            "current_column": current_of(sheet, contact[0]) if contact else [],
            "trigger_column": self._coil(order, motion, int(own.argmax())) if own.any() else [],
            "motor_column": motors if len(motors) == 1 else [],
        }
        return {key: sheet.column(places[0]) for key, places in taken.items() if places}

    def _contact(self, order: int, motion: str, k: int) -> list[int]:
        """The contact of a travel in motion k; none where several may be meant.

        Arcing contacts count before main ones, and resistor contacts never; of breaks in series
        the one that touches last or parts first (IEC 62271-100).
        """
        names, part, columns = self.sheet.names, self.travels[order].part(k), self.sheet.columns
        fits = {i: self._fits(i, order) for i in self.contacts}
        one_pole = any(fits.values())
        own = [i for i in fits if fits[i] or (fits[i] is None and not one_pole)]
        kinds = [[i for i in own if _kind(self.sheet, i) == kind] for kind in _KINDS]
        own = [i for i in next(filter(None, kinds), []) if not holds(names[i], "resistor contact")]
        own = [i for i in own if holds(names[i], "arcing")] or own
        if len(own) < 2:
            return own
        own = [i for i in own if one_pole or holds(names[i], "break")]
        at = {i: _switches(columns[i], part) for i in own}
        own = [i for i in own if at[i] >= 0]
        return sorted(own, key=at.__getitem__, reverse=motion == "closing")[:1]

    def _fits(self, contact: int, order: int) -> bool | None:
        """Whether a contact is of a travel by rows above, phase or number; None if it may be.

        Numbers of resistances are those of other channels.
        """
        (phases, numbers), own = self._marks[contact], self._marks[self.travels[order].place][1]
        if self._stated is not None:
            return self._stated.get(contact, ("",))[0] in (own or {str(order + 1)})
        if phases & self._known:
            return bool(phases & self._phases[order])
        numbers = set() if _kind(self.sheet, contact) == "resistance" else numbers
        if numbers & own:
            return True
        marked = (phases or numbers) and (own or self._phases[order])
        return False if marked or len(self.travels) > 1 else None

    def coils_before(self, travel: Travel, k: int) -> dict[int, int]:
        """Return the sample at which coils are energised before motion k of a travel, by column."""
        begin, end, found = travel.part(k)[0], int(travel.course.middles[k]), {}
        for i in self.coils:
            values = np.abs(self.sheet.columns[i] - np.nanmedian(self.sheet.columns[i]))
            on = values > FAINT * np.nanmax(values)
            edges = np.flatnonzero(on[begin:end] & ~np.append(False, on)[begin:end])
            if edges.size:
                found[i] = begin + int(edges[0])
        return found

    def _coil(self, order: int, motion: str, k: int) -> list[int]:
        """The coil of a travel before motion k; none or one.

        Of as many numbered coils as travels each belongs to the travel of its order. Other coils
        are of all poles, and the first that is energised counts.
        """
        names, at = self.sheet.names, self.coils_before(self.travels[order], k)
        own = [i for i in at if self._marks[i][0] & self._known <= self._phases[order]]
        own = [i for i in own if motion_of(names[i]) == motion] or [
            i for i in own if not motion_of(names[i])
        ]
        numbers = {i: min(map(int, self._marks[i][1]), default=0) for i in own}
        if len(own) == len(self.travels) > 1 and all(numbers.values()):
            return sorted(own, key=numbers.__getitem__)[order : order + 1]
        return sorted(own, key=at.__getitem__)[:1]

    def first_motions(self, travel: Travel) -> set[str]:
        """Return the first motion by levels of resistances and switches; both if these differ."""
        (begin, end), (begins, rests), closes = travel.part(0), travel.moves(0), set()
        for i in self.contacts:
            kind, values = _kind(self.sheet, i), np.abs(self.sheet.columns[i])
            before, after = map(np.nanmedian, (values[begin : begins + 1], values[rests - 1 : end]))
            if kind != "contact" and min(before, after) < FAINT * max(before, after):
                closes.add(bool(after > before) == (kind == "52a"))
        return {"closing" if each else "opening" for each in closes}


def columns_beside(
    sheet: Sheet, travels: Sequence[Travel], sign: int = 1
) -> list[dict[str, dict[str, str | int]]]:
    """Return the columns that belong to each travel, by motion and key of ``endurance.format``."""
    wiring, orders = Wiring(sheet, travels), range(len(travels))
    return [{motion: wiring.beside(i, motion, sign) for motion in MOTIONS} for i in orders]


def current_of(sheet: Sheet, contact: int) -> list[int]:
    """Return the column of the test current of a contact's resistance, by place; none or one."""
    own, found = _marks(sheet.names[contact]), []
    for i, name in enumerate(sheet.names) if _kind(sheet, contact) == "resistance" else ():
        flows = (_amperes(sheet, i) or holds(name, "current")) and not _kind(sheet, i)
        if flows and _marks(name) == own and not (holds(name, "motor") or _is_coil(sheet, i)):
            found.append(i)
    return found if len(found) == 1 else []


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
    kind = next((kind for kind in reversed(_KINDS) if holds(name, kind)), "")
    other = holds(name, "coil") or holds(name, "of the drive") or unit in TO_MM
    other = other or np.isfinite(amperes_of(name, unit))
    return "" if other and kind not in _SWITCHES else kind


def _is_coil(sheet: Sheet, place: int) -> bool:
    """Whether a column may be of a coil, and not of a motor or of a test of resistance."""
    name = sheet.names[place]
    other = holds(name, "test current") or holds(name, "of the drive")
    return holds(name, "coil") and not other and _amperes(sheet, place) <= _COIL


def _switches(values: np.ndarray, part: tuple[int, int]) -> int:
    """Sample at which a contact first changes in a part of a record, -1 where it does not."""
    high = values[slice(*part)] > 0.5 * (np.nanmin(values) + np.nanmax(values))
    changes = np.flatnonzero(high[1:] != high[:-1])
    return int(changes[0]) if changes.size else -1
