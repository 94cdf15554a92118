"""The two axes of a record: its times in ms, in even steps, and its travel in mm towards closed.

An instrument samples at an even rate. Printed times are uneven by their last digit, and skip what
was not stored: a gap of whole steps, in which samples are missing. All else, such as times that go
back or a rate that changes, is no clock that can be trusted, and the record is refused.

A length needs its unit alone. Degrees, volts or counts need the mm of one of them, ``ratio``, or a
table of readings and mm, between whose points a smooth curve is laid that never turns back. Beyond
the ends of a table there is no travel.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from breaker.records.files import RejectedCurveError, read_bytes
from breaker.records.rejections import Remark, UnusableError
from breaker.records.settings import READABLE, TO_MM, TO_MS

_LATEST = 1e14  # ms, beyond all clocks, also those that count from 1970 in any unit
_STEPS = (1.0 / READABLE[1], 1.0 / READABLE[0])  # ms, between samples
_DURATIONS = (10.0, 1e4)  # ms, outside of which another unit of time is likely
_UNEVEN = 0.25  # steps, by which a time may be off one step after the last
_PRINTED = 0.1  # steps, by which times are off where they are printed with digits enough
_SPARSE = 10  # places for a sample: no gap takes more memory than that
_FEW = 0.05  # share of times that do not increase, above which they are rounded
_RATE = 0.01  # share by which the times and the rate of the settings may differ

_BEYOND = 0.02  # of its width, by which noise may leave a table; there it goes on straight
_OUTSIDE = 0.05  # share of samples further out from which it is the wrong table

# Of readings that are rounded coarsely, this share at least is as the one before.
_TIES = 0.05
_TRIED = 12  # of the smallest steps: damaged samples make odd ones
_COUNTS = 10.5  # quanta, of a small step
_FEWEST = 10  # small steps,
_OFTEN = 3  # and the quantum itself among them
_NEARLY = 0.9  # share of them that are multiples
_EQUAL = 0.02  # share by which equal steps differ in print


def even_times(
    time: np.ndarray | None, lines: np.ndarray, settings: Mapping
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return times without gaps, and where among them the samples are.

    Args:
        time: Times, ``(n,)``, in the file's unit; None if the file has none.
        lines: Line of each sample in the file, ``(n,)``.
        settings: The section ``endurance.format`` of the configuration.

    Returns:
        Times ``(t,)``, ms; place of each sample among them, ``(n,)``; and a remark, "" if there is
        none.

    Raises:
        UnusableError: If the times do not increase in steps that are even or whole multiples, or
            speak for another unit or rate.
    """
    if lines.size < 2:
        raise UnusableError(f"has {lines.size} samples")
    if time is None:
        return np.arange(lines.size) / settings["rate"], np.arange(lines.size), ""
    unit = settings["time_unit"]
    if (late := np.flatnonzero(np.abs(time) > _LATEST / TO_MS[unit])).size:
        found = f"the time is {time[late[0]]:.4g} {unit}, which no clock shows"
        raise UnusableError(found, line=int(lines[late[0]]))
    time, said = _without_odd_ends(time * TO_MS[unit])
    _check_increase(time, lines)
    steps = np.diff(time)
    _check_unit(float(time[-1] - time[0]), float(np.median(steps)), unit)
    whole = _whole_steps(steps)
    if whole.sum() >= _SPARSE * time.size:
        gap = int(steps.argmax())
        raise UnusableError(f"a gap of {steps[gap]:.4g} ms", line=int(lines[gap + 1]))
    place = np.append(0, np.cumsum(whole.astype(int)))
    step = float(time[-1] - time[0]) / int(place[-1])
    _check_rate(step, settings["rate"])
    even = time[0] + step * np.arange(int(place[-1]) + 1)
    off = np.abs(time - even[place])
    _check_even(steps - whole * step, off, step, lines)
    even[place] = time
    if off.max() > _PRINTED * step:
        said.append(Remark("uneven", step=f"{step:.4g}", off=f"{off.max():.2g}"))
    return even, place, "; ".join(said)


