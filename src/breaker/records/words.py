"""Meanings of manufacturers' words for columns, units, motions and phases, from ``words.yaml``.

A column is found by its exact name, or else without its unit and in any case. A unit stands alone,
in brackets, or after a name; after a blank only if the name is of a time or a travel. The case of a
single letter matters, and letters of phases are not units: `Travel (S)`.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

_LONGEST = 200  # most signs of a name or text that are searched: bounds the time

BESIDE = ("contact", "current", "trigger")
"""Columns that a record may have in addition to time and travel, in any unit."""

MOTION_OF = {"C": "closing", "O": "opening"}
"""Motions by their letters in a sequence."""


def _joined(value: Any) -> Any:
    """Join the lines of long expressions."""
    if not isinstance(value, dict):
        return value
    joined = {k: "|".join(v) if isinstance(v, list) else v for k, v in value.items()}
    return {key: _joined(word) for key, word in joined.items()}


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # a tenth of the time
_TEXT = Path(__file__).with_name("words.yaml").read_text(encoding="utf-8")

WORDS: dict[str, Any] = {k: _joined(v) for k, v in yaml.load(_TEXT, Loader=_LOADER).items()}
"""Words by the keys of the lexicon."""


def any_of(words: Mapping[str, str]) -> str:
    """Return one regular expression for words of all languages, for text in lower case."""
    return f"(?:{'|'.join(words.values())})"


def by_words(table: Mapping[str, Mapping[str, str]]) -> Callable[[str], tuple[str, ...]]:
    """Return a function that finds the meanings of a text in a table of words for each meaning."""
    patterns = {meaning: re.compile(any_of(words)) for meaning, words in table.items()}

    @lru_cache(maxsize=2048)  # files of a folder have the same names
    def meant(text: str) -> tuple[str, ...]:
        return tuple(meaning for meaning, known in patterns.items() if known.search(text))

    return lambda text: meant(text[:_LONGEST].lower())


_kinds_of = by_words(WORDS["columns"])


def holds(name: str, kind: str) -> bool:
    """Return whether the name of a column has a meaning ``kind`` of the lexicon's ``columns``."""
    return kind in _kinds_of(name)


def wanted_columns(names: Sequence[str], settings: Mapping) -> dict[str, str | int]:
    """Return the columns of a record by kind, as settings name them. A travel column in digits is
    a number, unless it is one of the names.
    """
    travel = settings["travel_column"]
    if str(travel).isdecimal() and not places_of(names, str(travel)):
        travel = int(travel)
    wanted = {"time": settings["time_column"], "travel": travel}
    wanted |= {kind: settings[f"{kind}_column"] or None for kind in BESIDE}  # 0 is a time
    return {kind: column for kind, column in wanted.items() if column is not None}


def label_of(column: str | int) -> str:
    """Return the name of a column in messages."""
    return f"column {column}" if isinstance(column, int) else repr(column)


def places_of(row: Sequence[str], column: str | int) -> list[int]:
    """Return the places, from 0, of a column in a row of names."""
    if isinstance(column, int):
        return [column - 1] if column <= len(row) else []
    if column.casefold() not in "\n".join(row).casefold():
        return []
    names = [cell.strip() for cell in row]
    if column not in names:
        names = [split_unit(name)[0] for name in names]
    if column not in names:
        names, column = [name.casefold() for name in names], column.casefold()
    return [i for i, name in enumerate(names) if name == column]


_KNOWN = {spelling: unit for unit, spelt in WORDS["units"].items() for spelling in spelt.split()}
_KNOWN |= {other: other for other in WORDS["other_units"].split()}
_FOLDED = {spelling.casefold(): unit for spelling, unit in _KNOWN.items()}
_BEHIND = re.compile(
    r"(.*?)\s*(?:\[(.*)\]|\((.*)\)|/\s*(\S+)|(?:^|\s)in\s+(\S+)|[,_]\s*(\w{2,}|m|°)|([°º˚])"
    r"|(?<=\s)(?P<bare>[^\W_]{2,}|[ms]))\s*"
)
_AMPERES = re.compile(r"([\[(/,_ ])\s*(mA|A|[Aa]mp(?:ere)?s?)\s?[\])]?\Z")


def unit_of(text: str) -> str | None:
    """Return the unit that a text states, as the settings call it, or None if it is not known."""
    bare = text.strip().strip("[](){}<>").strip().removesuffix(".")
    return _KNOWN.get(bare) or (_FOLDED.get(bare.casefold()) if len(bare) > 1 else None)


def split_unit(name: str) -> tuple[str, str | None]:
    """Return the name of a column without its unit, and the unit, None without a unit."""
    match = _BEHIND.fullmatch(name) if len(name) <= _LONGEST else None
    if not match:
        return name, None
    suffix = next(filter(None, match.groups()[1:]), "")
    unit = unit_of(suffix)
    if match["bare"] and suffix not in WORDS["no_units"]:  # no unit in `Coil s` and `Travel min`
        timely = holds(match[1], "time") or holds(match[1], "travel")
        unit = unit if timely and unit in WORDS["units"] else None
    elif suffix.strip() in WORDS["no_units"]:
        inches = "in" in match.groups()[1:3] and holds(match[1], "travel")
        unit = unit if inches or match[5] else None  # `CH1 in V`
    return (match[1] or name, unit) if unit else (name, None)


