"""Curve files of fault recorders: COMTRADE (IEEE C37.111 of 1991, 1999 and 2013), either a pair of
``.cfg`` and ``.dat`` or a single ``.cff``. Recorders leave many cells of the description empty.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from breaker.common.lazy_numpy import np
from breaker.records.cells import columns_of_alike, is_number, strict_numbers
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import encoding_of
from breaker.records.settings import FORMAT, TO_MS
from breaker.records.sheet import Sheet

ENDINGS = dict.fromkeys((".cfg", ".cff"), "a COMTRADE record")
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = ""

_SECTION = re.compile(rb"(?im)^--- *file type: *([a-z]+)[^\r\n]*---[ \t]*\r?\n?")
_TYPES = {"BINARY": "<i2", "BINARY32": "<i4", "FLOAT32": "<f4"}  # of a sample of an analog channel
_NO_SAMPLE = 99999  # in ASCII, from 1999 on
_OFF = 0.01  # share by which rates may differ from stamps: recorders state rounded rates


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the analog and the status channels (1 and 0) of a COMTRADE record, and as the last
    column its times, in ``time_unit`` of the form: see ``registry``.

    Raises:
        RejectedCurveError: If a part is missing or damaged, or contradicts the other part.
    """
    head, data, source = _parts(opened)
    likely = encoding_of(head)
    encoding = form.get("encoding", likely)
    try:
        about = _Description(opened.file, head.decode(encoding).removeprefix("\ufeff"))
    except UnicodeError as error:
        reason = f"cannot be read: {error}; set endurance.format.encoding, for example to {likely}"
        raise RejectedCurveError(opened.file, reason) from error
    samples_of = _in_text if about.kind == "ASCII" else _in_bytes
    stamps, columns, missing = samples_of(about, data, source)
    if (count := len(stamps)) == 0 or count != about.rates[-1][1]:
        reason = f"states {about.rates[-1][1]} samples, but its data have {count}; copy both again"
        raise RejectedCurveError(opened.file, reason)
    for place, (factor, offset) in enumerate(about.scales):
        stored = columns[place]
        columns[place] = np.where(stored == missing, np.nan, factor * stored.astype(float) + offset)
    unit, time_column = form.get("time_unit", FORMAT["time_unit"]), form.get("time_column")
    unknown = "has names in an unknown code page; if they look wrong, set endurance.format.encoding"
    return [
        Sheet(
            opened.file,
            [*about.names, time_column if isinstance(time_column, str) else "time"],
            [*columns, _times(about, about.stamp * stamps) * TO_MS["s"] / TO_MS[unit]],
            [*about.units, unit],
            about.stated,
            {} if encoding == "utf-8" else {"encoding": encoding},
            clock=len(columns),
            remarks=(unknown,) if not form and likely == "cp1252" else (),
        )
    ]


def _parts(opened: Opened) -> tuple[bytes, bytes, str | Path]:
    """The description, the data, and the file with the data."""
    file, content = Path(opened.file), opened.content
    if file.suffix.lower() == ".cff":
        sections = _SECTION.split(content)  # alternately contents and types
        types = [each.upper() for each in sections[1::2]]
        if b"CFG" not in types or b"DAT" not in types:
            raise RejectedCurveError(file, "lacks its part CFG or DAT; copy it again")
        data = next(part for part in _SECTION.finditer(content) if part[1].upper() == b"DAT")
        return sections[2 * types.index(b"CFG") + 2], content[data.end() :], file
    if file.suffix.lower() == ".dat":
        head = _part(file, ".cfg")
        why = f"{head.name} is not there; copy both files, or name another text .csv"
        why = f"name {head.name}, which describes it, in its place" if head.exists() else why
        raise RejectedCurveError(file, f"is the data of a COMTRADE record: {why}")
    other = opened.once("data", lambda: _part(file, ".dat"))
    if not other.exists():
        reason = f"has no data: {other.name} is not there; copy both files into one folder"
        raise RejectedCurveError(file, reason)
    return content, opened.beside(other), other


