"""Tables and words of the page of a fleet."""

import pandas as pd

from breaker.common.document import Cell, Document, Table
from breaker.common.numerals import in_digits
from breaker.prognosis.drive_document import FLEET_STATES

TONES = dict(zip(FLEET_STATES, ("doubt", "good", *3 * ("doubt",), "bad"), strict=True))
"""What a state means, as of ``documents.parts.Cell``."""

_SHOWN = ("breaker", "phase", "type", "last", "state", "due_date", "odd", "pole_spread")


def fleet_document(table: pd.DataFrame, types: pd.DataFrame) -> Document:
    """Return the tables of ``fleet_table`` and ``type_table`` in words, drives in their order."""
    counts = table.state.value_counts()
    states = [f"{counts[each]} {each}" for each in reversed(FLEET_STATES) if each in counts]
    odd = int((table.odd != "").sum())
    plate = [
        ("Breakers", str(table.breaker.nunique())),
        ("Drives", str(len(table))),
        ("Last visit", str(table["last"].max())),
        ("State", ", ".join(states)),
    ]
    rows = [
        (*(_cell(name, each[name]) for name in _SHOWN), each["reason"])
        for each in table.to_dict("records")
    ]
    head = (*(name.replace("_", " ") for name in _SHOWN), "reason")
    of = sorted({each.replace("_", " ") for each in table.pole_spread_of if each})
    notes = [f"pole spread: ms, of {' or '.join(of)}"] if of else []
    notes.append("fleet.csv has all columns")
    known = [
        [in_digits(value, 3) if isinstance(value, float) else str(value) for value in row]
        for row in types.itertuples(index=False)
    ]
    tables = [
        Table(head, rows, "By what is due", notes),
        Table([*types.columns], known, "Types", ["spread: log-sd from drive to drive"]),
    ]
    worst = FLEET_STATES[max(map(FLEET_STATES.index, table.state))]
    verdict = Cell(f"{', '.join(states)}; unlike their type: {odd}", TONES[worst])
    return Document("Fleet", plate, [verdict], tables)


def _cell(name: str, value: object) -> Cell:
    if name == "state":
        return Cell(str(value), TONES[str(value)])
    text = f"{value:.2f}" if isinstance(value, float) else str(value)
    return Cell("" if text == "nan" else text, "bad" if name == "odd" else "")
