"""What stands above the samples, as names and their values: whatever separates the two.

Pairs in cells of their own, several in a line, pairs in one cell, and rows of a table.
"""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from breaker.records.dates import moments
from breaker.records.lexicon import WORDS
from breaker.records.words import split_unit

_SIGN = re.compile(r"\s*(?:(?<!\d)[:=：]|[:=：](?!\d))\s*")
_SPLIT = re.compile(
    rf"[\t;|]|\s{{2,}}|,\s*(?!(?i:{WORDS['before_colon']})\s*[:=])"  # rather a unit than a name
    r"(?=[^\W\d_][^,:=]{1,60}[:=](?!\d))"
)
_COMMAS = re.compile(r"[:=]\s*,|,\s*,")  # a line of commas in a file of other signs
_NUMBER = r"[-+]?\d+(?:[.,]\d+)*(?:[eE][-+]?\d+)?"
_VALUE = re.compile(rf"({_NUMBER}|[-+]?[.,]\d+)[.,]?\s*([^\d\s:,;.]\S{{0,11}})?")
_BEHIND = re.compile(rf"(.*?\D)[\s,]+((?:1\s?:\s?)?{_NUMBER}\s*[^\d\s]{{0,11}})")
_NAMED = re.compile(r"[^\d\W].*?[:=：]")
_LABEL = re.compile(r"[A-Za-z]{1,3}[\W_]?\d{1,2}")  # of a channel, in a bracket beside the unit
_DIGIT, _DIGITS = "\0", re.compile(r"\d+")  # what stands for numbers: no name has it
_LONG = 8  # signs of a name that may have lost one
_UNIT = re.compile(r"\s*[\[(]([^\[\]()]{1,12})[\])]\s*")


class Pair(NamedTuple):
    """A name and what stands behind it.

    Attributes:
        name: Without its unit and the sign behind it.
        unit: In brackets in the name; empty where none is.
        values: What stands in the cells behind it, without blank ones.
        row: Place of its line, from 0.
    """

    name: str
    unit: str
    values: tuple[str, ...]
    row: int

    @property
    def text(self) -> str:
        """The first value; empty where there is none."""
        return self.values[0] if self.values else ""

    def number(self, decimal: str = ".") -> tuple[float, str]:
        """Return the first value as a number, NaN where it is none, and its unit."""
        values, unit = numbers_of(self.values[:1], decimal)
        beside = self.values[1] if len(self.values) == 2 and not self.values[1][0].isdigit() else ""
        return (values or [float("nan")])[0], unit or self.unit or beside


def numbers_of(cells: Sequence[str], decimal: str) -> tuple[list[float], str]:
    """Return cells as numbers, NaN where one is none, and the unit behind the first that has one.

    >>> numbers_of(["1,64 mm", "-"], ",")
    ([1.64, nan], 'mm')
    """
    found, unit = [], ""
    for cell in cells:
        match = _VALUE.fullmatch(cell.strip())
        found.append(float("nan") if match is None else _float(match[1], decimal))
        unit = unit or ((match and match[2]) or "").strip("[]()")
    return found, unit


def _float(text: str, decimal: str) -> float:
    """A number; a sign between its digits that is not the decimal one separates thousands where
    three digits follow it each time.
    """
    other = "," if decimal == "." else "."
    if other in text and re.fullmatch(rf"[-+]?\d{{1,3}}(?:[{other}]\d{{3}})+", text):
        text = text.replace(other, "")
    text = text.replace(",", ".")
    return float(text) if text.count(".") < 2 else float("nan")


def pairs_of(rows: Iterable[Sequence[str]]) -> list[Pair]:
    """Return the pairs of lines, by their cells; a line that has not been split is one cell.

    >>> for pair in pairs_of([["Speed (kC) :", "10", "", "Range :", "8000"], ["Bay = 4"]]):
    ...     print(*pair[:3])
    Speed kC ('10',)
    Range  ('8000',)
    Bay  ('4',)
    """
    found = []
    for place, row in enumerate(rows):
        name, values = "", []
        for cell, named in _tokens(row):
            if named and name:
                found.append(_pair(name, values, place))
            if named:
                name, values = cell, []
            elif name and cell:
                values.append(cell)
        if name:
            found.append(_pair(name, values, place))
    return _respelled(found)


