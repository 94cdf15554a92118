r"""Exact derivatives of travel curves by the logs of the parameters and by the onset.

They go through the same series as the curves, by the product rule (``tangents``). Where the state's
velocity changes from v to w, at an event whose time moves by ``dt``, the derivative of the state at
a fixed time jumps by ``(v - w) dt``:

- at the onset, from rest, ``dt`` is 1 by the onset and 0 by a parameter;
- at the touch, ``x_b = L`` gives ``dt = (dL - dx_b) / x_b'``. The drive's acceleration loses
  ``gamma_b x_b'``, so the derivative of its speed jumps by ``gamma_b (dL - dx_b)``, also where
  the contact only just arrives; the contact is at L from there;
- at the parting the contact force is zero, so that both modes accelerate alike and ``dt`` does not
  matter. But a contact that parts at once (``f <= k_a L``) parts with the onset.

Travel and speed of the drive are continuous at the onset and at the event, and so are these
derivatives in time: there is one at every sample. What jumps there are their own slopes, so that
differences over a step that carries an event across a sample are of first order only.

A touch by a maximum alone comes and goes with the parameters, and with it a part of the curve. The
derivatives are those of the side that the curve is on.
"""

import numpy as np
from numba import njit, prange

from breaker.mechanism.arguments import blocks, check, contiguous
from breaker.mechanism.curves import Motion, travel
from breaker.mechanism.modes import (
    REACH,
    compiled,
    equilibrium,
    make_buffers,
    mode_of,
    passed,
    propagate,
    rate_of,
    velocity_of,
)
from breaker.mechanism.modes import SOURCE as MODES
from breaker.mechanism.tangents import (
    GAP,
    LANES,
    advance_tangents,
    lane,
    make_tangents,
    propagate_tangents,
    set_equilibrium_tangents,
    set_lane,
    set_mode_tangents,
    tangent_coefficients,
    tangent_values,
)
from breaker.mechanism.tangents import SOURCE as TANGENTS

__all__ = ["sensitivity"]

_ROWS = 16  # of a thread at a time, in the same buffers


def sensitivity(
    theta: np.ndarray,
    times: np.ndarray,
    motion: str,
    *,
    onset: float | np.ndarray = 0.0,
) -> tuple[Motion, np.ndarray]:
    """Simulate operations with their derivatives.

    Arguments and errors are those of ``mechanism.travel``.

    Returns:
        What ``travel`` returns, and the derivatives of the travel, ``(n, t, p + 1)``: by the
        natural log of each parameter, mm, and last by the onset, mm/ms (minus the speed).
    """
    result = travel(theta, times, motion, onset=onset)
    theta, times, onset = check(theta, times, motion, onset)
    slopes = np.empty((*result.travel.shape, LANES))
    for rows in blocks(len(theta)):
        arrays = contiguous(theta[rows], times, onset[rows], result.switching[rows])
        _differentiate(*arrays, motion == "closing", slopes[rows])
    return result, slopes


# ---- one curve -------------------------------------------------------------------------------


@compiled
def _follow(theta, free, pull, state, start, stop, times, sample, out, buffers, slopes):
    """Fill the derivatives (t, 8) in one mode from ``start`` to ``stop``: a whole number of steps.

    Return the next sample and the state at ``stop``; the state's derivatives stay in ``slopes``.
    """
    steps = int(np.ceil((stop - start) * rate_of(theta, free) / (2 * REACH)))
    if steps == 0:
        return sample, state
    h, lanes = (stop - start) / (2 * steps), out.shape[1]
    mode, (x_a, x_b) = mode_of(theta, free), equilibrium(theta, free, pull)
    rows, half, whole, _, _, _, _ = buffers
    d_mode, d_rows, d_half, d_whole, series, rest, dy, moved = slopes
    set_mode_tangents(theta, free, d_mode)
    set_equilibrium_tangents(theta, free, pull, rest)
    propagate(mode, h, rows, half, whole)
    propagate_tangents(mode, h, rows, half, slopes, lanes)
    dy -= rest
    y = state[0] - x_a, state[1], state[2] - x_b, state[3]
    y = advance_tangents(half, d_half, y, dy, moved, lanes)
    for step in range(1, steps + 1):
        end = start + 2 * step * h if step < steps else stop
        first, sample = sample, passed(times, sample, end)
        tangent_coefficients(rows, d_rows, y, dy, series, lanes)
        middle = start + (2 * step - 1) * h
        tangent_values(series, rest, times, first, sample, middle, h, out, lanes)
        if step < steps:
            y = advance_tangents(whole, d_whole, y, dy, moved, lanes)
    y = advance_tangents(half, d_half, y, dy, moved, lanes)
    dy += rest
    return sample, (y[0] + x_a, y[1], y[2] + x_b, y[3])


@compiled
def _start(before, after, dx):
    """Change the derivatives by the onset where the velocity changes with the onset."""
    for s in range(4):
        dx[(s + 1) * LANES - 1] += before[s] - after[s]


@compiled
def _curve(theta, times, onset, closing, switching, out, buffers, slopes):
    """Fill the derivatives of one curve, (t, 8), whose switching time is known."""
    gamma_b, f, gap = theta[4], theta[5], theta[6]
    dx, still = slopes.state, (0.0, 0.0, 0.0, 0.0)
    pull, state = f, still
    dx[:] = 0.0
    if not closing:
        pull, state = 0.0, (equilibrium(theta, False, f)[0], 0.0, gap, 0.0)
        set_equilibrium_tangents(theta, False, f, dx)
    sample = passed(times, 0, onset)
    out[:sample] = dx[:LANES]

    _start(still, velocity_of(theta, closing, pull, state), dx)
    stop = min(onset + switching, times[-1])
    sample, state = _follow(
        theta, closing, pull, state, onset, stop, times, sample, out, buffers, slopes
    )
    if sample == times.size:
        return
    if closing:
        for j in range(LANES):
            x_a, v_a, x_b, _ = lane(dx, 0, j)
            d_gap = gap if j == GAP else 0.0
            set_lane(dx, 0, j, (x_a, v_a + gamma_b * (d_gap - x_b), d_gap, 0.0))
        state = (state[0], state[1], gap, 0.0)
    else:
        before = velocity_of(theta, False, pull, state)
        _start(before, velocity_of(theta, True, pull, state), dx)
    last, free = times[-1], not closing
    _follow(theta, free, pull, state, stop, last, times, sample, out, buffers, slopes)


def _made_of(*sources):
    @njit(cache=True, parallel=True, error_model="numpy")
    def differentiate(theta, times, onset, switching, closing, out):
        _ = sources  # see ``modes.checksum``
        n = theta.shape[0]
        for block in prange((n + _ROWS - 1) // _ROWS):
            buffers, slopes = make_buffers(), make_tangents()
            for i in range(block * _ROWS, min(n, (block + 1) * _ROWS)):
                _curve(theta[i], times, onset[i], closing, switching[i], out[i], buffers, slopes)

    return differentiate


_differentiate = _made_of(MODES, TANGENTS)
