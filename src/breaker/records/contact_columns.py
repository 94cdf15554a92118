"""Which columns of contacts and of a coil go with a column of travel, by phase, number and time."""

import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from breaker.model.parameters import MOTIONS
from breaker.records.channels import Travel, stated_contacts
from breaker.records.layout import Layout
from breaker.records.settings import TO_MM
from breaker.records.words import COLUMN_PHASE, amperes_of, holds, motion_of

_AMPERES = re.compile(r"\bA\b|(?i:\bamp)")  # the unit, in its own case, or the word
_PHASES = re.compile(rf"(?<![a-z])({COLUMN_PHASE})(?![a-z])")
_FEWEST = 40  # samples
_LARGEST, _USUAL = 20.0, 0.98  # A, of a coil, and the share of its samples that has less
_SWITCHED = 3.0  # ratio of the resistances of a contact that is open and closed, at least
_ON = 0.25  # of its range, from which a coil is energised
_PULSE = (0.1, 15.0)  # least range of one that is: of the largest, and of its noise


class Beside(NamedTuple):
    """What goes with a travel in a motion.

    Attributes:
        settings: Columns by ``contact_column``, ``current_column``, ``trigger_column`` and
            ``motor_column`` of ``endurance.format``; a key is lacking where none is found.
        others: Columns of contacts of the same travel that are not taken.
    """

    settings: Mapping[str, str | int] = MappingProxyType({})
    others: tuple[str | int, ...] = ()


class _Pole(NamedTuple):
    """Phases and numbers of a travel, its place among the travels, from 1, and how many these are;
    and phases and numbers of all of them.
    """

    phases: set[str]
    numbers: set[str]
    order: int
    count: int
    known: set[str]
    numbered: set[str]


def columns_beside(
    layout: Layout, travels: Sequence[Travel], sign: int = 1
) -> list[dict[str, Beside]]:
    """Return what goes with each travel, by motion.

    A contact goes with the travel that rows above the columns state. Where none does, it goes with
    a travel of the same phase or number in its name, or where either has none; but of several
    resistances, which are numbered by channel, nobody knows what the channels belong to.
    As IEC 62271-100 counts the times of a pole, the arcing contacts go before the main ones,
    resistor contacts are left out, and of breaks in series that counts which touches last or parts
    first. A coil goes with the motion that its name says, and without one with those that it is
    energised before. Its number is that of a pole where as many coils as poles are energised; else
    it is one of several for all poles, of which the first that is energised counts.

    Args:
        layout: Of the file.
        travels: All of its columns of travel.
        sign: 1 if their reading grows towards closed, -1 if it falls.
    """
    own = [_marks(layout.names[each.place]) for each in travels]
    for travel, (phases, _) in zip(travels, own, strict=True):
        phases |= {travel.phase.casefold()} - {""}
    travelling = {each.place for each in travels}
    there = [i for i in range(len(layout.names)) if _has_signal(layout, i)]
    there = [i for i in there if i not in travelling and layout.units[i] not in TO_MM]
    taken = [layout.names[i] if i not in travelling else "" for i in range(len(layout.names))]
    stated = stated_contacts(layout.preamble, taken)
    several = len(_named(layout, there, "resistance")) > 1
    known = _known_phases(own)
    numbered = set().union(*(numbers for _, numbers in own))
    found = []
    for order, (travel, marks) in enumerate(zip(travels, own, strict=True), start=1):
        pole = _Pole(*marks, order, len(travels), known, numbered)
        fits = [i for i in there if _go_together(layout.names[i], pole, several)]
        contacts = _named(layout, fits, "contact") or _named(layout, fits, "resistance")
        if stated is not None:
            own = pole.numbers or {str(order)}
            contacts = [i for i in there if i in stated and stated[i][0] in own]
        each = {}
        for motion in MOTIONS:
            own_way = travel.rises == ((motion == "closing") == (sign > 0))
            k = int(own_way.argmax())
            counted = _counted(layout, contacts, travel, (motion, k))
            coils = coils_before(layout, travel, k) if own_way.any() else {}
            taken = {
                "contact_column": counted,
                "trigger_column": _coil(layout, coils, motion, pole),
                "motor_column": _motor(layout) if motion == "closing" else [],
            }
            taken["current_column"] = current_of(layout, counted[0]) if counted else []
            settings = {key: layout.column(places[0]) for key, places in taken.items() if places}
            others = (layout.column(i) for i in contacts if i not in counted[:1])
            each[motion] = Beside(settings, tuple(others))
        found.append(each)
    return found


def current_of(layout: Layout, contact: int) -> list[int]:
    """Return the column of the test current of a contact's resistance, by place; none or one.

    Analysers of dynamic resistance write it behind the resistance, under the same number or phase.
    """
    place = contact + 1
    if place >= len(layout.names) or not holds(layout.names[contact], "resistance"):
        return []
    name, unit = layout.names[place], layout.units[place] or ""
    flows = np.isfinite(amperes_of(name, unit)) or holds(name, "current")
    alike = _marks(name) == _marks(layout.names[contact])
    return [place] if flows and alike and not holds(name, "resistance") else []


