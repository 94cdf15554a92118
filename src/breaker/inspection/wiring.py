"""Which columns of contacts and of a coil go with a column of travel, by number or phase."""

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from breaker.files import motion_of
from breaker.inspection.channels import Travel
from breaker.inspection.layouts import Layout
from breaker.inspection.printed_results import phase_of
from breaker.mechanism import MOTIONS

__all__ = ["Beside", "columns_beside"]

_CONTACT = re.compile(
    r"(?i)contact|kontakt|\bmain\b|\barc|\bbreak\b|chamber|kammer|interrupter|\bpir|^c(?=\d)|触头"
)
_ARCING = re.compile(r"(?i)\barc|lichtbogen|abbrenn|弧")
_BREAK = re.compile(r"(?i)\bbreak\b|chamber|kammer|interrupter")
_RESISTANCE = re.compile(r"(?i)resistance|widerst|\bres\b|ohm")
_COIL = re.compile(r"(?i)coil|spule|bobin|\btrip\b|solenoid|auslös|线圈")
_INSERTED = re.compile(r"(?i)resistor|\bpir|insertion|einschaltwid")
_OTHER = re.compile(r"(?i)\baux|\bhilfs|motor|heater|heizung")
_PHASES = re.compile(r"(?i)(?<![a-z])(l[123]|[rybacstuvw]|red|yellow|blue)(?![a-z])")
_FEWEST = 40  # samples


class Beside(NamedTuple):
    """What goes with a travel in a motion.

    Attributes:
        settings: Columns by ``contact_column`` and ``trigger_column`` of ``endurance.format``; a
            key is lacking where none is found.
        others: Columns of contacts of the same travel that are not taken.
    """

    settings: Mapping[str, str | int] = MappingProxyType({})
    others: tuple[str | int, ...] = ()


def columns_beside(
    layout: Layout, travels: Sequence[Travel], sign: int = 1
) -> list[dict[str, Beside]]:
    """Return what goes with each travel, by motion.

    A column goes with a travel of the same phase or number in its name, or where either has none; a
    coil whose name says the motion goes with that. As IEC 62271-100 counts the times of a pole, the
    arcing contacts go before the main ones, resistor contacts are left out, and of breaks in series
    that counts which touches last or parts first.

    Args:
        layout: Of the file.
        travels: Its columns of travel.
        sign: 1 if their reading grows towards closed, -1 if it falls.
    """
    own = [_marks(layout.names[each.place]) for each in travels]
    for order, (travel, (phases, _)) in enumerate(zip(travels, own, strict=True), start=1):
        phases |= {phase_of(layout, travel.place, order).casefold()} - {""}
    known = set().union(*(phases for phases, _ in own))
    there = [i for i in range(len(layout.names)) if _has_signal(layout, i)]
    found = []
    for travel, marks in zip(travels, own, strict=True):
        fits = [i for i in there if _go_together(layout.names[i], marks, known)]
        found.append({of: _of_motion(layout, fits, travel, of, sign) for of in MOTIONS})
    return found


def _of_motion(
    layout: Layout, fits: Sequence[int], travel: Travel, motion: str, sign: int
) -> Beside:
    """Contact and coil of a motion, of those columns that go with its travel."""

    def of(kind: re.Pattern) -> list[int]:
        return [i for i in fits if kind.search(layout.names[i])]

    contacts = of(_CONTACT) or of(_RESISTANCE)
    counted = [i for i in contacts if not _INSERTED.search(layout.names[i])]
    counted = [i for i in counted if _ARCING.search(layout.names[i])] or counted
    if not any(_marks(layout.names[travel.place])) and len(counted) > 1:
        # Of several numbers each may be a pole of its own.
        counted = [i for i in counted if _BREAK.search(layout.names[i])]
    if len(counted) > 1:
        at = {i: _switches(layout.columns[i], travel, motion, sign) for i in counted}
        counted = [i for i in counted if at[i] >= 0]
        counted.sort(key=at.__getitem__, reverse=motion == "closing")
    coils = [i for i in of(_COIL) if motion_of(layout.names[i]) in ("", motion)]
    taken = {"contact_column": counted[:1], "trigger_column": coils if len(coils) == 1 else []}
    settings = {key: layout.column(places[0]) for key, places in taken.items() if places}
    others = tuple(layout.column(i) for i in contacts if i not in counted[:1])
    return Beside(settings, others)


def _switches(values: np.ndarray, travel: Travel, motion: str, sign: int) -> int:
    """Sample at which a contact first changes in a motion, -1 where it does not."""
    rising = (motion == "closing") == (sign > 0)
    parts = [travel.part(k) for k in np.flatnonzero(travel.rises == rising)]
    begin, end = (parts or [(0, values.size)])[0]
    high = values[begin:end] > 0.5 * (np.nanmin(values) + np.nanmax(values))
    changes = np.flatnonzero(high[1:] != high[:-1])
    return int(changes[0]) if changes.size else -1


def _has_signal(layout: Layout, place: int) -> bool:
    """Whether a column that may be one of a contact or coil has a signal."""
    values = layout.columns[place]
    there = values[np.isfinite(values)]
    named = not _OTHER.search(layout.names[place])
    return named and there.size >= _FEWEST and np.ptp(there) > 0.0


def _go_together(name: str, own: tuple[set, set], known: set) -> bool:
    """Whether a column goes with a travel of these phases and numbers, of all phases known."""
    (phases, numbers), (own_phases, own_numbers) = _marks(name), own
    if phases & known:
        return bool(phases & own_phases)
    if numbers and own_numbers:
        return bool(numbers & own_numbers)
    return not (phases or numbers) or not (own_phases or own_numbers)


def _marks(name: str) -> tuple[set[str], set[str]]:
    """Phases and numbers in the name of a column."""
    bare = re.sub(r"[\[(].*?[\])]|^[cC](?=\d)", " ", name)  # A may be a unit, or a phase
    phases = {each.casefold() for each in _PHASES.findall(bare)}
    return phases, set(re.findall(r"(?<![lL\d])\d+", bare))
