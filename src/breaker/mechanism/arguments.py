"""What the mechanism is asked for: checked, and cut into blocks of rows.

What is needed beside the output is made block by block, so that it does not grow with the number
of operations.
"""

from collections.abc import Iterator

import numpy as np

from breaker.mechanism.modes import rate_of
from breaker.mechanism.parameters import MOTIONS, NAMES

__all__ = ["blocks", "check", "check_motion", "contiguous"]

_LONGEST = 1e6  # rate * length of a record: 280,000 intervals, some 10 ms a curve
_ROWS = 8192  # of a block: some 20 ms of simulation, and 10 MB of curves


def blocks(n: int) -> Iterator[slice]:
    """Cut ``n`` rows into blocks."""
    return (slice(first, min(n, first + _ROWS)) for first in range(0, n, _ROWS))


def contiguous(*arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return arrays as compiled code takes them; copies only of those that are not so already."""
    return tuple(np.ascontiguousarray(array, dtype=np.float64) for array in arrays)


def check_motion(motion: str) -> None:
    """Raise ``ValueError`` unless it is one of the two."""
    if motion not in MOTIONS:
        raise ValueError(f"unknown motion {motion!r}; it must be one of {', '.join(MOTIONS)}")


def check(
    theta: np.ndarray, times: np.ndarray, motion: str, onset: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the parameters ``(n, p)``, times ``(t,)`` and onsets ``(n,)`` of a simulation.

    Raises:
        ValueError: If a parameter is not finite or not positive (the message names the first),
            if a drive is too fast to follow to the end of the record, if a shape is wrong, if
            times do not increase or an onset is not finite.
    """
    theta, times, onset = np.asarray(theta), np.asarray(times, dtype=np.float64), np.asarray(onset)
    if theta.ndim != 2 or theta.shape[1] != len(NAMES):
        raise ValueError(f"parameters must have the shape (n, {len(NAMES)}), not {theta.shape}")
    _check_parameters(theta)
    check_motion(motion)
    if (
        times.ndim != 1
        or times.size == 0
        or not np.all(np.isfinite(times))
        or np.any(np.diff(times) <= 0)
    ):
        raise ValueError("times must be one finite, increasing row")
    onset = _checked_onsets(onset, len(theta))
    _check_rates(theta, times, onset)
    return theta, times, onset


def _check_parameters(theta: np.ndarray) -> None:
    count, first = 0, None
    for rows in blocks(len(theta)):
        (block,) = contiguous(theta[rows])
        bad = ~(np.isfinite(block) & (block > 0))
        if bad.any():
            count += bad.any(axis=1).sum()
            row, column = np.argwhere(bad)[0]
            first = first or (NAMES[column], block[row, column], rows.start + row)
    if first:
        name, value, row = first
        raise ValueError(
            f"{count} of {len(theta)} rows have a parameter that is not finite and positive; the "
            f"first is {name} = {value} in row {row}"
        )


def _checked_onsets(onset: np.ndarray, n: int) -> np.ndarray:
    if onset.shape in {(), (n,)}:
        onsets = np.broadcast_to(onset, n)
        if all(np.all(np.isfinite(onsets[rows])) for rows in blocks(n)):
            return onsets
    raise ValueError(f"onset must be one finite time or one per row, ({n},)")


def _check_rates(theta: np.ndarray, times: np.ndarray, onset: np.ndarray) -> None:
    for rows in blocks(len(theta)):
        block, start = contiguous(theta[rows], onset[rows])
        span = times[-1] - np.minimum(times[0], start)
        with np.errstate(over="ignore"):  # an infinite rate is too fast as well
            rates = rate_of.py_func(block.T, True)
            row = int(np.argmax(rates * span))
            too_fast = rates[row] * span[row] > _LONGEST
        if too_fast:
            raise ValueError(
                f"the drive of row {rows.start + row} is too fast to follow over {span[row]:g} ms: "
                f"its rate is {rates[row]:.3g} / ms, from "
                f"{dict(zip(NAMES, block[row].tolist(), strict=True))}"
            )
