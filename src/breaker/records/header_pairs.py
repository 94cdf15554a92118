"""Names and values above the samples, whatever sign or cell separates them."""

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
_COMMAS = re.compile(r"[:=]\s*,|,\s*,")  # a line of commas in a file with another delimiter
_NUMBER = r"[-+]?\d+(?:[.,]\d+)*(?:[eE][-+]?\d+)?"
_VALUE = re.compile(rf"({_NUMBER}|[-+]?[.,]\d+)[.,]?\s*([^\d\s:,;.]\S{{0,11}})?")
_BEHIND = re.compile(rf"(.*?\D)[\s,]+((?:1\s?:\s?)?{_NUMBER}\s*[^\d\s]{{0,11}})")
_LABEL = re.compile(r"[A-Za-z]{1,3}[\W_]?\d{1,2}")  # of a channel, in a bracket next to the unit
_UNIT = re.compile(r"\s*[\[(]([^\[\]()]{1,12})[\])]\s*")
_DIGIT, _DIGITS = "\0", re.compile(r"\d+")  # a sign that stands for numbers, as no name has it
_LONG = 8  # characters of a name from which a missing letter leaves the name recognisable


class Pair(NamedTuple):
    """A name and its values.

    Attributes:
        name: Name without its unit and the sign behind it.
        unit: Unit in the name, empty where there is none.
        values: Cells behind the name that are not blank.
        row: Place of the line, from 0.
    """

    name: str
    unit: str
    values: tuple[str, ...]
    row: int

    @property
    def text(self) -> str:
        """First value, empty where there is none."""
        return self.values[0] if self.values else ""

    def number(self, decimal: str = ".") -> tuple[float, str]:
        """Return the first value as a number, NaN where it is not a number, and its unit."""
        values, unit = numbers_of(self.values[:1], decimal)
        behind = self.values[1] if len(self.values) == 2 and not self.values[1][0].isdigit() else ""
        return (values or [float("nan")])[0], unit or self.unit or behind


class Token(NamedTuple):
    """A part of a line: its text, whether it is a name, and the place of its cell, from 0."""

    text: str
    named: bool
    place: int


def numbers_of(cells: Sequence[str], decimal: str) -> tuple[list[float], str]:
    """Return cells as numbers, NaN where a cell is not a number, and the first unit behind one.

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
    """Return a number. The sign that is not the decimal sign separates groups of three digits."""
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
    found: list[Pair] = []
    for place, row in enumerate(rows):
        name, values = "", []
        for text, named, _ in [*tokens_of(row)[0], Token("", True, 0)]:
            if named and name:
                found.append(Pair(*name_of(name), tuple(values), place))
            if named:
                name, values = text, []
            elif name and text:
                values.append(text)
    return _respelled(found)


def _respelled(pairs: Sequence[Pair]) -> list[Pair]:
    """Complete names that lack one letter of the name that other channels have.

    >>> names = ["Mechanism Travel T1", "Mechanism Travel T2", "Mehanism Travel T3"]
    >>> _respelled([Pair(name, "", ("1",), 0) for name in names])[-1].name
    'Mechanism Travel T3'
    """
    right = respelling([pair.name for pair in pairs])
    return [pair._replace(name=right.get(pair.name, pair.name)) for pair in pairs]


def respelling(names: Sequence[str]) -> dict[str, str]:
    """Return the right spelling of each name that lacks one letter, by that name."""
    kinds = Counter(_DIGITS.sub(_DIGIT, name) for name in names)
    usual = [kind for kind, count in kinds.items() if count > 1 and _DIGIT in kind]
    whole = {k[:i] + k[i + 1 :]: k for k in usual for i in range(len(k)) if k[i].isalpha()}
    found = {}
    for name in names:
        near = whole.get(kind := _DIGITS.sub(_DIGIT, name), "")
        if len(near) > _LONG and kinds[kind] == 1:
            for number in _DIGITS.findall(name):
                near = near.replace(_DIGIT, number, 1)
            found[name] = near
    return found


def name_of(text: str) -> tuple[str, str]:
    """Return a name without its unit, and the unit; a channel in brackets belongs to the name.

    >>> name_of("Contact Travel(T1)(mm)")
    ('Contact Travel T1', 'mm')
    """
    brackets = [each[1].strip() for each in _UNIT.finditer(text)]
    label = next(filter(_LABEL.fullmatch, brackets), "") if len(brackets) > 1 else ""
    unit = next((each for each in brackets if each != label), "")
    bare = f"{_UNIT.sub(' ', text).strip()} {label}".strip() if brackets else text
    known = unit
    if not (unit or "/" in text):
        bare, known = split_unit(text)
    return bare or text, (known or "") if bare else ""


def tokens_of(row: Sequence[str]) -> tuple[list[Token], bool]:
    """Return the parts of a line, and whether signs behind the names tell names from values.

    Without a sign the place of a cell decides: the first cell is a name, and so is one behind a
    blank cell and before another cell.
    """
    cells: list[tuple[str, int]] = []
    for part, place in ((part, i) for i, cell in enumerate(row) for part in _parts(cell)):
        if part in (":", "=") and cells:
            cells[-1] = cells[-1][0] + part, cells[-1][1]  # in a cell of its own
        else:
            cells.append((part, place))
    if any(_SIGN.search(cell) and not moments(cell) for cell, _ in cells) or any(
        re.match(r"[^\d\W].*?[:=：]", cell) for cell, _ in cells
    ):
        return [Token(*each, place) for cell, place in cells for each in _signed(cell)], True
    filled = [(cell, place) for cell, place in cells if cell]
    if len(filled) == 1 and (behind := _BEHIND.fullmatch(filled[0][0])):
        place = filled[0][1]
        return [Token(behind[1].strip(" ,"), True, place), Token(behind[2], False, place)], False
    paired = len(filled) == len(cells) > 2 and len(cells) % 2 == 0
    if paired and all(re.match(r"[^\W\d_].*[^\W\d_]{2}", cell) for cell, _ in cells[::2]):
        return [Token(cell, i % 2 == 0, place) for i, (cell, place) in enumerate(cells)], False
    tokens, before = [], ""
    for i, (cell, place) in enumerate(cells):
        after = cells[i + 1][0] if i + 1 < len(cells) else ""
        tokens.append(
            Token(cell, bool(cell and not before and after and not cell[0].isdigit()), place)
        )
        before = cell
    return tokens, False


def _parts(cell: str) -> list[str]:
    """Split a cell that is a line with another delimiter."""
    quotes = '"' if cell.count('"') % 2 == 0 else r'^\s*"|(?<!\d)"\s*$'  # an odd one may be an inch
    cell = re.sub(quotes, "", cell).strip(" \t,").lstrip("#%! ")
    if _COMMAS.search(cell):
        return [part.strip() for part in cell.split(",")]
    cell = re.sub(r"\s+(?=[:=：](?:\s|$))", "", cell)
    cell = re.sub(r"(?<=[:=：])\s+", " ", cell)
    return [part.strip() for part in _SPLIT.split(cell)]


def _signed(cell: str) -> list[tuple[str, bool]]:
    """Split a cell at its sign into name and value; a cell without a sign is a value."""
    sign = _SIGN.search(cell)
    if not sign or not re.match(r"[^\W\d_]", cell):
        return [(cell, False)]
    name, value = cell[: sign.start()].strip(), cell[sign.end() :].strip()
    return [(name, True), (value, False)] if value else [(name, True)]
