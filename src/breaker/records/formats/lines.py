"""Texts with one record on each line, as monitors and benches for endurance tests save them.

On a line stand the number of the operation, its date, the interval between samples, and then all
values. They are named on the line (``ID:1;Interval (ms):0.4;Values:1204,1201``) or in a line of
names above, of which the last is that of the values. A file has thousands of records: its lines are
indexed once, and a line is read when it is asked for.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

from breaker.common.lazy_numpy import np
from breaker.records.cells import is_number, strict_numbers, why_none
from breaker.records.dates import clock_of, dates_of, day_order, in_order
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import encoding_of, signs_of
from breaker.records.header import header_of
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet, Table
from breaker.records.words import split_unit

ENDINGS: dict[str, str] = {}
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = ""

_KIND = "a text with a record on each line"
_LONGEST = 2**21  # bytes of the first lines: of a record of 3 s at 100 kHz
_FEWEST = 50  # values on a line: a record of 50 ms at 1 kHz; tables of one for each sample have 30
_NAME = re.compile(r"[^\W\d][^:=]*")
_QUOTES = ' \t\r\n"{'  # of names
_ENDS = ' \t\r\n;,|"[](){}'  # of cells, and what JSON has about them


class RecordLine(NamedTuple):
    """A line that is a record.

    Attributes:
        line: Of the file, from 1.
        number: Of the operation.
        date: As ISO 8601, with its time if that is stated; empty where it is not, or in doubt.
    """

    line: int
    number: int
    date: str


class _Form(NamedTuple):
    """How the lines of a file are to be read.

    Attributes:
        encoding, delimiter, decimal: Of the values.
        names: In the line of names; None where each line has its own.
    """

    encoding: str
    delimiter: str
    decimal: str
    names: Sequence[str] | None


class _Index(NamedTuple):
    """Where the lines of a file are that are no blank ones: first bytes and those after the last,
    ``(n,)``, numbers of the lines, and how they are read.
    """

    begins: np.ndarray
    ends: np.ndarray
    lines: np.ndarray
    form: _Form

    @property
    def nbytes(self) -> int:
        return self.begins.nbytes + self.ends.nbytes + self.lines.nbytes


def sniff(opened: Opened) -> bool:
    """Say whether a text has a record on each line: values with a name, many on a line, of which
    nothing names each.
    """
    return opened.once("form of lines", lambda: _form_of(opened.content)) is not None


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the record on a line, that of the form's ``line``, or on the first one.

    Raises:
        RejectedCurveError: If the line is none of a record, or its values are not numbers.
    """
    index, file = _index_of(opened), opened.file
    asked = form.get("line") or int(index.lines[0])
    if not (place := np.flatnonzero(index.lines == asked)).size:
        raise RejectedCurveError(file, "has no record on this line", line=asked)
    for key, sign in zip(("encoding", "delimiter", "decimal"), index.form, strict=False):
        if (given := form.get(key, sign)) != sign and key != "encoding":
            reason = f"endurance.format.{key} is {given!r}, but that of the values is {sign!r}"
            raise RejectedCurveError(file, reason, line=asked)
    fields, name, cells = _split(opened, index, int(place[0]))
    check_size(file, len(cells), 1, line=asked)
    numbers, wrong = strict_numbers(cells, index.form.decimal)
    if wrong:
        cell = cells[wrong[0]]
        reason = f"value {wrong[0] + 1} of {name!r} is {cell.strip()[:40]!r}, {why_none(cell)}"
        raise RejectedCurveError(file, reason, line=asked)
    pairs = [[f"{key}:", value] for key, value in fields]
    settings = dict(zip(("encoding", "delimiter", "decimal"), index.form, strict=False))
    unit = form.get("time_unit", "ms")
    # Most fields that state a rate are alike in all records; those of numbers and dates are not.
    alike = tuple(field for field in fields if split_unit(field[0])[1] or field[1].isalpha())
    rate = _rate(alike, index.form.decimal) or _rate(tuple(fields), index.form.decimal)
    names, columns, texts, clock = [name], [numbers], [""], None
    if rate and form.get("time_column", "") is not None:
        time = form.get("time_column") or "time"
        names = [time if isinstance(time, str) else "time", name]
        columns = [np.arange(numbers.size) / rate / TO_MS[unit], numbers]
        texts, clock = [unit, ""], 0
    said = ()
    if not form.get("line") and index.lines.size > 1:
        said = (f"has {index.lines.size} records, one on each line; this is that of line {asked}",)
    table = _Values(columns, asked)
    named = (asked, asked)
    return [Sheet(file, names, table, texts, pairs, settings, clock, named, said, kind=_KIND)]


@lru_cache(maxsize=16)
def _rate(fields: Sequence[tuple[str, str]], decimal: str) -> float:
    """The rate that fields state, kHz; 0 where they state none."""
    header = header_of([[f"{key}:", value] for key, value in fields], decimal)
    return float(np.nan_to_num(header.rate))


