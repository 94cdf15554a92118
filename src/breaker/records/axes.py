"""Convert the two axes of a record: times to even steps in ms, readings to mm towards closed.

An instrument samples at an even rate. Printed times are uneven by their last digit, and skip
samples that were not stored, by an integer number of steps. Records with other times are rejected.

A length needs only its unit; degrees, volts or counts need ``ratio``, the mm of one of them, or a
table of readings and mm.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from breaker.records.files import RejectedCurveError, read_bytes
from breaker.records.rejections import Remark, UnusableError
from breaker.records.settings import READABLE, SAME_RATE, TO_MM, TO_MS

_UNEVEN = 0.25  # steps, largest deviation of a step from an integer number of steps
_PRINTED = 0.1  # steps, largest deviation of times and readings that are printed with enough digits
_SPARSE = 10  # largest ratio of places to samples; bounds the memory for missing samples
_FEW = 0.05  # share that noise explains: of a table's width, of samples beyond, of equal readings
_SMALL = 10  # largest multiple of the smallest tenth of the differences that determines a quantum


def even_times(
    time: np.ndarray | None, lines: np.ndarray, settings: Mapping
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return even times, ``(t,)``, ms; the places of the samples among these; and a remark.

    Args:
        time: Times, ``(n,)``, in the file's unit; None if the file has none.
        lines: Line of each sample in the file, ``(n,)``.
        settings: The section ``endurance.format`` of the configuration.

    Raises:
        UnusableError: If the steps are not even, or not positive, or fit another unit or rate.
    """
    if lines.size < 2:
        raise UnusableError(f"has {lines.size} samples")
    rate, unit = settings["rate"], settings["time_unit"]
    if time is None:
        return np.arange(lines.size) / rate, np.arange(lines.size), ""
    with np.errstate(over="ignore"):
        time = time * TO_MS[unit]
        steps = np.diff(time)
    remedy = "export each sample once, in a line of its own, with all digits of its time"
    _refuse(~(steps > 0), lines, f"the time does not increase; {remedy}")
    median, (slow, fast) = float(np.median(steps)), (1.0 / rate for rate in READABLE)
    if not fast <= median <= slow:
        fits = [other for other, ms in TO_MS.items() if fast <= median * ms / TO_MS[unit] <= slow]
        raise UnusableError(
            f"one sample every {median:.4g} ms, not every {fast:.4g} to {slow:.4g} ms; is "
            f"endurance.format.time_unit {(fits or [unit])[0]!r}?"
        )
    # The mean of many steps is more precise than a single printed step.
    single = steps[np.rint(steps / median) <= 1.0]
    counts = np.maximum(np.rint(steps / (single.mean() if single.size else median)), 1.0)
    if counts.sum() >= _SPARSE * time.size:
        _refuse(steps == steps.max(), lines, f"a gap of {steps.max():.4g} ms before this line")
    place = np.append(0, np.cumsum(counts.astype(int)))
    step = float(time[-1] - time[0]) / int(place[-1])
    if rate is not None and abs(step * rate - 1.0) > SAME_RATE:
        raise UnusableError(
            f"the times give {1.0 / step:.4g} kHz, but endurance.format.rate is {rate:.4g} kHz; "
            "correct the rate, or leave it out"
        )
    even = time[0] + step * np.arange(int(place[-1]) + 1)
    off = np.abs(time - even[place]) / step
    uneven = np.abs(steps / step - counts) > _UNEVEN
    uneven[off[1:].argmax()] |= off.max() > 2 * _UNEVEN
    _refuse(uneven, lines, f"times are uneven before this line, in steps of {step:.4g} ms else")
    even[place] = time
    remark = Remark("uneven", step=f"{step:.4g}", off=f"{step * off.max():.2g}")
    return even, place, remark if off.max() > _PRINTED else ""


def _refuse(wrong: np.ndarray, lines: np.ndarray, reason: str) -> None:
    """Reject wrong steps, ``(n - 1,)`` of bool, with the line after the first wrong step."""
    if wrong.any():
        raise UnusableError(reason, line=int(lines[int(wrong.argmax()) + 1]))


@dataclass(frozen=True)
class Scale:
    """Conversion of a reading to travel: by the mm towards closed of one unit, or by a table of
    readings and mm, ``(2, n)``, and its sign. ``zero`` is the reading of the open breaker, or 0 if
    each record determines it.
    """

    factor: float
    zero: float
    table: np.ndarray | None = None

    @classmethod
    def from_settings(cls, settings: Mapping) -> "Scale":
        """Build from ``endurance.format``; raise ValueError if its table is not valid."""
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
        with np.errstate(over="ignore"):  # checks remove values that are too large
            if self.table is None:
                return self.factor * (reading - self.zero)
        from scipy.interpolate import PchipInterpolator  # slow to import and rarely needed

        low, high = self.table[0, [0, -1]]
        margin = _FEW * (high - low)
        outside = (reading < low - margin) | (reading > high + margin)
        if outside.sum() > _FEW * np.isfinite(reading).sum():
            raise UnusableError(
                f"endurance.format.table goes from {low:.4g} to {high:.4g}, and readings do not"
            )
        return np.where(outside, np.inf, self.factor * PchipInterpolator(*self.table)(reading))


def _read_table(file: str | Path) -> np.ndarray:
    """Return increasing readings and mm, ``(2, n)``, of a CSV file with commas and points."""
    try:
        text = read_bytes(file).decode("utf-8-sig").strip()
        if "\n" not in text:
            raise ValueError("it has no two lines")
        named = not text.lstrip("+-.")[:1].isdigit()  # the first line has names of columns
        table = np.loadtxt(StringIO(text), delimiter=",", skiprows=int(named), ndmin=2, unpack=True)
        table = table[:, np.argsort(table[0], kind="stable")]
        rises = np.diff(table, axis=1)
        steady = (rises[0] > 0).all() and ((rises[1] > 0).all() or (rises[1] < 0).all())
        if not (table.shape[0] == 2 and rises.size and steady and np.isfinite(table).all()):
            raise ValueError("its mm do not rise, or fall, from reading to reading")
    except (RejectedCurveError, ValueError) as error:
        remedy = "write two lines or more of a reading and its mm, with a comma between"
        raise ValueError(f"endurance.format.table, {file}: {error}; {remedy}") from error
    return table


def seen_quantum(travel: np.ndarray) -> float:
    """Return the step to which a record ``(t,)`` is rounded, mm; 0 if the step is below the noise.

    If many neighbours are equal, the smaller differences of the others are multiples of the step.
    """
    steps = np.abs(np.diff(travel[np.isfinite(travel)]))
    tied = np.isclose(steps, 0.0, atol=1e-9 * steps.max(initial=0.0))
    if tied.sum() <= _FEW * steps.size or tied.all():
        return 0.0
    steps = np.sort(steps[~tied])
    counts = np.rint(steps / steps[steps.size // _SMALL])
    small = (counts > 0.0) & (counts <= _SMALL)
    steps, counts = steps[small], counts[small]
    quantum = float(np.median(steps / counts))
    return quantum if np.median(np.abs(steps / quantum - counts)) < _PRINTED else 0.0