def amperes_of(name: str, unit: str = "") -> float:
    """Return the amperes of one unit of a column; nan if the unit, which may be stated separately
    from the name, is not a current. An `A` after a name is a phase, unless it names a current.
    """
    if unit.strip():
        return WORDS["amperes"].get(unit_of(unit), float("nan"))
    match = _AMPERES.search(name[-_LONGEST:].rstrip())
    if not match or (match[2] == "A" and match[1] != "[" and not holds(name, "current")):
        return float("nan")
    return WORDS["amperes"]["mA" if match[2] == "mA" else "A"]


def microohms_of(name: str, unit: str = "") -> float:
    """Return the microohms of one unit of a column; nan if the unit is not a resistance."""
    stated = unit_of(unit) if unit.strip() else split_unit(name)[1]
    stated = stated or unit_of(name.rpartition(" ")[2])
    return WORDS["microohms"].get(stated, float("nan"))


_ALONE = r"(?<![^\W\d_])(?:{})(?![^\W\d_])"  # Chinese has no blanks
motions_in = by_words(
    {
        motion: {k: forms if k == "zh" else _ALONE.format(forms) for k, forms in by.items()}
        for motion, by in WORDS["motion_words"].items()
    }
)
"""Motions that words of a text name."""


def motion_of(text: str) -> str:
    """Return the motion that a text names, empty if it names neither or both."""
    letter = re.match(r"\s*([CO])\b", text)
    named = motions_in(text) or (letter and (MOTION_OF[letter[1]],)) or ()
    return named[0] if len(named) == 1 else ""


def sequence_of(text: str) -> str:
    """Return the sequence of motions that a text states, such as ``"C-O"``."""
    words = re.findall(r"[^\W\d_]+", text.lower())
    letters = WORDS["letters"]
    parts = [part for word in words for part in (word if {*word} <= {*letters} else [word])]
    if max(map(len, words), default=0) == 1:
        letters = letters | WORDS["foreign_letters"]
    initials = {motion: letter for letter, motion in MOTION_OF.items()}
    named = (letters.get(part) or initials.get(motion_of(part), "") for part in parts)
    return "-".join(filter(None, named))


PHASE = WORDS["phases"]
"""A phase as it stands in the name of a file, in capitals: a regular expression."""

COLUMN_PHASE = "|".join([PHASE.lower(), *WORDS["colours"]])
"""A phase as it may stand in the name of a column, in lower case: a regular expression."""

IN_FILE = re.compile(rf"(?<![^\W_])({PHASE})(?![^\W_])")
"""A phase in the name of a file."""

_NO_LETTER = r"(?:(?<![^\W\d_])|(?<=[\u4e00-\u9fff]))"
_LABELS = {key: any_of(words) for key, words in WORDS["labels"].items()}
CHANNEL = re.compile(
    rf"(?:{_NO_LETTER}{_LABELS['channel']}[\W_]*|^\s*(?=\d{{1,2}}\s*$))(\d+)\b", re.I
)
"""A channel with its number, its first group; a number of one or two digits alone is one."""

_PHASE = re.compile(
    rf"{_NO_LETTER}(?:{_LABELS['phase']}[\s_.:-]*(l?[123]|{COLUMN_PHASE})(?![^\W_])"
    rf"|({COLUMN_PHASE})[\W_]*{_LABELS['phase behind its letter']}?$)",
    re.I,
)


def channel_of(text: str) -> int:
    """Return the number of the channel that a text names, 0 without a channel."""
    match = CHANNEL.search(text)
    return int(match[1]) if match else 0


def phase_in(text: str) -> str:
    """Return the phase that a text names, empty without a phase."""
    match = _PHASE.search(split_unit(text.strip())[0])
    return next(filter(None, match.groups()), "").strip() if match else ""


def phases_in_names(files: Iterable[Path]) -> dict[Path, str]:
    """Return the phase in the name of each file; nothing if a name lacks a phase.

    A letter is a phase if names differ only in it and in digits, and all letters are of one system.

    >>> [*phases_in_names([Path("108-R 1.csv"), Path("108-Y 1.csv")]).values()]
    ['R', 'Y']
    """
    groups: dict[str, dict[Path, str]] = defaultdict(dict)
    for file in files:
        matches = IN_FILE.findall(file.stem)
        other = re.sub("[0-9]", "0", IN_FILE.sub("", file.stem))
        groups[other][file] = matches[0] if len(matches) == 1 else ""
    named = {}
    for phases in groups.values():
        there = {*phases.values()}
        if len(there) < 2 or not any(there <= {*system.split()} for system in WORDS["systems"]):
            return {}
        named |= phases
    return named