def coils_before(layout: Layout, travel: Travel, k: int) -> dict[int, int]:
    """Return the columns of coils, and the sample at which each is energised before a motion, k,
    of a travel; -1 where it is not.
    """
    named = [i for i in _named(layout, range(len(layout.names)), "coil") if _is_coil(layout, i)]
    ranges = {i: float(np.nanmax(layout.columns[i]) - np.nanmin(layout.columns[i])) for i in named}
    begin, end = travel.part(k)[0], int(travel.course.middles[k])
    found = dict.fromkeys(named, -1)
    for i in named:
        values = layout.columns[i]
        noise = 1.4826 * float(np.nanmedian(np.abs(np.diff(values, n=3)))) / np.sqrt(20.0)
        if ranges[i] < max(_PULSE[0] * max(ranges.values()), _PULSE[1] * noise):
            continue
        on = np.abs(values - np.nanmedian(values)) > _ON * ranges[i]
        edges = np.flatnonzero(on & ~np.append(False, on[:-1]))
        edges = edges[(edges >= begin) & (edges < end)]
        found[i] = int(edges[0]) if edges.size else -1
    return found


def closes_by_resistance(layout: Layout, travel: Travel) -> float:
    """Return how surely resistances of contacts fall in the first motion of a travel: 1 where all
    that change do, -1 where all rise, 0 where there are none.
    """
    begin, end = travel.part(0)
    fall = []
    for i in _named(layout, range(len(layout.names)), "resistance"):
        values = layout.columns[i][begin:end]
        if not _has_signal(layout, i) or not np.isfinite(values).all():
            continue
        count = max(_FEWEST // 4, travel.begins(0) - begin)
        before, after = (np.median(np.abs(each)) for each in (values[:count], values[-count:]))
        if max(before, after) > _SWITCHED * min(before, after):
            fall.append(np.sign(before - after))
    return float(np.mean(fall)) if fall else 0.0


def switches_at(layout: Layout, travel: Travel) -> float:
    """Return the share of the first motion of a travel after which contacts switch in it, their
    median; nan where none does. A gap is most of the way: they touch late, and part early.
    """
    part, done, found = travel.part(0), travel.done(0), []
    for i in _named(layout, range(len(layout.names)), "contact"):
        if i != travel.place and layout.units[i] not in TO_MM and _has_signal(layout, i):
            at = _switches(layout.columns[i], part)
            if at >= 0 and travel.begins(0) <= part[0] + at:
                found.append(float(done[part[0] + at]))
    return float(np.median(found)) if found else float("nan")


def _known_phases(poles: Sequence[tuple[set[str], set[str]]]) -> set[str]:
    """All phases of travels."""
    if len(poles) > 1 and all(phases == poles[0][0] for phases, _ in poles):
        for phases, _ in poles:  # a letter that all have, as in s1 and s2, is no phase
            phases.clear()
    return set().union(*(phases for phases, _ in poles))


def _coil(layout: Layout, at: Mapping[int, int], motion: str, pole: _Pole) -> list[int]:
    """The coil of a motion of a pole, of those that are energised at some samples; none or one."""
    marks = {i: _marks(layout.names[i]) for i in at}
    own = [i for i in at if not marks[i][0] & pole.known or marks[i][0] & pole.phases]
    own = [i for i in own if motion_of(layout.names[i]) in ("", motion)]
    energised = [i for i in own if at[i] >= 0]
    energised = [i for i in energised if motion_of(layout.names[i])] or energised
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
    layout: Layout, contacts: Sequence[int], travel: Travel, motion: tuple[str, int]
) -> list[int]:
    """Contacts of a travel that may count in a motion, k, the one that does first."""
    counted = [i for i in contacts if not holds(layout.names[i], "resistor contact")]
    counted = _named(layout, counted, "arcing") or counted
    if not any(_marks(layout.names[travel.place])) and len(counted) > 1:
        # Of several numbers each may be a pole of its own.
        counted = _named(layout, counted, "break")
    if len(counted) > 1:
        at = {i: _switches(layout.columns[i], travel.part(motion[1])) for i in counted}
        counted = [i for i in counted if at[i] >= 0]
        counted.sort(key=at.__getitem__, reverse=motion[0] == "closing")
    return counted


def _switches(values: np.ndarray, part: tuple[int, int]) -> int:
    """Sample at which a contact first changes in a part of a record, -1 where it does not."""
    high = values[slice(*part)] > 0.5 * (np.nanmin(values) + np.nanmax(values))
    changes = np.flatnonzero(high[1:] != high[:-1])
    return int(changes[0]) if changes.size else -1


def _named(layout: Layout, places: Iterable[int], kind: str) -> list[int]:
    return [i for i in places if holds(layout.names[i], kind)]


def _has_signal(layout: Layout, place: int) -> bool:
    """Whether a column that may be one of a contact or coil has a signal."""
    values = layout.columns[place]
    there = values[np.isfinite(values)]
    named = not holds(layout.names[place], "of the drive")
    return named and there.size >= _FEWEST and np.ptp(there) > 0.0


def _is_coil(layout: Layout, place: int) -> bool:
    """Whether a column of a current may be that of a coil, and not that of a resistance test."""
    if not _has_signal(layout, place) or holds(layout.names[place], "test current"):
        return False
    name, before = layout.names[place], layout.names[place - 1] if place else ""
    pair = holds(before, "resistance") and _marks(before)[1] == _marks(name)[1]
    usual = np.nanquantile(np.abs(layout.columns[place]), _USUAL)
    return not pair and not (_AMPERES.search(name) and usual > _LARGEST)


def _motor(layout: Layout) -> list[int]:
    """The column of a motor's current; of several, nobody knows whose each is."""
    named = _named(layout, range(len(layout.names)), "motor")
    found = [i for i in named if np.isfinite(amperes_of(layout.names[i], layout.units[i] or ""))]
    found = [i for i in found if np.isfinite(layout.columns[i]).sum() >= _FEWEST]
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
    bare = re.sub(r"[\[(].*?[\])]|\b[cCtT](?=\d)", " ", name)  # A may be a unit, or a phase
    return set(_PHASES.findall(bare.lower())), set(re.findall(r"(?<![lL\d])\d+", bare))