def _part(file: Path, ending: str) -> Path:
    """The other part of a record, its ending in small letters or capitals."""
    lower, upper = file.with_suffix(ending), file.with_suffix(ending.upper())
    return upper if upper.exists() else lower


def lone_data(folder: str | Path) -> list[Path]:
    """List the data in a folder whose description is lacking, as after copying one of two files."""
    parts = sorted(Path(folder).glob("*.[dD][aA][tT]"))
    return [part for part in parts if part.is_file() and not _part(part, ".cfg").exists()]


def is_data(opened: Opened) -> bool:
    """Return whether a file is the data of a record, by its ending: another text needs its own."""
    return Path(opened.file).suffix.lower() == ".dat"


class _Description:
    """The text of a ``.cfg``: names, units, factors and offsets of channels, rates (each with the
    number of the last sample with it), the type of the data, and what a stamp counts, s.
    """

    def __init__(self, file: str | Path, text: str) -> None:
        self.file = file
        lines = re.split(r"\r*\n|\r", text.replace("\x1a", "").rstrip())
        self._lines = [[cell.strip() for cell in line.split(",")] for line in lines]
        station, _, year = self._cells(0)[:3]
        self.old = year in ("", "1991")
        counts = re.fullmatch(r"\d+;(\d{1,5})A;(\d{1,5})D", ";".join(self._cells(1)[:3]).upper())
        if not counts:
            raise self._wrong(1, "does not count analog and status channels, as 2,1A,1D does")
        status = 2 + int(counts[1])
        grid = status + int(counts[2])
        last = grid + 4 + max(1, int(self._number(grid + 1, 0, 0.0)))
        self.kind = self._cells(last)[0].upper()
        if self.kind not in ("ASCII", *_TYPES):
            raise self._wrong(last, f"is of the unknown type {self.kind[:40]!r}")
        self.rates = [
            (self._number(line, 0, 0.0), int(self._number(line, 1, -1.0)))
            for line in range(grid + 2, last - 2)
        ]
        ends = [0, *(end for _, end in self.rates)]
        if ends != sorted(ends) or min(self.rates)[0] < 0:
            raise self._wrong(grid + 2, "or a later line does not state a rate and its last sample")
        # A channel without a factor is not in use.
        analog = range(2, status)
        self.scales = [(self._number(i, 5, np.nan), self._number(i, 6, 0.0)) for i in analog]
        self.units = [self._cells(i)[4] if i < status else "" for i in range(2, grid)]
        channels = [(self._cells(i)[1] or f"channel {i - 1}", i) for i in range(2, grid)]
        several = Counter(name for name, _ in channels)
        self.names = [  # of several poles
            f"{name} {self._cells(i)[2]}".strip() if several[name] > 1 else name
            for name, i in channels
        ]
        begin, trigger = (",".join(self._lines[line]) for line in (last - 2, last - 1))
        self.stated = [["Station :", station]]
        with suppress(ValueError):
            order = "%m/%d/%Y" if self.old else "%d/%m/%Y"
            begun = datetime.strptime(begin.partition(".")[0], f"{order},%H:%M:%S")
            self.stated.append(["Test Date :", begun.isoformat()])
        more = last + 1 < len(self._lines) and self._number(last + 1, 0, 1.0)
        self.stamp = (more or 1.0) * (1e-9 if re.search(r"\.\d{7}", f"{begin} {trigger}") else 1e-6)

    def _wrong(self, line: int, reason: str) -> RejectedCurveError:
        return RejectedCurveError(self.file, reason, line=line + 1)

    def _cells(self, line: int) -> list[str]:
        """The cells of a line, with empty ones behind them."""
        if line >= len(self._lines):
            reason = "is the last line, but more are to follow; copy the file again"
            raise self._wrong(len(self._lines) - 1, reason)
        return [*self._lines[line], *[""] * 7]

    def _number(self, line: int, place: int, default: float) -> float:
        """A number of a line; the default where its cell is empty or not there."""
        cell = self._cells(line)[place]
        if cell and (not is_number(cell, ".") or abs(float(cell)) == np.inf):
            raise self._wrong(line, f"has {cell[:40]!r} as cell {place + 1}, not a number")
        return float(cell) if cell else default


