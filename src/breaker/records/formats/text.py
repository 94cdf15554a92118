r"""Tables of samples in texts: CSV and similar, in any encoding, with any end of line.

Settings define how a text is read. Without settings, encoding, delimiter and decimal sign are
estimated from lines of the entire text, to propose settings that a user confirms.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np

from breaker.records import words
from breaker.records.cells import (
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
DELIMITERS = (";", "\t", "|", ",", " ")  # in case of doubt, the first that fits


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the table of a text; see ``detection``."""
    file, content = opened.file, opened.content
    check_lines(file, content)
    encoding = form.get("encoding") or encoding_of(content)
    text = _decoded(file, content, encoding, strict=bool(form))
    pair = (form["delimiter"], form["decimal"]) if form else signs_of(_some_lines(text))
    settings = {"encoding": encoding, "delimiter": pair[0], "decimal": pair[1]}
    return [sheet_of(opened, text, settings)]


def sheet_of(opened: Opened, text: str, settings: Mapping, title: str = "") -> Sheet:
    r"""Return the table in a text, whose lines end with ``\n``; the file keeps it.

    Args:
        text, settings: The text; its delimiter and its decimal sign, by their keys.
        title: Name of the text in a file with several texts.

    Raises:
        RejectedCurveError: If there are no columns of numbers.
    """
    key = ("sheet", title, *settings.values())
    return opened.once(key, lambda: _sheet_of(opened.file, text, settings))


def _sheet_of(file: str | Path, text: str, settings: Mapping) -> Sheet:
    """Return the table below the head of a text. Samples begin with the first run of lines that are
    similar to those of the entire text.
    """
    delimiter, kind = settings["delimiter"], _kinds(settings["decimal"])
    lines = text[:BLOCK].split("\n", _TOP)[:_TOP]
    full = [i for i, line in enumerate(lines) if line.strip(_BLANK)]
    body = [[*map(kind, cells_of(line, delimiter))] for line in _some_lines(text)] or [[]]
    numbers, texts = (np.median([row.count(sort) for row in body]) for sort in (1, -1))

    @cache
    def fits(i: int) -> bool:
        kinds = [*map(kind, cells_of(lines[i], delimiter))]
        return 2 * kinds.count(1) >= numbers > 0 and kinds.count(-1) <= texts

    for above, first in enumerate(full):
        run = full[above : above + FEWEST]
        if fits(first) and 4 * sum(map(fits, run)) >= 3 * len(run):
            break
    else:
        reason = "has no columns of numbers"
        remedy = "is it a text of measurements? Export a table with a line for each sample"
        if signs_of(_some_lines(text)) != (delimiter, settings["decimal"]):
            reason += f" with endurance.format.delimiter {delimiter!r}"
            remedy = "`breaker inspect FILE --output my.yaml` proposes settings"
        raise RejectedCurveError(file, f"{reason}; {remedy}" if full else "is empty")
    preamble, width = [cells_of(lines[i], delimiter) for i in full[:above]], max(map(len, body))
    names, units = _pop_names(preamble, width, settings)
    if delimiter == " ":  # blanks also separate words of the preamble
        preamble = [[lines[i].strip()] for i in full[: len(preamble)]]
    width = max(len(names), len(units)) or width
    begin = sum(map(len, lines[:first])) + first
    check_size(file, text.count("\n", begin), width, line=first + 1)
    columns, rows, wrong = _samples(text, begin, first + 1, width, settings)
    names = [*names, *[""] * (width - len(names))]
    return Sheet(file, names, columns, units, preamble, settings, lines=rows, wrong=wrong)


