"""Names and values above the samples, whatever sign or cell separates them."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import lru_cache
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
_DIGITS = re.compile(r"\d+")
_LONG = (
    8  # letters of a name from which one that lacks a letter is no other name, as C1 and CH1 are
)


class Pair(NamedTuple):
    """A name and its values.

    Attributes:
        name: Name without its unit and the sign behind it.
        unit: Unit in the name, empty where there is none.
        values: Cells behind the name that are not blank.
    """

    name: str
    unit: str
    values: tuple[str, ...]

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


class Line(NamedTuple):
    """A line: its cells, their parts, and whether signs behind names tell these from values."""

    cells: Sequence[str]
    tokens: Sequence[Token]
    signed: bool


def lines_of(rows: Iterable[Sequence[str]]) -> list[Line]:
    """Return lines by their cells; a line that has not been split is one cell.

    A name that lacks one letter of the name that other channels have is completed.

    >>> rows = [["Mechanism Travel T1: 1"], ["Mechanism Travel T2: 1"], ["Mehanism Travel T3: 1"]]
    >>> lines_of(rows)[-1].tokens[0].text
    'Mechanism Travel T3'
    """
    lines = [Line(row, *_tokens_of(row)) if any(row) else Line((), (), False) for row in rows]
    kinds = Counter(_DIGITS.sub("0", t.text) for line in lines for t in line.tokens if t.named)
    usual = [kind for kind, count in kinds.items() if count > 1 and "0" in kind]
    whole = {k[:i] + k[i + 1 :]: k for k in usual for i in range(len(k)) if k[i].isalpha()}

    def completed(token: Token) -> Token:
        near = whole.get(kind := _DIGITS.sub("0", token.text), "") if token.named else ""
        if len(near) <= _LONG or kinds[kind] > 1:
            return token
        numbers = iter(_DIGITS.findall(token.text))
        return token._replace(text=re.sub("0", lambda _: next(numbers), near))

    return [line._replace(tokens=[*map(completed, line.tokens)]) for line in lines]


def pairs_of(lines: Iterable[Line]) -> list[Pair]:
    """Return the pairs of lines.

    >>> rows = [["Speed (kC) :", "10", "", "Range :", "8000"], ["Bay = 4"]]
    >>> for pair in pairs_of(lines_of(rows)):
    ...     print(*pair)
    Speed kC ('10',)
    Range  ('8000',)
    Bay  ('4',)
    """
    found: list[Pair] = []
    for line in lines:
        name, values = "", []
        for text, named, _ in [*line.tokens, Token("", True, 0)]:
            if named and name:
                found.append(Pair(*name_of(name), tuple(values)))
            if named:
                name, values = text, []
            elif name and text:
                values.append(text)
    return found


@lru_cache(maxsize=4096)  # files of a folder have the same names
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


def _tokens_of(row: Sequence[str]) -> tuple[list[Token], bool]:
    """Return the parts of a line, and whether signs tell its names.

    Without a sign the place of a cell decides: the first cell is a name, and so is one behind a
    blank cell and before another cell.
    """
    cells: list[Token] = []
    for part, place in ((part, i) for i, cell in enumerate(row) for part in _parts(cell)):
        if part in (":", "=") and cells:
            cells[-1] = cells[-1]._replace(text=cells[-1].text + part)  # in a cell of its own
        else:
            cells.append(Token(part, False, place))
    texts = [cell.text for cell in cells]
    if any(re.match(r"[^\d\W].*?[:=：]", t) or (_SIGN.search(t) and not moments(t)) for t in texts):
        return [Token(*each, cell.place) for cell in cells for each in _signed(cell.text)], True
    filled = [cell for cell in cells if cell.text]
    if len(filled) == 1 and (behind := _BEHIND.fullmatch(filled[0].text)):
        place = filled[0].place
        return [Token(behind[1].strip(" ,"), True, place), Token(behind[2], False, place)], False
    worded = all(re.match(r"[^\W\d_].*[^\W\d_]{2}", text) for text in texts[::2])
    paired = worded and len(filled) == len(cells) > 2 and len(cells) % 2 == 0
    named = [i % 2 == 0 for i in range(len(cells))]
    if not paired:
        around = zip(["", *texts], texts, [*texts[1:], ""], strict=False)
        named = [
            bool(t and not before and after and not t[0].isdigit()) for before, t, after in around
        ]
    return [cell._replace(named=each) for cell, each in zip(cells, named, strict=True)], False


@lru_cache(maxsize=4096)
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
