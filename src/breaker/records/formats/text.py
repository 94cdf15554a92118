r"""Tables of samples in texts: CSV and similar, in any encoding, with any end of line.

Settings define how a text is read. Without settings, encoding, delimiter and decimal sign are
estimated from lines of the entire text, to propose settings that a user confirms.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.records import words
from breaker.records.cells import (
    LARGEST_NUMBER,
    MISSING,
    NOT_A_NUMBER,
    cells_of,
    columns_of_alike,
    is_number,
    is_remark,
    strict_numbers,
)
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.sheet import EVERY, Sheet

BLOCK = 2**16
"""Signs of the longest line, of the lines above samples, and of the lines that are split at a time:
300 columns need a seventh of this, and their cells take twelve times the memory."""

FEWEST = 50
"""Samples of the shortest record, 50 ms at 1 kHz; an equal number of lines shows where samples
begin."""

_TOP = 500  # lines in which samples begin: a preamble has at most 400 (see ``header``)
_TWO = 2**21  # bytes that contain a record on one line, with 100,000 samples
_CODES = ("gb18030", "shift_jis", "cp1251")
_WORDS = re.compile(words.any_of(words.WORDS["telling"]))
_LONG = re.compile(rf"\n.{{{BLOCK}}}")
_BLANK = ';,|" \t\v\f'
_BLANK_LINE = re.compile(rf"\n[{_BLANK}]*\n")
_PADDED = re.compile(r"0\d+")
DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the table of a text; see ``registry``."""
    file, content = opened.file, opened.content
    check_lines(file, content)
    encoding = form.get("encoding") or encoding_of(content)
    text = _decoded(file, content, encoding, strict=bool(form))
    pair = (form["delimiter"], form["decimal"]) if form else signs_of(_some_lines(text))
    settings = {"encoding": encoding, "delimiter": pair[0], "decimal": pair[1]}
    return [sheet_of(opened, text, settings, form)]


def sheet_of(opened: Opened, text: str, settings: Mapping, form: Mapping, title: str = "") -> Sheet:
    r"""Return the table in a text, whose lines end with ``\n``.

    Args:
        opened: The file; it keeps the numbers, so that other settings need not read them again.
        text, settings: The text; its delimiter and its decimal sign, by their keys.
        form: The section ``endurance.format``, complete; empty if nothing is known.
        title: Name of the text in a file with several texts.

    Raises:
        RejectedCurveError: If there are no columns of numbers.
    """
    file, top = opened.file, _Top(text, settings)
    if form and not top.lines:
        raise RejectedCurveError(file, "is empty")
    wanted = words.wanted_columns(map(top.names, range(len(top.lines))), form) if form else {}
    if form and form["rate"]:
        wanted.pop("time", None)  # the rate may replace the column
    first, named, unit, width = _head(file, top, wanted)
    names, texts = [] if named is None else top.names(named), [] if unit is None else top.row(unit)
    width = max(width, len(names), len(texts))
    names = [*names, *[""] * (width - len(names))]
    line = top.numbers[first]
    begin = sum(map(len, text[:BLOCK].split("\n", _TOP)[: line - 1])) + line - 1
    check_size(file, text.count("\n", begin), width, line=line)
    untimed = form and form["time_column"] is None  # a short line is not a sample
    least = min(words.places_of(names, wanted["travel"]), default=0) if untimed else 0
    body = _Body(settings["delimiter"], settings["decimal"], width, least)
    key = title, settings.get("encoding"), body, begin
    columns, lines, wrong = opened.once(key, lambda: body.samples(text, begin, line))
    if not form:  # removes overflow values, such as the resistance of open contacts
        columns = [np.where(np.abs(c) > LARGEST_NUMBER["time"], np.nan, c) for c in columns]
    # If blanks separate cells, they also separate words of the preamble.
    preamble = [
        [top.lines[k].strip()] if top.delimiter == " " else top.row(k)
        for k in range(first)
        if k not in (named, unit)
    ]
    return Sheet(file, names, columns, texts, preamble, settings, lines=lines, wrong=wrong)


def first_line(content: bytes) -> bytes:
    """Return the first line of a text that is not blank, if it is long enough for a record."""
    line = next(filter(None, map(bytes.strip, content[:_TWO].split(b"\n", 9)[:9])), b"")
    return line if len(line) >= 2 * FEWEST else b""


def encoding_of(content: bytes) -> str:
    """Return the encoding of a text: by its byte order mark, UTF-8 if valid, or by words."""
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    start = content[:BLOCK]
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return "utf-8"
    codes = (code for code in _CODES if _WORDS.search(start.decode(code, errors="ignore")))
    return next(codes, "cp1252")


