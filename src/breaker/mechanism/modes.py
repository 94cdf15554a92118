r"""The two modes of the contact, in compiled code: linear systems, their series and their zeros.

A mode is ``y' = A y`` for the deviation ``y = (x_a, x_a', x_b, x_b')`` from its equilibrium:

``x_a'' = -m0 x_a - m1 x_a' + m2 x_b + m3 x_b'`` and ``x_b'' = m4 (x_a - x_b) + m5 (x_a' - x_b')``.

A closed contact is one of infinite mass, ``mu = 0``. A mode is followed in intervals of length 2h.
About the middle of each, ``y = sum_k (A h)^k / k! y(middle) u^k`` with ``u = (time - middle) / h``
from -1 to 1. So the coefficients of x_a and x_b are fixed rows times the state, and the state at
the next middle is ``exp(2 A h) y``: rows and exponentials are computed once for all intervals.

``rate = sqrt(k_a + k_b (1 + mu)) + gamma_a + gamma_b (1 + mu)`` bounds the norm of A in coordinates
scaled by mass. With ``rate * h <= 1.8``, what the series leaves out is below round-off.
"""

import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit

__all__ = [
    "REACH",
    "SOURCE",
    "TERMS",
    "Buffers",
    "checksum",
    "coefficients",
    "compiled",
    "equilibrium",
    "first_zero",
    "make_buffers",
    "mode_of",
    "passed",
    "propagate",
    "rate_of",
    "times_matrix",
    "times_system",
    "value_and_slope",
    "values",
    "velocity_of",
]

REACH = 1.8  # largest rate * h
TERMS = 24  # 1.8^24 / 24! = 2e-18, and 1.8^23 / 23! = 3e-17 for speeds
_NODES = np.linspace(-1.0, 1.0, 9)  # of an interval: at most one turn of a margin between two

compiled = njit(error_model="numpy")


def checksum(file: str) -> int:
    """Return the checksum of a module's source, for functions of other modules to close over.

    numba keeps compiled functions on disk. It compiles one anew when its own file has changed, but
    not when it calls into another file that has; the values of its closure, though, are in the key
    that it is found by.
    """
    return zlib.crc32(Path(file).read_bytes())


SOURCE = checksum(__file__)


class Buffers(NamedTuple):
    """What a thread needs to follow a mode: allocated once, for allocating is slow."""

    rows: np.ndarray  # (3, 4, k) of x_a, of x_b and of a margin
    half: np.ndarray  # (4, 4) exp(A h)
    whole: np.ndarray  # (4, 4) exp(2 A h)
    position: np.ndarray  # (k,) coefficients of x_a, of a margin and of its slope
    margin: np.ndarray
    slope: np.ndarray
    nodes: np.ndarray  # (2, nodes) values and slopes there


@compiled
def make_buffers():
    return Buffers(
        np.empty((3, 4, TERMS)),
        np.empty((4, 4)),
        np.empty((4, 4)),
        np.empty(TERMS),
        np.empty(TERMS),
        np.empty(TERMS),
        np.empty((2, _NODES.size)),
    )


# ---- linear systems --------------------------------------------------------------------------


@compiled
def rate_of(theta, free):
    """Bound of a mode's fastest rate, 1/ms."""
    mu, k_a, k_b, gamma_a, gamma_b, _, _ = theta
    if not free:
        mu = 0.0
    return np.sqrt(k_a + k_b * (1 + mu)) + gamma_a + gamma_b * (1 + mu)


@compiled
def mode_of(theta, free):
    """m0 to m5, and the 1 of ``x' = v``: with a 0 for it, a mode's derivative is such a row too."""
    mu, k_a, k_b, gamma_a, gamma_b, _, _ = theta
    if not free:
        mu = 0.0
    return k_a + k_b, gamma_a + gamma_b, k_b, gamma_b, mu * k_b, mu * gamma_b, 1.0


@compiled
def equilibrium(theta, free, pull):
    """Positions of drive and contact at which a mode rests under a force."""
    _, k_a, k_b, _, _, _, gap = theta
    if free:
        return pull / k_a, pull / k_a
    return (pull + k_b * gap) / (k_a + k_b), gap


@compiled
def velocity_of(theta, free, pull, state):
    """The derivative by time of ``(x_a, x_a', x_b, x_b')`` in a mode."""
    mode, (x_a, x_b) = mode_of(theta, free), equilibrium(theta, free, pull)
    a, v_a, b, v_b = state[0] - x_a, state[1], state[2] - x_b, state[3]
    return (
        v_a,
        mode[2] * b + mode[3] * v_b - mode[0] * a - mode[1] * v_a,
        v_b,
        mode[4] * (a - b) + mode[5] * (v_a - v_b),
    )


