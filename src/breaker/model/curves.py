"""Exact travel curves of the two-mass, two-spring drive of a breaker, and their derivatives.

Paper, Sec. 3. With units mm and ms, and ``x_a`` the drive, ``x_b`` the moving contact:

- *free* contact, Eq. (3):
  ``x_a'' = -k_a x_a + k_b (x_b - x_a) - gamma_a x_a' + gamma_b (x_b' - x_a') + f``,
  ``x_b'' = -mu k_b (x_b - x_a) - mu gamma_b (x_b' - x_a')``;
- *closed* contact, Eq. (4): the same for ``x_a`` with ``x_b = L`` and ``x_b' = 0``.

Three slips of the print are corrected. Eq. (5) says ``mu = M_b/M_a``, but (3) follows from (1)
only with ``mu = M_a/M_b``. Eq. (7) labels the closed state "open"; it is
``x_a = (f + k_b L) / (k_a + k_b)``, ``x_b = L``. And ``f`` is zero while opening, but opening
starts from the closed state that ``f`` had held.

*Closing* starts at rest at (0, 0) with ``f``; the contact touches when ``x_b`` first reaches
``L``, fully inelastically. *Opening* starts at rest in the closed state without ``f``; the contact
parts when its force ``k_b (x_a - L) + gamma_b x_a'`` falls to zero. One transition a motion.

Each mode is linear, so its solution is the Taylor series of the matrix exponential (``kernels``),
summed to round-off in intervals short against the fastest rate. There is no step error, and the
result does not depend on the grid of the samples. The cost grows with the rate.

- Contact never reached by the last sample: the switching time is ``inf``.
- Contact force not positive at the start of an opening (``f <= k_a L``, outside the prior's
  support): the contact parts at once, at 0.
- Contact force falling to zero again after a touch: flagged as ``reopening``, not modelled.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from breaker.model.equations import closed_rest, fastest_rate
from breaker.model.kernels import simulate
from breaker.model.parameters import MOTIONS, NAMES

_LONGEST = 1e6  # rate * length of a record: 280,000 intervals, some 10 ms a curve
_ROWS = 8192  # of a block: some 20 ms of simulation, and 10 MB of curves
_STEP = 1e-5  # of a derivative: errors of order and of rounding are then alike


class Motion(NamedTuple):
    """Exact curves of ``n`` operations.

    Attributes:
        travel: Position of the drive, ``(n, t)``, mm.
        switching: Time of touch or parting after the start of the motion, ``(n,)``, ms; ``inf``
            if not by the last sample.
        reopening: Whether the contact force fell to zero again after the touch, ``(n,)``; never
            in an opening.
    """

    travel: np.ndarray
    switching: np.ndarray
    reopening: np.ndarray


def travel(
    theta: np.ndarray, times: np.ndarray, motion: str, *, onset: float | np.ndarray = 0.0
) -> Motion:
    """Simulate operations exactly.

    Args:
        theta: Parameters, ``(n, p)``, in the order of ``parameters.NAMES``.
        times: Times of the samples, ``(t,)``, ms, increasing.
        motion: "closing" or "opening".
        onset: Start of the motion, ms, one for all or ``(n,)``. Before it the drive rests.

    Raises:
        ValueError: If a parameter is not finite or not positive (the message names the first),
            if a drive is too fast to follow to the end of the record, if a shape is wrong, if
            times do not increase or an onset is not finite.

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> curves = travel(theta, np.array([0.0, 10.0, 20.0, 60.0]), "closing")
        >>> curves.travel.round(2)
        array([[ 0.  , 11.05, 14.  , 13.53]])
        >>> curves.switching.round(2)
        array([10.09])
    """
    return _curves(*check(theta, times, motion, onset), motion)


def _empty(n: int, t: int) -> Motion:
    return Motion(np.empty((n, t)), np.empty(n), np.empty(n, dtype=np.bool_))


def _curves(theta: np.ndarray, times: np.ndarray, onset: np.ndarray, motion: str) -> Motion:
    result = _empty(len(theta), times.size)
    for rows in blocks(len(theta)):
        simulate(
            *_of_block(theta[rows], times, onset[rows]),
            motion == "closing",
            *(each[rows] for each in result),
        )
    return result


def sensitivity(
    theta: np.ndarray,
    times: np.ndarray,
    motion: str,
    *,
    onset: float | np.ndarray = 0.0,
    by: slice = slice(None),
) -> tuple[Motion, np.ndarray]:
    """Simulate operations with derivatives of their curves, central differences of step 1e-5.

    Derivatives over the prior are right to 1e-7 mm, except where an event passes a sample, or a
    touch comes or goes, within the step.

    Args:
        theta, times, motion, onset: As of ``travel``, with its errors.
        by: Which derivatives, of the seven parameters and the onset; all of them unless given.

    Returns:
        What ``travel`` returns, and the derivatives of the travel, ``(n, t, p + 1)``: by the
        natural log of each parameter, mm, and last by the onset, mm/ms (minus the speed).

    Example:
        >>> theta = np.array([[2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]])
        >>> curves, slopes = sensitivity(theta, np.array([10.0, 60.0]), "closing")
        >>> np.allclose(slopes[..., 5] + slopes[..., 6], curves.travel)  # f and L scale lengths
        True
    """
    theta, times, onset = check(theta, times, motion, onset)
    p, n = len(NAMES), len(theta)
    ahead = np.eye(p + 1)[by] * _STEP
    k, steps = len(ahead), np.concatenate([ahead, -ahead, np.zeros((1, p + 1))])
    result, slopes = _empty(n, times.size), np.empty((n, k, times.size))
    for rows in blocks(n, len(steps)):
        moved = np.asarray(theta[rows], np.float64)[:, None] * np.exp(steps[:, :p])
        onsets = onset[rows, None] + steps[:, p]
        found = _curves(moved.reshape(-1, p), times, onsets.ravel(), motion)
        for whole, part in zip(result, found, strict=True):
            whole[rows] = part[2 * k :: len(steps)]
        curves = found.travel.reshape(-1, len(steps), times.size)
        slopes[rows] = (curves[:, :k] - curves[:, k : 2 * k]) / (2 * _STEP)
    return result, np.moveaxis(slopes, 1, 2)


def rest_position(theta: np.ndarray, motion: str) -> np.ndarray:
    """Return where the drive rests before a motion, ``(..., p) -> (...)``, mm (Eqs. 6 and 7)."""
    _check_motion(motion)
    closed = closed_rest(np.asarray(theta, dtype=np.float64))
    return np.zeros_like(closed) if motion == "closing" else closed


# ---- checks and blocks -----------------------------------------------------------------------


def blocks(n: int, curves: int = 1) -> Iterator[slice]:
    """Cut ``n`` rows, each of so many curves, into blocks."""
    rows = max(1, _ROWS // curves)
    return (slice(first, min(n, first + rows)) for first in range(0, n, rows))


def _of_block(theta: np.ndarray, times: np.ndarray, onset: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return what compiled code takes of a block; no array of it outlives the block."""
    theta = np.asarray(theta, np.float64)
    rates = np.stack([fastest_rate(theta, free=free) for free in (False, True)], axis=-1)
    return _contiguous(theta, rates, times, onset)


