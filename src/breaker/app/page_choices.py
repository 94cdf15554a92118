"""What the address of a page says: which files are shown, and what of their settings was changed.

Nothing else is remembered, so two windows do not disturb each other, and a page that is opened
again shows the same.
"""

import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple
from urllib.parse import quote, unquote_to_bytes, urlencode

import yaml

from breaker.records.settings import FORMAT, TO_MM, TO_MS
from breaker.records.words import WORDS

WHOLE = "."
"""Id of the folder as a whole, by its table ``operations.csv`` or its folders of motions."""

_SET = "set."
_LONGEST = 200  # signs of a value


class Field(NamedTuple):
    """A setting that the page offers.

    Attributes:
        key: Of ``endurance.format``.
        label: What the page calls it.
        kind: "choice" of given values, "column" of the file, "number", or "text".
        options: Values and what they are called, of a choice.
        none: What no value means; empty where there must be one.
    """

    key: str
    label: str
    kind: str
    options: Sequence[tuple[Any, str]] = ()
    none: str = ""


def _same(values: Sequence[str]) -> list[tuple[str, str]]:
    return [(each, each) for each in values]


FIELDS = (
    Field("rate", "Rate (kHz, samples in a ms)", "number", none="by the column of times"),
    Field("time_column", "Column of the time", "column", none="none: the rate tells the times"),
    Field("time_unit", "Unit of the time", "choice", _same([*TO_MS])),
    Field("travel_column", "Column of the travel", "column", none="every column that moves"),
    Field(
        "travel_unit",
        "Unit of the travel",
        "choice",
        _same([*TO_MM, *sorted(WORDS["other_units"].split())]),
    ),
    Field("ratio", "Scale (mm for one unit)", "number", none="none: the unit is a length"),
    Field(
        "sign",
        "Motion: the reading grows when the breaker",
        "choice",
        ((1, "closes"), (-1, "opens")),
    ),
    Field("zero", "Reading of the open breaker (a number, or rest)", "text"),
    Field("contact_column", "Main contact", "column", none="as found beside each travel"),
    Field("current_column", "Test current", "column", none="as found beside the contact"),
    Field("trigger_column", "Coil", "column", none="as found beside each travel"),
    Field("motor_column", "Motor", "column", none="as found beside each travel"),
    Field("delimiter", "Sign between columns", "text"),
    Field("decimal", "Decimal sign", "choice", _same([".", ","])),
    Field("encoding", "Encoding", "text"),
)
"""The settings that the page offers, in the order of their importance."""

_FIELD = {each.key: each for each in FIELDS}


class Choices(NamedTuple):
    """What a page shows.

    Attributes:
        files, before: Ids of the files of the visit, and of the visit before.
        base: "seen", settings as they are proposed, or "configured"; empty for what suits.
        settings: What was changed of ``endurance.format``.
        same: Whether both inspections have the same transducer.
    """

    files: tuple[str, ...] = ()
    before: tuple[str, ...] = ()
    base: str = ""
    settings: Mapping[str, Any] = {}
    same: bool = False

    @property
    def address(self) -> str:
        """The query of the page's address.

        >>> Choices(("a.csv",), settings={"rate": 5.0}).address
        'file=a.csv&set.rate=5.0'
        """
        pairs = [("file", each) for each in self.files] + [("before", each) for each in self.before]
        pairs += [("base", self.base)] if self.base else []
        pairs += [("same", "1")] if self.same else []
        pairs += [(_SET + key, as_text(key, value)) for key, value in self.settings.items()]
        return urlencode(pairs)


def read_choices(query: Mapping[str, Sequence[str]]) -> Choices:
    """Read the query of an address.

    Raises:
        ValueError: If a setting is none that the page offers, or its value is none.
    """
    settings = {}
    for name, values in query.items():
        if name.startswith(_SET):
            if (key := name.removeprefix(_SET)) not in _FIELD:
                raise ValueError(f"the page has no setting {key!r}; leave it out of the address")
            settings[key] = _value(_FIELD[key], values[-1])
    if settings.get("travel_column") is None:  # all that move
        settings.pop("travel_column", None)
    base = query.get("base", [""])[-1]
    return Choices(
        tuple(dict.fromkeys(query.get("file", ()))),
        tuple(dict.fromkeys(query.get("before", ()))),
        base if base in ("seen", "configured") else "",
        settings,
        "same" in query,
    )


def _value(field: Field, text: str) -> Any:
    """A value of a setting, from the text of its field."""
    if len(text) > _LONGEST:
        raise ValueError(f"{field.label} has more than {_LONGEST} signs; shorten it")
    if field.kind in ("choice", "column"):
        try:
            value = json.loads(text or "null")
        except ValueError:
            value = text
        if not isinstance(value, str | int | None) or isinstance(value, bool):
            raise ValueError(f"{field.label}: {text!r} is no choice; choose one of the list")
        return value
    if field.kind == "text" and field.key != "zero":
        return text or FORMAT[field.key]
    if not text.strip():
        return FORMAT[field.key]
    if field.key == "zero" and text.strip() == "rest":
        return "rest"
    with suppress(ValueError):
        if math.isfinite(value := float(text.replace(",", "."))):
            return value
    raise ValueError(f"{field.label}: {text!r} is no number; write one, such as 10 or 0.25")


def as_text(key: str, value: object) -> str:
    """Return the text of a field for a value of its setting.

    >>> as_text("travel_column", "S 1"), as_text("rate", None), as_text("rate", 5.0)
    ('"S 1"', '', '5.0')
    """
    if _FIELD[key].kind in ("choice", "column"):
        return json.dumps(value, ensure_ascii=False)
    return "" if value is None else str(value)


def overlay_text(form: Mapping) -> str:
    """Return the lines of YAML that set what differs from the configuration; a comment where
    nothing does.

    >>> overlay_text({"rate": 5.0}).splitlines()
    ['endurance:', '  format:', '    rate: 5.0']
    """
    found = {"endurance": {"format": dict(form)}} if form else {}
    if not found:
        return "# nothing differs from the configuration\n{}\n"
    return yaml.safe_dump(found, sort_keys=False, allow_unicode=True)


def id_of(name: str) -> str:
    """Return the name of a file as a text of plain signs, whatever bytes it has."""
    return quote(os.fsencode(name), safe="/ ()+,;=@")


def name_of(identity: str) -> str:
    r"""Return the name of which ``id_of`` is the id.

    >>> name_of(id_of("Weg \udce9 %41.csv"))
    'Weg \udce9 %41.csv'
    """
    return os.fsdecode(unquote_to_bytes(identity))
