r"""Tables of samples in texts: CSV and the like, in any encoding, with any end of line.

Settings define how a text is read. Encoding, delimiter and decimal sign that they leave out are
estimated from lines of the entire text, to propose settings that a user confirms.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from itertools import islice
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

BLOCK = 2**18
"""Signs of the longest line, of what stands above samples, and of the lines that are split at a
time: 300 columns need a thirtieth of it, and their cells take twelve times the memory."""

FEWEST = 50
"""Samples of the shortest record, 50 ms at 1 kHz: as many lines show where samples begin."""

_CODES = ("gb18030", "cp1252", "shift_jis", "euc_kr", "cp1251", "cp1250")
_WORDS = re.compile(any_of(WORDS["telling"]))
_FOREIGN = re.compile(r"[^\x00-\x7f°µ²³±·½×ßäöüÄÖÜéèêëàâçîïôûñáíóúãõÉÀ–’]|[^\x00-\x7f]{2}")
_PADDED = re.compile(r"0\d+")
_DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits
_VALUE = re.compile(r"[-+]?\d+(?:[.,]\d+)?(?:\s+\S{0,5}|(?P<unit>\S{0,5}))|.*[:=]")  # not `52a`


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the table of a text: see ``registry``."""
    file, content = opened.file, opened.content
    check_lines(file, content)
    encoding = form.get("encoding") or encoding_of(content)
    text = _decode(file, content, encoding, strict="encoding" in form)
    guessed = "delimiter" not in form
    signs = signs_of(_some_lines(text)) if guessed else (form["delimiter"], form["decimal"])
    settings = {"encoding": encoding, "delimiter": signs[0], "decimal": signs[1]}
    return [sheet_of(file, text, settings, form)]


def sheet_of(file: str | Path, text: str, settings: Mapping, form: Mapping) -> Sheet:
    r"""Return the table in a text.

    Args:
        file: Name in messages.
        text: Its lines end with ``\n``.
        settings: Its delimiter and its decimal sign, by their keys in ``endurance.format``.
        form: The section ``endurance.format``, complete, whose columns the table must have; empty
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
    own = (*head.named, None if head.named[0] is None else top.over(head.named[0]))
    preamble = [top.above(i) for i in range(head.first) if i not in own]
    named = tuple(None if i is None else i + 1 for i in head.named)
    names, texts = ([*row, *[""] * head.width][: head.width] for row in (head.names, head.texts))
    labview = next((row for row in preamble if row[0] == "Y_Unit_Label"), None)
    if labview and not any(texts):
        timed = any(row[:2] == ["X_Dimension", "Time"] for row in preamble)  # it is in seconds
        texts = [*["s" if timed else "", *labview[1:], *texts][: head.width]]
    return Sheet(file, names, table, texts, preamble, settings, named=named)


# ---- bytes ---------------------------------------------------------------------------------------


def encoding_of(content: bytes) -> str:
    """Return the encoding of a text: by its mark, UTF-8 where it is valid, or by words."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    start = content[:BLOCK]
    if 4 * (zeros := start.count(0)) > len(start):
        return "utf-16-be" if 2 * start[::2].count(0) > zeros else "utf-16-le"
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return "utf-8"
    lines = (line for line in re.split(rb"[\r\n]+", start) if not line.isascii())
    texts = b"\n".join(lines)
    for code in _CODES:
        if _WORDS.search(texts.decode(code, errors="ignore")):
            return code
    # Western letters hardly stand in pairs; where others do, the code page is not known.
    western = texts.decode("cp1252", errors="replace")
    return "latin-1" if _FOREIGN.search(western) else "cp1252"