def _decoded(file: str | Path, content: bytes, encoding: str, *, strict: bool) -> str:
    r"""Return the text of a file, without a byte order mark, its lines ended by ``\n``. If the
    encoding is only estimated (not ``strict``), damaged signs are replaced, not rejected.
    """
    try:
        text = content.decode(encoding, errors="strict" if strict else "replace")
        if strict and "\0" in text:
            raise UnicodeError("it has zero bytes")
    except UnicodeError as error:
        line = content.count(b"\n", 0, getattr(error, "start", content.find(0))) + 1
        reason = f"cannot be read: {error}; is it complete, and endurance.format.encoding right?"
        raise RejectedCurveError(file, reason, line=line) from error
    text = text.replace("\0", "\ufffd").removeprefix("\ufeff").rstrip("\n\r\x1a")
    if "\r" in text:  # lines that were converted twice end with two returns
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
    if long := _LONG.search(f"\n{text}"):
        reason = f"has more than {BLOCK:,} signs; export a table with one line per sample"
        raise RejectedCurveError(file, reason, line=text.count("\n", 0, long.start()) + 1)
    return text


def _some_lines(text: str) -> list[str]:
    """Return up to 200 lines from all parts of a text except its first fifth, without blanks."""
    lines = {}
    for place in np.linspace(0.2 * len(text), max(len(text) - 1, 0), 200).astype(int).tolist():
        begin, end = text.rfind("\n", 0, place) + 1, text.find("\n", place)
        lines[begin] = text[begin : end if end >= 0 else len(text)]
    return [line for line in lines.values() if line.strip()]


def signs_of(lines: Sequence[str]) -> tuple[str, str]:
    """Return the delimiter and the decimal sign with which most cells of lines, and the fewest
    others, are numbers.
    """
    signs = set().union(*lines)
    delimiters = [d for d in DELIMITERS if d in signs or d == ";"]  # none in a single column
    pairs = [(d, sign) for d in delimiters for sign in ".," if d != sign or '"' in signs]

    def fit(pair: tuple[str, str]) -> tuple[bool, int]:
        rows, kind = [cells_of(line, pair[0]) for line in lines], _kinds(pair[1])
        # 12,045 is one number: only a first column may have integers with leading zeros.
        padded = any(_PADDED.fullmatch(cell) for row in rows for cell in row[1:])
        return not padded, sum(kind(cell) for row in rows for cell in row)

    return max(pairs, key=fit)


def _kinds(decimal: str) -> Callable[[str], int]:
    """Return a function of a cell: 1 for a number, 0 for a missing sample, -1 for a text."""

    @cache
    def kind(cell: str) -> int:
        return 0 if cell.strip().lower() in MISSING else 2 * is_number(cell, decimal) - 1

    return kind


_Head = tuple[int, int | None, int | None, int]
"""Places of the first sample, the names and the units among the first lines; and the number of
columns of the samples, 0 if the names determine it."""


class _Top:
    """First lines of a text that are not blank, and their numbers, from 1."""

    def __init__(self, text: str, settings: Mapping) -> None:
        self.text, self.delimiter = text, settings["delimiter"]
        self.kind = _kinds(settings["decimal"])
        lines = text[:BLOCK].split("\n", _TOP)[:_TOP]
        self.numbers = [i for i, line in enumerate(lines, start=1) if line.strip(_BLANK)]
        self.lines = [lines[i - 1] for i in self.numbers]
        self.row = cache(lambda k: cells_of(self.lines[k], self.delimiter))

    def kinds(self, k: int, places: Sequence[int]) -> list[int]:
        """Return the kinds of cells of a line; a missing cell counts as a missing sample."""
        return [self.kind("".join(self.row(k)[place : place + 1])) for place in places]

    def names(self, k: int) -> list[str]:
        """Return the names in a line."""
        row = self.row(k)
        return [row[0].lstrip("#%! ") or row[0], *row[1:]]


