"""Phases and channels that names of columns and of files state. Light to import."""

import re

from breaker.reading.files.column_names import split_unit
from breaker.reading.files.lexicon import COLOURS, LABELS, SYSTEMS
from breaker.reading.files.word_lookup import any_of

_LETTERS = "".join(dict.fromkeys("".join(SYSTEMS[1:]).replace(" ", "")))
_LETTER, _NUMBERED = f"[{_LETTERS}]", "L[123]"
PHASE = f"{_NUMBERED}|{_LETTER}"
"""A phase as it stands in the name of a file, in capitals: a regular expression."""

COLUMN_PHASE = "|".join([PHASE.lower(), *COLOURS])
"""A phase as it may stand in the name of a column, in lower case: a regular expression."""

_BETWEEN = "[,_+&]"
IN_FILE = re.compile(rf"(?<![^\W_])({PHASE})(?![^\W_])")
"""A phase in the name of a file."""

PHASES_IN_FILE = re.compile(rf"(?<![^\W_])(?:{PHASE})(?:{_BETWEEN}(?:{PHASE}))*(?![^\W_])")
"""A phase, or several that are listed, in the name of a file."""

LISTED = re.compile(
    rf"(?<![^\W_])(?:{_NUMBERED}(?:{_BETWEEN}{_NUMBERED})+|{_LETTER}(?:{_BETWEEN}{_LETTER})+)"
    r"(?![^\W_])"
)
"""Phases that the name of a file lists, as `A,B,C` does."""

_NONE = r"(?:(?<![^\W\d_])|(?<=[\u4e00-\u9fff]))"
_CHANNEL = re.compile(rf"{_NONE}{any_of(LABELS['channel'])}[\W_]*(\d+)\b", re.I)
_PHASE = re.compile(
    rf"{_NONE}(?:{any_of(LABELS['phase'])}[\s_.:-]*(l?[123]|{COLUMN_PHASE})(?![^\W_])"
    rf"|({COLUMN_PHASE})[\W_]*{any_of(LABELS['phase behind its letter'])}?$)",
    re.I,
)


def channel_of(text: str) -> int:
    """Return the number of the channel that a text names, 0 where it names none."""
    found = channel_in(text) or re.fullmatch(r"\s*(\d{1,2})\s*()", text)
    return int(found[1]) if found else 0


def channel_in(text: str) -> re.Match | None:
    """Find a channel with its number, its first group, in a text."""
    return _CHANNEL.search(text)


def phase_in(text: str) -> str:
    """Return the phase that a text names, empty where it names none.

    >>> phase_in("Phase R"), phase_in("L2"), phase_in("Travel 1")
    ('R', 'L2', '')
    """
    found = _PHASE.search(split_unit(text.strip())[0])
    return next(filter(None, found.groups()), "").strip() if found else ""


def listed_in(name: str) -> list[str]:
    """Return the phases that the name of a file lists, first ones first; none where it does not.

    >>> listed_in("201-A,B,C 03-01-2014"), listed_in("A 2014")
    (['A', 'B', 'C'], [])
    """
    found = LISTED.search(name)
    return re.split(_BETWEEN, found[0]) if found else []