def _decode(file: str | Path, content: bytes, encoding: str, *, strict: bool) -> str:
    r"""The text of a file, without a byte order mark, its lines ended by ``\n``. Where its encoding
    is estimated, damaged signs do not hide the rest; reading refuses them.
    """
    if codecs.lookup(encoding).name == "utf-16" and content[:1] == b"\0" != content[1:2]:
        encoding = "utf-16-be"  # without a mark; it begins with a sign of ASCII
    try:
        text = content.decode(encoding, errors="strict" if strict else "replace")
    except UnicodeError as error:
        line = content.count(b"\n", 0, getattr(error, "start", 0)) + 1
        reason = f"cannot be read: {error}; is it a text file, endurance.format.encoding right?"
        raise RejectedCurveError(file, reason, line=line) from error
    if strict and "\0" in text:
        reason = "has zero bytes: it is damaged, or endurance.format.encoding is another one"
        line = text.count("\n", 0, text.index("\0")) + 1
        raise RejectedCurveError(file, reason, line=line)
    text = text.replace("\0", "\ufffd").removeprefix("\ufeff").rstrip("\n\r\x1a")
    if "\r" in text:  # lines that were translated twice end with two returns
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
    begin = 0
    while begin + BLOCK < len(text):
        end = text.rfind("\n", begin, begin + BLOCK + 1)
        if end < 0:
            signs = (text.find("\n", begin) + 1 or len(text) + 1) - 1 - begin
            reason = f"has {signs:,} signs; export a table with one line per sample"
            raise RejectedCurveError(file, reason, line=text.count("\n", 0, begin) + 1)
        begin = end + 1
    return text


# ---- signs and kinds of cells --------------------------------------------------------------------


def _some_lines(text: str) -> list[str]:
    """Return up to 200 lines from all over a text but its first part, without blank ones."""
    some: dict[int, str] = {}
    for at in np.linspace(0.2 * len(text), max(len(text) - 1, 0), 200).astype(int).tolist():
        begin, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
        if sum(map(len, some.values())) < 4 * BLOCK:
            some[begin] = text[begin : end if end >= 0 else len(text)]
    return [line for line in some.values() if line.strip()]


def signs_of(some: Sequence[str]) -> tuple[str, str]:
    """Return the delimiter and the decimal sign with which most cells of lines, and the fewest
    others, are numbers.
    """
    signs = set().union(*some)
    absent = [d for d in _DELIMITERS if d not in signs][:1]  # one is like the other
    pairs = [
        (d, sign)
        for d in _DELIMITERS
        for sign in ".,"
        if (d in signs or d in absent) and (d != sign or '"' in signs)
    ]

    def fit(pair: tuple[str, str]) -> tuple[bool, int]:
        rows, kind = [cells_of(line, pair[0]) for line in some], _kinds(pair[1])
        # 12,045 is one number: no column has zeros before whole numbers, but perhaps the first.
        padded = any(_PADDED.fullmatch(cell) for row in rows for cell in row[1:])
        return not padded, sum(kind(cell) for row in rows for cell in row)

    return max(pairs, key=fit)


def _kinds(decimal: str) -> Callable[[str], int]:
    """Return a function of a cell: 1 for a number, 0 for a missing sample, -1 for a text."""

    @cache
    def kind(cell: str) -> int:
        return 0 if cell.strip().lower() in MISSING else 2 * is_number(cell, decimal) - 1

    return kind


# ---- heads ---------------------------------------------------------------------------------------


class _Head(NamedTuple):
    """First line of samples, from 0, number of columns, names, units, and lines of both."""

    first: int
    width: int
    names: Sequence[str] = ()
    texts: Sequence[str] = ()
    named: tuple[int | None, int | None] = (None, None)