def _head(file: str | Path, top: _Top, wanted: Mapping[str, str | int]) -> _Head:
    """Return the head above the first run of lines that are similar to those of the entire text.

    The names are in the last line above the run that contains all wanted names, or else in the last
    line, or in the line above the units.
    """
    needed = [column for kind, column in wanted.items() if kind not in words.BESIDE]
    places = [column - 1 for column in needed if isinstance(column, int)]
    rows = [cells_of(line, top.delimiter) for line in _some_lines(top.text)] or [[]]
    body = [[*map(top.kind, row)] for row in rows]
    numbers, texts = (np.median([row.count(kind) for row in body]) for kind in (1, -1))

    @cache
    def fits(k: int) -> bool:
        kinds = [*map(top.kind, top.row(k))]
        similar = 2 * kinds.count(1) >= numbers > 0 and kinds.count(-1) <= texts
        return similar and all(kind == 1 for kind in top.kinds(k, places))

    for first in range(len(top.lines)):
        run = range(first, min(first + FEWEST, len(top.lines)))
        if fits(first) and 4 * sum(map(fits, run)) >= 3 * max(len(run), 1 if wanted else 5):
            break
    else:
        reason = "has no columns of numbers; is it a text of measurements?"
        remedy = "See endurance.format.delimiter and decimal, or breaker inspect FILE"
        raise RejectedCurveError(file, f"{reason} {remedy}")
    width, above = max(map(len, body)), first - 1
    by_names = any(isinstance(column, str) for column in wanted.values())
    for k in range(above, -1, -1) if by_names else ():
        if all(words.places_of(top.names(k), column) for column in wanted.values()):
            return first, k, above if k == above - 1 else None, 0  # unnamed columns do not count
    units = above if above >= 0 and _are_units(top.row(above)) else None
    names = above if units is None else above - 1
    cells = [*filter(None, top.row(names))] if names >= 0 else []
    values = sum(top.kind(cell) == 1 or cell.endswith((":", "=")) for cell in cells)
    least, most = (width, width) if top.delimiter == " " else (width / 2, width + 1)
    if not (2 * values < len(cells) and least <= len(cells) <= most):
        names, units = units, None  # names such as "t;s" may look like units
    return first, names, units, width


def _are_units(row: Sequence[str]) -> bool:
    """Return whether at least two thirds of the cells of a line are units."""
    cells = [cell for cell in row if cell.strip("[]()-1")]
    units = sum(words.unit_of(cell) is not None for cell in cells)
    return bool(cells) and 3 * units >= 2 * len(cells)


class _Body(NamedTuple):
    """Reader of samples; a line with at most ``least`` cells is not a sample."""

    delimiter: str
    decimal: str
    width: int
    least: int

    def samples(
        self, text: str, begin: int, line: int
    ) -> tuple[list[np.ndarray], np.ndarray, dict[int, tuple[int, str]]]:
        """Return the columns, the line of each sample, and wrong cells; see ``Sheet``."""
        wrong: dict[int, tuple[int, str]] = {}
        parts, lines = {place: [np.zeros(0)] for place in range(self.width)}, [np.zeros(0, int)]
        while begin < len(text):
            end = text.find("\n", begin + BLOCK)
            end = len(text) if end < 0 else end
            numbers, cells = self._cells(text[begin:end], line, wrong)
            for place in range(self.width):
                values, others = strict_numbers(cells[place], self.decimal)
                parts[place].append(values)
                if others and place not in wrong:
                    cell = cells[place][others[0]].strip()[:40]
                    wrong[place] = int(numbers[others[0]]), f"is {cell!r}, {NOT_A_NUMBER}"
            lines.append(numbers)
            begin, line = end + 1, line + text.count("\n", begin, end) + 1
        return [np.concatenate(part) for part in parts.values()], np.concatenate(lines), wrong

    def _cells(
        self, part: str, line: int, wrong: dict[int, tuple[int, str]]
    ) -> tuple[np.ndarray, Sequence[Sequence[str]]]:
        """Return line numbers of samples and columns of cells of lines; add errors to ``wrong``."""
        every, width = part.split("\n"), self.width
        columns = columns_of_alike(every, width, self.delimiter)
        if columns is not None and not _BLANK_LINE.search(f"\n{part}\n"):
            return np.arange(line, line + len(every)), columns
        kept, padded = [], []
        for number, row in enumerate((cells_of(cells, self.delimiter) for cells in every), line):
            if not any(row) or is_remark(row) or len(row) <= self.least:
                continue
            # Surplus cells come from decimal commas if commas separate cells; if blanks separate
            # cells and some are missing, their columns are unknown.
            if any(row[width:]) or (self.delimiter == " " and len(row) < width):
                reason = f"{len(row)} cells where there are {width} columns"
                remedy = "see endurance.format.delimiter and endurance.format.decimal"
                wrong.setdefault(EVERY, (number, f"{reason}; {remedy}"))
            kept.append(number)
            padded.append([*row, *[""] * width][:width])
        return np.array(kept, int), [*zip(*padded, strict=True)] or [()] * width
