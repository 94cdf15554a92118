r"""Exact travel curves of the two-mass, two-spring drive of a breaker.

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

Method. Each mode is linear with constant coefficients, so its solution is the Taylor series of
the matrix exponential (``modes``). The record is cut into intervals short against the fastest rate,
the series is summed to round-off in each, and every sample and event inside is a value or a root of
the same polynomial: there is no step error, and the result does not depend on the grid of the
samples. In the stiff limit (large ``k_b``) nothing fails; the cost grows with the rate.

Answers at the edges:

- An event exactly at a sample: both modes give the same position there.
- Contact never reached by the last sample: the switching time is ``inf``.
- Contact force not positive at the start of an opening (``f <= k_a L``, outside the prior's
  support): the contact parts at once, at 0.
- Contact force falling to zero again after a touch: flagged as ``reopening``, not modelled.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from breaker.mechanism.arguments import blocks, check, check_motion, contiguous
from breaker.mechanism.modes import (
    REACH,
    SOURCE,
    coefficients,
    compiled,
    equilibrium,
    first_zero,
    make_buffers,
    mode_of,
    passed,
    propagate,
    rate_of,
    times_matrix,
    value_and_slope,
    values,
)
from breaker.mechanism.parameters import split

__all__ = ["Motion", "rest_position", "travel"]

_ROWS = 64  # of a thread at a time, in the same buffers


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
    theta: np.ndarray,
    times: np.ndarray,
    motion: str,
    *,
    onset: float | np.ndarray = 0.0,
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
    """
    theta, times, onset = check(theta, times, motion, onset)
    n = len(theta)
    result = Motion(np.empty((n, times.size)), np.empty(n), np.empty(n, dtype=np.bool_))
    for rows in blocks(n):
        _simulate(
            *contiguous(theta[rows], times, onset[rows]),
            motion == "closing",
            *(each[rows] for each in result),
        )
    return result


def rest_position(theta: np.ndarray, motion: str) -> np.ndarray:
    """Return where the drive rests before a motion, ``(..., p) -> (...)``, mm (Eqs. 6 and 7)."""
    check_motion(motion)
    _, k_a, k_b, _, _, f, gap = split(np.asarray(theta, dtype=np.float64))
    return np.zeros_like(f) if motion == "closing" else (f + k_b * gap) / (k_a + k_b)


# ---- one curve -------------------------------------------------------------------------------
# A mode is left when its margin falls to zero: four numbers, (w, w0) of w . (x_a, x_a', x_b) + w0.


@compiled
def _watch(margin, h, rows):
    """Fill the rows of a margin from those of x_a and x_b."""
    terms = rows.shape[2]
    for s in range(4):
        for k in range(terms):
            rows[2, s, k] = margin[0] * rows[0, s, k] + margin[2] * rows[1, s, k]
        for k in range(terms - 1):
            rows[2, s, k] += margin[1] / h * (k + 1) * rows[0, s, k + 1]


@compiled
def _stays_positive(mode, margin, offset, y):
    """Whether the force of a closed contact can fall to zero no more.

    ``m0 x_a^2 + x_a'^2`` of the deviation never grows, and bounds how far the force can be from
    ``offset``, its value at rest.
    """
    reach = (margin[0] ** 2 / mode[0] + margin[1] ** 2) * (mode[0] * y[0] ** 2 + y[1] ** 2)
    return mode[4] == 0 and offset > 0 and reach < offset**2


@compiled
def _follow(theta, free, pull, state, start, margin, ends, times, sample, travel, row, buffers):
    """Fill the curve in one mode, from the state at ``start`` until the margin is not positive.

    A margin that ends nothing (``ends``) is only watched; one without weights is not. Return the
    next sample, the time of the margin's zero (inf if not by the last sample), and x_a and x_a'
    at the end of the mode.
    """
    mode, h = mode_of(theta, free), REACH / rate_of(theta, free)
    x_a, x_b = equilibrium(theta, free, pull)
    rows, half, whole, position, margins, slope, nodes = buffers
    propagate(mode, h, rows, half, whole)
    _watch(margin, h, rows)
    offset = margin[3] + margin[0] * x_a + margin[2] * x_b
    watching = margin[0] != 0 or margin[2] != 0
    y = times_matrix(half, (state[0] - x_a, state[1], state[2] - x_b, state[3]))
    zero = u = np.inf
    interval = 0
    while sample < times.size:
        begin, stop = start + 2 * interval * h, start + 2 * (interval + 1) * h
        if watching:
            coefficients(rows, 2, y, margins)
            margins[0] += offset
            u = first_zero(margins, slope, nodes)
            if begin + (1 + u) * h <= times[-1]:
                watching, zero = False, begin + (1 + u) * h
            elif _stays_positive(mode, margin, offset, y):
                watching = False
        ended = ends and zero < np.inf
        coefficients(rows, 0, y, position)
        position[0] += x_a
        first, sample = sample, passed(times, sample, zero if ended else stop)
        # Whole vectors of eight: what is too many, the next interval fills again.
        filled = min(times.size, first + (sample - first + 7) // 8 * 8)
        values(position, times, first, filled, begin + h, h, travel, row)
        if ended:
            x_a, v_a = value_and_slope(position, u)
            return sample, zero, x_a, v_a / h
        y = times_matrix(whole, y)
        interval += 1
    return sample, zero, np.nan, np.nan


@compiled
def _curve(theta, times, onset, closing, travel, row, buffers):
    """Fill one curve (t,); return its switching time and reopening flag."""
    _, _, k_b, _, gamma_b, f, gap = theta
    distance, force = (0.0, 0.0, -1.0, gap), (k_b, gamma_b, 0.0, -k_b * gap)
    if closing:
        pull, state, margin, later = f, (0.0, 0.0, 0.0, 0.0), distance, force
    else:
        held = equilibrium(theta, False, f)[0]
        pull, state, margin, later = 0.0, (held, 0.0, gap, 0.0), force, (0.0, 0.0, 0.0, 0.0)
    sample = passed(times, 0, onset)
    travel[row, :sample] = state[0]
    sample, switching, x_a, v_a = _follow(
        theta, closing, pull, state, onset, margin, True, times, sample, travel, row, buffers
    )
    again = np.inf
    if sample < times.size:  # the contact stops dead at the gap, or leaves it from rest
        state = (x_a, v_a, gap, 0.0)
        start, free = switching, not closing
        _, again, _, _ = _follow(
            theta, free, pull, state, start, later, False, times, sample, travel, row, buffers
        )
    return switching - onset, again < np.inf


def _made_of(source):
    @njit(cache=True, parallel=True, error_model="numpy")
    def simulate(theta, times, onset, closing, travel, switching, reopening):
        _ = source  # see ``modes.checksum``
        n = theta.shape[0]
        for block in prange((n + _ROWS - 1) // _ROWS):
            buffers = make_buffers()
            for i in range(block * _ROWS, min(n, (block + 1) * _ROWS)):
                switching[i], reopening[i] = _curve(
                    theta[i], times, onset[i], closing, travel, i, buffers
                )

    return simulate


_simulate = _made_of(SOURCE)
