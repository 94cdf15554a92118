"""Compiled code of the exact curves: the two modes of the contact, their series and end times.

A mode (paper, Eqs. 3 and 4) is ``y' = A y`` for the deviation ``y = (x_a, x_a', x_b, x_b')`` from
its equilibrium:

``x_a'' = -m0 x_a - m1 x_a' + m2 x_b + m3 x_b'`` and ``x_b'' = m4 (x_a - x_b) + m5 (x_a' - x_b')``.

A closed contact has infinite mass, ``mu = 0``. A mode is solved in intervals of length 2h. Around
the middle of an interval, ``y = sum_k (A h)^k / k! y(middle) u^k`` with
``u = (time - middle) / h`` from -1 to 1. The coefficients of x_a and x_b are fixed rows times the
state, and the state at the next middle is ``exp(2 A h) y``. With ``rate * h <= 1.8`` the truncated
terms are below round-off. A mode ends when its *margin* falls to zero: the distance that the
contact has to the gap, or the contact force.
"""

from typing import NamedTuple

import numpy as np

from breaker.common.compiling import compiled, numba_or_plain

njit, prange = numba_or_plain()
_REACH = 1.8  # largest rate * h
_TERMS = 24  # truncation error 1.8^24 / 24! = 2e-18, and 1.8^23 / 23! = 3e-17 for speeds
_ROWS = 64  # curves that a thread simulates in turn with the same buffers
_compiled = njit(error_model="numpy")
_inlined = njit(error_model="numpy", forceinline=True)  # a call costs more than 24 terms
# Fused multiply-add: only for polynomials, because stiff systems lose digits by it.
_fused = {"error_model": "numpy", "fastmath": {"contract"}}


class Buffers(NamedTuple):
    """Arrays of a thread, allocated once because allocation is slow."""

    rows: np.ndarray  # (3, 4, k) rows of x_a, x_b and a margin
    half: np.ndarray  # (4, 4) exp(A h)
    whole: np.ndarray  # (4, 4) exp(2 A h)
    position: np.ndarray  # (k,) coefficients of x_a
    margin: np.ndarray  # (k,) coefficients of a margin


class Mode(NamedTuple):
    """A free or closed contact under a constant force."""

    m: tuple  # m0 to m5
    h: float  # half an interval, ms
    x_a: float  # positions at rest, mm
    x_b: float


class Margin(NamedTuple):
    """``x_a * drive + x_a' * speed + x_b * contact + offset``, positive until the mode ends."""

    drive: float
    speed: float
    contact: float
    offset: float


# ---- linear systems --------------------------------------------------------------------------


@_compiled
def mode_of(theta, rates, free, pull):
    """Return the mode of a contact, free or closed, with a force ``pull`` on the drive."""
    mu, k_a, k_b, gamma_a, gamma_b, _, gap = theta
    m = k_a + k_b, gamma_a + gamma_b, k_b, gamma_b, mu * free * k_b, mu * free * gamma_b
    h = _REACH / rates[1 if free else 0]
    if free:
        return Mode(m, h, pull / k_a, pull / k_a)
    return Mode(m, h, (pull + k_b * gap) / (k_a + k_b), gap)


@_compiled
def _times_system(row, m, scale):
    """``scale * row @ A``."""
    a, b, c, d = row
    return (
        scale * (m[4] * d - m[0] * b),
        scale * (a - m[1] * b + m[5] * d),
        scale * (m[2] * b - m[4] * d),
        scale * (c + m[3] * b - m[5] * d),
    )


@_compiled
def _times_matrix(matrix, y):
    """``matrix @ y``, (4, 4) by (4,)."""
    a, b, c, d = y
    return (
        matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2] * c + matrix[0, 3] * d,
        matrix[1, 0] * a + matrix[1, 1] * b + matrix[1, 2] * c + matrix[1, 3] * d,
        matrix[2, 0] * a + matrix[2, 1] * b + matrix[2, 2] * c + matrix[2, 3] * d,
        matrix[3, 0] * a + matrix[3, 1] * b + matrix[3, 2] * c + matrix[3, 3] * d,
    )