def records_in(opened: Opened) -> list[RecordLine]:
    """Return the records of a file, in the order of their lines; none where it is of another kind.
    A record without a number has that of its place, from 1.
    """
    if not sniff(opened):
        return []
    index = _index_of(opened)
    every = [_split(opened, index, place)[0] for place in range(index.lines.size)]
    dates = [next(filter(None, (dates_of(value) for _, value in row)), {}) for row in every]
    order, found = day_order(filter(None, dates)), []
    for place, (row, readings) in enumerate(zip(every, dates, strict=True)):
        whole = (int(value) for _, value in row if value.isdecimal())
        day = in_order(readings, order) if readings else ()
        clock = next(filter(None, (clock_of(value) for _, value in row)), "")
        date = day[0] + clock if len(day) == 1 else ""
        found.append(RecordLine(int(index.lines[place]), next(whole, place + 1), date))
    return found


class _Values(Table):
    """The columns of a record on one line."""

    def __init__(self, columns: Sequence[np.ndarray], line: int) -> None:
        super().__init__(columns)
        self._line = line

    @property
    def lines(self) -> np.ndarray:
        return np.full(len(self._columns[0]), self._line)


def _form_of(content: bytes) -> _Form | None:
    """How the lines are to be read, by the first two; None where these are no records."""
    first = [line for line in content[:_LONGEST].split(b"\n", 9)[:9] if line.strip()][:2]
    if not first or max(map(len, first)) < 2 * _FEWEST or b"\r" in first[0].strip():
        return None  # nothing, short lines, or lines that end otherwise
    encoding = encoding_of(b"\n".join(first))
    texts = [line.decode(encoding, errors="replace").strip() for line in first]
    delimiter, decimal = signs_of([texts[-1][: 200 * _FEWEST]])
    cells = _cells(texts[-1], delimiter)
    if sum(is_number(cell, decimal) for cell in cells[: 20 * _FEWEST]) < _FEWEST:
        return None
    if _values_at(cells, decimal):
        return _Form(encoding, delimiter, decimal, None)
    names = [name.strip(_QUOTES) for name in _cells(texts[0], delimiter)]
    if len(texts) > 1 and 2 <= len(names) < len(cells) / 2 and all(names):
        return _Form(encoding, delimiter, decimal, names)
    above = sum(is_number(name, decimal) for name in names)
    dated = any(map(dates_of, cells[: len(cells) - _FEWEST]))
    return _Form(encoding, delimiter, decimal, []) if above >= _FEWEST and dated else None


def _cells(text: str, delimiter: str) -> list[str]:
    return text.strip(_ENDS).split(None if delimiter == " " else delimiter)


def _values_at(cells: Sequence[str], decimal: str) -> tuple[int, str, str, str] | None:
    """The cell that has the name of the values: its place, what stands before the name, the name,
    and the first value, if it stands in the same cell; None where no cell has it.
    """
    for place, cell in enumerate(cells[:_FEWEST]):
        for sign in [sign for sign in ":=" if sign in cell]:
            before, _, value = cell.rpartition(sign)
            parts = re.split(r"([;,|\t{])", before)
            name, after = parts[-1].strip(_QUOTES), cells[place + 1 : place + _FEWEST]
            named = _NAME.fullmatch(name) and not any(s in "".join(after) for s in ":=")
            numbers = sum(is_number(each, decimal) for each in after)
            value = value.strip(_ENDS)
            if named and 2 * numbers > _FEWEST and (not value or is_number(value, decimal)):
                return place, "".join(parts[:-1]), name, value
    return None


def _index_of(opened: Opened) -> _Index:
    form = opened.once("form of lines", lambda: _form_of(opened.content))
    return opened.once("lines", lambda: _indexed(opened, form))


def _indexed(opened: Opened, form: _Form) -> _Index:
    content = opened.content
    check_lines(opened.file, content)
    at = np.flatnonzero(np.frombuffer(content, np.uint8) == ord("\n"))
    begins, ends = np.append(0, at + 1), np.append(at, len(content))
    filled = [
        bool(content[a : min(a + _FEWEST, b)].strip()) for a, b in zip(begins, ends, strict=True)
    ]
    kept = np.flatnonzero(filled)[form.names is not None :]
    return _Index(begins[kept], ends[kept], kept + 1, form)


def _split(
    opened: Opened, index: _Index, place: int
) -> tuple[list[tuple[str, str]], str, list[str]]:
    """The names and values of what a record states, and the name and the cells of its values.

    Raises:
        RejectedCurveError: If its values have no name.
    """
    form, line = index.form, int(index.lines[place])
    content = opened.content[index.begins[place] : index.ends[place]]
    cells = _cells(content.decode(form.encoding, errors="replace"), form.delimiter)
    if form.names:
        last = len(form.names) - 1
        values = (value.strip(_ENDS) for value in cells[:last])
        return list(zip(form.names, values, strict=False)), form.names[last], cells[last:]
    if form.names is not None or (found := _values_at(cells, form.decimal)) is None:
        reason = (
            "has many values without a name: write a line of names above, such as Number, Date, "
            "Interval (ms), Values, the last of which is that of all values"
        )
        raise RejectedCurveError(opened.file, reason, line=line)
    at, before, name, value = found
    signs = r"[;|\t]" if form.decimal == "," else r"[;|\t,]"
    parts = re.split(signs, form.delimiter.join([*cells[:at], before]))
    fields = (re.split("[:=]", part, maxsplit=1) for part in parts)
    stated = [(f[0].strip(_QUOTES), f[1].strip(_ENDS)) for f in fields if len(f) > 1]
    return stated, name, [*filter(None, [value]), *cells[at + 1 :]]