def _contiguous(*arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return arrays as compiled code takes them: writable, as numba would compile read-only ones
    anew.
    """
    return tuple(np.require(array, np.float64, ["C", "W"]) for array in arrays)


def _check_motion(motion: str) -> None:
    if motion not in MOTIONS:
        raise ValueError(f"unknown motion {motion!r}; it must be one of {', '.join(MOTIONS)}")


def check(
    theta: np.ndarray, times: np.ndarray, motion: str, onset: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the parameters ``(n, p)``, times ``(t,)`` and onsets ``(n,)`` of a simulation; raise
    what ``travel`` raises.
    """
    theta, times, onset = np.asarray(theta), np.asarray(times, dtype=np.float64), np.asarray(onset)
    if theta.ndim != 2 or theta.shape[1] != len(NAMES):
        raise ValueError(f"parameters must have the shape (n, {len(NAMES)}), not {theta.shape}")
    _check_parameters(theta)
    _check_motion(motion)
    is_row = times.ndim == 1 and times.size > 0 and np.isfinite(times).all()
    if not is_row or np.any(np.diff(times) <= 0):
        raise ValueError("times must be one finite, increasing row")
    n = len(theta)
    known = np.broadcast_to(onset if onset.shape in {(), (n,)} else np.nan, n)
    if not np.isfinite(known).all():
        raise ValueError(f"onset must be one finite time or one per row, ({n},)")
    _check_rates(theta, times, known)
    return theta, times, known


def _check_parameters(theta: np.ndarray) -> None:
    bad = ~(np.isfinite(theta) & (theta > 0))
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise ValueError(
            f"{bad.any(axis=1).sum()} of {len(theta)} rows have a parameter that is not finite and "
            f"positive; the first is {NAMES[column]} = {theta[row, column]} in row {row}"
        )


def too_fast(theta: np.ndarray, times: np.ndarray, onset: float | np.ndarray = 0.0) -> np.ndarray:
    """Say which drives are too fast to follow to the end of a record, ``(..., p) -> (...)``.

    Times ``(t,)`` are those of the samples, ms; the onset is one for all or ``(...)``.
    """
    return _intervals(theta, times, onset) > _LONGEST


def _intervals(theta: np.ndarray, times: np.ndarray, onset: float | np.ndarray) -> np.ndarray:
    return fastest_rate(theta) * (times[-1] - np.minimum(times[0], onset))


def _check_rates(theta: np.ndarray, times: np.ndarray, onset: np.ndarray) -> None:
    if not len(theta):
        return
    theta = np.asarray(theta, np.float64)
    row = int(np.argmax(_intervals(theta, times, onset)))
    if too_fast(theta[row], times, onset[row]):
        raise ValueError(
            f"the drive of row {row} is too fast to follow over "
            f"{times[-1] - min(times[0], onset[row]):g} ms: its rate is "
            f"{fastest_rate(theta[row]):.3g} / ms, from "
            f"{dict(zip(NAMES, theta[row].tolist(), strict=True))}"
        )
