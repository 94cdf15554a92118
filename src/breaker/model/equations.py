"""Formulas of the parameters of a drive, and conditions on them in words, light to import.

A closed contact is pressed only if ``f > k_a L`` (paper, Sec. 3), and a curve can be followed only
if the fastest rate of its drive is bounded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from breaker.common.lazy_numpy import np
from breaker.model.parameters import NAMES, split

PRESSED = "f > k_a L"
"""The condition on a contact that stays pressed."""

PRESSING = "f"
"""Of what more presses a contact."""

RELEASING = "k_a or L"
"""Of what less presses it."""

_SIGNS = {"f": 1.0, "k_a": -1.0, "L": -1.0}  # log f - log k_a - log L > 0


def pressed(theta: np.ndarray) -> np.ndarray:
    """Say which parameter sets keep the contact pressed, ``(..., p) -> (...)`` of bool."""
    _, k_a, _, _, _, f, gap = split(np.asarray(theta))
    return f > k_a * gap


def pressed_half_space(
    medians: Sequence[float], log_sds: Sequence[float]
) -> tuple[tuple[float, ...], float]:
    """Return ``a`` and ``b`` of the same condition ``a . z + b > 0`` on standardised logarithms
    ``z``.
    """
    signs = [_SIGNS.get(name, 0.0) for name in NAMES]
    slope = tuple(sign * sd for sign, sd in zip(signs, log_sds, strict=True))
    logs = (sign * math.log(median) for sign, median in zip(signs, medians, strict=True))
    return slope, float(sum(logs))


def wipe(theta: np.ndarray) -> np.ndarray:
    """Return how far the contact spring is pressed at rest, ``(..., p) -> (...)``, mm (Eq. 7).

    Not positive where a contact does not stay pressed.
    """
    _, k_a, k_b, _, _, f, gap = split(theta)
    return (f - k_a * gap) / (k_a + k_b)


def closed_rest(theta: np.ndarray) -> np.ndarray:
    """Return where the drive rests closed, ``(..., p) -> (...)``, mm (Eq. 7): gap and wipe."""
    _, k_a, k_b, _, _, f, gap = split(theta)
    return (f + k_b * gap) / (k_a + k_b)


def own_time(theta: np.ndarray, motion: str) -> np.ndarray:
    """Return the time in which the force, or the opening spring, moves a drive, ``(..., p) ->
    (...)``, ms.
    """
    _, k_a, _, _, _, f, gap = split(theta)
    return np.sqrt(gap / f if motion == "closing" else 1.0 / k_a)


def fastest_rate(theta: np.ndarray, *, free: bool = True) -> np.ndarray:
    """Return a bound of the fastest rate of drives, ``(..., p) -> (...)``, 1/ms, with a free
    contact or the smaller one with a closed contact: of the norm of a mode's matrix (see
    ``kernels``).
    """
    mu, k_a, k_b, gamma_a, gamma_b, *_ = split(theta)
    moved = 1.0 + mu * free
    with np.errstate(over="ignore"):  # an infinite rate is too fast as well
        return np.sqrt(k_a + k_b * moved) + gamma_a + gamma_b * moved
