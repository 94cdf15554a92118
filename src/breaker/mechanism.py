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
the matrix exponential. The record is cut into intervals short against the fastest rate, the
series is summed to round-off once an interval, and every sample and event inside is a value or a
root of the same polynomial: there is no step error, and the result does not depend on the grid of
the samples. Intervals are bounded by ``rate * length <= 4``, with
``rate = sqrt(k_a + k_b (1 + mu)) + gamma_a + gamma_b (1 + mu)``, a bound of the norm of the
system in coordinates scaled by mass. In the stiff limit (large ``k_b``) nothing fails; the cost
grows with the rate.

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

from breaker.parameters import MOTIONS, NAMES, split

__all__ = ["Motion", "rest_position", "travel"]

_ORDER = 33  # 4^34 / 34! = 1e-18: below round-off with the bound on the intervals
_REACH = 4.0  # rate * length of an interval
_PIECES = 8  # of an interval, each short enough for at most one turn of a margin
_LONGEST = 1e6  # rate * length of a record: 250,000 intervals, about a second a curve


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
            if a drive is too fast to follow over the record, if a shape is wrong, if times do not
            increase or an onset is not finite.
    """
    theta = _checked_parameters(theta)
    _check_motion(motion)
    times = np.ascontiguousarray(times, dtype=np.float64)
    if (
        times.ndim != 1
        or times.size == 0
        or not np.all(np.isfinite(times))
        or np.any(np.diff(times) <= 0)
    ):
        raise ValueError("times must be one finite, increasing row")
    _check_rates(theta, times[-1] - times[0])
    onset = np.asarray(onset, dtype=np.float64)
    if onset.shape not in {(), theta.shape[:1]} or not np.all(np.isfinite(onset)):
        raise ValueError(f"onset must be one finite time or one per row, ({len(theta)},)")
    onset = np.ascontiguousarray(np.broadcast_to(onset, theta.shape[:1]))

    result = Motion(
        travel=np.empty((len(theta), len(times))),
        switching=np.empty(len(theta)),
        reopening=np.empty(len(theta), dtype=np.bool_),
    )
    _simulate(theta, times, onset, motion == "closing", *result)
    return result


def rest_position(theta: np.ndarray, motion: str) -> np.ndarray:
    """Return where the drive rests before a motion, ``(..., p) -> (...)``, mm (Eqs. 6 and 7)."""
    _check_motion(motion)
    _, k_a, k_b, _, _, f, gap = split(np.asarray(theta, dtype=np.float64))
    return np.zeros_like(f) if motion == "closing" else (f + k_b * gap) / (k_a + k_b)


def _check_motion(motion: str) -> None:
    if motion not in MOTIONS:
        raise ValueError(f"unknown motion {motion!r}; it must be one of {', '.join(MOTIONS)}")


def _check_rates(theta: np.ndarray, span: float) -> None:
    rates = _rate(theta.T)
    if np.any(rates * span > _LONGEST):
        row = int(rates.argmax())
        raise ValueError(
            f"the drive of row {row} is too fast to follow over {span:g} ms: its rate is "
            f"{rates[row]:.3g} / ms, from {dict(zip(NAMES, theta[row].tolist(), strict=True))}"
        )


def _checked_parameters(theta: np.ndarray) -> np.ndarray:
    theta = np.ascontiguousarray(theta, dtype=np.float64)
    if theta.ndim != 2 or theta.shape[1] != len(NAMES):
        raise ValueError(f"parameters must have the shape (n, {len(NAMES)}), not {theta.shape}")
    bad = ~(np.isfinite(theta) & (theta > 0))
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise ValueError(
            f"{bad.any(axis=1).sum()} of {len(theta)} rows have a parameter that is not finite "
            f"and positive; the first is {NAMES[column]} = {theta[row, column]} in row {row}"
        )
    return theta


# One curve. A mode is a row of six coefficients and an equilibrium, from which deviations are
# measured: x_a'' = -m0 x_a - m1 x_a' + m2 x_b + m3 x_b' and
# x_b'' = m4 (x_a - x_b) + m5 (x_a' - x_b').
# It is left when its margin w . (x_a, x_a', x_b) + w0 falls to zero.


@njit(cache=True)
def _rate(theta):
    """Bound of a drive's fastest rate, 1/ms, from parameters (p,) or (p, n)."""
    mu, k_a, k_b, gamma_a, gamma_b = theta[0], theta[1], theta[2], theta[3], theta[4]
    return np.sqrt(k_a + k_b * (1 + mu)) + gamma_a + gamma_b * (1 + mu)


@njit(cache=True)
def _series(mode, state, length, series):
    """Fill ``series`` (4, order + 1) with the solution's coefficients in time / length."""
    for i in range(4):
        series[i, 0] = state[i]
    for k in range(_ORDER):
        step = length / (k + 1)
        x_a, v_a, x_b, v_b = series[0, k], series[1, k], series[2, k], series[3, k]
        series[0, k + 1] = step * v_a
        series[1, k + 1] = step * (mode[2] * x_b + mode[3] * v_b - mode[0] * x_a - mode[1] * v_a)
        series[2, k + 1] = step * v_b
        series[3, k + 1] = step * (mode[4] * (x_a - x_b) + mode[5] * (v_a - v_b))


