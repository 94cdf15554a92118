r"""The derivatives of ``modes`` by the logs of the parameters and by the onset, in compiled code.

In a mode, a row of coefficients obeys the product rule of its recursion, ``(r A)' = r' A + r A'``,
and so does the state, ``exp(A h) y``, at a fixed time. f and L are not in A; they, and the onset,
move the state and the equilibrium alone.

All eight derivatives of a number are side by side, one vector of a processor. Arrays are flat, and
a loop over the eight has a length that the compiler does not know: then it sees that rows do not
overlap, and vectorises these loops and no others.
"""

from typing import NamedTuple

import numpy as np

from breaker.mechanism.modes import (
    TERMS,
    checksum,
    compiled,
    equilibrium,
    times_matrix,
    times_system,
)
from breaker.mechanism.parameters import NAMES

__all__ = [
    "GAP",
    "LANES",
    "SOURCE",
    "Tangents",
    "advance_tangents",
    "lane",
    "make_tangents",
    "propagate_tangents",
    "set_equilibrium_tangents",
    "set_lane",
    "set_mode_tangents",
    "tangent_coefficients",
    "tangent_values",
]

LANES = len(NAMES) + 1  # the onset's is the last
_MU, _K_A, _K_B, _GAMMA_A, _GAMMA_B, _F, GAP = range(len(NAMES))
SOURCE = checksum(__file__)


class Tangents(NamedTuple):
    """What a thread needs beside ``modes.Buffers``: the derivatives of what is there."""

    mode: np.ndarray  # (7, 8) of a mode's coefficients
    rows: np.ndarray  # (2, k, 4, 8) of the rows of x_a and x_b
    half: np.ndarray  # (4, 4, 8) of exp(A h)
    whole: np.ndarray  # (4, 4, 8) of exp(2 A h)
    series: np.ndarray  # (k, 8) of the coefficients of x_a
    rest: np.ndarray  # (4, 8) of the equilibrium
    state: np.ndarray  # (4, 8) of the state, or of its deviation from the equilibrium
    moved: np.ndarray  # (4, 8) of the deviation after a step


@compiled
def make_tangents():
    n = LANES
    return Tangents(
        np.zeros(7 * n),
        np.empty(8 * TERMS * n),
        np.empty(16 * n),
        np.empty(16 * n),
        np.empty(TERMS * n),
        np.empty(4 * n),
        np.empty(4 * n),
        np.empty(4 * n),
    )


@compiled
def _at(row, j):
    """Index of a derivative: unsigned, as in ``modes.values``."""
    return np.uint64(row) * np.uint64(LANES) + np.uint64(j)


@compiled
def lane(array, row, j):
    """Four rows of one derivative."""
    return (
        array[_at(row, j)],
        array[_at(row + 1, j)],
        array[_at(row + 2, j)],
        array[_at(row + 3, j)],
    )


@compiled
def set_lane(array, row, j, y):
    array[_at(row, j)], array[_at(row + 1, j)], array[_at(row + 2, j)], array[_at(row + 3, j)] = y


