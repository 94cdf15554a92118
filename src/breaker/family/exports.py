"""Simulated files of analysers, for ``breaker example`` and to validate the reader."""

import tempfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.common.randomness import generator
from breaker.configuration.data_files import simulated_test
from breaker.configuration.loading import read
from breaker.family.endurance import EnduranceTest, rows, texts, write_curve
from breaker.family.rich_drive import Drive
from breaker.model.parameters import MOTIONS, Size
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor

_EXAMPLES = read(Path(__file__).with_name("examples.yaml"))
_HIGH, _VISITS, _WIDE = (_EXAMPLES[key] for key in ("high_voltage", "inspections", "wide"))
HIGH_VOLTAGE = Size(lengths=_HIGH["lengths"], times=_HIGH["times"])
"""Size of the high-voltage breaker, relative to the drive of the simulated endurance test."""
CHANNELS = ("S 1", "S 2", "S 3", "R 1", "R 2", "R 3")  # columns of travel of an analyser
_STATED = "Station: Example\nSerial No: EX-0001\nType: 12 kV\nTest Date: {date}\nOperation: C-O"


def write_wide(
    file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
) -> None:
    """Write a record as an analyser does: columns of currents and travels, a rate, no times.

    Args:
        time: Times at the rate of the layout, ``(t,)``, ms.
        travel: Travel of the first channels, ``(t,)`` or ``(channels, t)``, mm; NaN for a missing
            sample. Other channels are at rest, and end early.
        motion, operation: Values on which the number of lines above the samples depends.
    """
    rate = (time.size - 1) / (time[-1] - time[0])
    above = [f"Sampling rate;{rate:g} kHz", "Gerät;Prüfstand 7", f"{motion}: {operation}"]
    more = zlib.crc32(f"{motion} {operation}".encode()) % 42
    above += ["Temp;21 °C", *(f"channel {i};{i}" for i in range(more))]
    unused = np.where(np.arange(time.size) < 0.9 * time.size, 0.0, np.nan)
    readings = _WIDE["quantum"] * np.rint(np.atleast_2d(travel) / _WIDE["quantum"])
    columns = {f"I{i + 1}": texts(0.01 * np.sin(time + i), 2) for i in range(6)}
    for i, channel in enumerate(CHANNELS):
        columns[channel] = texts(readings[i] if i < len(readings) else unused, 2)
    lines = [f"{line};;" for line in [*above, *rows(columns, ";")]]
    Path(file).write_text("\n".join([*lines, ""]), encoding="utf-8", newline="\r\n")