def _without_odd_ends(time: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Times, ms, whose first and last go on evenly where nothing else fits, and which did not."""
    step, said, time = float(np.median(np.diff(time))), [], time.copy()
    for name, end, near, sign in (("first", 0, 1, -1.0), ("last", -1, -2, 1.0)):
        gap = sign * (time[end] - time[near])
        if step > 0.0 and not 0.0 < gap < (_SPARSE - 1) * time.size * step:
            said.append(Remark("odd-end", which=name, time=f"{time[end]:.6g}"))
            time[end] = time[near] + sign * step
    return time, said


def _check_increase(time: np.ndarray, lines: np.ndarray) -> None:
    """Refuse times, ms, that stay or go back."""
    if (back := np.flatnonzero(np.diff(time) <= 0)).size:
        more = f" ({back.size} such times)" if back.size > 1 else ""
        few = (
            "; export each sample once, in a line of its own, with all digits of its time: "
            "endurance.format.rate would not know which times are doubled"
        )
        reason = f"the time does not increase{more}{few if back.size > _FEW * time.size else ''}"
        raise UnusableError(reason, line=int(lines[back[0] + 1]))


def _whole_steps(steps: np.ndarray) -> np.ndarray:
    """Number of steps of the clock from each sample to the next, ``(n - 1,)``, at least 1."""
    step = np.median(steps)
    for _ in range(2):  # of many steps together, the mean is better than one that was printed
        whole = np.maximum(np.rint(steps / step), 1.0)
        if (single := whole == 1.0).any():
            step = steps[single].mean()
    return whole


def _check_unit(duration: float, step: float, unit: str) -> None:
    """Refuse a step and a duration, ms, that no record has, with the unit that they speak for."""
    hint = ""
    for other, factor in TO_MS.items():
        ratio = factor / TO_MS[unit]
        if (
            _STEPS[0] <= ratio * step <= _STEPS[1]
            and _DURATIONS[0] <= ratio * duration <= _DURATIONS[1]
        ):
            hint = f"; is endurance.format.time_unit {other!r} rather than {unit!r}?"
            break
    fits = _DURATIONS[0] <= duration <= _DURATIONS[1]
    if not fits and hint:
        raise UnusableError(f"lasts {duration:.4g} ms{hint}")
    if step > _STEPS[1]:
        raise UnusableError(
            f"one sample every {step:.4g} ms is too slow: at least one every ms is needed{hint}"
        )
    if step < _STEPS[0]:
        raise UnusableError(f"one sample every {step:.4g} ms is faster than any recorder{hint}")


def _check_rate(step: float, rate: float | None) -> None:
    """Refuse a step, ms, that is not that of the settings' rate, kHz."""
    if rate is not None and abs(step * rate - 1.0) > _RATE:
        raise UnusableError(
            f"the times give {1.0 / step:.4g} kHz, but endurance.format.rate is {rate:.4g} kHz; if "
            "the rate is right, set endurance.format.time_column to null"
        )


def _check_even(odd: np.ndarray, off: np.ndarray, step: float, lines: np.ndarray) -> None:
    """Refuse steps ``(n - 1,)`` that are ``odd`` by much, and times ``(n,)`` far off; both ms."""
    if (uneven := np.flatnonzero(np.abs(odd) > _UNEVEN * step)).size:
        line = int(lines[uneven[0] + 1])
        raise UnusableError("the time steps are uneven before this line", line=line)
    if off.max() > 2 * _UNEVEN * step:
        raise UnusableError(
            f"the rate changes: times are off even steps of {step:.4g} ms by {off.max():.2g} ms",
            line=int(lines[off.argmax()]),
        )


@dataclass(frozen=True)
class Scale:
    """How a reading becomes travel.

    Attributes:
        factor: mm towards closed for one unit of the reading, or for a mm of the table.
        zero: Reading of the open breaker; 0 where it is found in each record.
        table: Readings and mm, ``(2, n)``; None where the factor is all.

    Example:
        >>> scale = Scale.from_settings(
        ...     {"travel_unit": "deg", "ratio": 1.5, "table": None, "zero": 10.0, "sign": -1})
        >>> scale.travel(np.array([10.0, 0.0]))
        array([-0., 15.])
    """

    factor: float
    zero: float
    table: np.ndarray | None = None

    @classmethod
    def from_settings(cls, settings: Mapping) -> "Scale":
        """Build from the section ``endurance.format`` of the configuration.

        Raises:
            ValueError: If the table cannot be read, or is not one of readings and mm.
        """
        zero = 0.0 if settings["zero"] == "rest" else settings["zero"]
        if settings["table"] is not None:
            return cls(float(settings["sign"]), zero, _read_table(settings["table"]))
        factor = TO_MM[settings["travel_unit"]] if settings["ratio"] is None else settings["ratio"]
        return cls(settings["sign"] * factor, zero)

    def travel(self, reading: np.ndarray) -> np.ndarray:
        """Return travel for readings, ``(t,) -> (t,)``, mm; NaN for NaN, infinite beyond a table.

        Raises:
            UnusableError: If more than a few readings are beyond the table.
        """
        with np.errstate(over="ignore"):  # what is too large is no travel, and said to be so later
            if self.table is None:
                return self.factor * (reading - self.zero)
        from scipy.interpolate import PchipInterpolator  # slow to import, and few need it

        low, high = self.table[0, [0, -1]]
        margin = _BEYOND * (high - low)
        outside = (reading < low - margin) | (reading > high + margin)
        if outside.sum() > _OUTSIDE * np.isfinite(reading).sum():
            raise UnusableError(
                f"reads {np.nanmin(reading):.4g} to {np.nanmax(reading):.4g}, but "
                f"endurance.format.table goes from {low:.4g} to {high:.4g}"
            )
        curve = PchipInterpolator(*self.table)
        inside = np.clip(reading, low, high)
        slope = np.where(reading < low, curve(low, 1), curve(high, 1))
        travel = self.factor * (curve(inside) + slope * (reading - inside))
        return np.where(outside, np.inf, travel)


def _read_table(file: str | Path) -> np.ndarray:
    """Readings, increasing, and mm, ``(2, n)``, of a CSV file with commas and decimal points."""
    name = f"endurance.format.table, {file}"
    try:
        lines = StringIO(read_bytes(file).decode("utf-8-sig"), newline="")
        rows = [row for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    except RejectedCurveError as error:
        raise ValueError(f"endurance.format.table, {error}") from error
    except (UnicodeError, csv.Error) as error:
        raise ValueError(f"{name}: cannot be read: {error}") from error
    try:
        float(rows[0][0])
    except (IndexError, ValueError):
        rows = rows[1:]  # the names of the columns
    try:
        table = np.array([(float(reading), float(mm)) for reading, mm in rows]).reshape(-1, 2).T
    except ValueError as error:
        raise ValueError(
            f"{name}: has lines that are not two numbers, reading and mm, with a comma between "
            "them and decimal points"
        ) from error
    table = table[:, np.argsort(table[0], kind="stable")]
    rises = np.diff(table, axis=1)
    steady = (rises[0] > 0).all() and ((rises[1] > 0).all() or (rises[1] < 0).all())
    if not (rises.size and steady and np.isfinite(table).all()):
        raise ValueError(
            f"{name}: needs two points or more, each reading once, and mm that only rise or only "
            "fall with it"
        )
    return table


def seen_quantum(travel: np.ndarray) -> float:
    """Return the step to which a record is rounded, mm; 0 where it is fine beside the noise.

    It is the smallest of the steps between neighbouring samples of which nearly all small steps
    are multiples.

    Args:
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
    """
    steps = np.abs(np.diff(travel[np.isfinite(travel)]))
    fine = 1e-9 * max(1.0, float(steps.max(initial=0.0)))
    if steps.size == 0 or (steps <= fine).mean() < _TIES:
        return 0.0
    steps = np.sort(steps[steps > fine])
    others = np.flatnonzero(steps[1:] > (1.0 + _EQUAL) * steps[:-1]) + 1
    for quantum in steps[[0, *others[: _TRIED - 1]]] if steps.size >= _FEWEST else []:
        counts = steps[: np.searchsorted(steps, _COUNTS * quantum)] / quantum
        whole = np.rint(counts)
        multiples = (whole > 0.0) & (np.abs(counts - whole) < 0.2)
        if counts.size >= _FEWEST and (whole == 1.0).sum() >= _OFTEN and multiples.mean() > _NEARLY:
            return float(np.median(counts[multiples] / whole[multiples]) * quantum)
    return 0.0