def _respelled(pairs: Sequence[Pair]) -> list[Pair]:
    """Pairs, with names that lack one letter of those of other channels as these have them.

    >>> names = ["Mechanism Travel T1", "Mechanism Travel T2", "Mehanism Travel T3"]
    >>> _respelled([Pair(name, "", ("1",), 0) for name in names])[-1].name
    'Mechanism Travel T3'
    """
    kinds = Counter(_DIGITS.sub(_DIGIT, pair.name) for pair in pairs)
    usual = [kind for kind, count in kinds.items() if count > 1 and _DIGIT in kind]
    whole = {k[:i] + k[i + 1 :]: k for k in usual for i in range(len(k)) if k[i].isalpha()}
    found = []
    for pair in pairs:
        near = whole.get(_DIGITS.sub(_DIGIT, pair.name), "")
        if near and len(near) > _LONG and kinds[_DIGITS.sub(_DIGIT, pair.name)] == 1:
            for number in _DIGITS.findall(pair.name):
                near = near.replace(_DIGIT, number, 1)
            pair = pair._replace(name=near)
        found.append(pair)
    return found


def _pair(name: str, values: Sequence[str], row: int) -> Pair:
    brackets = [each[1].strip() for each in _UNIT.finditer(name)]
    label = next(filter(_LABEL.fullmatch, brackets), "") if len(brackets) > 1 else ""
    unit = next((each for each in brackets if each != label), "")
    bare = f"{_UNIT.sub(' ', name).strip()} {label}".strip() if brackets else name
    known = unit
    if not (unit or "/" in name):
        bare, known = split_unit(name)
    return Pair(bare or name, (known or "") if bare else "", tuple(values), row)


def _tokens(row: Sequence[str]) -> list[tuple[str, bool]]:
    """Cells of a line, and whether each is a name: by the sign behind it, or else by its place."""
    cells: list[str] = []
    for part in (part for cell in row for part in _parts(cell)):
        if part in (":", "=") and cells:
            cells[-1] += part  # in a cell of its own
        else:
            cells.append(part)
    if any(map(_NAMED.match, cells)) or any(
        _SIGN.search(cell) and not moments(cell) for cell in cells
    ):
        return [token for cell in cells for token in _signed(cell)]
    filled = [cell for cell in cells if cell]
    if len(filled) == 1 and (behind := _BEHIND.fullmatch(filled[0])):
        return [(behind[1].strip(" ,"), True), (behind[2], False)]
    if len(filled) == len(cells) > 2 and len(cells) % 2 == 0 and all(map(_is_word, cells[::2])):
        return [(cell, place % 2 == 0) for place, cell in enumerate(cells)]
    # Without a sign the first cell is a name, and so is one behind a blank cell and before another.
    tokens, before = [], ""
    for i, cell in enumerate(cells):
        begins = cell and not before and "".join(cells[i + 1 : i + 2]) and not cell[0].isdigit()
        tokens.append((cell, bool(begins)))
        before = cell
    return tokens


def _is_word(cell: str) -> bool:
    """Whether a cell without a sign may be a name rather than a value, a phase or a unit."""
    return re.match(r"[^\W\d_].*[^\W\d_]{2}", cell) is not None


def _parts(cell: str) -> list[str]:
    """A cell, split where it is a line of other signs."""
    quotes = '"' if cell.count('"') % 2 == 0 else r'^\s*"|(?<!\d)"\s*$'  # an odd one may be an inch
    cell = re.sub(quotes, "", cell).strip(" \t,").lstrip("#%! ")
    if _COMMAS.search(cell):
        return [part.strip() for part in cell.split(",")]
    cell = re.sub(r"\s+(?=[:=：](?:\s|$))", "", cell)
    cell = re.sub(r"(?<=[:=：])\s+", " ", cell)
    return [part.strip() for part in _SPLIT.split(cell)]


def _signed(cell: str) -> list[tuple[str, bool]]:
    """A cell as a name, with its value if it has one, or as a value."""
    sign = _SIGN.search(cell)
    if not sign or not re.match(r"[^\W\d_]", cell):
        return [(cell, False)]
    name, value = cell[: sign.start()].strip(), cell[sign.end() :].strip()
    return [(name, True), (value, False)] if value else [(name, True)]