def _close_open(
    drive: Drive, time: np.ndarray, numbers: Mapping, poles: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simulate a closing and an opening of poles that scatter around a drive.

    Returns:
        Starts of the motions, times of contact touch and separation, ``(poles, m)``, ms, and
        travel, ``(poles, t)``, mm.
    """
    trigger = numbers["start"] + numbers["start_sd"] * rng.standard_normal()
    starts, switches, travels = [], [], []
    for _ in range(poles):
        sds = {name: sd * rng.standard_normal() for name, sd in numbers["scatter"].items()}
        pole = drive.changed(**{n: drive.value(n) * (1.0 + sd) for n, sd in sds.items()})
        shifts = numbers["phases_sd"] * rng.standard_normal(2)
        begins = trigger + shifts + (0.0, numbers["apart"])
        both = [pole.operate(m, time - begin) for m, begin in zip(MOTIONS, begins, strict=True)]
        way = np.where(time < begins[1], *(travel for travel, _ in both))
        travels.append(way + numbers["noise_sd"] * rng.standard_normal(time.size))
        starts.append(begins)
        switches.append(begins + [switching for _, switching in both])
    return np.array(starts), np.array(switches), np.array(travels)


def write_close_opens(
    drive: Drive, seed: int, folder: Path, operations: Sequence[int]
) -> dict[int, np.ndarray]:
    """Write a file for each operation, such as ``rack_0001.txt``, of a drive of the simulated
    endurance test at the size of high voltage. The folder need not exist.

    Returns:
        Start of each motion of each channel, ms of the record, ``(channels, m)``, by operation.
    """
    folder.mkdir(parents=True, exist_ok=True)
    time, starts = np.arange(0.0, _HIGH["length"], 1.0 / _HIGH["rate"]), {}
    for operation in operations:
        rng, large = generator(seed, "high voltage", operation), drive.scaled(HIGH_VOLTAGE)
        starts[operation], _, travels = _close_open(large, time, _HIGH, len(CHANNELS), rng)
        travels[-1, round(0.95 * time.size) :] = np.nan  # a channel that ends early
        file = folder / f"rack_{operation:04d}.txt"
        write_wide(file, time, travels, motion="close-open", operation=operation)
    return starts


def write_inspections(settings: Mapping, folder: Path) -> int:
    """Write exports of two inspections of a drive, and one without a date or times; return their
    number. The drive is that of the simulated endurance test of a configuration.
    """
    test = EnduranceTest.from_settings(simulated_test(settings), settings["seed"])
    for date, share in _VISITS["dates"].items():
        rng = generator(settings["seed"], "example", date)
        columns = _inspection(test.worn(round(share * test.operations), scatter=False), rng)
        text = "\n".join([_STATED.format(date=date), "", *rows(columns, ";"), ""])
        (folder / f"inspection_{date}.csv").write_text(text, encoding="utf-8")
    bare = {f"s{i + 1}": columns[f"Travel {pole} (mm)"] for i, pole in enumerate("RST")}
    (folder / "unknown.txt").write_text("\n".join([*rows(bare, ";"), ""]), encoding="utf-8")
    return len(_VISITS["dates"]) + 1


def _inspection(drive: Drive, rng: np.random.Generator) -> dict[str, list[str]]:
    """Return the columns of a closing and an opening of three poles, as text."""
    time = np.arange(round(_VISITS["length"] * _VISITS["rate"])) / _VISITS["rate"]
    starts, switches, travels = _close_open(drive, time, _VISITS, 3, rng)
    columns = {"Time (ms)": texts(time, 2)}
    columns |= {f"Travel {p} (mm)": texts(way, 3) for p, way in zip("RST", travels, strict=True)}
    for pole, (touch, separation) in zip("RST", switches, strict=True):
        closed = (time >= touch) & (time < separation)
        columns[f"Contact {pole}"] = texts(1.0 * closed, 0)
    for motion, start in zip(MOTIONS, starts[0], strict=True):
        after = time - (start - _VISITS["delay"])
        flows = (after > 0.0) & (after < _VISITS["lasts"])
        current = -_VISITS["current"] * np.expm1(-np.maximum(after, 0.0) / _VISITS["rise"])
        columns[f"Coil {motion} (A)"] = texts(current * flows, 3)
    return columns


class Layout(NamedTuple):
    """Layout of files: writer, section ``endurance.format`` that reads it, ending, rate in kHz."""

    write: Callable
    settings: Mapping
    ending: str = ".csv"
    rate: float = _WIDE["rate"]


LAYOUTS = {"comma": Layout(write_curve, {}), "wide": Layout(write_wide, _WIDE)}


def through_files(
    prior: Prior,
    sensor: Sensor,
    motion: str,
    n: int,
    rng: np.random.Generator,
    layouts: Mapping[str, Layout] = LAYOUTS,
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Draw ``n`` records from the prior, write each in one of the layouts, and read them. A
    rejection depends on the record alone, so ranks of the true values of the others stay uniform.

    Returns:
        Records on the grid, ``(n, t)``, mm; their parameters, and if the onset is inferred the time
        from the first detected motion to the true start, ms: ``(n, q)``; and the reasons why the
        reader rejected the other records.

    Raises:
        RuntimeError: If the reader rejects all records.
    """
    from breaker.model.curves import travel  # no export of an example needs the reader
    from breaker.records.curves import Grid, read_curves
    from breaker.records.operations import Operation

    numbers, theta = _EXAMPLES["through_files"], prior.sample(n, rng)
    starts = numbers["margin"] - sensor.start + numbers["spread"] * (rng.random(n) - 0.5)
    measured, first = np.empty((n, sensor.samples)), np.empty(n)
    reasons = np.full(n, "", dtype=object)
    length = sensor.stop - sensor.start + 2 * numbers["margin"]
    for i, layout in enumerate(layouts.values()):
        part, operations = slice(i, None, len(layouts)), []
        time = np.arange(round(length * layout.rate)) / layout.rate
        curves = travel(theta[part], time, motion, onset=starts[part]).travel
        with tempfile.TemporaryDirectory() as folder:
            for number, record in enumerate(sensor.corrupt(curves, rng)):
                file = Path(folder, f"{motion}_{number:05d}{layout.ending}")
                layout.write(file, time, record, motion=motion, operation=number)
                operations.append(Operation(number, file))
            settings = {"stroke": numbers["stroke"], **layout.settings}
            files = read_curves(operations, settings, Grid(sensor.times), motion)
        measured[part], first[part], reasons[part] = files.travel, files.first_motion, files.reason
    # The networks of the paper take complete records.
    reasons[(reasons == "") & np.isnan(measured).any(axis=1)] = "a sample is missing or masked"
    truth = np.column_stack([theta, starts - first]) if sensor.infers_onset else theta
    accepted = reasons == ""
    if not accepted.any():
        raise RuntimeError(f"the reader rejects all {n} curves of the model: {reasons[0]}")
    return measured[accepted], truth[accepted], reasons[~accepted].tolist()
