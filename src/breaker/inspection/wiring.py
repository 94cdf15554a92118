"""Which columns of a contact and of a coil go with a column of travel, by number or phase."""

import re
from collections.abc import Mapping

import numpy as np

from breaker.files import phase_in
from breaker.inspection.guesses import motion_in
from breaker.inspection.layouts import Layout

__all__ = ["columns_beside"]

# The first kind of column that is there counts.
_KINDS = {
    "contact_column": (
        re.compile(r"(?i)(?<!aux )(?:contact|kontakt|\bmain\b|触头)"),
        re.compile(r"(?i)resist|widerst|\bres\b|ohm"),
    ),
    "trigger_column": (re.compile(r"(?i)coil|spule|bobin|\btrip\b|solenoid|线圈"),),
}
_OTHER = re.compile(r"(?i)\baux|\bhilfs|motor|heater|heizung")
_FEWEST = 40  # samples


def columns_beside(layout: Layout, place: int, motion: str) -> Mapping[str, str | int]:
    """Return settings of ``endurance.format`` that name the contact and the coil of a travel.

    A column goes with a travel of the same number or phase in its name, or where either has none;
    a coil whose name says the motion goes with that. Of several alike, as of two breaks in series,
    none is taken.

    Args:
        layout: Of the file.
        place: Column of the travel.
        motion: "closing" or "opening".

    Returns:
        Columns by ``contact_column`` and ``trigger_column``; a key is lacking where none is found.
    """
    found, own = {}, _key(layout, place)
    for key, kinds in _KINDS.items():
        of_kinds = ([i for i in range(len(layout.names)) if _is(layout, i, kind)] for kind in kinds)
        alike = next(filter(None, of_kinds), [])
        alike = [i for i in alike if not own or _key(layout, i) in ("", own)]
        if key == "trigger_column":
            alike = [i for i in alike if motion_in(layout.names[i]) in (None, motion)]
        if len(alike) == 1:
            found[key] = layout.column(alike[0])
    return found


def _is(layout: Layout, place: int, kind: re.Pattern) -> bool:
    """Whether a column is of a kind by its name, and has a signal."""
    name, values = layout.names[place], layout.columns[place]
    there = values[np.isfinite(values)]
    named = kind.search(name) and not _OTHER.search(name)
    return bool(named) and there.size >= _FEWEST and np.ptp(there) > 0.0


def _key(layout: Layout, place: int) -> str:
    """Phase or number in the name of a column."""
    name = re.sub(r"[\[(].*?[\])]", "", layout.names[place])  # A may be a unit, or a phase
    numbers = re.findall(r"\d+", name)
    return phase_in(name) or (numbers[-1] if numbers else "")
