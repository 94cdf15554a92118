"""Exact travel curves of the drive, and their derivatives by the parameters.

The paper (Sec. 3, see ``equations``) integrates the equations with a standard solver. Here each
linear mode is solved by the Taylor series of its matrix exponential. ``kernels`` sums the series to
round-off in intervals that are short relative to the fastest rate. There is no step error, the
result does not depend on the grid of the samples, and the cost grows with the rate.

- If the contact does not touch or separate by the last sample, the switching time is ``inf``.
- If the contact is not pressed at the start of an opening (``f <= k_a L``, outside the support of
  the prior), it separates at time 0.
- If the contact force falls to zero again after the touch (0.3 % of the prior), the contact stays
  closed: the second separation is not modelled.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from breaker.model.equations import fastest_rate
from breaker.model.kernels import simulate
from breaker.model.parameters import MOTIONS, NAMES

_LONGEST = 1e6  # rate * length of a record; limits a curve to 280,000 intervals, some 10 ms
_ROWS = 8192  # curves in a block; limits a block to some 20 ms of simulation and 10 MB
_STEP = 1e-5  # of central differences: truncation error and rounding error are about equal


class Motion(NamedTuple):
    """Exact curves of ``n`` motions.

    Attributes:
        travel: Position of the drive, ``(n, t)``, mm.
        switching: Time from the start of motion to the contact event, ``(n,)``, ms; or ``inf``.
    """

    travel: np.ndarray
    switching: np.ndarray


def travel(
    theta: np.ndarray, times: np.ndarray, motion: str, *, onset: float | np.ndarray = 0.0
) -> Motion:
    """Simulate motions exactly.

    Args:
        theta: Parameters, ``(n, p)``, in the order of ``parameters.NAMES``.
        times: Times of the samples, ``(t,)``, ms, increasing.
        motion: "closing" or "opening".
        onset: Start of motion, ms, one for all or ``(n,)``. The drive rests until then.

    Raises:
        ValueError: If a parameter is not finite and positive, a drive is too fast to simulate to
            the end of the record, a shape is wrong, times do not increase, or an onset is not
            finite.

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> curves = travel(theta, np.array([0.0, 10.0, 20.0, 60.0]), "closing")
        >>> curves.travel.round(2)
        array([[ 0.  , 11.05, 14.  , 13.53]])
        >>> curves.switching.round(2)
        array([10.09])
    """
    return _curves(*check(theta, times, motion, onset), motion)


def sensitivity(
    theta: np.ndarray,
    times: np.ndarray,
    motion: str,
    *,
    onset: float | np.ndarray = 0.0,
) -> tuple[Motion, np.ndarray]:
    """Simulate motions, with derivatives of their curves by central differences.

    Over the prior the error is below 1e-7 mm, except where a contact event crosses a sample, or
    appears or disappears, within the step.

    Args:
        theta, times, motion, onset: As in ``travel``, with its errors.

    Returns:
        The result of ``travel``, and the derivatives of the travel, ``(n, t, p + 1)``: by the
        natural logarithm of each parameter, mm, and last by the onset, mm/ms (minus the speed).

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> curves, slopes = sensitivity(theta, np.array([10.0, 60.0]), "closing")
        >>> np.allclose(slopes[..., 5] + slopes[..., 6], curves.travel)  # f and L scale lengths
        True
    """
    theta, times, onset = check(theta, times, motion, onset)
    p, n, k = len(NAMES), len(theta), len(NAMES) + 1
    ahead = np.eye(k) * _STEP
    steps = np.concatenate([ahead, -ahead, np.zeros((1, k))])
    result, slopes = _empty(n, times.size), np.empty((n, k, times.size))
    for rows in blocks(n, len(steps)):
        moved = np.asarray(theta[rows], np.float64)[:, None] * np.exp(steps[:, :p])
        onsets = onset[rows, None] + steps[:, p]
        flat = _curves(np.concatenate(moved), times, onsets.ravel(), motion)
        for target, part in zip(result, flat, strict=True):
            target[rows] = part[2 * k :: len(steps)]
        curves = flat.travel.reshape(len(moved), len(steps), times.size)
        slopes[rows] = (curves[:, :k] - curves[:, k : 2 * k]) / (2 * _STEP)
    return result, np.moveaxis(slopes, 1, 2)


# ---- blocks ----------------------------------------------------------------------------------


def blocks(n: int, curves: int = 1) -> Iterator[slice]:
    """Split ``n`` rows, with ``curves`` curves each, into blocks."""
    rows = _ROWS // curves
    return (slice(first, min(n, first + rows)) for first in range(0, n, rows))


def _curves(theta: np.ndarray, times: np.ndarray, onset: np.ndarray, motion: str) -> Motion:
    result = _empty(len(theta), times.size)
    for rows in blocks(len(theta)):
        given = _of_block(theta[rows], times, onset[rows])
        simulate(*given, motion == "closing", *(array[rows] for array in result))
        del given  # keeps only one block in memory
    return result


def _of_block(theta: np.ndarray, *others: np.ndarray) -> list[np.ndarray]:
    """Return parameters, rates and other arrays in the form that compiled code needs.

    They are writable and contiguous, because numba compiles again for other arrays.
    """
    theta = np.asarray(theta, np.float64)
    rates = np.column_stack([fastest_rate(theta, free=free) for free in (False, True)])
    return [np.require(array, np.float64, ["C", "W"]) for array in (theta, rates, *others)]


def _empty(n: int, t: int) -> Motion:
    return Motion(np.empty((n, t)), np.empty(n))


# ---- checks ----------------------------------------------------------------------------------


def check(
    theta: np.ndarray, times: np.ndarray, motion: str, onset: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the checked parameters ``(n, p)``, times ``(t,)`` and onsets ``(n,)`` of a simulation;
    raise the errors of ``travel``.
    """
    theta, times, onset = np.asarray(theta), np.asarray(times, dtype=np.float64), np.asarray(onset)
    if theta.ndim != 2 or theta.shape[1] != len(NAMES):
        raise ValueError(f"parameters must have the shape (n, {len(NAMES)}), not {theta.shape}")
    bad = ~(np.isfinite(theta) & (theta > 0))
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise ValueError(
            f"{bad.any(axis=1).sum()} of {len(theta)} rows have a parameter that is not finite and "
            f"positive; the first is {NAMES[column]} = {theta[row, column]} in row {row}"
        )
    if motion not in MOTIONS:
        raise ValueError(f"unknown motion {motion!r}; it must be one of {', '.join(MOTIONS)}")
    is_row = times.ndim == 1 and times.size > 0 and np.isfinite(times).all()
    if not is_row or np.any(np.diff(times) <= 0):
        raise ValueError("times must be one finite, increasing row")
    n = len(theta)
    onset = np.broadcast_to(onset if onset.shape in {(), (n,)} else np.nan, n)
    if not np.isfinite(onset).all():
        raise ValueError(f"onset must be one finite time or one per row, ({n},)")
    fast = too_fast(theta, times, onset)
    if fast.any():
        row = int(np.argmax(fast))
        raise ValueError(
            f"the drive of row {row} is too fast to follow to the end of the record: its rate is "
            f"{fastest_rate(theta[row]):.3g} / ms, from "
            f"{dict(zip(NAMES, theta[row].tolist(), strict=True))}"
        )
    return theta, times, onset


def too_fast(theta: np.ndarray, times: np.ndarray, onset: float | np.ndarray = 0.0) -> np.ndarray:
    """Return which drives are too fast to simulate at ``times`` (t,), ``(..., p) -> (...)``."""
    return fastest_rate(theta) * (times[-1] - np.minimum(times[0], onset)) > _LONGEST
