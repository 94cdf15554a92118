"""Names and values above the samples, whatever sign or cell separates them."""

import math
import re
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

from breaker.records.words import split_unit

_SIGN = r"(?:(?<!\d)[:=：]|[:=：](?!\d))"  # not that of a time or a ratio
_SIGNED = re.compile(rf"([^\W\d_].*?)\s*{_SIGN}\s*(.*)")
_SPLIT = re.compile(rf"[\t;|]|\s{{2,}}|,(?=\s*[^\W\d_][^,:=]*{_SIGN})")
_NUMBER = r"[-+]?\d+(?:[.,]\d+)*(?:[eE][-+]?\d+)?"
_VALUE = re.compile(rf"({_NUMBER}|[-+]?[.,]\d+)[.,]?\s*([^\d\s:,;.]\S{{0,11}})?")
_GROUPS = re.compile(r"[-+]?\d{1,3}(?:[.,]\d{3})+")
_BEHIND = re.compile(rf"([^\W\d_].*[^\d\s,:.-])[\s,]+({_NUMBER}\s*[^\d\s]{{0,11}})")
_LABEL = re.compile(r"[A-Za-z]{1,3}[\W_]?\d{1,2}")  # of a channel, in brackets next to the unit
_UNIT = re.compile(r"\s*[\[(]([^\[\]()]{1,12})[\])]\s*")


class Pair(NamedTuple):
    """A name without its unit, the unit, and the values behind it."""

    name: str
    unit: str
    values: tuple[str, ...]

    @property
    def text(self) -> str:
        """First value, empty where there is none."""
        return self.values[0] if self.values else ""

    def number(self, decimal: str = ".") -> tuple[float, str]:
        """Return the first value as a number, NaN where it is not a number, and its unit."""
        number, unit = number_of(self.text, decimal)
        behind = self.values[1] if len(self.values) == 2 and not self.values[1][0].isdigit() else ""
        return number, unit or self.unit or behind


class Token(NamedTuple):
    """A part of a line, whether it is a name, and the place of its cell, from 0."""

    text: str
    named: bool
    place: int


class Line(NamedTuple):
    """Parts of a line, and whether signs behind names separate these from values."""

    tokens: Sequence[Token]
    signed: bool


def number_of(text: str, decimal: str) -> tuple[float, str]:
    """Return a text as a number, NaN where it is not a number, and the unit behind it."""
    match = _VALUE.fullmatch(text.strip())
    if match is None:
        return math.nan, ""
    digits, unit = match[1], (match[2] or "").strip("[]()")
    if _GROUPS.fullmatch(digits) and decimal not in digits:
        digits = re.sub("[.,]", "", digits)
    digits = digits.replace(",", ".")
    return (float(digits) if digits.count(".") < 2 else math.nan), unit


def pairs_of(lines: Iterable[Line]) -> list[Pair]:
    """Return the pairs of lines."""
    found: list[tuple[str, list[str]]] = []
    for line in lines:
        values: list[str] = []  # those before a name belong to none
        for text, named, _ in line.tokens:
            if named:
                found.append((text, values := []))
            elif text:
                values.append(text)
    return [Pair(*name_of(name), tuple(values)) for name, values in found]


@lru_cache(maxsize=4096)  # files of a folder have the same names
def name_of(text: str) -> tuple[str, str]:
    """Return a name without its unit, and the unit; a channel in brackets belongs to the name."""
    brackets = [each[1].strip() for each in _UNIT.finditer(text)]
    if not brackets:
        bare, unit = (text, "") if "/" in text else split_unit(text)
        return (bare, unit or "") if bare else (text, "")
    label = next(filter(_LABEL.fullmatch, brackets), "") if len(brackets) > 1 else ""
    unit = next((each for each in brackets if each != label), "")
    return f"{_UNIT.sub(' ', text).strip()} {label}".strip(), unit


def line_of(row: Sequence[str]) -> Line:
    """Return a line by its cells. Without a sign a name is first or behind a blank cell, or names
    and values stand in turn.
    """
    cells = [part for cell in row for part in _parts(cell)]
    if any(map(_SIGNED.match, cells)):
        tokens = [token for place, cell in enumerate(cells) for token in _signed(cell, place)]
        return Line(tokens, True)
    if behind := _BEHIND.fullmatch("".join(cells)) if len([*filter(None, cells)]) == 1 else None:
        return Line([Token(behind[1], True, 0), Token(behind[2], False, 0)], False)
    around = zip(["", *cells], cells, [*cells[1:], ""], strict=False)
    named = [not before and after and cell[:1].isalpha() for before, cell, after in around]
    if len(cells) % 2 == 0 and all(cells) and all(cell[0].isalpha() for cell in cells[::2]):
        named = [place % 2 == 0 for place in range(len(cells))]
    tokens = [Token(cell, bool(named[place]), place) for place, cell in enumerate(cells)]
    return Line(tokens, False)


@lru_cache(maxsize=4096)
def _parts(cell: str) -> list[str]:
    """Split a cell that is a line with another delimiter."""
    cell = cell.replace('"', "").strip(" \t,")
    cell = re.sub(r"\s*([:=：])(?=\s|$)\s*", r"\1 ", cell.lstrip("#%! ") or cell)
    return [part.strip(" ,") for part in _SPLIT.split(cell)]


def _signed(cell: str, place: int) -> list[Token]:
    """Split a cell at its signs into names and a value; a cell without a sign is a value."""
    if not (match := _SIGNED.match(cell)):
        return [Token(cell, False, place)] if cell else []
    return [Token(match[1], True, place), *_signed(match[2].lstrip(" ,"), place)]
