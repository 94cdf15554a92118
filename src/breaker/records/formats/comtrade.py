"""Curve files of fault recorders: COMTRADE (IEEE C37.111), by the package of this name (the extra
``comtrade``), either a pair of ``.cfg`` and ``.dat`` or a single ``.cff``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path

from breaker.common.lazy_numpy import np
from breaker.common.numerals import in_digits
from breaker.records.files import Opened, RejectedCurveError, check_size
from breaker.records.settings import FORMAT, TO_MS
from breaker.records.sheet import Sheet

_SECTION = re.compile(rb"(?im)^--- *file type: *([a-z]+)[^\r\n]*---[ \t]*\r?\n?")
_MOST_CHANNELS = 10_000
_MOST_VALUES = 8_000_000  # of a text, where a line takes the time of ten
_NO_STAMP, _OFF = 2.0**32 - 1, 0.01  # us, of a sample without one; share by which rates may differ
_BYTES = {"BINARY": 2, "BINARY32": 4, "FLOAT32": 4}  # of an analog value


ENDINGS = dict.fromkeys((".cfg", ".cff"), "a COMTRADE record")
SIGNATURES: tuple[bytes, ...] = ()
EXTRA = "comtrade"


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the times of a COMTRADE record, its analog and its status channels: see ``registry``.
    The record knows its own times; they are in ``time_unit``.
    """
    file, settings = opened.file, {}
    try:
        record = _open(opened, form.get("encoding", "utf-8"))
    except RejectedCurveError:
        if form:
            raise
        settings = {"encoding": "latin-1"}
        record = _open(opened, **settings)
    cfg, unit = record.cfg, form.get("time_unit", FORMAT["time_unit"])
    analog, status = cfg.analog_channels, cfg.status_channels
    name = form.get("time_column")
    names = [*(each.name for each in (*analog, *status)), name if isinstance(name, str) else "time"]
    texts = [*(each.uu for each in analog), *[""] * len(status), unit]
    columns = [*map(np.asarray, record.analog)]
    columns += [np.asarray(each, dtype=float) for each in record.status]
    columns.append(np.asarray(record.time) * 1e3 / TO_MS[unit])
    said = [["Station :", str(cfg.station_name)]]
    if (when := cfg.start_timestamp).year > 1970:
        said.append(["Test Date :", when.isoformat()])
    notes = {
        place: f"{each.name!r} is of the secondary side, with a ratio of "
        f"{in_digits(each.primary, 6)} : {in_digits(each.secondary, 6)}"
        for place, each in enumerate(analog)
        if each.pors.upper() == "S" and each.primary != each.secondary
    }
    clock = len(names) - 1
    return [Sheet(file, names, columns, texts, said, settings, clock=clock, notes=notes)]


def _open(opened: Opened, encoding: str):
    """Return a record with all of its channels.

    Raises:
        RejectedCurveError: If a part is missing, or has not what the other says.
        ModuleNotFoundError: If the package comtrade is not installed.
    """
    import comtrade

    file, (head, data) = opened.file, _parts(opened, encoding)
    _check_counts(file, head)
    cfg = comtrade.Cfg(ignore_warnings=True)
    cfg.read(head)
    _check_data(file, cfg, data)
    record = comtrade.Comtrade(
        ignore_warnings=True, use_numpy_arrays=True, use_double_precision=True
    )
    record.read(head, data)
    return record


def _parts(opened: Opened, encoding: str) -> tuple[str, bytes]:
    """The text of the configuration, and the data."""
    file, content = opened.file, opened.content
    if Path(file).suffix.lower() == ".cff":
        found = list(_SECTION.finditer(content))
        starts = {each[1].upper(): each.end() for each in reversed(found)}
        if not {b"CFG", b"DAT"} <= set(starts):
            raise RejectedCurveError(file, "lacks its part CFG or DAT")
        data = content[starts[b"DAT"] :]
        after = (each.start() for each in found if each.start() >= starts[b"CFG"])
        content = content[starts[b"CFG"] : next(after)]
    else:
        data = opened.beside(opened.once("beside", lambda: _beside(file)))
    try:
        return content.decode(encoding).removeprefix("\ufeff"), data
    except UnicodeError as error:
        reason = f"cannot be read: {error}; is endurance.format.encoding right?"
        raise RejectedCurveError(file, reason) from error


