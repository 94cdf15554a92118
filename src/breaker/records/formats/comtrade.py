"""Curve files of fault recorders: COMTRADE (IEEE C37.111 of 1991, 1999 and 2013), either a pair of
``.cfg`` and ``.dat`` or a single ``.cff``; data of type ASCII, BINARY, BINARY32 or FLOAT32.

The description is read cell by cell, so that a cell which recorders leave empty does not hide the
record. Status channels are columns of 1 and 0.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from breaker.common.lazy_numpy import np
from breaker.common.numerals import in_digits
from breaker.records.cells import is_number
from breaker.records.files import Opened, RejectedCurveError, check_lines, check_size
from breaker.records.formats.text import encoding_of, sheet_of
from breaker.records.settings import FORMAT, TO_MS
from breaker.records.sheet import Sheet

ENDINGS = dict.fromkeys((".cfg", ".cff"), "a COMTRADE record")
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = ""

_SECTION = re.compile(rb"(?im)^--- *file type: *([a-z]+)[^\r\n]*---[ \t]*\r?\n?")
_TYPES = {"BINARY": "<i2", "BINARY32": "<i4", "FLOAT32": "<f4"}  # of a sample of an analog channel
_NO_SAMPLE = "99999"  # in ASCII, from 1999 on
_DATA = re.compile(rb"\x01\0\0\0|\s*1 *,[ \d]*,[^\n]*\n\s*2 *,[ \d]*,")  # how a ``.dat`` begins
_OFF = 0.01  # share by which rates may differ from stamps: recorders state rounded rates


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the analog and the status channels of a COMTRADE record, and as the last column its
    times, in ``time_unit`` of the form: see ``registry``.

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
    columns, stamps = _columns(about, data, source)
    unit, time_column = form.get("time_unit", FORMAT["time_unit"]), form.get("time_column")
    time = _times(about, stamps) * TO_MS["s"] / TO_MS[unit]
    said = [["Station :", about.station]]
    if about.begin:
        said.append(["Test Date :", about.begin])
    doubt = (
        "has names in a code page that is not known: if they look wrong, set "
        "endurance.format.encoding to that of the recorder, such as cp1250 or cp1251"
    )
    return [
        Sheet(
            opened.file,
            [*about.names, time_column if isinstance(time_column, str) else "time"],
            [*columns, time],
            [*about.units, *[""] * (len(columns) - len(about.units)), unit],
            said,
            {} if encoding == "utf-8" else {"encoding": encoding},
            clock=len(columns),
            remarks=(doubt,) if encoding == likely == "latin-1" else (),
            notes=about.notes,
        )
    ]


# ---- the description -----------------------------------------------------------------------------


def _parts(opened: Opened) -> tuple[bytes, bytes, str | Path]:
    """The description, the data, and the file with the data."""
    file, content = Path(opened.file), opened.content
    if file.suffix.lower() == ".cff":
        sections = list(_SECTION.finditer(content))
        starts = {section[1].upper(): section.end() for section in reversed(sections)}
        if not {b"CFG", b"DAT"} <= set(starts):
            raise RejectedCurveError(file, "lacks its part CFG or DAT")
        after = (part.start() for part in sections if part.start() >= starts[b"CFG"])
        return content[starts[b"CFG"] : next(after)], content[starts[b"DAT"] :], file
    if file.suffix.lower() == ".dat":
        head = _part(file, ".cfg")
        why = f"name {head.name}, which describes it, in its place"
        if not head.exists():
            why = (
                f"{head.name} is not there; copy both files, or name it .csv if it is another text"
            )
        raise RejectedCurveError(file, f"is the data of a COMTRADE record: {why}")
    other = opened.once("data", lambda: _part(file, ".dat"))
    if not other.exists():
        reason = f"has no data: {other.name} is not there; copy both files into one folder"
        raise RejectedCurveError(file, reason)
    return content, opened.beside(other), other


def _part(file: Path, ending: str) -> Path:
    """The other part of a record, its ending in any case; with that of small letters if none is."""
    every = [file.with_suffix(each) for each in (ending, ending.upper(), ending.title())]
    return next((part for part in every if part.exists()), every[0])


def lone_data(folder: str | Path) -> list[Path]:
    """List the data in a folder whose description is lacking, as after copying one of two files."""
    parts = sorted(Path(folder).glob("*.[dD][aA][tT]"))
    return [part for part in parts if part.is_file() and not _part(part, ".cfg").exists()]


def is_data(opened: Opened) -> bool:
    """Say whether a file is the data of a record, which its description is needed for."""
    file = Path(opened.file)
    if file.suffix.lower() != ".dat":
        return False
    return _part(file, ".cfg").exists() or _DATA.match(opened.content) is not None


class _Description:
    """The text of a ``.cfg``, read line by line.

    Attributes:
        names: Names of the analog and then of the status channels.
        units, factors, offsets, least: Of each analog channel: its reading is factor times what is
            stored, plus offset; what is stored is not below ``least``.
        notes: What is doubtful about a channel, by its place.
        rates: Pairs of a rate, Hz, and the number of the last sample with it.
        stamp: What a stamp counts, s.

    Raises:
        RejectedCurveError: If it does not describe the channels, rates and data that it counts.
    """

    def __init__(self, file: str | Path, text: str) -> None:
        self.file, self.line = file, 0
        lines = re.split(r"\r*\n|\r", text.replace("\x1a", "").rstrip())
        self._lines = [[cell.strip() for cell in line.split(",")] for line in lines]
        self.station, *_, year = self._next()
        self.year = int(year) if re.fullmatch(r"\d{4}", year) else 1991
        counts = re.fullmatch(r"\d+;(\d{1,5})A;(\d{1,5})D", ";".join(self._next()[:3]).upper())
        if not counts:
            raise self._wrong("does not count analog and status channels, as 2,1A,1D does")
        self.units, self.factors, self.offsets, self.least, self.notes = [], [], [], [], {}
        self.names = self._analog(int(counts[1]))
        self.names += ["".join(self._next()[1:2]) for _ in range(int(counts[2]))]
        self._next()  # the frequency of the grid
        self._next()
        self.rates = []
        for _ in range(max(1, int(self._number(0, 0.0)))):
            self._next()
            self.rates.append((self._number(0, 0.0), int(self._number(1, -1.0))))
        ends = [end for _, end in self.rates]
        if ends != sorted(ends) or ends[0] < 0 or min(rate for rate, _ in self.rates) < 0:
            raise self._wrong("does not state a rate and the number of the last sample with it")
        times = [",".join(self._next()) for _ in range(2)]
        self.begin = self._iso(times[0])
        self.kind = self._next()[0].upper()
        if self.kind not in ("ASCII", *_TYPES):
            raise self._wrong(f"is of the unknown type {self.kind[:40]!r}")
        nanoseconds = any(re.search(r"\.\d{7}", time) for time in times)
        more = self.line < len(self._lines) and self._next()
        self.stamp = (self._number(0, 1.0) if more else 1.0) * (1e-9 if nanoseconds else 1e-6)

    def _wrong(self, reason: str) -> RejectedCurveError:
        return RejectedCurveError(self.file, reason, line=self.line)

    def _next(self) -> list[str]:
        """The cells of the next line."""
        if self.line == len(self._lines):
            raise self._wrong("is the last line, but more are to follow; copy the file again")
        self.line += 1
        return self._lines[self.line - 1]

    def _number(self, place: int, default: float) -> float:
        """A number of the present line; the default where its cell is empty or not there."""
        cell = "".join(self._lines[self.line - 1][place : place + 1])
        if cell and (not is_number(cell, ".") or abs(float(cell)) == np.inf):
            raise self._wrong(f"has {cell[:40]!r}, which is not a number, as cell {place + 1}")
        return float(cell) if cell else default

    def _analog(self, count: int) -> list[str]:
        """The names of the analog channels; a name that several have is followed by the phase."""
        names, phases = [], []
        for place in range(count):
            name, phase, _, unit = [*self._next(), "", "", "", ""][1:5]
            names.append(name or f"channel {place + 1}")
            phases.append(phase)
            self.units.append(unit)
            # A channel without a factor is not in use: nobody knows what its numbers mean.
            self.factors.append(self._number(5, np.nan))
            self.offsets.append(self._number(6, 0.0))
            self.least.append(self._number(8, -np.inf))
            sides = self._number(10, 1.0), self._number(11, 1.0)
            if "".join(self._lines[self.line - 1][12:]).upper() == "S" and sides[0] != sides[1]:
                ratio = " : ".join(in_digits(side, 6) for side in sides)
                said = f"{name!r} is of the secondary side, with a ratio of {ratio}"
                self.notes[place] = said
        several = Counter(names)
        pairs = zip(names, phases, strict=True)
        return [f"{name} {phase}" if phase and several[name] > 1 else name for name, phase in pairs]

    def _iso(self, text: str) -> str:
        """When the record begins, as ISO 8601; empty where it is not stated."""
        for order in ("%m/%d/%Y", "%d/%m/%Y") if self.year == 1991 else ("%d/%m/%Y",):
            with suppress(ValueError):
                return datetime.strptime(text.partition(".")[0], f"{order},%H:%M:%S").isoformat()
        return ""


# ---- the samples ---------------------------------------------------------------------------------


def _columns(
    about: _Description, data: bytes, source: str | Path
) -> tuple[list[np.ndarray], np.ndarray]:
    """The columns of analog and of status channels, and the stamps, s, each ``(t,)`` and NaN where
    one is missing.

    Raises:
        RejectedCurveError: If there are not as many samples as the description counts.
    """
    analog, status = len(about.factors), len(about.names) - len(about.factors)
    if about.kind == "ASCII":
        rows = _numbers(source, data, 2 + analog + status)
        there, stamps, stored, states = (
            len(rows[0]),
            rows[1],
            rows[2 : 2 + analog],
            rows[2 + analog :],
        )
        missing = [float(_NO_SAMPLE) if about.year > 1991 else np.nan] * analog
    else:
        words = -(-status // 16)  # a bit for each status channel
        of_analog, of_status = ("x", _TYPES[about.kind], (analog,)), ("s", "<u2", (words,))
        row = np.dtype([("n", "<u4"), ("t", "<u4"), of_analog, of_status])
        there = len(data) // row.itemsize
        check_size(about.file, there, 1 + analog + words)
        rows = np.frombuffer(data, row, there)
        stamps = np.where(rows["t"] == np.iinfo("<u4").max, np.nan, rows["t"])
        stored = rows["x"].T
        bits = np.ascontiguousarray(rows["s"]).view("u1")
        states = np.unpackbits(bits, axis=1, count=status, bitorder="little").T
        limits = np.iinfo if about.kind != "FLOAT32" else np.finfo
        missing = [limits(rows["x"].dtype).min] * analog
        if about.year == 1991:  # all bits are set, which is -1: a reading, if any is negative
            missing = [
                -1 if least >= 0 else low for low, least in zip(missing, about.least, strict=True)
            ]
    if there == 0 or there != (stated := about.rates[-1][1]):
        reason = f"says that there are {stated} samples, but its data have {there}"
        raise RejectedCurveError(about.file, f"{reason}; copy both again")
    described = zip(stored, about.factors, about.offsets, missing, strict=True)
    columns = [np.where(x == none, np.nan, a * x.astype(float) + b) for x, a, b, none in described]
    return [*columns, *states], about.stamp * stamps


def _numbers(file: str | Path, data: bytes, width: int) -> Sequence[np.ndarray]:
    """The columns of cells of a text, ``(t,)``, NaN where one is empty."""
    check_lines(file, data)
    signs, first = {"delimiter": ",", "decimal": "."}, {"time_column": 1, "travel_column": 1}
    text = data.decode("latin-1").replace("\r", "").replace("\x1a", "")
    table = sheet_of(file, text, signs, FORMAT | first).columns
    check_size(file, table.lines.size, width)
    narrow = ~table.present(width - 1)
    wrong = {int(table.lines[row]): "has fewer cells" for row in np.flatnonzero(narrow)[:1]}
    rows = table.numbers(range(min(width, len(table))))
    for place in range(len(rows)):
        wrong |= {int(table.lines[row]): f"has {why}" for row, why in table.wrong(place).items()}
    wrong |= table.odd_widths
    if wrong or len(table) != width:
        line = min(wrong, default=1)
        reason = f"{wrong.get(line, 'has other cells')}; lines have {width} numbers: of the sample,"
        raise RejectedCurveError(file, f"{reason} its time, and its channels", line=line)
    return rows


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
        raise RejectedCurveError(
            about.file,
            f"states {in_digits(rate, 6)} kHz, but the stamps of its data are those of "
            f"{in_digits(rate * ratio, 4)} kHz; see the recorder's settings, and write the right "
            "rate into its last lines, or 0 there if the stamps are right",
        )
    return time
