"""Curve files of fault recorders: COMTRADE (IEEE C37.111 of 1991, 1999 and 2013), pairs of ``.cfg``
and ``.dat``. Recorders leave many cells of the ``.cfg`` empty.
"""

import re
from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path

import numpy as np

from breaker.records.cells import columns_of_alike, strict_numbers
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import encoding_of
from breaker.records.settings import FORMAT, SAME_RATE, TO_MS
from breaker.records.sheet import Sheet

_TYPES = {"BINARY": "<i2", "BINARY32": "<i4", "FLOAT32": "<f4"}  # types of analog samples
_NO_SAMPLE = 99999  # missing sample in ASCII


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the analog and the status channels (1 and 0) of a COMTRADE record, and in the last
    column its times, in ``time_unit`` of the form; see ``detection``.
    """
    file = Path(opened.file)
    if file.suffix.lower() == ".dat":
        reason = f"is the data of a COMTRADE record: name {_part(file, '.cfg').name}"
        raise RejectedCurveError(file, f"{reason}, copy both files, or name another text .csv")
    content, source = opened.content, opened.once("data", lambda: _part(file, ".dat"))
    data = opened.companion(source)
    check_lines(opened.file, content)
    encoding = form.get("encoding", encoding_of(content))
    head = _Description(opened.file, content.decode(encoding, "replace").removeprefix("\ufeff"))
    samples_of = _in_text if head.kind == "ASCII" else _in_bytes
    stamps, *columns = samples_of(head, data, source)
    if stamps.size == 0 or stamps.size != head.rates[-1][1]:
        reason = f"states another number of samples than {stamps.size}, which its data have"
        raise RejectedCurveError(opened.file, f"{reason}; copy both again")
    for place, (factor, offset) in enumerate(head.scales):
        columns[place] = factor * columns[place] + offset
    unit = form.get("time_unit", FORMAT["time_unit"])
    columns.append(_times(opened.file, head, stamps) * TO_MS["s"] / TO_MS[unit])
    names, units = [*head.names, "time"], [*head.units, unit]
    settings = {} if encoding == "utf-8" else {"encoding": encoding}
    clock = len(columns) - 1
    return [Sheet(opened.file, names, columns, units, head.stated, settings, clock)]


def _part(file: Path, ending: str) -> Path:
    """Return the other part of a record, whose ending may be in capitals."""
    lower, upper = file.with_suffix(ending), file.with_suffix(ending.upper())
    return upper if upper.exists() else lower


class _Description:
    """Content of a ``.cfg``: names and units of channels, factors and offsets of analog channels
    (nan if not used), rates, Hz, each with the number of its last sample, the type of the data, and
    the unit of a time stamp, s. Any error is turned into a rejection by ``detection``.
    """

    def __init__(self, file: str | Path, text: str) -> None:
        rows = re.split(r"\r*\n|\r", text.replace("\x1a", "").rstrip())
        lines = [[*map(str.strip, row.split(",")), *[""] * 7] for row in rows]
        counts = re.fullmatch(r"\d+;(\d{1,5})A;(\d{1,5})D", ";".join(lines[1][:3]).upper())
        if not counts:
            reason = "does not count analog and status channels, as 2,1A,1D does"
            raise RejectedCurveError(file, reason, line=2)
        analog, status = map(int, counts.groups())
        grid = 2 + analog + status
        last = grid + 4 + max(1, int(float(lines[grid + 1][0] or 0)))
        self.kind = lines[last][0].upper()
        rates = lines[grid + 2 : last - 2]
        self.rates = [(float(rate or 0), int(float(end or -1))) for rate, end, *_ in rates]
        ends = [0, *(end for _, end in self.rates)]
        known = self.kind in ("ASCII", *_TYPES)
        if not known or ends != sorted(ends) or not min(self.rates)[0] >= 0:
            reason = "is of an unknown type, or does not state rates and their last samples"
            raise RejectedCurveError(file, reason, line=last + 1)
        channels = lines[2:grid]
        self.scales = [(float(c[5] or "nan"), float(c[6] or 0)) for c in channels[:analog]]
        self.units = [*(channel[4] for channel in channels[:analog]), *[""] * status]
        names = (f"{name} {phase}".strip() for _, name, phase, *_ in channels)
        self.names = [name or f"channel {i}" for i, name in enumerate(names, start=1)]
        begin, trigger = (",".join(lines[i][:2]) for i in (last - 2, last - 1))
        self.stated = [["Station :", lines[0][0]]]
        with suppress(ValueError):  # before 1999, the order of day and month differs
            begun = datetime.strptime(begin.partition(".")[0], "%d/%m/%Y,%H:%M:%S")
            self.stated += (
                [] if lines[0][2] in ("", "1991") else [["Test Date :", begun.isoformat()]]
            )
        factor = float(lines[last + 1][0] or 0) if last + 1 < len(lines) else 0.0
        unit = 1e-9 if re.search(r"\.\d{7}", f"{begin} {trigger}") else 1e-6
        self.stamp = (factor or 1.0) * unit


def _in_bytes(head: _Description, data: bytes, source: str | Path) -> list[np.ndarray]:
    """Return stamps and samples of each channel from binary data, ``(t,)``, NaN where missing."""
    analog = len(head.scales)
    status = len(head.names) - analog
    words = -(-status // 16)  # a bit for each status channel
    of_analog, of_status = ("x", _TYPES[head.kind], (analog,)), ("s", "<u2", (words,))
    row = np.dtype([("n", "<u4"), ("t", "<u4"), of_analog, of_status])
    check_size(source, len(data) // row.itemsize, 1 + analog + words)
    rows = np.frombuffer(data, row, len(data) // row.itemsize)
    bits = np.ascontiguousarray(rows["s"]).view("u1")
    states = np.unpackbits(bits, axis=1, count=status, bitorder="little").T
    stamps = np.where(rows["t"] == np.iinfo("<u4").max, np.nan, rows["t"])
    missing = (np.finfo if head.kind == "FLOAT32" else np.iinfo)(rows["x"].dtype).min
    samples = np.where(rows["x"] == missing, np.nan, rows["x"].astype(float))
    return [stamps, *samples.T, *states]


def _in_text(head: _Description, data: bytes, source: str | Path) -> list[np.ndarray]:
    """Return stamps and samples of each channel from ASCII data, ``(t,)``, NaN where missing."""
    check_lines(source, data)
    text = data.decode("latin-1").replace("\r", "").replace("\x1a", "")
    lines, width = text.strip().split("\n"), 2 + len(head.names)
    check_size(source, len(lines), width)
    cells = columns_of_alike(lines, width, ",") or []
    columns = [strict_numbers(column, ".") for column in cells]
    wrong = [1 + places[0] for _, places in columns if places]
    if wrong or not cells:
        reason = f"has a line without {width} numbers: of the sample, its time, and its channels"
        line = min(wrong, default=None)
        raise RejectedCurveError(source, f"{reason}; copy it again", line=line)
    return [np.where(numbers == _NO_SAMPLE, np.nan, numbers) for numbers, _ in columns[1:]]


def _times(file: str | Path, head: _Description, stamps: np.ndarray) -> np.ndarray:
    """Return times, s, ``(t,)``, by the stated rates, or by the stamps without a rate."""
    rates, ends = zip(*head.rates, strict=True)
    steps = [1.0 / rate if rate else np.nan for rate in rates]
    time = np.append(0.0, np.cumsum(np.repeat(steps, np.diff(ends, prepend=0))[1:]))
    stamps = head.stamp * stamps
    if np.isnan(time).any():
        return stamps
    if time.size == 1 or np.isnan(stamps).any() or stamps[-1] <= stamps[0]:
        return time
    # Some recorders write stamps in microseconds although their clock shows nanoseconds.
    ratio, rate = time[-1] / (stamps[-1] - stamps[0]), 1e-3 * (time.size - 1) / time[-1]
    if min(abs(ratio * unit - 1.0) for unit in (1e-3, 1.0, 1e3)) > SAME_RATE:
        reason = f"states {rate:.6g} kHz, but the stamps of its data are those of "
        remedy = "write the right rate into its last lines, or 0 if the stamps are right"
        raise RejectedCurveError(file, f"{reason}{rate * ratio:.4g} kHz; {remedy}")
    return time