class _Top:
    """Rows of cells of the first lines of a text."""

    def __init__(self, file: str | Path, text: str, settings: Mapping) -> None:
        self.file, self.text, self.delimiter = file, text, settings["delimiter"]
        self.kind = _kinds(settings["decimal"])
        self.lines = text[:BLOCK].split("\n")
        self.row = cache(lambda i: cells_of(self.lines[i], self.delimiter))

    def filled(self, begin: int = 0, step: int = 1) -> Iterator[int]:
        """Return the lines from one on, or back, that are not blank."""
        blank, end = f'{self.delimiter}" \t\v\f', len(self.lines) if step > 0 else -1
        return (i for i in range(begin, end, step) if self.lines[i].strip(blank))

    def offset(self, line: int) -> int:
        """Return where a line begins in the text."""
        return sum(map(len, self.lines[:line])) + line

    def above(self, line: int) -> list[str]:
        """Return the cells of a line; one cell where blanks separate, as they do words, too."""
        return [self.lines[line].strip()] if self.delimiter == " " else self.row(line)

    def numeric(self, i: int, places: Iterable[int]) -> bool:
        """Return whether a line has numbers in some places."""
        return all(self.kind("".join(self.row(i)[at : at + 1])) == 1 for at in places)

    def names(self, i: int) -> list[str]:
        """Return the names in a line, with those of a line of merged cells above it; none where it
        is the upper one of such two.
        """
        below, over, names = next(self.filled(i + 1), None), self.over(i), self.row(i)
        if below is not None and self._merged(i, below):
            return []
        if over is not None:
            names, top = [], ""
            for place, cell in enumerate(self.row(i)):
                top = "".join(self.row(over)[place : place + 1]) or top
                bare, unit = split_unit(top)
                own = f"{bare} ({cell})"  # `Time` above `ms`
                joined = " ".join(filter(None, [bare, cell, top[len(bare) :].strip()]))
                names.append(own if unit is None and split_unit(own)[1] else joined)
        return [names[0].lstrip("#%! ") or names[0], *names[1:]]

    def over(self, i: int) -> int | None:
        """Return the line above another one, where its cells span cells of that."""
        above = next(self.filled(i - 1, -1), None)
        return above if above is not None and self._merged(above, i) else None

    def _merged(self, over: int, i: int) -> bool:
        """Whether cells of the upper line are names of columns, and span some of the lower line."""
        tops, cells = ([*filter(None, self.row(k))] for k in (over, i))
        fits = self.row(over)[0] and 2 <= len({*tops}) < len(cells) >= 0.75 * len(self.row(i))
        if not fits or any(self.kind(cell) == 1 for cell in (*tops, *cells)) or _are_units(cells):
            return False
        return all(any(says(top, words) for words in WORDS["columns"].values()) for top in tops)


def _head_of(top: _Top, form: Mapping) -> _Head:
    """Find the head of a table: by the names of the columns that are wanted, or else by numbers."""
    if form and not top.text.strip():
        raise RejectedCurveError(top.file, "is empty")
    wanted = wanted_columns(map(top.row, top.filled()), form) if form else {}
    time, rows = wanted.get("time"), map(top.names, top.filled())
    if isinstance(time, str) and form["rate"] and not any(r and places_of(r, time) for r in rows):
        del wanted["time"]
    own = [column for kind, column in wanted.items() if kind not in BESIDE]
    if any(isinstance(column, str) for column in wanted.values()):
        return _by_names(top, [*wanted.values()], own)
    return _by_numbers(top, [column - 1 for column in own])


def _by_names(top: _Top, wanted: Sequence[str | int], own: Sequence[str | int]) -> _Head:
    """The head with the first line that has all names, if possible with numbers below it: units may
    stand below it, and all that follows are samples.
    """
    found = None
    for i in top.filled():
        if (names := top.names(i)) and all(places_of(names, column) for column in wanted):
            at = [places_of(names, column)[0] for column in own]
            found = found or (i, at)
            if any(top.numeric(k, at) for k in islice(top.filled(i + 1), 3)):
                found = i, at
                break
    if found is None:
        raise RejectedCurveError(top.file, _no_names(top, wanted))
    i, at = found
    below, units = (k for k in top.filled(i + 1) if not is_remark(top.row(k))), None
    first = next(below, None)
    if first is not None:
        row = top.row(first)
        kinds = {top.kind(row[place]) for place in at if place < len(row)} - {0}
        if (kinds or {top.kind(cell) for cell in row} - {0}) == {-1}:
            units, first = first, next(below, None)
    if first is None:
        line = top.text.count("\n") + 1
        raise RejectedCurveError(top.file, f"ends before its first sample, with line {line}")
    return _head(top, first, 0, i, units)


