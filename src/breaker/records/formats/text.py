"""Tables of samples in texts: CSV and the like, in any encoding, with any end of line.

Settings say how a text is read. What they leave out is guessed, to propose settings that are then
shown and confirmed by reading: the encoding, the signs between cells and within numbers, and where
names and samples are. A table is searched in the first lines, and its columns are known by lines
from all of it: a file may hold anything, of any size.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from itertools import repeat
from pathlib import Path
from typing import NamedTuple

from breaker.common.lazy_numpy import np
from breaker.records.cells import (
    LARGEST_NUMBER,
    MISSING,
    cells_of,
    columns_of_alike,
    is_number,
    is_remark,
    strict_numbers,
    why_none,
)
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.lexicon import WORDS
from breaker.records.sheet import LayoutError, Sheet, Table
from breaker.records.words import (
    BESIDE,
    any_of,
    label_of,
    listed,
    places_of,
    says,
    split_unit,
    unit_of,
    wanted_columns,
)

ENDINGS = dict.fromkeys((".csv", ".txt", ".tsv"), "a text") | {".lvm": "a LabVIEW text"}
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = ""

_LONGEST_LINE = 100_000  # signs; a line of 300 columns has a tenth of it
_BLOCK = 2**20  # signs that are split into cells at a time, which take twelve times their memory
_TOP = 10_000  # lines among which samples begin
_RUN = 20  # lines of which most are samples, where these begin

_CODES = ("gb18030", "cp1252", "shift_jis", "euc_kr", "cp1251", "cp1250")
_WORDS = re.compile(any_of(WORDS["telling"]))
_FOREIGN = re.compile(r"[^\x00-\x7f°µ²³±·½×ßäöüÄÖÜéèêëàâçîïôûñáíóúãõÉÀ–’]|[^\x00-\x7f]{2}")
_PADDED = re.compile(r"0\d+")
_DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits
# "10 kHz", "10kHz", "Rate:": of no column, but `52a` is a name.
_VALUE = re.compile(r"[-+]?\d+(?:[.,]\d+)?(?:\s+\S{0,5}|(?P<unit>\S{0,5}))|.*[:=]")


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the table of a text: see ``registry``."""
    file, content = opened.file, opened.content
    check_lines(file, content)
    encoding = form.get("encoding") or encoding_of(content)
    text = _decode(file, content, encoding, strict="encoding" in form)
    _check_lengths(file, text)
    guessed = "delimiter" not in form
    signs = signs_of(_some_lines(text, 200)) if guessed else (form["delimiter"], form["decimal"])
    settings = {"encoding": encoding, "delimiter": signs[0], "decimal": signs[1]}
    return [sheet_of(file, text, settings, form)]


def sheet_of(file: str | Path, text: str, settings: Mapping, form: Mapping) -> Sheet:
    r"""Return the table in a text.

    Args:
        file: Named in messages.
        text: Its lines end with ``\n``.
        settings: Its delimiter and its decimal sign, by their keys in ``endurance.format``.
        form: The section ``endurance.format``, complete, of which the table has the columns; empty
            where nothing is known.

    Raises:
        LayoutError: If nothing is known, and there are no columns of numbers.
        RejectedCurveError: If columns are not there, or more than a record has.
    """
    top = _Top(file, text, settings)
    head = _head_of(top, form)
    check_size(file, 1, head.width, line=head.first + 1)
    table = _Cells(text, top.offset(head.first), head, settings)
    if not form:
        check_size(file, table.lines.size, head.width)
    names, texts = ([*row, *[""] * head.width][: head.width] for row in (head.names, head.texts))
    preamble = [top.above(i) for i in range(head.first) if i not in head.own]
    named = tuple(None if i is None else i + 1 for i in head.named)
    if settings["delimiter"] == "\t":
        texts = _of_labview(preamble, texts)
    return Sheet(file, names, table, texts, preamble, settings, named=named)


# ---- bytes ---------------------------------------------------------------------------------------