@_compiled
def propagate(mode, margin, buffers):
    """Fill the rows of x_a, x_b and the margin, and exp(A h) and exp(2 A h), of a mode."""
    rows, half, whole, h = buffers.rows, buffers.half, buffers.whole, mode.h
    a, b = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)
    for k in range(_TERMS):
        rows[0, 0, k], rows[0, 1, k], rows[0, 2, k], rows[0, 3, k] = a
        rows[1, 0, k], rows[1, 1, k], rows[1, 2, k], rows[1, 3, k] = b
        a, b = _times_system(a, mode.m, h / (k + 1)), _times_system(b, mode.m, h / (k + 1))
    for s in range(4):  # the series of positions and speeds at u = 1, four sums in parallel
        x_a = x_b = v_a = v_b = 0.0
        for k in range(_TERMS):
            x_a, v_a = x_a + rows[0, s, k], v_a + k * rows[0, s, k]
            x_b, v_b = x_b + rows[1, s, k], v_b + k * rows[1, s, k]
        half[0, s], half[1, s], half[2, s], half[3, s] = x_a, v_a / h, x_b, v_b / h
    for s in range(4):
        column = half[0, s], half[1, s], half[2, s], half[3, s]
        whole[0, s], whole[1, s], whole[2, s], whole[3, s] = _times_matrix(half, column)
        for k in range(_TERMS):
            rows[2, s, k] = margin.drive * rows[0, s, k] + margin.contact * rows[1, s, k]
        for k in range(1, _TERMS):
            rows[2, s, k - 1] += margin.speed / h * k * rows[0, s, k]


# ---- polynomials in u ------------------------------------------------------------------------


@_inlined
def coefficients(rows, i, y, constant, out):
    """Fill the coefficients of a polynomial, (k,): rows times the state, plus a constant."""
    a, b, c, d = y
    for k in range(_TERMS):
        out[k] = rows[i, 0, k] * a + rows[i, 1, k] * b + rows[i, 2, k] * c + rows[i, 3, k] * d
    out[0] += constant


@_compiled
def _passed(times, sample, stop):
    """Index of the first sample after a time, searched from ``sample``."""
    while sample < times.size and times[sample] <= stop:
        sample += 1
    return sample


@njit(forceinline=True, **_fused)
def _fill(polynomial, times, travel, first, stop, middle, h):
    """Fill the values of a curve at samples from first to stop.

    The unsigned index lets the loop over samples vectorise, which is twice as fast.
    """
    for sample in range(np.uint64(first), np.uint64(stop)):
        u = (times[sample] - middle) / h
        even, odd, square = polynomial[_TERMS - 2], polynomial[_TERMS - 1], u * u
        for k in range(_TERMS - 4, -1, -2):  # two sums in parallel
            even, odd = even * square + polynomial[k], odd * square + polynomial[k + 1]
        travel[sample] = even + u * odd


@njit(**_fused)
def _value_and_slope(polynomial, u):
    value = slope = 0.0
    for coefficient in polynomial[::-1]:
        value, slope = value * u + coefficient, slope * u + value
    return value, slope


@_compiled
def _root(polynomial, low, high):
    """Root of a polynomial that is positive at one end only, by Newton's steps in a bracket."""
    falling = _value_and_slope(polynomial, high)[0] <= 0
    u = 0.5 * (low + high)
    for _ in range(100):
        value, slope = _value_and_slope(polynomial, u)
        low, high = (u, high) if (value > 0) == falling else (low, u)
        step = value / slope
        if abs(step) < 1e-15:
            break
        u = u - step if low < u - step < high else 0.5 * (low + high)
        if high - low < 1e-15:
            break
    return u


