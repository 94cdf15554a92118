"""Write simulated records as files of instruments, and the exports of ``breaker example``."""

import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import read
from breaker.family.curve_file import rows, texts, write_curve
from breaker.family.endurance import EnduranceTest
from breaker.family.rich_drive import Drive
from breaker.model.parameters import GAP, MOTIONS, Size

_EXAMPLES = read(Path(__file__).with_name("examples.yaml"))
_HIGH = _EXAMPLES["high_voltage"]
HIGH_VOLTAGE = Size(lengths=_HIGH["lengths"], times=_HIGH["times"])
"""Size of the high-voltage breaker, relative to the drive of the simulated endurance test."""
CHANNELS = ("S 1", "S 2", "S 3", "R 1", "R 2", "R 3")
"""Names of the columns of travel in an export of an analyser."""
_STEP = 0.08  # mm, of a reading of an analyser: coarse, as at a stroke of 150 mm
_STATED = "Station: Example\nSerial No: EX-0001\nType: 12 kV\nTest Date: {date}\nOperation: C-O"


def write_wide(
    file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
) -> None:
    """Write a record as an analyser does: currents and travels side by side, a rate, no times.

    Args:
        time: Times at the rate of the layout, ``(t,)``, ms.
        travel: Travel of the first channels, ``(t,)`` or ``(channels, t)``, mm; NaN for a missing
            sample. Other channels are at rest, and end early.
        motion: Motion above the samples.
        operation: Operation; the number of lines above the samples depends on both.
    """
    rate = (time.size - 1) / (time[-1] - time[0])
    above = [f"Sampling rate;{rate:g} kHz", "Gerät;Prüfstand 7", f"{motion}: {operation}"]
    more = zlib.crc32(f"{motion} {operation}".encode()) % 42
    above += ["Temp;21 °C", *(f"channel {i};{i}" for i in range(more))]
    unused = np.where(np.arange(time.size) < 0.9 * time.size, 0.0, np.nan)
    readings = _STEP * np.rint(np.atleast_2d(travel) / _STEP)
    columns = {f"I{i + 1}": texts(0.01 * np.sin(time + i), 2) for i in range(6)}
    for i, channel in enumerate(CHANNELS):
        columns[channel] = texts(readings[i] if i < len(readings) else unused, 2)
    lines = [f"{line};;" for line in [*above, *rows(columns, ";")]]
    Path(file).write_text("\n".join([*lines, ""]), encoding="utf-8", newline="\r\n")


class Layout(NamedTuple):
    """Form of the files of an instrument.

    Attributes:
        write: Function that writes a record.
        settings: Section ``endurance.format`` that reads the files; other keys have defaults.
        ending: Ending of the names of files.
        rate: Rate of the samples, kHz.
    """

    write: Callable
    settings: Mapping
    ending: str = ".csv"
    rate: float = 10.0


LAYOUTS = {
    "comma": Layout(write_curve, {}),
    "wide": Layout(
        write_wide,
        {
            "delimiter": ";",
            "time_column": None,
            "rate": 10.0,
            "travel_column": CHANNELS[0],
            "quantum": _STEP,
        },
    ),
}
"""Layouts in which the validation writes curves of the model."""


class _Pole(NamedTuple):
    """A record of one pole: its drive, start of each motion, ms, and travel, ``(t,)``, mm."""

    drive: Drive
    starts: Mapping[str, float]
    travel: np.ndarray


def _close_open(
    drive: Drive, time: np.ndarray, numbers: Mapping, poles: Sequence[str], rng: np.random.Generator
) -> dict[str, _Pole]:
    """Simulate a close and an open of poles that scatter around a drive."""
    trigger, records = numbers["start"] + numbers["start_sd"] * rng.standard_normal(), {}
    for pole in poles:
        changed = {}
        for name, sd in numbers["scatter"].items():
            changed[name] = drive.value(name) * (1.0 + sd * rng.standard_normal())
        own, shifts = drive.changed(**changed), numbers["phases_sd"] * rng.standard_normal(2)
        starts = dict(zip(MOTIONS, trigger + shifts + (0.0, numbers["apart"]), strict=True))
        closing, opening = (own.travel(motion, time - at) for motion, at in starts.items())
        travel = np.where(time < starts["opening"], closing, opening)
        travel += numbers["noise_sd"] * rng.standard_normal(time.size)
        records[pole] = _Pole(own, starts, travel)
    return records