def encoding_of(content: bytes) -> str:
    """Return the encoding of a text: by its mark, UTF-8 where it is that, or by its words."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return "utf-8"
    if (zeros := content[:2000].count(0)) > len(content[:2000]) / 4:
        return "utf-16-le" if content[1:2000:2].count(0) > zeros / 2 else "utf-16-be"
    # Lines of numbers tell nothing.
    lines = (line for line in re.split(rb"[\r\n]+", content[:_BLOCK]) if not line.isascii())
    telling = b"\n".join(lines)[:20_000]
    for code in _CODES:  # so few signs leave doubts, but words do not
        if _WORDS.search(telling.decode(code, errors="ignore")):
            return code
    western = telling.decode("cp1252", errors="replace")
    # Else letters stand in pairs or words of their own.
    return "latin-1" if _FOREIGN.search(western) else "cp1252"


def _decode(file: str | Path, content: bytes, encoding: str, *, strict: bool) -> str:
    r"""The text of a file, without a byte order mark, its lines ended by ``\n``. Where it is
    guessed, damaged signs do not hide the rest; reading says where they are.
    """
    if codecs.lookup(encoding).name == "utf-16" and content[:1] == b"\0" != content[1:2]:
        encoding = "utf-16-be"  # without a mark; it begins with a sign of ASCII
    try:
        text = content.decode(encoding, errors="strict" if strict else "replace")
    except UnicodeError as error:
        line = content.count(b"\n", 0, getattr(error, "start", 0)) + 1
        reason = f"cannot be read: {error}; is it a text file, endurance.format.encoding right?"
        raise RejectedCurveError(file, reason, line=line) from error
    if "\0" in text:
        if strict:
            reason = "has zero bytes: it is damaged, or endurance.format.encoding is utf-16, say"
            line = text.count("\n", 0, text.index("\0")) + 1
            raise RejectedCurveError(file, reason, line=line)
        text = text.replace("\0", "\ufffd")
    text = text.removeprefix("\ufeff").rstrip("\n\r\x1a")  # the old sign for the end of a file
    if "\r" in text:
        # Lines that were translated twice end with two returns.
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
    return text


def _check_lengths(file: str | Path, text: str) -> None:
    begin = 0
    while begin + _LONGEST_LINE < len(text):
        end = text.rfind("\n", begin, begin + _LONGEST_LINE + 1)
        if end < 0:
            end = text.find("\n", begin)
            signs = (len(text) if end < 0 else end) - begin
            reason = f"has {signs:,} signs; export a table with one line per sample"
            raise RejectedCurveError(file, reason, line=text.count("\n", 0, begin) + 1)
        begin = end + 1


# ---- signs and kinds of cells --------------------------------------------------------------------


def _some_lines(text: str, count: int) -> list[str]:
    """Return lines from all over a text but its first part, without blank ones: at most as many,
    and of no more signs than a block.
    """
    some: dict[int, str] = {}
    size, length = 0, max(len(text), 1)
    for at in np.linspace(0.2 * length, length - 1, count).astype(int).tolist():
        begin = text.rfind("\n", 0, at) + 1
        if begin not in some and size < _BLOCK:
            end = text.find("\n", at)
            line = text[begin : end if end >= 0 else length]
            some[begin], size = line, size + len(line)
    return [line for line in some.values() if line.strip()]


def signs_of(some: Sequence[str]) -> tuple[str, str]:
    """Return the delimiter and the decimal sign with which most cells of lines, and the fewest
    others, are numbers.
    """
    signs = set().union(*some)
    there = [d for d in _DELIMITERS if d in signs]
    absent = [d for d in _DELIMITERS if d not in signs]  # one is like the other
    either = sorted([*there, *absent[:1]], key=_DELIMITERS.index)
    pairs = [(d, sign) for d in either for sign in ".," if d != sign or '"' in signs]

    def fit(pair: tuple[str, str]) -> tuple[bool, int]:
        rows, kind = [cells_of(line, pair[0]) for line in some], _kinds(pair[1])
        # 12,045 is one number: no column has zeros before whole numbers, but perhaps the first.
        padded = any(_PADDED.fullmatch(cell) for cell in {c for row in rows for c in row[1:]})
        return not padded, sum(kind(cell) for row in rows for cell in row)

    return max(pairs, key=fit)


def _kinds(decimal: str) -> Callable[[str], int]:
    """Return a function that says what a cell is: 1 a number, 0 a missing sample, -1 another. Each
    is looked at once: samples of an instrument repeat themselves.
    """

    @cache
    def kind(cell: str) -> int:
        return 0 if cell.strip().lower() in MISSING else 2 * is_number(cell, decimal) - 1

    return kind


# ---- heads ---------------------------------------------------------------------------------------


class _Head(NamedTuple):
    """What stands above the samples, by lines from 0.

    Attributes:
        first: Line of the first sample.
        width: Number of columns.
        names: Of the columns.
        texts: Their units, where these stand in a line of their own.
        named: Line of the names, and of the units, if any.
        own: Lines of names and units, as far as there are such.
    """

    first: int
    width: int
    names: Sequence[str] = ()
    texts: Sequence[str] = ()
    named: tuple[int | None, int | None] = (None, None)
    own: Sequence[int | None] = ()


class _Top(Sequence):
    """The rows of cells of the first lines of a text, and what these are."""

    def __init__(self, file: str | Path, text: str, settings: Mapping) -> None:
        self.file, self.delimiter, self.decimal = file, settings["delimiter"], settings["decimal"]
        self.text, self.kind = text, _kinds(settings["decimal"])
        self.lines = text[:_BLOCK].split("\n")[:_TOP]
        self.blank = f'{self.delimiter}" \t\v\f'
        self.row = cache(lambda i: cells_of(self.lines[i], self.delimiter))

    def __len__(self) -> int:
        return len(self.lines)

    def __getitem__(self, i: int) -> list[str]:
        return self.row(i)

    def filled(self, begin: int, step: int = 1) -> Iterator[int]:
        """Yield the lines from one on, or back, that are not blank."""
        end = len(self.lines) if step > 0 else -1
        return (i for i in range(begin, end, step) if self.lines[i].strip(self.blank))

    def offset(self, line: int) -> int:
        """Return where a line begins in the text."""
        return sum(map(len, self.lines[:line])) + line

    def above(self, line: int) -> list[str]:
        """Return the cells of a line above the samples; where blanks separate, it is one cell, as
        blanks are between words, too.
        """
        return [self.lines[line].strip()] if self.delimiter == " " else [*self[line]]

    def numeric(self, i: int, places: Iterable[int]) -> bool:
        """Say whether a line has numbers in some places."""
        row = self[i]
        return all(at < len(row) and self.kind(row[at]) == 1 for at in places)

    def names(self, i: int) -> list[str]:
        """Return the names in a line, with those of a line of merged cells above it; none where it
        is the upper of such two.
        """
        below, over = next(self.filled(i + 1), None), self.over(i)
        if below is not None and self._merged(i, below):
            return []
        names = self[i] if over is None else self._joined(over, i)
        return [names[0].lstrip("#%! ") or names[0], *names[1:]]

    def has(self, column: str) -> bool:
        """Say whether a line has a name."""
        if column.casefold() not in "\n".join(self.lines).casefold():
            return False
        return any((names := self.names(i)) and places_of(names, column) for i in self.filled(0))

    def over(self, i: int) -> int | None:
        """Return the line above another one, where its cells span cells of that."""
        above = next(self.filled(i - 1, -1), None)
        return above if above is not None and self._merged(above, i) else None

    def _merged(self, over: int, i: int) -> bool:
        """Whether two lines are names together: cells of the upper one are those of columns, and
        span several cells of the lower one, which are no numbers, and not all units.
        """
        upper, lower = self[over], self[i]
        tops, cells = list(filter(None, upper)), list(filter(None, lower))
        if not (upper[0] and 2 <= len({*tops}) < len(cells)) or len(upper) > len(lower) + 1:
            return False
        if any(self.kind(cell) == 1 for cell in (*tops, *cells)) or _are_units(cells):
            return False
        known = (any(says(top, words) for words in WORDS["columns"].values()) for top in tops)
        return len(cells) >= 0.75 * len(lower) and all(known)

    def _joined(self, over: int, i: int) -> list[str]:
        names, top = [], ""
        for place, cell in enumerate(self[i]):
            top = self[over][place] if place < len(self[over]) and self[over][place] else top
            bare, unit = split_unit(top)
            own = f"{bare} ({cell})"
            if unit is None and split_unit(own)[1]:
                names.append(own)
            else:
                names.append(" ".join(filter(None, [bare, cell, top[len(bare) :].strip()])))
        return names


def _head_of(top: _Top, form: Mapping) -> _Head:
    """Find the head of a table: by the names of the columns that are wanted, or else by numbers."""
    if form and not top.text.strip(top.blank + "\n"):
        raise RejectedCurveError(top.file, "is empty")
    wanted = wanted_columns((top[i] for i in top.filled(0)), form) if form else {}
    time = wanted.get("time")
    if form and form["rate"] and isinstance(time, str) and not top.has(time):
        del wanted["time"]
    own = {kind: column for kind, column in wanted.items() if kind not in BESIDE}
    if all(isinstance(column, int) for column in wanted.values()):
        return _by_numbers(top, [column - 1 for column in own.values()])
    return _by_names(top, wanted, own)


def _by_names(top: _Top, wanted: Mapping[str, str | int], own: Mapping) -> _Head:
    """The head with the first line that has the names, if possible with numbers below it."""
    first = None
    for i in top.filled(0):
        names = top.names(i)
        found = {kind: places_of(names, column) if names else [] for kind, column in wanted.items()}
        if all(found.values()):
            at = [found[kind][0] for kind in own]
            first = i if first is None else first
            below = [k for _, k in zip(range(3), top.filled(i + 1), strict=False)]
            if any(top.numeric(k, at) for k in below):
                break
    else:
        i = first
    if i is None:
        raise RejectedCurveError(top.file, _no_names(top, wanted))
    names = top.names(i)
    at = [places_of(names, column)[0] for column in own.values()]
    return _below(top, i, names, at)


def _below(top: _Top, i: int, names: Sequence[str], at: Sequence[int]) -> _Head:
    """The head with names in a line: units may stand below it, and text above the samples."""
    units = None
    below = (k for k in top.filled(i + 1) if not is_remark(top[k]))
    first = next(below, None)
    if first is not None and _has_texts(top, top[first], at):
        units, first = first, next(below, None)
    if first is None:
        line = top.text.count("\n") + 1
        raise RejectedCurveError(top.file, f"ends before its first sample, with line {line}")
    cells = list(filter(str.strip, top[first]))
    if 2 * len(cells) <= len(names) and not any(top.kind(cell) == 1 for cell in cells):
        # A line of text rather than a damaged sample.
        first = next((k for k in top.filled(first) if top.numeric(k, at)), first)
    return _head(top, first, len(names), i, units)


def _head(top: _Top, first: int, width: int, i: int, units: int | None) -> _Head:
    """The head with names and units in some lines."""
    names, texts = top.names(i) or top[i], [] if units is None else top[units]
    width = max(width, len(names), len(texts))
    return _Head(first, width, names, texts, (i, units), (i, units, top.over(i)))


def _has_texts(top: _Top, row: Sequence[str], at: Iterable[int]) -> bool:
    """Whether a line below the names is none of samples: it has a text, and no number."""
    cells = [row[place] for place in at if place < len(row)]
    if all(top.kind(cell) == 0 for cell in cells):  # the other columns decide
        cells = row
    kinds = {top.kind(cell) for cell in cells}
    return -1 in kinds and 1 not in kinds


def _by_numbers(top: _Top, wanted: Sequence[int]) -> _Head:
    """The head above the first lines of numbers, with names and units if there are such.

    Raises:
        LayoutError: If there are none, or not in the places that are wanted.
    """
    body = [cells_of(line, top.delimiter) for line in _some_lines(top.text, 1000)]
    width = max(map(len, body), default=0)
    counts = np.zeros((3, width))
    for row in body:
        for place, cell in enumerate(row):
            counts[top.kind(cell), place] += 1
    numeric = [i for i in range(width) if counts[1, i] > 3 * counts[-1, i]]
    usual = np.median([sum(top.kind(cell) == 1 for cell in row) for row in body]) if body else 0

    @cache
    def fits(i: int) -> bool:
        kinds = [top.kind(cell) for cell in top[i]]
        texts = any(kinds[at] < 0 for at in numeric if at < len(kinds))
        return 2 * kinds.count(1) >= usual > 0 and not texts and top.numeric(i, wanted)

    lines = list(top.filled(0))
    for at, i in enumerate(lines):
        run = lines[at : at + _RUN]
        if numeric and fits(i) and sum(map(fits, run)) >= 0.75 * max(len(run), 1 if wanted else 5):
            return _named(top, i, width)
    if wanted:
        columns = " and ".join(str(place + 1) for place in wanted)
        reason = f"has no numbers in column {columns}; see endurance.format, also delimiter and"
        raise RejectedCurveError(top.file, f"{reason} decimal")
    place = "" if len(top) > top.text.count("\n") else f" in the first {len(top):,} lines"
    reason = f"no columns of numbers are found{place}; is it a text file of measurements?"
    raise LayoutError(top.file, reason)


def _named(top: _Top, first: int, width: int) -> _Head:
    """The head above a sample: names and units next to each other, in the last lines above it or,
    with other text below, where there are such.
    """
    above = [i for i in top.filled(first - 1, -1)]
    units = above[0] if above and _are_units(top[above[0]]) else None
    candidates = above[1:] if units is not None else above
    if candidates and _are_names(top[candidates[0]], width):
        names = candidates[0]
    elif units is not None:  # a line of short names, such as "t;s", may look like one of units
        names, units = units, None
    else:
        pairs = zip(above[1:], above, strict=False)
        fit = ((i, k) for i, k in pairs if _are_names(top[i], width) and _are_units(top[k]))
        names, units = next(fit, (None, None))
    if names is None:
        return _Head(first, width)
    return _head(top, first, width, names, units)


def _are_units(row: Iterable[str]) -> bool:
    cells = [cell for cell in row if cell.strip("[]()-1")]
    return bool(cells) and sum(unit_of(cell) is not None for cell in cells) >= 2 / 3 * len(cells)


def _are_names(row: Sequence[str], columns: int) -> bool:
    """Whether a line has names of columns, one more at most, such as one of remarks."""
    cells = list(filter(None, row))
    found = filter(None, map(_VALUE.fullmatch, cells))
    values = sum(not each["unit"] or unit_of(each["unit"]) is not None for each in found)
    short = all(len(cell) <= 60 for cell in cells)
    return short and 2 * values < len(cells) and columns / 2 <= len(cells) <= columns + 1


def _no_names(top: _Top, wanted: Mapping[str, str | int]) -> str:
    """Why no line has the names."""
    rows = [top.names(i) for i in top.filled(0)]
    lacking = [c for c in wanted.values() if not any(row and places_of(row, c) for row in rows)]
    columns = " and ".join(map(label_of, lacking or wanted.values()))
    for sign in ",;\t| ":
        split = ([cell.strip('"') for cell in top.lines[i].split(sign)] for i in top.filled(0))
        if sign != top.delimiter and any(
            all(places_of(cells, column) for column in wanted.values()) for cells in split
        ):
            return f"no line has {columns}; is endurance.format.delimiter {sign!r}?"
    reason = f"no line has {columns}"
    with suppress(RejectedCurveError):
        head = _by_numbers(top, [])
        if head.named[0] is not None:
            has = listed(head.names)
            reason += f"; line {head.named[0] + 1}, above the numbers, has {has}"
    return reason + "; see endurance.format, also its encoding, or give numbers of columns"


def _of_labview(preamble: Iterable[Sequence[str]], texts: Sequence[str]) -> list[str]:
    """Units of columns, also as a LabVIEW text has them: above the names, in a line of its own."""
    found = next((row for row in preamble if row[0] == "Y_Unit_Label"), None)
    if found is None or any(texts):
        return [*texts]
    timed = any(row[:2] == ["X_Dimension", "Time"] for row in preamble)  # it is in seconds
    return [*["s" if timed else "", *found[1:], *texts][: len(texts)]]


# ---- samples -------------------------------------------------------------------------------------


class _Part(NamedTuple):
    """Lines of samples, without blank ones and remarks.

    Attributes:
        lines: Of each row, from 1, ``(t,)``.
        columns: Cells of each column.
        widths: Number of cells of each row; None where all have the usual one.
    """

    lines: np.ndarray
    columns: Sequence[Sequence[str]]
    widths: Sequence[int] | None


class _Cells(Table):
    """Columns of cells, which are read as numbers when they are asked for."""

    def __init__(self, text: str, begin: int, head: _Head, settings: Mapping) -> None:
        self._width, self._decimal = head.width, settings["decimal"]
        self._delimiter, self._text = settings["delimiter"], text
        self._place = begin, head.first + 1, self._width
        self._read: dict[int, tuple[np.ndarray, dict[int, str]]] = {}
        self._rows: tuple[np.ndarray, np.ndarray] | None = None  # lines and widths
        self.odd_widths: dict[int, str] = {}

    def __len__(self) -> int:
        return self._width

    def __getitem__(self, place: int | slice) -> np.ndarray | list[np.ndarray]:
        if isinstance(place, slice):
            return [self[i] for i in range(self._width)[place]]
        if not -self._width <= place < self._width:
            raise IndexError(place)
        place %= self._width
        several = range(self._width) if len(self._text) > 2 * _BLOCK else ()
        values = self.numbers([place, *several])[0]
        beyond = np.abs(values) > LARGEST_NUMBER["time"]
        return np.where(beyond, np.nan, values) if beyond.any() else values

    @property
    def lines(self) -> np.ndarray:
        self.numbers([])
        return self._rows[0]

    @property
    def nbytes(self) -> int:
        return len(self._text) + sum(values.nbytes for values, _ in self._read.values())

    def wrong(self, place: int) -> Mapping[int, str]:
        return self._read[place][1]

    def present(self, place: int) -> np.ndarray:
        self.numbers([])
        return self._rows[1] > place

    def numbers(self, places: Iterable[int]) -> list[np.ndarray]:
        """Return some columns; of a large text, each time that one is new, all parts are split."""
        places = [*places]
        new = [place for place in dict.fromkeys(places) if place not in self._read]
        if new or self._rows is None:
            self._parse(new)
        return [self._read[place][0] for place in places]

    def _parse(self, places: Sequence[int]) -> None:
        lines, widths, count = [], [], 0
        values = {place: [] for place in places}
        wrong: dict[int, dict[int, str]] = {place: {} for place in places}
        split = _kept_parts if len(self._text) <= 2 * _BLOCK else _parts
        for part in split(self._text, self._delimiter, *self._place):
            for place in places:
                cells = part.columns[place]
                numbers, odd = strict_numbers(cells, self._decimal)
                values[place].append(numbers)
                if odd and not wrong[place]:
                    cell = cells[odd[0]]
                    wrong[place][count + odd[0]] = f"{cell.strip()[:40]!r}, {why_none(cell)}"
            lines.append(part.lines)
            usual = np.full(part.lines.size, self._width)
            widths.append(usual if part.widths is None else np.array(part.widths))
            count += part.lines.size
        none = np.zeros(0)
        for place in places:
            self._read[place] = np.concatenate([*values[place], none]), wrong[place]
        if self._rows is None:
            self._rows = np.concatenate([*lines, none]).astype(int), np.concatenate([*widths, none])
            self._check_widths()

    def _check_widths(self) -> None:
        """Find a line with more cells than names, as decimal commas make where commas separate; and
        where blanks do, also one with fewer: nobody knows which cell is blank.
        """
        lines, widths = self._rows
        odd = widths > self._width if self._delimiter != " " else widths != self._width
        if odd.any():
            at = int(odd.argmax())
            self.odd_widths[int(lines[at])] = (
                f"{int(widths[at])} cells where there are {self._width} columns; see "
                "endurance.format.delimiter and endurance.format.decimal"
            )


def _parts(text: str, delimiter: str, begin: int, line: int, width: int) -> Iterator[_Part]:
    """Split a text from a sign on, at which a line begins, part by part of entire lines."""
    blank = f'{delimiter}" \t\v\f'
    while begin < len(text):
        end = text.find("\n", begin + _BLOCK)
        end = len(text) if end < 0 else end
        every = text[begin:end].split("\n")
        filled = list(map(str.strip, every, repeat(blank)))
        kept = np.arange(len(every)) if all(filled) else np.flatnonzero(list(map(bool, filled)))
        lines = every if kept.size == len(every) else [every[i] for i in kept.tolist()]
        columns, widths = columns_of_alike(lines, width, delimiter), None
        if columns is None:
            rows = [cells_of(each, delimiter) for each in lines]
            samples = [i for i, row in enumerate(rows) if not is_remark(row)]
            rows, kept = [rows[i] for i in samples], kept[samples]
            columns = [[row[at] if at < len(row) else "" for row in rows] for at in range(width)]
            widths = [len(row) if any(row[width:]) else min(len(row), width) for row in rows]
        yield _Part(line + kept, columns, widths)
        begin, line = end + 1, line + len(every)


# Columns are asked for one after the other. Cells take twelve times the bytes of their text.
@lru_cache(maxsize=2)
def _kept_parts(*text: str | int) -> list[_Part]:
    return list(_parts(*text))