@compiled
def _plus(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@compiled
def set_mode_tangents(theta, free, mode):
    """Fill the derivatives of ``modes.mode_of``: those that are ever other than zero."""
    mu, k_a, k_b, gamma_a, gamma_b, _, _ = theta
    if not free:
        mu = 0.0
    mode[_at(0, _K_A)] = k_a
    mode[_at(0, _K_B)] = mode[_at(2, _K_B)] = k_b
    mode[_at(1, _GAMMA_A)] = gamma_a
    mode[_at(1, _GAMMA_B)] = mode[_at(3, _GAMMA_B)] = gamma_b
    mode[_at(4, _MU)] = mode[_at(4, _K_B)] = mu * k_b
    mode[_at(5, _MU)] = mode[_at(5, _GAMMA_B)] = mu * gamma_b


@compiled
def set_equilibrium_tangents(theta, free, pull, rest):
    """Fill the derivatives of ``modes.equilibrium``; the pull is f or nothing."""
    _, k_a, k_b, _, _, _, gap = theta
    x_a, _ = equilibrium(theta, free, pull)
    rest[:] = 0.0
    if free:
        rest[_at(0, _K_A)] = rest[_at(2, _K_A)] = -x_a
        rest[_at(0, _F)] = rest[_at(2, _F)] = x_a
    else:
        rest[_at(0, _K_A)] = -k_a * x_a / (k_a + k_b)
        rest[_at(0, _K_B)] = k_b * (gap - x_a) / (k_a + k_b)
        rest[_at(0, _F)] = pull / (k_a + k_b)
        rest[_at(0, GAP)], rest[_at(2, GAP)] = k_b * gap / (k_a + k_b), gap


@compiled
def propagate_tangents(mode, h, rows, half, tangents, lanes):
    """Fill the derivatives of what ``modes.propagate`` filled."""
    d_mode, d_rows, d_half, d_whole = tangents.mode, tangents.rows, tangents.half, tangents.whole
    for i in range(2):
        for j in range(lanes):
            set_lane(d_rows, 4 * TERMS * i, j, (0.0, 0.0, 0.0, 0.0))
        for k in range(TERMS - 1):
            scale, at = h / (k + 1), 4 * (TERMS * i + k)
            row = rows[i, 0, k], rows[i, 1, k], rows[i, 2, k], rows[i, 3, k]
            for j in range(lanes):
                a, b, c, d = lane(d_mode, 0, j)
                d_mode_j = a, b, c, d, d_mode[_at(4, j)], d_mode[_at(5, j)], 0.0
                d_row = times_system(lane(d_rows, at, j), mode, scale)
                set_lane(d_rows, at + 4, j, _plus(d_row, times_system(row, d_mode_j, scale)))
        for s in range(4):
            for j in range(lanes):
                value = slope = 0.0
                for k in range(TERMS):
                    value += d_rows[_at(4 * (TERMS * i + k) + s, j)]
                    slope += k * d_rows[_at(4 * (TERMS * i + k) + s, j)]
                d_half[_at(8 * i + s, j)], d_half[_at(8 * i + 4 + s, j)] = value, slope / h
    for r in range(4):
        for s in range(4):
            for j in range(lanes):
                total = 0.0
                for q in range(4):
                    total += d_half[_at(4 * r + q, j)] * half[q, s]
                    total += half[r, q] * d_half[_at(4 * q + s, j)]
                d_whole[_at(4 * r + s, j)] = total


@compiled
def advance_tangents(matrix, d_matrix, y, dy, moved, lanes):
    """Return a matrix times a deviation, and fill the derivatives of both with the product's."""
    for s in range(4):
        for j in range(lanes):
            a, b, c, d = lane(dy, 0, j)
            total = matrix[s, 0] * a + matrix[s, 1] * b + matrix[s, 2] * c + matrix[s, 3] * d
            a, b, c, d = lane(d_matrix, 4 * s, j)
            moved[_at(s, j)] = total + a * y[0] + b * y[1] + c * y[2] + d * y[3]
    dy[:] = moved
    return times_matrix(matrix, y)


@compiled
def tangent_coefficients(rows, d_rows, y, dy, series, lanes):
    """Fill the derivatives of ``modes.coefficients`` of x_a."""
    for k in range(TERMS):
        row = rows[0, 0, k], rows[0, 1, k], rows[0, 2, k], rows[0, 3, k]
        for j in range(lanes):
            a, b, c, d = lane(dy, 0, j)
            total = row[0] * a + row[1] * b + row[2] * c + row[3] * d
            a, b, c, d = lane(d_rows, 4 * k, j)
            series[_at(k, j)] = total + a * y[0] + b * y[1] + c * y[2] + d * y[3]


@compiled
def tangent_values(series, rest, times, first, stop, middle, h, out, lanes):
    """Fill the derivatives at samples from first to stop, ``out[first:stop]``."""
    per_h = 1.0 / h
    for sample in range(np.uint64(first), np.uint64(stop)):
        u = (times[sample] - middle) * per_h
        for j in range(lanes):
            total = series[_at(TERMS - 1, j)]
            for k in range(TERMS - 2, -1, -1):
                total = total * u + series[_at(k, j)]
            out[sample, np.uint64(j)] = rest[_at(0, j)] + total
