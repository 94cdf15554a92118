"""Conditions on the parameters of a drive, in formulas and in words, light to import.

The closing force has to exceed that of the opening spring where the contact touches, ``f > k_a L``
(paper, Sec. 3), or a closed contact is not pressed. And the fastest rate of a drive is bounded, or
its curve cannot be followed.
"""

import math
from collections.abc import Mapping

import numpy as np

from breaker.quantities.parameters import NAMES, split

PRESSED = "f > k_a L"
"""The condition on a contact that stays pressed."""

PRESSING = "f"
"""Of what more presses a contact."""

RELEASING = "k_a or L"
"""Of what less presses it."""

HURRYING = "mu, k_b, gamma_a or gamma_b"
"""Of what less slows a drive down."""

_SIGNS = {"f": 1.0, "k_a": -1.0, "L": -1.0}  # log f - log k_a - log L > 0


def pressed(theta: np.ndarray) -> np.ndarray:
    """Say which parameter sets keep the contact pressed, ``(..., p) -> (...)`` of bool."""
    _, k_a, _, _, _, f, gap = split(np.asarray(theta))
    return f > k_a * gap


def why_not_pressed(values: Mapping[str, float]) -> str:
    """Return why parameters by name do not keep the contact pressed; empty if they do."""
    spring = values["k_a"] * values["L"]
    return "" if values["f"] > spring else f"f is {values['f']:.3g}, and k_a L {spring:.3g} mm/ms^2"


def pressed_half_space(medians: np.ndarray, log_sds: np.ndarray) -> tuple[np.ndarray, float]:
    """Return ``a`` and ``b`` of the same condition ``a . z + b > 0`` on logarithms.

    Args:
        medians, log_sds: By which ``z``, ``(p,)``, is standardised.
    """
    signs = np.array([_SIGNS.get(name, 0.0) for name in NAMES])
    return signs * log_sds, float(signs @ np.log(medians))


def rate_bound(values: Mapping[str, float]) -> float:
    """Return the bound of the fastest rate of a drive of parameters by name, 1/ms.

    That of ``kernels.rate_of`` for a free contact. It is written twice, as numba notices changes of
    the kernels' own file only, and takes longer to import than a configuration to be checked.

    Example:
        >>> values = [2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0]
        >>> round(rate_bound(dict(zip(NAMES, values, strict=True))), 3)
        1.066
    """
    moved = 1.0 + values["mu"]
    springs = math.sqrt(values["k_a"] + values["k_b"] * moved)
    return springs + values["gamma_a"] + values["gamma_b"] * moved
