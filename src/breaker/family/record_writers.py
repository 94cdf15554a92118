"""What writes the records of instruments: texts, workbooks, COMTRADE and NetCDF.

Each takes a dialect (``breaker.family.dialects``), a file, and what the file is to
show.
"""

import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from breaker.family.export import write_curve
from breaker.records.settings import FORMAT, TO_MS

if TYPE_CHECKING:
    from breaker.family.dialects import Dialect

_SPELT = {"ms": "msec", "deg": "°"}


class Recording(NamedTuple):
    """What an instrument writes of an operation.

    Attributes:
        time: Times, ``(t,)``, ms.
        readings: Of the first channels, ``(channels, t)``, in the dialect's unit.
        motion: "closing" or "opening".
        number: Of the operation.
    """

    time: np.ndarray
    readings: np.ndarray
    motion: str
    number: int


def _stand_in(dialect: "Dialect", file: Path, recording: Recording) -> None:
    time, first = recording.time, recording.readings[0]
    write_curve(file, time, first, motion=recording.motion, operation=recording.number)


def _rows(dialect: "Dialect", recording: Recording) -> tuple[list[list[str]], list[list[float]]]:
    """Rows of text above the samples, and the samples."""
    time, readings, motion, number = recording
    settings = {**FORMAT, **dialect.settings}
    low, high = dialect.preamble
    lines = low + zlib.crc32(f"{motion} {number}".encode()) % (high - low + 1)
    above = [["Gerät", "Prüfstand 7"], [f"{motion}: {number}"], ["Temp", "21 °C"]]
    if not settings["time_column"]:
        above.insert(0, ["Sampling rate", f"{dialect.rate:g} kHz"])
    above = [*above, *([f"channel {i}", f"{i:d}"] for i in range(lines))][:lines]
    units = [settings["time_unit"]] if settings["time_column"] else []
    units += ["kA"] * dialect.currents + [settings["travel_unit"]] * len(dialect.channels)
    columns = [settings["time_column"]] if settings["time_column"] else []
    columns += [f"I{i + 1}" for i in range(dialect.currents)] + list(dialect.channels)
    if dialect.names:
        named = zip(columns, units, strict=True)
        above.append([dialect.names.format(name=name, unit=unit) for name, unit in named])
    if dialect.units:
        above.append([dialect.units.format(unit=_SPELT.get(unit, unit)) for unit in units])
    shown = [time / TO_MS[settings["time_unit"]]] if settings["time_column"] else []
    shown += [0.01 * np.sin(time + i) for i in range(dialect.currents)]
    short = np.where(np.arange(time.size) < 0.9 * time.size, dialect.rest, np.nan)
    shown += [*readings, *[short] * (len(dialect.channels) - len(readings))]
    return above, np.column_stack(shown).tolist()


def _text(dialect: "Dialect", file: Path, recording: Recording) -> None:
    settings = {**FORMAT, **dialect.settings}
    above, samples = _rows(dialect, recording)
    digits = [dialect.digits] * len(samples[0])
    if settings["time_column"]:
        digits[0] = {"s": 7, "ms": 3, "us": 0}[settings["time_unit"]]
    end = [""] * dialect.trailing
    lines = [settings["delimiter"].join([*row, *end]) for row in above]
    for sample in samples:
        row = [f"{x:.{n}f}" if x == x else "" for x, n in zip(sample, digits, strict=True)]
        line = settings["delimiter"].join([*row, *end])
        lines.append(line.replace(".", settings["decimal"]))
    file.write_bytes(dialect.eol.join([*lines, ""]).encode(settings["encoding"]))


def _excel(dialect: "Dialect", file: Path, recording: Recording) -> None:
    import openpyxl

    above, samples = _rows(dialect, recording)
    book = openpyxl.Workbook(write_only=True)
    book.create_sheet("Info").append(["made by", "Prüfstand 7"])
    sheet = book.create_sheet("Data")
    for row in [*above, *samples]:
        sheet.append([None if x != x else x for x in row])
    book.save(file)


def _comtrade(dialect: "Dialect", file: Path, recording: Recording) -> None:
    """A pair of files, with 32 bits for a value."""
    time, readings = recording.time, recording.readings
    rate = 1e3 * (time.size - 1) / (time[-1] - time[0])
    described = [
        f"{i + 1},{name},,,mm,{dialect.step},0,0,-2147483647,2147483647,1,1,P"
        for i, name in enumerate(dialect.channels[: len(readings)])
    ]
    start = "20/11/2024,15:13:07.000000"
    count = len(described)
    head = ["Prüfstand,7,2013", f"{count},{count}A,0D", *described, "50", "1"]
    head += [f"{rate:.6f},{time.size}", start, start, "BINARY32", "1", "0,0", "0,0", ""]
    file.write_text("\r\n".join(head), encoding="utf-8", newline="")
    rows = np.zeros(time.size, [("n", "<u4"), ("t", "<u4"), ("x", "<i4", count)])
    rows["n"], rows["t"] = np.arange(1, time.size + 1), np.rint(1e3 * (time - time[0]))
    steps = np.rint(readings / dialect.step)
    rows["x"] = np.where(np.isnan(steps), -(2**31), steps).T  # missing
    file.with_suffix(".dat").write_bytes(rows.tobytes())


def _netcdf(dialect: "Dialect", file: Path, recording: Recording) -> None:
    import xarray as xr

    unit = {"units": "millimeter"}
    named = zip(dialect.channels, recording.readings, strict=False)
    xr.Dataset(
        {name: ("time", reading, unit) for name, reading in named},
        coords={"time": ("time", recording.time, {"units": "msec"})},
        attrs={"motion": recording.motion, "operation": recording.number},
    ).to_netcdf(file, engine="scipy")


WRITERS: Mapping[str, Callable] = {
    "stand-in": _stand_in,
    "text": _text,
    "excel": _excel,
    "comtrade": _comtrade,
    "netcdf": _netcdf,
}
"""By the kind of a dialect."""
