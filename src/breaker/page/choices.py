"""What the address of a page chooses: files, the type of breaker, and how the files are read.

Nothing else is remembered, so two windows do not disturb each other, and an address that is opened
again shows the same.
"""

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple
from urllib.parse import quote, unquote_to_bytes, urlencode

from breaker.diagnosis.estimate import DriveRecord
from breaker.records.proposal import Proposal
from breaker.records.settings import FORMAT, TO_MM, TO_MS
from breaker.records.sheet import Sheet

_SET = "set."
_LONGEST = 200  # characters of a value: a longer one is a mistake

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
    "motor_column": "Motor",
    "decimal": "Decimal sign",
}
"""Import settings of the page: keys of ``endurance.format``, and their names."""

_OPTIONS = {
    "time_unit": {unit: unit for unit in TO_MS},
    "travel_unit": {unit: unit for unit in (*TO_MM, "deg", "V", "mV", "%")},
    "sign": {1: "closes", -1: "opens"},
    "decimal": {".": "point", ",": "comma"},
}
_NO_COLUMN = {"travel_column": "every column that moves", "time_column": "none: use the rate"}


class Choices(NamedTuple):
    """What a page shows.

    Attributes:
        files, before: Identifiers of files, of the inspection and of the earlier one.
        type: Type of breaker; empty for the one that the files state.
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
        """The query of the address.

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
        ValueError: If the page has no such setting, or a value is too long.
    """
    settings = {}
    for name, values in query.items():
        if name.startswith(_SET):
            if (key := name.removeprefix(_SET)) not in LABELS or len(values[-1]) > _LONGEST:
                raise ValueError(f"the page has no setting {name[:_LONGEST]!r} of this value")
            settings[key] = _value(key, values[-1].strip())
    if settings.get("travel_column") is None:  # all that move
        settings.pop("travel_column", None)
    files, before = (tuple(dict.fromkeys(query.get(key, ()))) for key in ("file", "before"))
    of_type = query.get("type", [""])[-1].strip()[:_LONGEST]
    return Choices(files, before, of_type, settings, "same" in query)


def _value(key: str, text: str) -> Any:
    """Return the value of a setting: the configuration is checked as a whole where it is read."""
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
    r"""Return the name of a file in plain characters, whatever bytes it has.

    >>> name_of(id_of("Weg \udce9 %41.csv"))
    'Weg \udce9 %41.csv'
    """
    return quote(os.fsencode(name), safe="/ ()+,;=@")


def name_of(identity: str) -> str:
    """Return the name of an identifier."""
    return os.fsdecode(unquote_to_bytes(identity))


# ---- the form of the import settings -------------------------------------------------------------


class SettingRow(NamedTuple):
    """An import setting as the page shows it.

    Attributes:
        key, label: Its key of ``endurance.format``, and its name.
        text: Its value.
        state, reason: "missing", "doubtful", "chosen" or "sure", and where the value is from.
        options: Texts of a choice with their names; none of a field for text.
    """

    key: str
    label: str
    text: str
    state: str
    reason: str
    options: Mapping[str, str]


_STATES = ("missing", "doubtful", "chosen", "sure")


def rows_of(
    base: Mapping[str, Any],
    chosen: Mapping[str, Any],
    proposal: Proposal | None,
    sheet: Sheet | None,
    records: Sequence[DriveRecord],
) -> list[SettingRow]:
    """Return the form of the import settings: what must be decided stands first. ``base`` are the
    settings before any choice.
    """
    columns = [sheet.column(i) for i in range(len(sheet.columns))] if sheet else []
    rows = []
    for key, label in LABELS.items():
        value = chosen.get(key, None if key == "travel_column" else base[key])
        used = (record.operation.settings.get(key) for record in records)
        stated = [*dict.fromkeys(str(setting) for setting in used if setting is not None)]
        state, reason = "chosen", "your choice"
        if key not in chosen:
            state, reason = _reason_for(key, base, proposal, stated)
        options = {as_text(option): name for option, name in _OPTIONS.get(key, {}).items()}
        if key.endswith("_column"):
            options = {"": _NO_COLUMN.get(key, "the one that belongs to each travel")}
            options |= {as_text(column): str(column) for column in columns}
        if options:
            options.setdefault(as_text(value), str(value))
        rows.append(SettingRow(key, label, as_text(value), state, reason, options))
    return sorted(rows, key=lambda row: _STATES.index(row.state))


def _reason_for(
    key: str, base: Mapping[str, Any], proposal: Proposal | None, stated: Sequence[str]
) -> tuple[str, str]:
    """Return the state of a setting that was not chosen, and the reason for its value."""
    if stated:
        return "sure", f"{', '.join(stated)}: stated by the file or its table"
    if proposal and key in proposal.lacking:
        return "missing", f"fill it in: {proposal.lacking[key]}"
    if proposal and (doubts := proposal.findings.doubts.get(key)):
        return "doubtful", "; ".join(doubts)
    if base[key] == FORMAT[key]:
        return "sure", "default"
    return "sure", "seen in the file" if proposal else "from the configuration"