@njit(cache=True)
def _value(coefficients, u):
    total = coefficients[-1]
    for k in range(coefficients.size - 2, -1, -1):
        total = total * u + coefficients[k]
    return total


@njit(cache=True)
def _values(coefficients, u, values):
    """Fill the values at several ``u``: the inner loop runs over them, so that it vectorises."""
    values[:] = coefficients[-1]
    for k in range(coefficients.size - 2, -1, -1):
        for i in range(u.size):
            values[i] = values[i] * u[i] + coefficients[k]


@njit(cache=True)
def _derivative(coefficients):
    derivative = np.empty(coefficients.size - 1)
    for k in range(derivative.size):
        derivative[k] = (k + 1) * coefficients[k + 1]
    return derivative


@njit(cache=True)
def _root(coefficients, low, high):
    """Root of a polynomial that is positive at just one end: Newton's steps, kept in a bracket."""
    derivative = _derivative(coefficients)
    falling = _value(coefficients, high) <= 0
    u = 0.5 * (low + high)
    for _ in range(100):
        value = _value(coefficients, u)
        if (value > 0) == falling:
            low = u
        else:
            high = u
        slope = _value(derivative, u)
        step = value / slope if slope != 0 else np.inf
        if abs(step) < 1e-15:
            break
        u = u - step if low < u - step < high else 0.5 * (low + high)
        if high - low < 1e-15:
            break
    return u


@njit(cache=True)
def _first_zero(margin):
    """First u in [0, 1] at which a margin is no longer positive, or inf.

    Between two nodes the margin may dip below zero and return: then it has a minimum there.
    """
    if margin[0] <= 0:
        return 0.0
    if np.abs(margin[1:]).sum() < margin[0]:
        return np.inf
    slope = _derivative(margin)
    low, slope_low = 0.0, margin[1]
    for k in range(1, _PIECES + 1):
        high = k / _PIECES
        if _value(margin, high) <= 0:
            return _root(margin, low, high)
        slope_high = _value(slope, high)
        if slope_low < 0 and slope_high > 0:
            lowest = _root(slope, low, high)
            if _value(margin, lowest) <= 0:
                return _root(margin, low, lowest)
        low, slope_low = high, slope_high
    return np.inf


@njit(cache=True)
def _curve(theta, times, onset, closing, travel):
    """Fill one curve (t,); return its switching time and reopening flag."""
    mu, k_a, k_b, gamma_a, gamma_b, f, gap = theta
    held = (f + k_b * gap) / (k_a + k_b)
    free = np.array([k_a + k_b, gamma_a + gamma_b, k_b, gamma_b, mu * k_b, mu * gamma_b])
    closed = np.array([k_a + k_b, gamma_a + gamma_b, 0.0, 0.0, 0.0, 0.0])
    rate = _rate(theta)

    # Equilibria of drive and contact, the margin's weights, and the state as deviations.
    force = np.array([k_b, gamma_b, 0.0])
    if closing:
        mode, centre_a, centre_b, weights = free, f / k_a, f / k_a, np.array([0.0, 0.0, -1.0])
        rest, state = 0.0, np.array([-centre_a, 0.0, -centre_b, 0.0])
        constant = gap - centre_b
    else:
        mode, centre_a, centre_b, weights = closed, k_b * gap / (k_a + k_b), gap, force
        rest, state = held, np.array([held - centre_a, 0.0, 0.0, 0.0])
        constant = k_b * (centre_a - gap)

    switching, reopening, switched = np.inf, False, False
    series, margin = np.empty((4, _ORDER + 1)), np.empty(_ORDER + 1)
    now, sample, last = onset, 0, times[-1]
    while sample < times.size and times[sample] <= onset:
        travel[sample] = rest
        sample += 1
    while sample < times.size:
        length = min(_REACH / rate, last - now)
        _series(mode, state, length, series)
        end, leave = 1.0, np.inf
        if not switched or (closing and not reopening):
            for k in range(_ORDER + 1):
                margin[k] = (
                    weights[0] * series[0, k]
                    + weights[1] * series[1, k]
                    + weights[2] * series[2, k]
                )
            margin[0] += constant
            leave = _first_zero(margin)
        if leave <= 1.0 and not switched:
            end = leave
        stop = last if now + end * length >= last else now + end * length
        first = sample
        while sample < times.size and times[sample] <= stop:
            sample += 1
        _values(series[0], (times[first:sample] - now) / length, travel[first:sample])
        travel[first:sample] += centre_a
        for i in range(4):
            state[i] = _value(series[i], end)
        now = stop
        if leave <= 1.0 and switched:
            reopening = True
        elif leave <= 1.0:
            switched, switching = True, now - onset
            position = centre_a + state[0]
            if closing:  # the contact stops dead at the gap
                mode, centre_a, weights = closed, held, force
                constant = k_b * (centre_a - gap)
                state[2] = state[3] = 0.0
            else:  # the contact leaves from rest at the gap
                mode, centre_a = free, 0.0
                state[2], state[3] = gap, 0.0
            state[0] = position - centre_a
    return switching, reopening


@njit(cache=True, parallel=True)
def _simulate(theta, times, onset, closing, travel, switching, reopening):
    for i in prange(theta.shape[0]):
        switching[i], reopening[i] = _curve(theta[i], times, onset[i], closing, travel[i])