def _head(top: _Top, first: int, width: int, i: int, units: int | None) -> _Head:
    names, texts = top.names(i) or top.row(i), [] if units is None else top.row(units)
    return _Head(first, max(width, len(names), len(texts)), names, texts, (i, units))


def _by_numbers(top: _Top, wanted: Sequence[int]) -> _Head:
    """The head above the first run of lines that are like those of the entire text."""
    rows = (cells_of(line, top.delimiter) for line in _some_lines(top.text))
    body = [[top.kind(cell) for cell in row] for row in rows] or [[]]
    numbers, texts = (np.median([row.count(kind) for row in body]) for kind in (1, -1))

    @cache
    def fits(i: int) -> bool:
        kinds = [top.kind(cell) for cell in top.row(i)]
        alike = 2 * kinds.count(1) >= numbers and kinds.count(-1) <= texts
        return alike and top.numeric(i, wanted)

    lines = [*top.filled()] if numbers else []
    for at, i in enumerate(lines):
        run = lines[at : at + FEWEST]
        if fits(i) and sum(map(fits, run)) >= 0.75 * max(len(run), 1 if wanted else 5):
            return _named(top, i, max(map(len, body)))
    if wanted:
        columns = " and ".join(str(place + 1) for place in wanted)
        reason = f"has no numbers in column {columns}; see endurance.format.delimiter and decimal"
        raise RejectedCurveError(top.file, reason)
    raise LayoutError(top.file, "no columns of numbers are found; is it a text of measurements?")


def _named(top: _Top, first: int, width: int) -> _Head:
    """The head above a sample: names in the last line above it, or above one of units."""
    above = [*islice(top.filled(first - 1, -1), 2), None, None]
    units = above.pop(0) if above[0] is not None and _are_units(top.row(above[0])) else None
    if above[0] is not None and _are_names(top, above[0], width):
        return _head(top, first, width, above[0], units)
    if units is not None:  # a line of short names, such as "t;s", may look like one of units
        return _head(top, first, width, units, None)
    return _Head(first, width)


def _are_units(row: Iterable[str]) -> bool:
    cells = [cell for cell in row if cell.strip("[]()-1")]
    return bool(cells) and sum(unit_of(cell) is not None for cell in cells) >= 2 / 3 * len(cells)


def _are_names(top: _Top, i: int, columns: int) -> bool:
    """Whether a line has as many names as there are columns, or about so many with blank cells."""
    cells = list(filter(None, top.row(i)))
    matches = filter(None, map(_VALUE.fullmatch, cells))
    values = sum(not each["unit"] or unit_of(each["unit"]) is not None for each in matches)
    least, most = (columns, columns) if top.delimiter == " " else (columns / 2, columns + 1)
    return 2 * values < len(cells) and least <= len(cells) <= most


def _no_names(top: _Top, wanted: Sequence[str | int]) -> str:
    """Why no line has the names."""
    rows = [row for row in map(top.names, top.filled()) if row]
    lacking = [column for column in wanted if not any(places_of(row, column) for row in rows)]
    reason, names = f"no line has {' and '.join(map(label_of, lacking or wanted))}", ""
    with suppress(RejectedCurveError):
        names = listed(_by_numbers(top, []).names)
    shown = f"; above the numbers stand {names}" if names else ""
    return f"{reason}{shown}; see endurance.format, also encoding and delimiter, or give numbers"


# ---- samples -------------------------------------------------------------------------------------


