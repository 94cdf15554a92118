"""Texts with one record on each line, as monitors and benches for endurance tests save them.

On a line stand the number of the operation, its date, the interval between samples, and then all
values: in named fields (``ID:1;Interval (ms):0.4;Values:1204,1201``), or below a line of names, the
last of which is that of the values. A file has thousands of records: a line is read when it is
asked for.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

from breaker.common.lazy_numpy import np
from breaker.records.cells import is_number, strict_numbers, why_none
from breaker.records.dates import clock_of, dates_of, day_order, in_order
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import BLOCK, FEWEST, encoding_of, signs_of
from breaker.records.header import header_of
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet, Table

ENDINGS: dict[str, str] = {}
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = ""

_FIELDS = re.compile(r"(.*[;|\t,])?\s*([^\W\d][^:=;|\t,]*)[:=]([^:=]*)")  # before, name, values


class RecordLine(NamedTuple):
    """A line that is a record.

    Attributes:
        line: Line of the file, from 1.
        number: Number of the operation.
        date: ISO 8601, with its time if that is stated; empty where it is not, or in doubt.
    """

    line: int
    number: int
    date: str


class _Form(NamedTuple):
    """Encoding, delimiter and decimal sign of values, and names above; None for named fields."""

    encoding: str
    delimiter: str
    decimal: str
    names: Sequence[str] | None


def sniff(opened: Opened) -> bool:
    """Return whether a text has a record on each line: many values, and one name for all."""
    return _form(opened) is not None


def _form(opened: Opened) -> _Form | None:
    return opened.once("form of lines", lambda: _form_of(opened.content))


def _form_of(content: bytes) -> _Form | None:
    """The form of the first two lines; None where these are not records."""
    first = [line for line in content[: 8 * BLOCK].split(b"\n", 9)[:9] if line.strip()][:2]
    if not first or max(map(len, first)) < 2 * FEWEST or b"\r" in first[0].strip():
        return None  # nothing, short lines, or lines that end otherwise
    encoding = encoding_of(b"\n".join(first))
    texts = [line.decode(encoding, errors="replace").strip() for line in first]
    found = _FIELDS.fullmatch(texts[-1])
    delimiter, decimal = signs_of([(found[3] if found else texts[-1])[: 200 * FEWEST]])
    cells = _cells(found[3] if found else texts[-1], delimiter)
    numbers = [is_number(cell, decimal) for cell in cells[: 20 * FEWEST]]
    if sum(numbers) < FEWEST:
        return None
    if found:
        return _Form(encoding, delimiter, decimal, None)
    names = [name.strip(' "') for name in _cells(texts[0], delimiter)]
    if len(texts) > 1 and 2 <= len(names) < len(cells) / 2 and all(names):
        return _Form(encoding, delimiter, decimal, names)
    unnamed = sum(is_number(name, decimal) for name in names) >= FEWEST
    dated = any(map(dates_of, cells[:FEWEST]))
    return _Form(encoding, delimiter, decimal, []) if unnamed and dated else None


def _cells(text: str, delimiter: str) -> list[str]:
    text = text.strip(f" \t\r\n;|{delimiter}")
    return text.split(None if delimiter == " " else delimiter)


def records_in(opened: Opened) -> list[RecordLine]:
    """Return the records of a file, in the order of their lines; none where it is of another kind.
    A record without a number has that of its place, from 1.
    """
    if not sniff(opened):
        return []
    records = [(line, _split(opened, line)[0]) for line in _records(opened)]
    dates = [next(filter(None, (dates_of(v) for _, v in fields)), {}) for _, fields in records]
    order, found = day_order(filter(None, dates)), []
    for place, ((line, fields), readings) in enumerate(zip(records, dates, strict=True), start=1):
        numbers = (int(value) for _, value in fields if value.isdecimal())
        days = in_order(readings, order) if readings else ()
        clock = next(filter(None, (clock_of(value) for _, value in fields)), "")
        date = days[0] + clock if len(days) == 1 else ""
        found.append(RecordLine(line, next(numbers, place), date))
    return found


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the record on a line, that of the form's ``line``, or on the first one.

    Raises:
        RejectedCurveError: If the line is not that of a record, or its values are not numbers.
    """
    file, (first, second) = opened.file, [*islice(_records(opened), 2), 0, 0][:2]
    line = form.get("line") or first
    if not _content(opened, line):
        raise RejectedCurveError(file, "has no record on this line", line=line)
    signs = _form(opened)._asdict()
    names_above = signs.pop("names")
    for key in ("delimiter", "decimal"):
        if form.get(key, signs[key]) != signs[key]:
            reason = f"endurance.format.{key} is {form[key]!r}, but that of the values is"
            raise RejectedCurveError(file, f"{reason} {signs[key]!r}", line=line)
    fields, name, cells = _split(opened, line)
    check_size(file, len(cells), 1, line=line)
    numbers, wrong = strict_numbers(cells, signs["decimal"])
    if wrong:
        cell = cells[wrong[0]]
        reason = f"value {wrong[0] + 1} of {name!r} is {cell.strip()[:40]!r}, {why_none(cell)}"
        raise RejectedCurveError(file, reason, line=line)
    pairs = [[f"{key}:", value] for key, value in fields]
    rate, unit = header_of(pairs, signs["decimal"]).rate, form.get("time_unit", "ms")
    names, columns, texts, clock = [name], [numbers], [""], None
    if rate > 0 and form.get("time_column", "") is not None:
        time = form.get("time_column")
        names = [time if time and isinstance(time, str) else "time", name]
        columns = [np.arange(numbers.size) / rate / TO_MS[unit], numbers]
        texts, clock = [unit, ""], 0
    said = ()
    if not form.get("line") and second:
        said = (f"has a record on each line; this is that of line {line}",)
    table, kind = Table(columns, np.full(numbers.size, line)), "a text with a record on each line"
    named = (1 if names_above else line,) * 2
    return [Sheet(file, names, table, texts, pairs, signs, clock, named, said, kind=kind)]


