"""Convert the two axes of a record: times to even steps in ms, readings to mm towards closed.

An instrument samples at an even rate. Printed times are uneven by their last digit, and skip
samples that were not stored, by an integer number of steps. Records with other times are rejected.

A length needs only its unit; degrees, volts or counts need ``ratio``, the mm of one of them.
"""

from collections.abc import Mapping

import numpy as np

from breaker.records.rejections import Remark, UnusableError
from breaker.records.settings import READABLE, SAME_RATE, TO_MM, TO_MS

_UNEVEN = 0.25  # steps, largest deviation of a step from an integer number of steps
_PRINTED = 0.1  # steps, largest deviation of times and readings that are printed with enough digits
_SPARSE = 10  # largest ratio of places to samples; bounds the memory for missing samples
_FEW = 0.05  # share of equal neighbours that noise explains
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


def travel_of(reading: np.ndarray, settings: Mapping) -> np.ndarray:
    """Return travel towards closed for readings, ``(t,) -> (t,)``, mm; NaN where missing. With
    ``zero: rest``, the record determines its zero later.

    Args:
        settings: The section ``endurance.format``, complete.
    """
    factor = TO_MM[settings["travel_unit"]] if settings["ratio"] is None else settings["ratio"]
    zero = 0.0 if settings["zero"] == "rest" else settings["zero"]
    with np.errstate(over="ignore"):  # checks remove values that are too large
        return settings["sign"] * factor * (reading - zero)


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
