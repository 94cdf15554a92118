"""Texts with one record on each line, as monitors and benches for endurance tests save them.

A line contains the number of the operation, its date, the interval between samples, and then all
values: in named fields (``ID:1;Interval (ms):0.4;Values:1204,1201``), or below a line of names,
whose last name is for the values. A file has thousands of records, so a line is only read on
request.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from breaker.records.cells import NOT_A_NUMBER, is_number, strict_numbers
from breaker.records.dates import clock_of, dates_of, day_order, in_order
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import DELIMITERS, FEWEST, encoding_of, long_lines, signs_of
from breaker.records.header import header_of
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet

_SAMPLE = 2000  # signs of values from which the delimiter and the decimal sign are estimated
_FIELDS = re.compile(r"(.*[;|\t,])?\s*([^\W\d][^:=;|\t,]*)[:=]([^:=]*)")  # before, name, values


class RecordLine(NamedTuple):
    """Line that is a record.

    Attributes:
        line: Line of the file, from 1.
        number: Number of the operation.
        date: Date as ISO 8601, with time if stated; empty if not stated or ambiguous.
    """

    line: int
    number: int
    date: str


class _Form(NamedTuple):
    """Layout of lines: signs of values, names above them (empty for named fields), the sign between
    names, and the bytes of each record by its line.
    """

    signs: Mapping[str, str]
    names: Sequence[str]
    between: str
    records: Mapping[int, bytes]


def form_of(opened: Opened) -> _Form | None:
    """Return the layout of a text with a record (one name, many values) on each line, or None."""
    return opened.once("form of lines", lambda: _form_of(opened))


def _form_of(opened: Opened) -> _Form | None:
    """Return the layout by the first two lines; None if these are not records."""
    first = long_lines(opened.content)
    if not first or b"\r" in first[0].strip():
        return None  # no lines, short lines, or other ends of lines
    encoding = encoding_of(b"\n".join(first))
    head, last = (line.decode(encoding, errors="replace").strip() for line in (first[0], first[-1]))
    names, between = [], ""
    if fields := _FIELDS.fullmatch(last):
        values = fields[3]
    else:
        between = next((sign for sign in DELIMITERS if sign in head), ";")
        names = _cells(head, between)
        values = _cells(last, between, len(names) - 1)[-1]
    delimiter, decimal = signs_of([values[:_SAMPLE]])
    cells = _cells(values, delimiter)
    if sum(is_number(cell, decimal) for cell in cells[:_SAMPLE]) < FEWEST:
        return None
    if not fields and not (len(first) > 1 and 2 <= len(names) < len(cells) / 2 and all(names)):
        return None
    check_lines(opened.file, opened.content)
    lines = enumerate(map(bytes.strip, opened.content.split(b"\n")), start=1)
    records = {number: line for number, line in lines if line}
    if names:
        del records[min(records)]
    signs = {"encoding": encoding, "delimiter": delimiter, "decimal": decimal}
    return _Form(signs, names, between, records)


def _cells(text: str, delimiter: str, most: int = -1) -> list[str]:
    text = text.strip(f" \t\r\n;|{delimiter}")
    cells = text.split(None if delimiter == " " else delimiter, most)
    return [cell.strip(' "') for cell in cells] if " " in text or '"' in text else cells


def records_in(opened: Opened) -> list[RecordLine]:
    """Return the records of a file, in the order of their lines. A record without a stated number
    gets its place, from 1.
    """
    form = form_of(opened)
    stated = [[pair[1] for pair in _split(form, line)[0]] for line in form.records.values()]
    dates = [next(filter(None, map(dates_of, values)), {}) for values in stated]
    order, records = day_order(filter(None, dates)), []
    for values, readings, line in zip(stated, dates, form.records, strict=True):
        number = next(filter(str.isdecimal, values), len(records) + 1)
        days = in_order(readings, order) if readings else ()
        clock = next(filter(None, map(clock_of, values)), "")
        date = days[0] + clock if len(days) == 1 else ""
        records.append(RecordLine(line, int(number), date))
    return records


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the record on the line ``line`` of the form, or on the first line.

    Raises:
        RejectedCurveError: If the line is not a record, or its values are not numbers.
    """
    file, layout = opened.file, form_of(opened)
    line = form.get("line") or next(iter(layout.records), 0)
    signs = layout.signs | {key: form[key] for key in layout.signs if key in form}
    fields, name, values = _split(layout._replace(signs=signs), layout.records.get(line, b""))
    cells, decimal = _cells(values, signs["delimiter"]), signs["decimal"]
    if not name:
        reason = "has no record on this line; write on each its values as one list, of one name"
        raise RejectedCurveError(file, reason, line=line)
    check_size(file, len(cells), 1, line=line)
    numbers, wrong = strict_numbers(cells, decimal)
    if wrong:
        cell = cells[wrong[0]].strip()[:40]
        reason = f"value {wrong[0] + 1} of {name!r} is {cell!r}, {NOT_A_NUMBER}"
        raise RejectedCurveError(file, reason, line=line)
    header = header_of([[f"{key}:", value] for key, value in fields], numbers.size)
    unit, names, columns, texts = form.get("time_unit", "ms"), [name], [numbers], [""]
    if timed := header.rate > 0 and form.get("time_column", "") is not None:
        time = np.arange(numbers.size) / header.rate / TO_MS[unit]
        names, columns, texts = ["time", name], [time, numbers], [unit, ""]
    remarks = ()
    if not form.get("line") and len(layout.records) > 1:
        remarks = (f"has a record on each line; this is that of line {line}",)
    sheet = Sheet(
        file,
        names,
        columns,
        texts,
        settings=signs,
        clock=0 if timed else None,
        remarks=remarks,
        lines=np.full(numbers.size, line),
        header=header,
    )
    return [sheet]


def _split(form: _Form, line: bytes) -> tuple[list[tuple[str, str]], str, str]:
    """Return the stated names and values of a record, and the name and the text of its samples; all
    are empty if the line is not a record.
    """
    text = line.decode(form.signs["encoding"], errors="replace")
    if form.names:
        last = len(form.names) - 1
        *cells, values = _cells(text, form.between, last)
        pairs = zip(form.names, cells, strict=False)
        return [*pairs], form.names[last] if len(cells) == last else "", values
    head = max(text.rfind(":"), text.rfind("=")) + 1  # matching all values would be slow
    if (fields := _FIELDS.fullmatch(text[:head])) is None:
        return [], "", ""
    before, name, _ = fields.groups()
    parts = re.split(r"[;|\t]" if form.signs["decimal"] == "," else r"[;|\t,]", before or "")
    pairs = (re.split("[:=]", part, maxsplit=1) for part in parts)
    stated = [(pair[0].strip(' "'), pair[1].strip(' "')) for pair in pairs if len(pair) > 1]
    return stated, name.strip(' "'), text[head:]