def _content(opened: Opened, line: int) -> bytes:
    """The content of a line, from 1; empty where it is not that of a record."""
    ends = opened.once("ends of lines", lambda: _ends_of(opened))
    if not 0 < line < ends.size or (line == 1 and _form(opened).names):
        return b""
    return opened.content[ends[line - 1] + 1 : ends[line]].strip()


def _records(opened: Opened) -> Iterator[int]:
    """Return the lines of records."""
    ends = opened.once("ends of lines", lambda: _ends_of(opened))
    return (line for line in range(1, ends.size) if _content(opened, line))


def _ends_of(opened: Opened) -> np.ndarray:
    """Places of the ends of lines, ``(n + 1,)``; the first is that before the first line."""
    check_lines(opened.file, opened.content)
    ends = np.flatnonzero(np.frombuffer(opened.content, np.uint8) == ord("\n"))
    return np.array([-1, *ends, len(opened.content)])


def _split(opened: Opened, line: int) -> tuple[list[tuple[str, str]], str, list[str]]:
    """The names and values of what a record states, and the name and the cells of its values."""
    form = _form(opened)
    text = _content(opened, line).decode(form.encoding, errors="replace").strip()
    if form.names:
        cells, last = _cells(text, form.delimiter), len(form.names) - 1
        stated = [
            (name, cell.strip(' "')) for name, cell in zip(form.names, cells[:last], strict=False)
        ]
        return stated, form.names[last], cells[last:]
    if form.names is not None or (found := _FIELDS.fullmatch(text)) is None:
        reason = (
            "has many values without a name: write a line of names above, such as Number, Date, "
            "Interval (ms), Values, the last of which is that of all values"
        )
        raise RejectedCurveError(opened.file, reason, line=line)
    before, name, values = found.groups()
    parts = re.split(r"[;|\t]" if form.decimal == "," else r"[;|\t,]", before or "")
    fields = (re.split("[:=]", part, maxsplit=1) for part in parts)
    stated = [(field[0].strip(' "'), field[1].strip(' "')) for field in fields if len(field) > 1]
    return stated, name.strip(' "'), _cells(values, form.delimiter)