@_compiled
def first_zero(margin):
    """First u in [-1, 1] at which a margin is no longer positive, or inf.

    The search goes through nodes at distances of 1/4, between which a margin turns at most once. If
    a margin dips below zero and returns between two nodes, it has a minimum between them.
    """
    change = 0.0
    for k in range(1, _TERMS):
        change += abs(margin[k])
    if change < margin[0]:
        return np.inf
    low = -1.0
    value, falling = _value_and_slope(margin, low)
    if value <= 0:
        return low
    for node in range(-3, 5):
        high = node / 4
        value, rising = _value_and_slope(margin, high)
        if value <= 0:
            return _root(margin, low, high)
        if falling < 0 < rising:
            lowest = _root(margin[1:] * np.arange(1.0, _TERMS), low, high)
            if _value_and_slope(margin, lowest)[0] <= 0:
                return _root(margin, low, lowest)
        low, falling = high, rising
    return np.inf


# ---- curves ----------------------------------------------------------------------------------


@_compiled
def _follow(mode, margin, watching, state, start, times, travel, sample, buffers):
    """Fill a curve in one mode, from the state at ``start`` until the margin ends the mode.

    Return the next sample, the time of the margin's zero (inf if it has none by the last sample),
    and x_a and x_a' at the end of the mode. Without ``watching``, the mode does not end.
    """
    propagate(mode, margin, buffers)
    rows, position, h = buffers.rows, buffers.position, mode.h
    offset = margin.offset + margin.drive * mode.x_a + margin.contact * mode.x_b
    deviation = state[0] - mode.x_a, state[1], state[2] - mode.x_b, state[3]
    y = _times_matrix(buffers.half, deviation)
    zero = u = np.inf
    interval = 0
    while sample < times.size:
        begin, stop = start + 2 * interval * h, start + 2 * (interval + 1) * h
        if watching:
            coefficients(rows, 2, y, offset, buffers.margin)
            u = first_zero(buffers.margin)
            if begin + (1 + u) * h <= times[-1]:
                zero = begin + (1 + u) * h
        ended = zero < np.inf
        coefficients(rows, 0, y, mode.x_a, position)
        first, sample = sample, _passed(times, sample, zero if ended else stop)
        # Fill full vectors of eight: the next interval overwrites the surplus samples.
        filled = min(times.size, first + (sample - first + 7) // 8 * 8)
        _fill(position, times, travel, first, filled, begin + h, h)
        if ended:
            x_a, v_a = _value_and_slope(position, u)
            return sample, zero, x_a, v_a / h
        y = _times_matrix(buffers.whole, y)
        interval += 1
    return sample, zero, np.nan, np.nan


@_compiled
def _curve(theta, rates, times, onset, closing, travel, buffers):
    """Fill one curve; return its switching time after the onset."""
    _, _, k_b, _, gamma_b, f, gap = theta
    if closing:
        pull, state = f, (0.0, 0.0, 0.0, 0.0)
        margin = Margin(0.0, 0.0, -1.0, gap)  # distance to the gap
    else:
        pull, state = 0.0, (mode_of(theta, rates, False, f).x_a, 0.0, gap, 0.0)
        margin = Margin(k_b, gamma_b, 0.0, -k_b * gap)  # contact force
    sample = _passed(times, 0, onset)
    travel[:sample] = state[0]
    mode = mode_of(theta, rates, closing, pull)
    sample, switching, x_a, v_a = _follow(
        mode, margin, True, state, onset, times, travel, sample, buffers
    )
    if sample < times.size:  # the contact stops at the gap, or leaves it from rest
        mode, state = mode_of(theta, rates, not closing, pull), (x_a, v_a, gap, 0.0)
        _follow(mode, margin, False, state, switching, times, travel, sample, buffers)
    return switching - onset


@compiled(parallel=True)
def simulate(theta, rates, times, onset, closing, travel, switching):
    """Fill curves (n, t) and switching times (n,) of parameters (n, p).

    Rates (n, 2) are bounds for the closed and the free contact (``equations.fastest_rate``).
    """
    n = theta.shape[0]
    for block in prange(-(-n // _ROWS)):
        terms, squares = np.empty((5, 4, _TERMS)), np.empty((2, 4, 4))
        buffers = Buffers(terms[:3], squares[0], squares[1], terms[3, 0], terms[4, 0])
        for i in range(block * _ROWS, min(n, (block + 1) * _ROWS)):
            switching[i] = _curve(theta[i], rates[i], times, onset[i], closing, travel[i], buffers)
