"""Nine forms of files of instruments, each with the settings that read it.

They differ in kind, encoding, delimiters, lines above the samples, units, a rate in place of times,
channels side by side, blank cells, steps, sign and zero.
"""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import openpyxl

from breaker.family import exports
from breaker.records.settings import FORMAT, TO_MM, TO_MS

_TIME_DIGITS = {"s": 7, "ms": 3, "us": 0}
_SPELT = {"ms": "msec", "deg": "°"}


@dataclass(frozen=True)
class Layout:
    """Form of the text files of one kind of instrument.

    Attributes:
        settings: Section ``endurance.format`` that reads the files; other keys have defaults.
        ending: Ending of the names of files.
        channel: Name of the column of travel.
        names: Pattern of a name with its unit; empty if the files have no names.
        units: Pattern of a unit in the line below the names; empty if there is no such line.
        rest: Reading of the open breaker, in the unit of the travel.
        eol: End of a line.
        rate: Rate of the samples, kHz.
    """

    settings: Mapping = field(default_factory=dict)
    ending: str = ".csv"
    channel: str = "travel"
    names: str = "{name}"
    units: str = ""
    rest: float = 0.0
    eol: str = "\n"
    rate: float = 10.0

    def reading(self, travel: np.ndarray) -> np.ndarray:
        """Return the readings of travel in mm, in the unit of the instrument, in steps of 0.001."""
        complete = {**FORMAT, **self.settings}
        exact = travel / (complete["ratio"] or TO_MM[complete["travel_unit"]])
        return 1e-3 * np.rint((complete["sign"] * exact + self.rest) / 1e-3)

    def rows(
        self, time: np.ndarray, travel: np.ndarray, motion: str, operation: int
    ) -> tuple[list[list[str]], list[list[float]]]:
        """Return rows of text above the samples, and the samples."""
        settings = {**FORMAT, **self.settings}
        count = 3 + zlib.crc32(f"{motion} {operation}".encode()) % 10
        above = [["Gerät", "Prüfstand 7"], [f"{motion}: {operation}"], ["Temp", "21 °C"]]
        above += [[f"channel {i}", f"{i:d}"] for i in range(count - 3)]
        columns = {settings["time_column"]: settings["time_unit"]}
        columns[self.channel] = settings["travel_unit"]
        if self.names:
            named = columns.items()
            above.append([self.names.format(name=name, unit=unit) for name, unit in named])
        if self.units:
            units = columns.values()
            above.append([self.units.format(unit=_SPELT.get(unit, unit)) for unit in units])
        samples = time / TO_MS[settings["time_unit"]], self.reading(travel)
        return above, np.column_stack(samples).tolist()

    def write(
        self, file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
    ) -> None:
        """Write a record: times, ms, and travel, mm, ``(t,)``; NaN for a missing sample."""
        settings = {**FORMAT, **self.settings}
        above, samples = self.rows(time, travel, motion, operation)
        digits = _TIME_DIGITS[settings["time_unit"]]
        lines = [settings["delimiter"].join(row) for row in above]
        for at, reading in samples:
            cells = [f"{at:.{digits}f}", f"{reading:.3f}" if reading == reading else ""]
            line = settings["delimiter"].join(cells)
            lines.append(line.replace(".", settings["decimal"]))
        Path(file).write_bytes(self.eol.join([*lines, ""]).encode(settings["encoding"]))


class _Excel(Layout):
    def write(self, file, time, travel, *, motion, operation) -> None:
        above, samples = self.rows(time, travel, motion, operation)
        book = openpyxl.Workbook(write_only=True)
        book.create_sheet("Info").append(["made by", "Prüfstand 7"])
        sheet = book.create_sheet("Data")
        for row in [*above, *samples]:
            sheet.append([None if x != x else x for x in row])
        book.save(file)


class _Comtrade(Layout):
    """A pair of files, with 32 bits for a value."""

    def write(self, file, time, travel, *, motion, operation) -> None:
        file, start = Path(file), "20/11/2024,15:13:07.000000"
        rate = 1e3 * (time.size - 1) / (time[-1] - time[0])
        channel = f"1,{self.channel},,,mm,0.001,0,0,-2147483647,2147483647,1,1,P"
        head = ["Prüfstand,7,2013", "1,1A,0D", channel, "50", "1", f"{rate:.6f},{time.size}"]
        head += [start, start, "BINARY32", "1", "0,0", "0,0", ""]
        file.write_text("\r\n".join(head), encoding="utf-8", newline="")
        rows = np.zeros(time.size, [("n", "<u4"), ("t", "<u4"), ("x", "<i4")])
        rows["n"], rows["t"] = np.arange(1, time.size + 1), np.rint(1e3 * (time - time[0]))
        steps = np.rint(self.reading(travel) / 1e-3)
        rows["x"] = np.where(np.isnan(steps), -(2**31), steps)  # missing
        file.with_suffix(".dat").write_bytes(rows.tobytes())


LAYOUTS = {
    "comma": exports.LAYOUTS["comma"],
    "semicolon": Layout(
        settings={
            "encoding": "latin-1",
            "delimiter": ";",
            "decimal": ",",
            "time_column": "Zeit",
            "time_unit": "ms",
            "travel_column": "Weg °",
        },
        channel="Weg °",
        names="{name} ({unit})",
        eol="\r\n",
    ),
    "tab": Layout({"delimiter": "\t", "time_unit": "ms"}, ".txt", units="[{unit}]"),
    "wide": exports.LAYOUTS["wide"],
    "degrees": Layout(
        settings={
            "delimiter": " ",
            "time_column": 1,
            "travel_column": 2,
            "travel_unit": "deg",
            "ratio": 0.25,
        },
        ending=".txt",
        names="",
    ),
    "angles": Layout(
        settings={"delimiter": "|", "time_unit": "us", "travel_unit": "deg", "ratio": 0.25},
        names='"{name}"',
        units="({unit})",
    ),
    "inverted": Layout(
        settings={"encoding": "utf-16", "delimiter": "\t", "sign": -1, "zero": "rest"},
        ending=".txt",
        rest=87.5,
        units="{unit}",
        eol="\r",
    ),
    "excel": _Excel(
        {"time_unit": "ms", "travel_column": "travel 2"}, ".xlsx", "travel 2", "{name} [{unit}]"
    ),
    "comtrade": _Comtrade({"travel_column": "Travel A"}, ".cfg", "Travel A"),
}
"""The nine layouts, by name; the names seed the files of the studies."""
