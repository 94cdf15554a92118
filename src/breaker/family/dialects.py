"""Ten ways in which instruments write a record, each with the settings that read it.

They differ in all that files differ in: kind, encoding, signs between and in numbers, preambles,
units, a rate for the times, channels side by side, blank cells, steps, sign, zero and mechanics.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from breaker.family.record_writers import WRITERS, Recording
from breaker.records.settings import FORMAT, TO_MM

ANGLES = Path(__file__).with_name("angles.csv")
"""Table of a transducer on a lever of 40 mm: degrees and mm, open at -50 degrees."""

_RATE = 10.0  # kHz, of all of these instruments


@dataclass(frozen=True)
class Dialect:
    """How one kind of instrument writes.

    Attributes:
        ending: Of its files.
        settings: The section ``endurance.format`` that reads them, but for what has its default.
        digits: Digits of a reading after the decimal sign.
        rest: Reading of the open breaker, in the unit of the travel.
        channels: Names, in its files, of the columns of travel.
        preamble: Least and most lines above the names; how many differs from file to file.
        names: Pattern of a name with its unit; nothing where there are no names.
        units: Pattern of a unit in a line below the names; nothing where there is no such line.
        currents: Columns of current before those of travel.
        trailing: Blank cells at the end of a line.
        eol: End of a line.
        kind: "text", or what else its files are.
        rate: kHz, of its samples.
    """

    ending: str = ".csv"
    settings: Mapping = field(default_factory=dict)
    digits: int = 3
    rest: float = 0.0
    channels: tuple[str, ...] = ("travel",)
    preamble: tuple[int, int] = (3, 12)
    names: str = "{name}"
    units: str = ""
    currents: int = 0
    trailing: int = 0
    eol: str = "\n"
    kind: str = "text"
    rate: float = _RATE

    def file_name(self, motion: str, operation: int) -> str:
        """Return the name of a file."""
        return f"{motion}_{operation:05d}{self.ending}"

    @property
    def step(self) -> float:
        """The step of a reading, in the unit of the travel."""
        return self.settings.get("quantum") or 10.0**-self.digits

    def reaching(self, way: float, folder: str | Path) -> "Dialect":
        """Return the same of a drive with a longer way, mm: a table as of a longer lever.

        Args:
            folder: Where such a table is written.
        """
        table = self.settings.get("table")
        if not table:
            return self
        degrees, mm = np.loadtxt(table, delimiter=",", skiprows=1).T
        if (longer := 1.05 * way / mm[-1]) <= 1.0:
            return self
        file, lines = Path(folder, "longer.csv"), np.column_stack([degrees, longer * mm])
        np.savetxt(file, lines, delimiter=",", header="deg,mm", comments="")
        return replace(self, settings={**self.settings, "table": str(file)})

    def reading(self, travel: np.ndarray) -> np.ndarray:
        """Return what the instrument shows for travel in mm, in its unit and its steps."""
        complete = {**FORMAT, **self.settings}
        if complete["table"]:
            degrees, mm = np.loadtxt(complete["table"], delimiter=",", skiprows=1).T
            fine = np.linspace(degrees[0], degrees[-1], 100_001)
            from scipy.interpolate import PchipInterpolator

            exact = np.interp(travel, PchipInterpolator(degrees, mm)(fine), fine)
        else:
            exact = travel / (complete["ratio"] or TO_MM[complete["travel_unit"]])
        return self.step * np.rint((complete["sign"] * exact + self.rest) / self.step)

    def write(
        self, file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
    ) -> None:
        """Write a record.

        Args:
            time: Times, ``(t,)``, ms; evenly spaced where the dialect has a rate instead.
            travel: Travel of the first channels, ``(t,)`` or ``(channels, t)``, mm, zero at the
                open position; NaN where a sample is missing. Other channels end early.
            motion: Named in the preamble.
            operation: Named in the preamble.

        Example:
            >>> import tempfile
            >>> time, file = np.arange(3.0), Path(tempfile.mkdtemp(), "a.txt")
            >>> DIALECTS["tab"].write(file, time, 0.1 * time, motion="closing", operation=1)
            >>> file.read_text().splitlines()[-1].split()
            ['2.000', '0.200']
        """
        readings = self.reading(np.atleast_2d(travel))
        recording = Recording(time, readings, motion, operation)
        WRITERS[self.kind](self, Path(file), recording)


DIALECTS: dict[str, Dialect] = {
    "stand-in": Dialect(kind="stand-in"),
    "semicolon": Dialect(
        settings={
            "encoding": "latin-1",
            "delimiter": ";",
            "decimal": ",",
            "time_column": "Zeit",
            "time_unit": "ms",
            "travel_column": "Weg °",
        },
        channels=("Weg °",),
        names="{name} ({unit})",
        eol="\r\n",
    ),
    "tab": Dialect(".txt", {"delimiter": "\t", "time_unit": "ms"}, units="[{unit}]"),
    # Close and open, six currents and six travels, no times, coarse steps.
    "wide": Dialect(
        settings={
            "delimiter": ";",
            "time_column": None,
            "rate": _RATE,
            "travel_column": "S 1",
            "quantum": 0.08,
        },
        digits=2,
        channels=("S 1", "S 2", "S 3", "R 1", "R 2", "R 3"),
        preamble=(4, 45),
        currents=6,
        trailing=2,
        eol="\r\n",
    ),
    "degrees": Dialect(
        ending=".txt",
        settings={
            "delimiter": " ",
            "time_column": 1,
            "travel_column": 2,
            "travel_unit": "deg",
            "ratio": 0.25,
        },
        names="",
    ),
    "angles": Dialect(
        settings={"delimiter": "|", "time_unit": "us", "travel_unit": "deg", "table": str(ANGLES)},
        names='"{name}"',
        units="({unit})",
    ),
    "inverted": Dialect(
        ending=".txt",
        settings={"encoding": "utf-16", "delimiter": "\t", "sign": -1, "zero": "rest"},
        rest=87.5,
        units="{unit}",
        eol="\r",
    ),
    "excel": Dialect(
        ending=".xlsx",
        settings={"time_unit": "ms", "travel_column": "travel 2"},
        channels=("travel 2",),
        names="{name} [{unit}]",
        kind="excel",
    ),
    "comtrade": Dialect(
        ending=".cfg",
        settings={"travel_column": "Travel A"},
        channels=("Travel A",),
        kind="comtrade",
    ),
    "netcdf": Dialect(ending=".nc", settings={"time_unit": "ms"}, kind="netcdf"),
}
"""The ten dialects, by name."""
