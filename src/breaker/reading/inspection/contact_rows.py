"""Which travel and phase a contact belongs to, as rows above the columns of an analyser state it.

Such rows are aligned with the columns of contacts: one names the transducer of each (``TR1``), one
the phase and the number of its break (``YBreak2``, or ``NA`` where nothing is connected).
"""

import re
from collections.abc import Iterable, Mapping, Sequence

from breaker.reading.files.format_settings import TO_MM
from breaker.reading.files.lexicon import LABELS
from breaker.reading.files.word_meanings import PHASE, any_of, holds, split_unit

_TRAVEL = re.compile(rf"{any_of(LABELS['transducer'])}\W{{0,2}}0*(\d+)", re.I)
_BREAK = re.compile(rf"({PHASE})?\W{{0,2}}{any_of(LABELS['break'])}\W{{0,2}}\d*", re.I)
_NOT_CONNECTED = re.compile(any_of(LABELS["not connected"]), re.I)


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
        of_travel = {i: m[1] for i, cell in cells.items() if (m := _TRAVEL.fullmatch(cell))}
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