def write_close_opens(
    drive: Drive, seed: int, folder: Path, operations: Sequence[int]
) -> dict[tuple[str, str, int], float]:
    """Write a file for each operation of a high-voltage breaker, such as ``rack_0001.txt``.

    Args:
        drive: Drive of the size of the simulated endurance test, which is enlarged.
        seed: Seed, which determines the files.
        folder: Folder of the files, which is made if it does not exist.
        operations: Numbers of the operations.

    Returns:
        Start of each motion, ms of the record, by channel, motion and operation.
    """
    folder.mkdir(parents=True, exist_ok=True)
    time, starts = np.arange(0.0, _HIGH["length"], 1.0 / _HIGH["rate"]), {}
    for operation in operations:
        rng = generator(seed, "high voltage", operation)
        poles = _close_open(drive.scaled(HIGH_VOLTAGE), time, _HIGH, CHANNELS, rng)
        for channel, pole in poles.items():
            starts |= {(channel, motion, operation): at for motion, at in pole.starts.items()}
        travels = np.array([pole.travel for pole in poles.values()])
        travels[-1, round(0.95 * time.size) :] = np.nan  # a channel that ends early
        file = folder / f"rack_{operation:04d}.txt"
        write_wide(file, time, travels, motion="close-open", operation=operation)
    return starts


def write_inspections(settings: Mapping, folder: Path) -> int:
    """Write exports of two inspections, and one without a date or times; return their number.

    Args:
        settings: Configuration; the drive of its simulated endurance test is inspected.

    Example:
        >>> from breaker.configuration.loading import defaults
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as name:
        ...     write_inspections(defaults(), Path(name))
        3
    """
    test = EnduranceTest.from_settings(simulated_test(settings), settings["seed"])
    numbers = _EXAMPLES["inspections"]
    for date, share in numbers["dates"].items():
        rng = generator(settings["seed"], "example", date)
        columns = _inspection(test.worn(round(share * test.operations), scatter=False), rng)
        text = "\n".join([_STATED.format(date=date), "", *rows(columns, ";"), ""])
        (folder / f"visit_{date}.csv").write_text(text, encoding="utf-8")
    travels = [column for name, column in columns.items() if name.startswith("Travel")]
    bare = rows(dict(zip(("s1", "s2", "s3"), travels, strict=True)), ";")
    (folder / "unknown.txt").write_text("\n".join([*bare, ""]), encoding="utf-8")
    return len(numbers["dates"]) + 1


def _inspection(drive: Drive, rng: np.random.Generator) -> dict[str, list[str]]:
    """Return the columns of a close and an open of three poles, as text."""
    numbers = _EXAMPLES["inspections"]
    time = np.arange(round(numbers["length"] * numbers["rate"])) / numbers["rate"]
    poles = _close_open(drive, time, numbers, "RST", rng)
    columns = {"Time (ms)": texts(time, 2)}
    for name, pole in poles.items():
        columns[f"Travel {name} (mm)"] = texts(pole.travel, 3)
    for name, pole in poles.items():
        columns[f"Contact {name}"] = texts(1.0 * (pole.travel > pole.drive.value(GAP.name)), 0)
    for motion, start in poles["R"].starts.items():
        after = time - (start - numbers["delay"])
        flows = (after > 0.0) & (after < numbers["lasts"])
        current = -numbers["current"] * np.expm1(-np.maximum(after, 0.0) / numbers["rise"])
        columns[f"Coil {motion} (A)"] = texts(current * flows, 3)
    return columns