def _beside(file: str | Path) -> Path:
    """The data file of a ``.cfg``, its ending in any case."""
    file = Path(file)
    found = [file.with_suffix(ending) for ending in (".dat", ".DAT", ".Dat")]
    there = [each for each in found if each.exists()]
    if not there:
        reason = f"has no data beside it: {found[0].name} is not there; copy both files"
        raise RejectedCurveError(file, reason)
    return there[0]


def _check_counts(file: str | Path, head: str) -> None:
    """Reject a configuration that counts more channels than it has lines, or than any record has:
    they are built first.
    """
    lines = head.splitlines()
    counts = re.findall(r"[0-9]+", lines[1]) if len(lines) > 1 else []
    if not counts or any(len(count) > 6 or int(count) > len(lines) for count in counts):
        raise RejectedCurveError(file, "does not describe the channels that it counts", line=2)
    if max(map(int, counts)) > _MOST_CHANNELS:
        reason = f"counts more than {_MOST_CHANNELS} channels; export fewer"
        raise RejectedCurveError(file, reason, line=2)


def _check_data(file: str | Path, cfg, data: bytes) -> None:
    """Reject data that have not as many samples as the configuration says: zeros would stand for
    the missing ones.
    """
    stated, kind = cfg.sample_rates[-1][1], cfg.ft.upper()
    if not all(math.isfinite(rate) for rate, _ in cfg.sample_rates):
        raise RejectedCurveError(file, "states a rate that is no number; export it again")
    if kind == "ASCII":
        if not data.isascii() or b"_" in data:
            raise RejectedCurveError(file, "has data that are no plain numbers")
        there = sum(bool(line.strip(b" \t\r\x1a")) for line in data.split(b"\n"))
        if there * (10 + cfg.analog_count + cfg.status_count) > _MOST_VALUES:
            reason = f"has too large data for a text: {there} samples; export it as BINARY"
            raise RejectedCurveError(file, f"{reason}, or fewer channels")
    elif kind in _BYTES:
        row = 8 + _BYTES[kind] * cfg.analog_count + 2 * math.ceil(cfg.status_count / 16)
        there = len(data) // row
    else:
        raise RejectedCurveError(file, f"is of the unknown type {cfg.ft[:40]!r}")
    check_size(file, there, 1 + cfg.analog_count)
    if there != stated:
        reason = f"says that there are {stated} samples, but its data have {there}; copy both again"
        raise RejectedCurveError(file, reason)
    _check_stamps(file, cfg, data, there)


def _check_stamps(file: str | Path, cfg, data: bytes, count: int) -> None:
    """Reject data whose stamps contradict the rate that is stated: nobody knows which is right."""
    rates = {rate for rate, _ in cfg.sample_rates}
    if count < 2 or len(rates) != 1 or not (rate := rates.pop()) > 0:
        return
    if cfg.ft.upper() == "ASCII":
        lines = (line.split(b",") for line in data.split(b"\n") if line.count(b",") > 1)
        found = [float(cells[1]) for cells in lines if cells[1].strip().isdigit()]
    else:
        rows = np.frombuffer(data, np.uint8)[: len(data) // count * count].reshape(count, -1)
        found = rows[:, 4:8].copy().view("<u4").ravel()
    stamps = np.asarray(found, dtype=float)
    if stamps.size < count or (stamps >= _NO_STAMP).any() or stamps[-1] <= stamps[0]:
        return
    seen = 1e3 * (count - 1) / ((stamps[-1] - stamps[0]) * cfg.timemult)  # kHz, stamps are in us
    if abs(seen / (1e-3 * rate) - 1.0) > _OFF:
        raise RejectedCurveError(
            file,
            f"states {in_digits(1e-3 * rate, 6)} kHz, but the stamps of its data are those of "
            f"{in_digits(seen, 4)} kHz; see the recorder's settings, and write the right rate into "
            "its last lines, or 0 there if the stamps are right",
        )
