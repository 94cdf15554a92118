"""What words of makers mean, by the lexicon: units, columns by name, motions, phases, channels.

A column is found by its name in these words, or else without regard to capitals and to a unit
behind it. A unit is bare, in brackets, or behind a name, in the usual languages; behind a blank
only if the name is of a time or a travel. `Grad` is a degree, as no transducer reads gons. A single
letter counts in its own case, and letters of phases are no units behind a name: `Travel (S)`.

Light to import: words are compiled when looked for.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path

from breaker.records.files import RejectedCurveError
from breaker.records.lexicon import WORDS

_LONGEST = 200  # signs of a text that is remembered


def any_of(words: Mapping[str, str]) -> str:
    """Return one regular expression for words of all languages, for text in lower case."""
    return f"(?:{'|'.join(words.values())})"


@cache
def _compiled(*words: str) -> re.Pattern:
    return re.compile("|".join(words))


def says(text: str, words: Mapping[str, str]) -> bool:
    """Say whether a text has any of some words, by language, in any case.

    >>> [says(name, WORDS["columns"]["contact"]) for name in ("Hauptkontakt 1", "Hub")]
    [True, False]
    """
    return _compiled(*words.values()).search(text.lower()) is not None


def holds(name: str, kind: str) -> bool:
    """Say whether a column holds a kind of ``columns`` of the lexicon, by its name."""
    return says(name, WORDS["columns"][kind])


def by_words(table: Mapping[str, Mapping[str, str]]) -> Callable[[str], tuple[str, ...]]:
    r"""Return a function that says which meanings of a table a text has, by words for each. Files
    of a folder have the same names, so that it remembers them.

    >>> by_words({"station": {"en": r"\bstation"}, "date": {"en": r"\bdat[ea]\b"}})("Test Date")
    ('date',)
    """

    @lru_cache(maxsize=2048)
    def meant(text: str) -> tuple[str, ...]:
        return tuple(meaning for meaning, words in table.items() if says(text, words))

    return lambda text: (meant if len(text) <= _LONGEST else meant.__wrapped__)(text)


# ---- units, and columns by their names -----------------------------------------------------------

BESIDE = ("contact", "current", "trigger", "motor")
"""Columns that a record may have beside time and travel, in any unit."""

_KNOWN = {each: unit for unit, spelt in WORDS["units"].items() for each in spelt.split()}
_KNOWN |= {other: other for other in WORDS["other_units"].split()}
_FOLDED = {spelling.casefold(): unit for spelling, unit in _KNOWN.items() if len(spelling) > 1}
_BEHIND = re.compile(
    r"(.*?)\s*(?:\[(.*)\]|\((.*)\)|/\s*(\S+)|(?:^|\s)in\s+(\S+)|[,_]\s*(\w{2,}|m|°)|([°º˚])"
    r"|(?<=\s)(?P<bare>[^\W_]{2,}|[ms]))\s*"
)
_LONGEST_NAME = 200  # signs of a name
_AMPERES = re.compile(r"([\[(/,_ ])\s*(mA|A|[Aa]mp(?:ere)?s?)\s*[\])]?\s*")


def wanted_columns(rows: Iterable[Sequence[str]], settings: Mapping) -> dict[str, str | int]:
    """Return the columns that are wanted, by kind: ``"time"``, if there is one, ``"travel"``, and
    those of ``BESIDE`` that the settings name. A travel that is a number in words is a number,
    unless one of the rows has it for a name.
    """
    travel = settings["travel_column"]
    if str(travel).isdecimal() and not any(places_of(row, str(travel)) for row in rows):
        travel = int(travel)
    wanted = {"time": settings["time_column"], "travel": travel}
    # A trigger at time 0 has no column.
    wanted |= {kind: settings[f"{kind}_column"] or None for kind in BESIDE}
    return {kind: column for kind, column in wanted.items() if column is not None}


def label_of(column: str | int) -> str:
    """Return what messages call a column."""
    return f"column {column}" if isinstance(column, int) else repr(column)


def places_of(row: Sequence[str], column: str | int) -> list[int]:
    """Return the places, from 0, of a column in a row of names: at best in these words.

    >>> places_of(["# Time [s]", "Travel 1 (mm)", "travel 2"], "travel 1")
    [1]
    """
    if isinstance(column, int):
        return [column - 1] if column <= len(row) else []
    if column.casefold() not in "\n".join(row).casefold():
        return []
    names = [cell.strip() for cell in row]
    names[0] = names[0].lstrip("#%! ") or names[0]
    if column not in names:
        names = [split_unit(name)[0] for name in names]
    if column not in names:
        names, column = [name.casefold() for name in names], column.casefold()
    return [i for i, name in enumerate(names) if name == column]


def place_of(
    file: str | Path, row: Sequence[str], column: str | int, *, line: int | None = None
) -> int:
    """Return the one place of a column in a row of names.

    Raises:
        RejectedCurveError: If it is not there, or more than once.
    """
    found = places_of(row, column)
    if len(found) == 1:
        return found[0]
    reason = f"no column {column!r} among {listed(row)}; see endurance.format"
    if found:
        numbers = " or ".join(str(place + 1) for place in found)
        reason = f"more than one column {column!r}; give its number, {numbers}, for its name"
    raise RejectedCurveError(file, reason, line=line)


def listed(row: Sequence[str]) -> str:
    """Return what a message shows of a row of names."""
    return ", ".join(repr(cell.strip()[:40]) for cell in filter(str.strip, row[:40]))


def check_unit(
    file: str | Path,
    column: tuple[str, str],
    text: str,
    settings: Mapping,
    line: int | None = None,
) -> tuple[str, ...]:
    """Return what is to be remarked on the unit of a column: that it is not known.

    Args:
        file, line: Named in messages.
        column: Its kind, "time" or "travel", and what messages call it.
        text: The unit as it stands in the file, empty where none is stated.
        settings: The section ``endurance.format``, complete.

    Raises:
        RejectedCurveError: If it is another than that of the settings.
    """
    kind, label = column
    wanted, stated = settings[f"{kind}_unit"], unit_of(text)
    known = f"the unit of {label} is {text!r}"
    but = f"endurance.format.{kind}_unit is {wanted!r}"
    if stated and stated != wanted:
        raise RejectedCurveError(file, f"{known}, but {but}", line=line)
    return (f"{known}, which is not known; {but}",) if text and not stated else ()


def unit_of(text: str) -> str | None:
    """Return the unit that a text states, as the settings call it, or None if it is not known.

    >>> [unit_of(text) for text in ("[msec]", "Grad", "°", "(INCH)", "kA")]
    ['ms', 'deg', 'deg', 'inch', 'kA']
    """
    bare = text.strip().strip("[](){}<>").strip().removesuffix(".")
    return _KNOWN.get(bare) or _FOLDED.get(bare.casefold())


def amperes_of(name: str, unit: str = "") -> float:
    """Return how many amperes one of the unit of a column is; nan where that is no current.

    Args:
        name: Of the column. An `A` behind it is a phase, unless the name is of a current.
        unit: That is stated apart from the name.

    >>> [amperes_of(name) for name in ("I coil [A]", "Trip (mA)", "Coil Current (A)", "Coil (A)")]
    [1.0, 0.001, 1.0, nan]
    """
    if unit.strip():
        return WORDS["amperes"].get(unit_of(unit), float("nan"))
    ends = [each for each in _AMPERES.finditer(name[-_LONGEST_NAME:]) if each.end() == len(name)]
    if not ends:
        return float("nan")
    before, found = ends[-1].groups()
    if found == "A" and before != "[" and not holds(name, "current"):
        return float("nan")
    return WORDS["amperes"]["mA" if found == "mA" else "A"]


def split_unit(name: str) -> tuple[str, str | None]:
    """Return the name of a column without its unit, and the unit; None where it has none.

    >>> [split_unit(name) for name in ("Travel [mm]", "t/ms", "Travel (A)", "weg cm")]
    [('Travel', 'mm'), ('t', 'ms'), ('Travel (A)', None), ('weg', 'cm')]
    """
    found = _BEHIND.fullmatch(name) if len(name) <= _LONGEST_NAME else None
    behind = next(filter(None, found.groups()[1:]), "") if found else ""
    inches = found and "in" in found.groups()[1:3] and holds(found[1], "travel")
    sure = inches or (found and found[5])  # `CH1 in V`
    unit = unit_of(behind) if sure or behind.strip() not in WORDS["no_units"] else None
    if found and found["bare"]:  # `Coil s` and `Travel min` have none
        timely = holds(found[1], "time") or holds(found[1], "travel")
        unit = unit if timely and unit in WORDS["units"] else None
    return (found[1] or name, unit) if unit else (name, None)


# ---- motions -------------------------------------------------------------------------------------


def _whole(words: Mapping[str, str]) -> dict[str, str]:
    """Words that stand alone, and signs that stand within others."""
    alone = any_of({language: each for language, each in words.items() if language != "zh"})
    return {"alone": rf"(?<![^\W\d_]){alone}(?![^\W\d_])", "within": words["zh"]}


motions_in = by_words({motion: _whole(words) for motion, words in WORDS["motion_words"].items()})
"""The motions that words of a text name."""

MOTION_OF = {"C": "closing", "O": "opening"}
"""Motions by their letters in a sequence."""

_MOTION_LETTERS = {
    sign: letter for letter, motion in MOTION_OF.items() for sign in WORDS["letters"][motion]
}
_FOREIGN_LETTERS = {
    sign: letter
    for letter, motion in MOTION_OF.items()
    for sign in WORDS["foreign_letters"][motion]
}


def motion_of(text: str) -> str:
    """Return the motion that a text names, empty where it names none, or both.

    >>> motion_of("Ausschaltweg"), motion_of("V closing (m/s)"), motion_of("C speed")
    ('opening', 'closing', 'closing')
    """
    letter = re.match(r"\s*([CO])\b", text)
    said = motions_in(text) or (letter and (MOTION_OF[letter[1]],)) or ()
    return said[0] if len(said) == 1 else ""


def sequence_of(text: str) -> str:
    """Return the motions of an operation that a text states, in their order.

    >>> sequence_of("O-0.3s-CO"), sequence_of("Closing"), sequence_of("AUS - EIN")
    ('O-C-O', 'C', 'O-C')
    """
    words = re.findall(r"[^\W\d_]+", text.lower())
    letters = _MOTION_LETTERS | (_FOREIGN_LETTERS if max(map(len, words), default=0) == 1 else {})
    parts = (part for w in words for part in (w if {*w} <= {*_MOTION_LETTERS} else [w]))
    initials = {motion: letter for letter, motion in MOTION_OF.items()}
    said = (letters.get(part) or initials.get(motion_of(part), "") for part in parts)
    return "-".join(filter(None, said))


# ---- phases and channels -------------------------------------------------------------------------

_PHASE_LETTERS = "".join(dict.fromkeys("".join(WORDS["systems"][1:]).replace(" ", "")))
_LETTER = f"[{_PHASE_LETTERS}]"
PHASE = f"{WORDS['numbered_phases']}|{_LETTER}"
"""A phase as it stands in the name of a file, in capitals: a regular expression."""

COLUMN_PHASE = "|".join([PHASE.lower(), *WORDS["colours"]])
"""A phase as it may stand in the name of a column, in lower case: a regular expression."""

_BETWEEN = "[,_+&]"
IN_FILE = re.compile(rf"(?<![^\W_])({PHASE})(?![^\W_])")
"""A phase in the name of a file."""

LISTED = re.compile(
    rf"(?<![^\W_])(?:{WORDS['numbered_phases']}(?:{_BETWEEN}{WORDS['numbered_phases']})+|{_LETTER}(?:{_BETWEEN}{_LETTER})+)"
    r"(?![^\W_])"
)
"""Phases that the name of a file lists, as `A,B,C` does."""

_NO_LETTER = r"(?:(?<![^\W\d_])|(?<=[\u4e00-\u9fff]))"
_CHANNEL_NUMBER = re.compile(
    rf"{_NO_LETTER}{any_of(WORDS['labels']['channel'])}[\W_]*(\d+)\b", re.I
)
_PHASE = re.compile(
    rf"{_NO_LETTER}(?:{any_of(WORDS['labels']['phase'])}[\s_.:-]*(l?[123]|{COLUMN_PHASE})(?![^\W_])"
    rf"|({COLUMN_PHASE})[\W_]*{any_of(WORDS['labels']['phase behind its letter'])}?$)",
    re.I,
)


def channel_of(text: str) -> int:
    """Return the number of the channel that a text names, 0 where it names none."""
    found = channel_in(text) or re.fullmatch(r"\s*(\d{1,2})\s*()", text)
    return int(found[1]) if found else 0


def channel_in(text: str) -> re.Match | None:
    """Find a channel with its number, its first group, in a text."""
    return _CHANNEL_NUMBER.search(text)


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


# ---- names of types and bays, which are spelt in several ways ------------------------------------


def bare(name: str) -> str:
    """Return what all spellings of a name have in common: letters and digits alone, in one case.

    >>> {bare(name) for name in ("GL314", "GL 314", "gl-314")}
    {'gl314'}
    """
    return re.sub(r"[\W_]+", "", name).casefold()


def usual_spelling(names: Iterable[str]) -> dict[str, str]:
    """Return how each type is mostly spelt, by its bare name; of equally many, the first.

    >>> usual_spelling(["GL 314", "GL314", "gl-314", "GL314"])
    {'gl314': 'GL314'}
    """
    spelt: dict[str, Counter] = {}
    for name in names:
        spelt.setdefault(bare(name), Counter())[name] += 1
    return {key: counts.most_common(1)[0][0] for key, counts in spelt.items()}