def _pop_names(
    above: list[list[str]], width: int, settings: Mapping
) -> tuple[list[str], list[str]]:
    """Remove the names and units of columns from the lines above samples, and return both. Names
    are in the last line, or in the line above the units; empty if not there.
    """
    units = above.pop() if above and _are_units(above[-1]) else []
    names = above[-1] if above else []
    kind, cells = _kinds(settings["decimal"]), [*filter(None, names)]
    values = sum(kind(cell) == 1 or cell.endswith((":", "=")) for cell in cells)
    least, most = (width, width) if settings["delimiter"] == " " else (width / 2, width + 1)
    if 2 * values < len(cells) and least <= len(cells) <= most:
        above.pop()
    else:
        names, units = units, []  # names such as "t;s" may look like units
    return [name.lstrip("#%! ") or name for name in names[:1]] + names[1:], units


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

    def fit(pair: tuple[str, str]) -> int:
        kind = _kinds(pair[1])
        return sum(kind(cell) for line in lines for cell in cells_of(line, pair[0]))

    return max(pairs, key=fit)


def _kinds(decimal: str) -> Callable[[str], int]:
    """Return a function of a cell: 1 for a number, 0 for a missing sample, -1 for a text."""

    @cache
    def kind(cell: str) -> int:
        return 0 if cell.strip().lower() in MISSING else 2 * is_number(cell, decimal) - 1

    return kind


def _are_units(row: Sequence[str]) -> bool:
    """Return whether at least two thirds of the cells of a line are units."""
    cells = [cell for cell in row if cell.strip("[]()-1")]
    units = sum(words.unit_of(cell) is not None for cell in cells)
    return bool(cells) and 3 * units >= 2 * len(cells)


_Wrong = dict[int, tuple[int, str]]
"""Line and reason of the first wrong cell of a column, by its place."""


def _samples(
    text: str, begin: int, line: int, width: int, settings: Mapping
) -> tuple[list[np.ndarray], np.ndarray, _Wrong]:
    """Return the columns, ``(t,)``, and the line of each sample, and wrong cells, of the text from
    the sign ``begin`` of a line on, block by block.
    """
    wrong: _Wrong = {}
    parts, lines = [[np.zeros(0)] for _ in range(width)], [np.zeros(0, int)]
    while begin < len(text):
        end = text.find("\n", begin + BLOCK)
        end = len(text) if end < 0 else end
        numbers, cells = _cells(text[begin:end], line, width, settings, wrong)
        for place in range(width):
            values, others = strict_numbers(cells[place], settings["decimal"])
            parts[place].append(values)
            if others and place not in wrong:
                cell = cells[place][others[0]].strip()[:40]
                wrong[place] = int(numbers[others[0]]), f"is {cell!r}, {NOT_A_NUMBER}"
        lines.append(numbers)
        begin, line = end + 1, line + text.count("\n", begin, end) + 1
    return [np.concatenate(part) for part in parts], np.concatenate(lines), wrong


def _cells(
    part: str, line: int, width: int, settings: Mapping, wrong: _Wrong
) -> tuple[np.ndarray, Sequence[Sequence[str]]]:
    """Return line numbers of samples and columns of cells of lines; add errors to ``wrong``. A line
    with a single cell that is not a number is not a sample of several columns.
    """
    every, delimiter = part.split("\n"), settings["delimiter"]
    columns = columns_of_alike(every, width, delimiter)
    if columns is not None and not _BLANK_LINE.search(f"\n{part}\n"):
        return np.arange(line, line + len(every)), columns
    kept, padded = [], []
    for number, row in enumerate((cells_of(cells, delimiter) for cells in every), line):
        alone = len(row) == 1 < width and not is_number(row[0], settings["decimal"])
        if not any(row) or is_remark(row) or alone:
            continue
        # Surplus cells come from decimal commas if commas separate cells; if blanks separate
        # cells and some are missing, their columns are unknown.
        if any(row[width:]) or (delimiter == " " and len(row) < width):
            reason = f"{len(row)} cells where there are {width} columns"
            remedy = "see endurance.format.delimiter and endurance.format.decimal"
            wrong.setdefault(EVERY, (number, f"{reason}; {remedy}"))
        kept.append(number)
        padded.append([*row, *[""] * width][:width])
    return np.array(kept, int), [*zip(*padded, strict=True)] or [()] * width