_Samples = tuple[np.ndarray, list[np.ndarray], float]


def _in_bytes(about: _Description, data: bytes, source: str | Path) -> _Samples:
    """The stamps, the samples of each channel, ``(t,)``, and what is stored of a missing one."""
    analog = len(about.scales)
    status = len(about.names) - analog
    words = -(-status // 16)  # a bit for each status channel
    of_analog, of_status = ("x", _TYPES[about.kind], (analog,)), ("s", "<u2", (words,))
    row = np.dtype([("n", "<u4"), ("t", "<u4"), of_analog, of_status])
    check_size(source, len(data) // row.itemsize, 1 + analog + words)
    rows = np.frombuffer(data, row, len(data) // row.itemsize)
    bits = np.ascontiguousarray(rows["s"]).view("u1")
    states = np.unpackbits(bits, axis=1, count=status, bitorder="little").T
    stamps = np.where(rows["t"] == np.iinfo("<u4").max, np.nan, rows["t"])
    missing = (np.finfo if about.kind == "FLOAT32" else np.iinfo)(rows["x"].dtype).min
    return stamps, [*rows["x"].T, *states], missing


def _in_text(about: _Description, data: bytes, source: str | Path) -> _Samples:
    """The same of a text."""
    check_lines(source, data)
    text = data.decode("latin-1").replace("\r", "").replace("\x1a", "")
    lines, width = text.strip().split("\n"), 2 + len(about.names)
    check_size(source, len(lines), width)
    if (cells := columns_of_alike(lines, width, ",")) is None:
        alike = (columns_of_alike([line], width, ",") for line in lines)
        line = next((i for i, cells in enumerate(alike, start=1) if cells is None), 1)
        reason = f"does not have {width} numbers: of the sample, its time, and its channels"
        raise RejectedCurveError(source, f"{reason}; copy it again", line=line)
    columns = [strict_numbers(column, ".") for column in cells]
    for column, (_, wrong) in zip(cells, columns, strict=True):
        if wrong:
            reason = f"has {column[wrong[0]][:40]!r}, which is not a number; copy it again"
            raise RejectedCurveError(source, reason, line=wrong[0] + 1)
    stamps, *samples = (numbers for numbers, _ in columns[1:])
    return stamps, samples, np.nan if about.old else _NO_SAMPLE


def _times(about: _Description, stamps: np.ndarray) -> np.ndarray:
    """Times, s, ``(t,)``: by the rates that are stated, or by the stamps where none is.

    Raises:
        RejectedCurveError: If there is neither, or they contradict: nobody knows which is right.
    """
    steps, begin = np.zeros(stamps.size), 0
    for rate, end in about.rates:
        steps[begin:end], begin = (1.0 / rate if rate else np.nan), end
    steps[0] = 0.0
    time, stamped = np.cumsum(steps), not np.isnan(stamps).any()
    if np.isnan(time).any():
        if not stamped:
            raise RejectedCurveError(about.file, "states neither a rate nor all of its times")
        return stamps
    if time.size == 1 or not stamped or stamps[-1] <= stamps[0]:
        return time
    # Some recorders stamp in microseconds though their clock shows nanoseconds.
    ratio, rate = time[-1] / (stamps[-1] - stamps[0]), 1e-3 * (time.size - 1) / time[-1]
    if min(abs(ratio * unit - 1.0) for unit in (1e-3, 1.0, 1e3)) > _OFF:
        reason = f"states {rate:.6g} kHz, but the stamps of its data are those of "
        remedy = "write the right rate into its last lines, or 0 if the stamps are right"
        raise RejectedCurveError(about.file, f"{reason}{rate * ratio:.4g} kHz; {remedy}")
    return time
