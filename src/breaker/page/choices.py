"""Choices in the address of a page: files, type of breaker, and import settings of the files.

The server keeps no other state, so two windows are independent, and an address always shows the
same page.
"""

import json
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, get_args
from urllib.parse import quote, unquote_to_bytes, urlencode

from breaker.configuration.settings import Unit
from breaker.diagnosis.estimate import DriveRecord
from breaker.records.proposal import Proposal
from breaker.records.settings import FORMAT, TO_MS
from breaker.records.sheet import Sheet

_SET = "set."
LABELS = {
    "rate": "Sampling rate (kHz)",
    "time_column": "Column of time",
    "time_unit": "Unit of time",
    "travel_column": "Column of travel",
    "travel_unit": "Unit of travel",
    "ratio": "Scale (mm per unit)",
    "sign": "The reading rises when the breaker",
    "zero": "Reading of the open breaker (a number, or rest)",
    "contact_column": "Contact",
    "current_column": "Test current",
    "trigger_column": "Coil",
    "decimal": "Decimal sign",
}
"""Import settings of the page: keys of ``endurance.format``, and their names."""

_OPTIONS = {
    "time_unit": {unit: unit for unit in TO_MS},
    "travel_unit": {unit: unit for unit in get_args(Unit)},
    "sign": {1: "closes", -1: "opens"},
    "decimal": {".": "point", ",": "comma"},
}
_NO_COLUMN = {"travel_column": "every column that moves", "time_column": "none: use the rate"}


def labelled(text: str) -> str:
    """Return a text with the names on the page for keys of ``endurance.format``."""
    name = lambda key: repr(LABELS[key[1]]) if key[1] in LABELS else key[0]  # noqa: E731
    return re.sub(r"endurance\.format\.(\w+)", name, text)


class Choices(NamedTuple):
    """Content of a page.

    Attributes:
        files, before: Identifiers of the files of the inspection and of the earlier inspection.
        type: Type of breaker; empty for the type that the files state.
        settings: Changes to ``endurance.format``.
        same: Whether both inspections have the same transducer.
    """

    files: tuple[str, ...] = ()
    before: tuple[str, ...] = ()
    type: str = ""
    settings: Mapping[str, Any] = {}
    same: bool = False

    @property
    def query(self) -> str:
        """Query of the address.

        >>> Choices(("a.csv",), settings={"rate": 5.0}).query
        'file=a.csv&set.rate=5.0'
        """
        pairs = [("file", name) for name in self.files] + [("before", n) for n in self.before]
        pairs += [("type", self.type)] * bool(self.type) + [("same", "1")] * self.same
        pairs += [(_SET + key, as_text(value)) for key, value in self.settings.items()]
        return urlencode(pairs)


def read_choices(query: Mapping[str, Sequence[str]]) -> Choices:
    """Read the query of an address.

    Raises:
        ValueError: If the page has no such setting.
    """
    settings = {}
    for name, values in query.items():
        if name.startswith(_SET):
            if (key := name.removeprefix(_SET)) not in LABELS:
                raise ValueError(f"the page has no setting {name!r}; go back to the list")
            settings[key] = _value(key, values[-1].strip())
    if settings.get("travel_column") is None:  # all columns that move
        settings.pop("travel_column", None)
    files, before = (tuple(dict.fromkeys(query.get(key, ()))) for key in ("file", "before"))
    return Choices(files, before, query.get("type", [""])[-1].strip(), settings, "same" in query)


def _value(key: str, text: str) -> Any:
    """Return the value of a setting, unchecked; ``check`` later checks the entire configuration."""
    if not text:
        return None if key.endswith("_column") else FORMAT[key]
    try:
        return json.loads(text.replace(",", ".") if key in ("rate", "ratio", "zero") else text)
    except ValueError:
        return text


def as_text(value: object) -> str:
    """Return the text of a field for a value.

    >>> as_text("S 1"), as_text(None), as_text(5.0)
    ('"S 1"', '', '5.0')
    """
    return "" if value is None else json.dumps(value, ensure_ascii=False)


def id_of(name: str) -> str:
    r"""Return the name of a file, with any bytes, as an identifier of plain characters.

    >>> name_of(id_of("Weg \udce9 %41.csv"))
    'Weg \udce9 %41.csv'
    """
    return quote(os.fsencode(name), safe="/ ()+,;=@")


def name_of(identity: str) -> str:
    """Return the file name of an identifier."""
    return os.fsdecode(unquote_to_bytes(identity))


class SettingRow(NamedTuple):
    """An import setting on the page.

    Attributes:
        key, label: Key of ``endurance.format``, and name on the page.
        text: Value as text.
        state, reason: "missing", "doubtful", "chosen" or "sure", and source of the value.
        options: Texts of a choice with their names; empty for a text field.
    """

    key: str
    label: str
    text: str
    state: str
    reason: str
    options: Mapping[str, str]


def rows_of(
    base: Mapping[str, Any],
    chosen: Mapping[str, Any],
    proposal: Proposal | None,
    sheet: Sheet | None,
    records: Sequence[DriveRecord],
) -> list[SettingRow]:
    """Return the rows of the import settings, settings that need a decision first. ``base`` are
    the settings before any choice.
    """
    columns = [sheet.column(i) for i in range(len(sheet.columns))] if sheet else []
    rows = []
    for key, label in LABELS.items():
        value = chosen.get(key, None if key == "travel_column" else base[key])
        used = (record.operation.settings.get(key) for record in records)
        stated = [*dict.fromkeys(str(setting) for setting in used if setting is not None)]
        state, reason = "sure", "default" if base[key] == FORMAT[key] else "from the configuration"
        if key in chosen:
            state, reason = "chosen", "your choice"
        elif stated:
            reason = f"{', '.join(stated)}: stated by the file or its table"
        elif proposal and key in proposal.lacking:
            state, reason = "missing", f"fill it in: {proposal.lacking[key]}"
        elif proposal and (doubts := proposal.findings.doubts.get(key)):
            state, reason = "doubtful", "; ".join(doubts)
        elif proposal and base[key] != FORMAT[key]:
            reason = "seen in the file"
        options = {as_text(option): name for option, name in _OPTIONS.get(key, {}).items()}
        if key.endswith("_column"):
            options = {"": _NO_COLUMN.get(key, "the one that belongs to each travel")}
            options |= {as_text(column): str(column) for column in columns}
        if options:
            options.setdefault(as_text(value), str(value))
        rows.append(SettingRow(key, label, as_text(value), state, reason, options))
    return sorted(rows, key=lambda row: ("missing", "doubtful", "chosen", "sure").index(row.state))
