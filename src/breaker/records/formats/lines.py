"""Texts with one record on each line, as monitors and benches for endurance tests save them.

A line consists of named fields, and the last field has the values of all samples:
``ID:1;Date:2024-11-20 15:11:07;Interval (ms):0.4;Values:1204,1201``. A file has thousands of
records, so a line is only read on request.
"""

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from breaker.records.cells import NOT_A_NUMBER, is_number, strict_numbers
from breaker.records.dates import clock_of, dates_of, day_order, in_order
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import FEWEST, encoding_of, first_line, signs_of
from breaker.records.header import header_of, pairs_in
from breaker.records.settings import TO_MS
from breaker.records.sheet import Sheet

_SAMPLE = 2000  # signs of values from which the delimiter and the decimal sign are estimated
_FIELDS = re.compile(r"(.*[;|\t,])?\s*([^\W\d][^:=;|\t,]*)[:=]")  # fields before, name of values


class RecordLine(NamedTuple):
    """Line of the file, from 1, that is a record; number of its operation; its date as ISO 8601,
    with time if stated, empty if not stated or ambiguous.
    """

    line: int
    number: int
    date: str


class _Form(NamedTuple):
    """Layout of lines: signs of values, and the bytes of each record by its line."""

    signs: Mapping[str, str]
    records: Mapping[int, bytes]


def form_of(opened: Opened) -> _Form | None:
    """Return the layout of a text with a record on each line; None for another first line."""
    return opened.once("form of lines", lambda: _form_of(opened))


def _form_of(opened: Opened) -> _Form | None:
    first = first_line(opened.content)
    if b"\r" in first:
        return None
    encoding = encoding_of(first)
    _, _, values = _split(first, encoding)
    delimiter, decimal = signs_of([values[:_SAMPLE]])
    if sum(is_number(cell, decimal) for cell in _cells(values[:_SAMPLE], delimiter)) < FEWEST:
        return None
    check_lines(opened.file, opened.content)
    lines = enumerate(map(bytes.strip, opened.content.split(b"\n")), start=1)
    signs = {"encoding": encoding, "delimiter": delimiter, "decimal": decimal}
    return _Form(signs, {number: line for number, line in lines if line})


def _split(line: bytes, encoding: str) -> tuple[str, str, str]:
    """Return the fields before the samples of a record, and the name and the text of the samples;
    all are empty if the line is not a record.
    """
    text = line.decode(encoding, errors="replace")
    head = max(text.rfind(":"), text.rfind("=")) + 1
    if (fields := _FIELDS.fullmatch(text[:head])) is None:
        return "", "", ""
    return fields[1] or "", fields[2].strip(' "'), text[head:]


def _cells(text: str, delimiter: str) -> list[str]:
    text = text.strip(f" \t\r\n;|{delimiter}")
    cells = text.split(None if delimiter == " " else delimiter)
    return [cell.strip(' "') for cell in cells] if " " in text or '"' in text else cells


def records_in(opened: Opened) -> list[RecordLine]:
    """Return the records of a file, in the order of their lines. A record without a stated number
    gets its place, from 1.
    """
    encoding, lines = form_of(opened).signs["encoding"], form_of(opened).records
    fields = [[_split(line, encoding)[0]] for line in lines.values()]
    stated = [[pair.text for pair in pairs_in(row)] for row in fields]
    dates = [next(filter(None, map(dates_of, values)), {}) for values in stated]
    order, records = day_order(filter(None, dates)), []
    for values, readings, line in zip(stated, dates, lines, strict=True):
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
    line = form.get("line") or min(layout.records)
    signs = layout.signs | {key: form[key] for key in layout.signs if key in form}
    fields, name, values = _split(layout.records.get(line, b""), signs["encoding"])
    cells = _cells(values, signs["delimiter"])
    if not name:
        reason = "has no record on this line; write on each its values as one list, of one name"
        raise RejectedCurveError(file, reason, line=line)
    check_size(file, len(cells), 1, line=line)
    numbers, wrong = strict_numbers(cells, signs["decimal"])
    if wrong:
        cell = cells[wrong[0]].strip()[:40]
        reason = f"value {wrong[0] + 1} of {name!r} is {cell!r}, {NOT_A_NUMBER}"
        raise RejectedCurveError(file, reason, line=line)
    header = header_of([[fields]], numbers.size)
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