class _Cells(Table):
    """Columns of cells, which are read as numbers when they are asked for."""

    def __init__(self, text: str, begin: int, head: _Head, settings: Mapping) -> None:
        super().__init__(range(head.width))
        self._text, self._begin, self._first = text, begin, head.first + 1
        self._signs = settings["delimiter"], settings["decimal"]
        self._read: dict[int, tuple[np.ndarray, dict[int, str]]] = {}
        self._widths = None
        self.odd_widths: dict[int, str] = {}

    def __getitem__(self, place: int | slice) -> np.ndarray | list[np.ndarray]:
        if isinstance(place, slice):
            return super().__getitem__(place)
        self.numbers(range(len(self)))  # whoever looks into one column, looks into others
        values = super().__getitem__(place)
        beyond = np.abs(values) > LARGEST_NUMBER["time"]
        return np.where(beyond, np.nan, values) if beyond.any() else values

    @property
    def lines(self) -> np.ndarray:
        self.numbers([])
        return self._lines

    @property
    def nbytes(self) -> int:
        return len(self._text) + sum(values.nbytes for values, _ in self._read.values())

    def wrong(self, place: int) -> Mapping[int, str]:
        return self._read[place][1]

    def present(self, place: int) -> np.ndarray:
        self.numbers([])
        return self._widths > place

    def numbers(self, places: Iterable[int]) -> list[np.ndarray]:
        """Return columns; those that are new are read together."""
        places = [*places]
        if (new := {*places} - {*self._read}) or self._widths is None:
            self._parse(new)
        return [self._read[place][0] for place in places]

    def _parse(self, places: Iterable[int]) -> None:
        lines, widths, count = [], [], 0
        values = {place: [np.zeros(0)] for place in places}
        wrong: dict[int, dict[int, str]] = {place: {} for place in places}
        for numbers, columns, cells in self._parts():
            for place in places:
                part, odd = strict_numbers(columns[place], self._signs[1])
                values[place].append(part)
                if odd and not wrong[place]:
                    cell = columns[place][odd[0]]
                    wrong[place][count + odd[0]] = f"{cell.strip()[:40]!r}, {why_none(cell)}"
            lines.append(numbers)
            widths.append(cells)
            count += len(numbers)
        self._read |= {p: (np.concatenate(values[p]), wrong[p]) for p in places}
        self._lines = np.concatenate([*lines, np.zeros(0, int)])
        self._widths = np.concatenate([*widths, np.zeros(0, int)])
        # More cells than names are those of decimal commas where commas separate. Where blanks
        # separate, nobody knows which of fewer cells is blank.
        more, other = self._widths > len(self), self._widths != len(self)
        for at in np.flatnonzero(other if self._signs[0] == " " else more)[:1]:
            self.odd_widths[int(self._lines[at])] = (
                f"{self._widths[at]} cells where there are {len(self)} columns; see "
                "endurance.format.delimiter and endurance.format.decimal"
            )

    def _parts(self) -> Iterator[tuple[np.ndarray, Sequence[Sequence[str]], np.ndarray]]:
        """Yield line numbers of samples, columns of cells and numbers of cells, block by block."""
        text, begin, line, width = self._text, self._begin, self._first, len(self)
        delimiter = self._signs[0]
        blanks = f'[{re.escape(delimiter)}" \t\v\f]*'
        while begin < len(text):
            end = text.find("\n", begin + BLOCK)
            end = len(text) if end < 0 else end
            every = text[begin:end].split("\n")
            lines, kept = every, np.arange(len(every))
            if re.search(f"\n{blanks}\n", f"\n{text[begin:end]}\n"):
                kept = np.array([i for i in kept if not re.fullmatch(blanks, every[i])], int)
                lines = [every[i] for i in kept]
            columns, widths = columns_of_alike(lines, width, delimiter), np.full(kept.size, width)
            if columns is None:
                rows = [cells_of(each, delimiter) for each in lines]
                samples = [i for i, row in enumerate(rows) if not is_remark(row)]
                rows, kept = [rows[i] for i in samples], kept[samples]
                columns = [
                    [row[at] if at < len(row) else "" for row in rows] for at in range(width)
                ]
                sizes = [len(row) if any(row[width:]) else min(len(row), width) for row in rows]
                widths = np.array(sizes, int)
            yield line + kept, columns, widths
            begin, line = end + 1, line + len(every)