@compiled
def times_system(row, mode, scale):
    """``scale * row @ A``."""
    a, b, c, d = row
    return (
        scale * (mode[4] * d - mode[0] * b),
        scale * (mode[6] * a - mode[1] * b + mode[5] * d),
        scale * (mode[2] * b - mode[4] * d),
        scale * (mode[6] * c + mode[3] * b - mode[5] * d),
    )


@compiled
def times_matrix(matrix, y):
    """``matrix @ y``, (4, 4) by (4,)."""
    a, b, c, d = y
    return (
        matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2] * c + matrix[0, 3] * d,
        matrix[1, 0] * a + matrix[1, 1] * b + matrix[1, 2] * c + matrix[1, 3] * d,
        matrix[2, 0] * a + matrix[2, 1] * b + matrix[2, 2] * c + matrix[2, 3] * d,
        matrix[3, 0] * a + matrix[3, 1] * b + matrix[3, 2] * c + matrix[3, 3] * d,
    )


@compiled
def propagate(mode, h, rows, half, whole):
    """Fill the rows of x_a and x_b, exp(A h) and exp(2 A h) of a mode."""
    a, b = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)
    for k in range(TERMS):
        rows[0, 0, k], rows[0, 1, k], rows[0, 2, k], rows[0, 3, k] = a
        rows[1, 0, k], rows[1, 1, k], rows[1, 2, k], rows[1, 3, k] = b
        a, b = times_system(a, mode, h / (k + 1)), times_system(b, mode, h / (k + 1))
    for i in range(2):  # the series at u = 1, and those of the speeds
        for s in range(4):
            value = slope = 0.0
            for k in range(TERMS):
                value += rows[i, s, k]
                slope += k * rows[i, s, k]
            half[2 * i, s], half[2 * i + 1, s] = value, slope / h
    for s in range(4):
        column = half[0, s], half[1, s], half[2, s], half[3, s]
        whole[0, s], whole[1, s], whole[2, s], whole[3, s] = times_matrix(half, column)


# ---- polynomials in u ------------------------------------------------------------------------


@compiled
def coefficients(rows, i, y, out):
    """Fill the coefficients of a polynomial, (k,): its rows times the state."""
    a, b, c, d = y
    for k in range(TERMS):
        out[k] = rows[i, 0, k] * a + rows[i, 1, k] * b + rows[i, 2, k] * c + rows[i, 3, k] * d


@compiled
def passed(times, sample, stop):
    """Index of the first sample after a time, searched from ``sample``."""
    while sample < times.size and times[sample] <= stop:
        sample += 1
    return sample


@compiled
def values(polynomial, times, first, stop, middle, h, out, i):
    """Fill the values at samples from first to stop, ``out[i]``.

    The loop over samples vectorises. Their index is unsigned, or numba would look for negative
    ones, and gather, at half the speed of a whole simulation.
    """
    per_h = 1.0 / h
    for sample in range(np.uint64(first), np.uint64(stop)):
        u = (times[sample] - middle) * per_h
        total = polynomial[TERMS - 1]
        for k in range(TERMS - 2, -1, -1):
            total = total * u + polynomial[k]
        out[i, sample] = total


@compiled
def value_and_slope(polynomial, u):
    value, slope = polynomial[TERMS - 1], 0.0
    for k in range(TERMS - 2, -1, -1):
        slope = slope * u + value
        value = value * u + polynomial[k]
    return value, slope


@compiled
def _root(polynomial, low, high):
    """Root of a polynomial that is positive at just one end: Newton's steps, kept in a bracket."""
    falling = value_and_slope(polynomial, high)[0] <= 0
    u = 0.5 * (low + high)
    for _ in range(100):
        value, slope = value_and_slope(polynomial, u)
        if (value > 0) == falling:
            low = u
        else:
            high = u
        step = value / slope
        if abs(step) < 1e-15:
            break
        u = u - step if low < u - step < high else 0.5 * (low + high)
        if high - low < 1e-15:
            break
    return u


@compiled
def first_zero(margin, slope, nodes):
    """First u in [-1, 1] at which a margin is no longer positive, or inf.

    Between two nodes the margin may dip below zero and return: then it has a minimum there.
    """
    change = 0.0
    for k in range(1, TERMS):
        change += abs(margin[k])
    if change < margin[0]:
        return np.inf
    for i in range(_NODES.size):
        nodes[0, i], nodes[1, i] = value_and_slope(margin, _NODES[i])
    if nodes[0, 0] <= 0:
        return -1.0
    for i in range(1, _NODES.size):
        low, high = _NODES[i - 1], _NODES[i]
        if nodes[0, i] <= 0:
            return _root(margin, low, high)
        if nodes[1, i - 1] < 0 < nodes[1, i]:
            for k in range(TERMS - 1):
                slope[k] = (k + 1) * margin[k + 1]
            slope[TERMS - 1] = 0.0
            lowest = _root(slope, low, high)
            if value_and_slope(margin, lowest)[0] <= 0:
                return _root(margin, low, lowest)
    return np.inf
