"""The equations of the drive, and formulas that follow from them.

Paper, Sec. 3, in mm and ms. ``x_a`` is the position of the drive, ``x_b`` that of the contact.

- Free contact, Eq. (3):
  ``x_a'' = -k_a x_a + k_b (x_b - x_a) - gamma_a x_a' + gamma_b (x_b' - x_a') + f``,
  ``x_b'' = -mu k_b (x_b - x_a) - mu gamma_b (x_b' - x_a')``.
- Closed contact, Eq. (4): the same for ``x_a`` with ``x_b = L`` and ``x_b' = 0``.
- Open rest position, Eq. (6): ``x_a = x_b = 0``.
- Closed rest position, Eq. (7): ``x_a = (f + k_b L) / (k_a + k_b)`` and ``x_b = L``.

*Closing* starts at the open rest position with ``f``. The contact touches when ``x_b`` first
reaches ``L``, and stays there (inelastic). *Opening* starts at the closed rest position without
``f``. The contact separates when its force ``k_b (x_a - L) + gamma_b x_a'`` falls to zero. Each
motion has one change of mode.

Three slips of the paper are corrected:

1. Eq. (5) prints ``mu = M_b / M_a``, but (3) follows from (1) only with ``mu = M_a / M_b``.
2. Eq. (7) labels the closed rest position "open".
3. ``f`` is zero during opening, but the closed rest position, where opening starts, depends on
   ``f``. So does an opening curve.
"""

import numpy as np

from breaker.model.parameters import split

PRESSED = "f > k_a L"
"""Condition for a contact that is pressed in the closed rest position (``pressed``)."""


def pressed(theta: np.ndarray) -> np.ndarray:
    """Return which parameter sets keep the contact pressed, ``(..., p) -> (...)`` of bool."""
    _, k_a, _, _, _, f, gap = split(np.asarray(theta))
    return f > k_a * gap


def spring_compression(theta: np.ndarray) -> np.ndarray:
    """Return the compression of the contact spring at the closed rest position, ``x_a - L`` of
    Eq. (7), ``(..., p) -> (...)``, mm; zero or negative where the contact is not pressed.
    """
    _, k_a, k_b, _, _, f, gap = split(theta)
    return (f - k_a * gap) / (k_a + k_b)


def closed_rest(theta: np.ndarray) -> np.ndarray:
    """Return the closed rest position of the drive, Eq. (7), ``(..., p) -> (...)``, mm."""
    _, k_a, k_b, _, _, f, gap = split(theta)
    return (f + k_b * gap) / (k_a + k_b)


def own_time(theta: np.ndarray, motion: str) -> np.ndarray:
    """Return the time scale of a motion, ``(..., p) -> (...)``, ms: ``sqrt(L / f)`` of a closing,
    and ``sqrt(1 / k_a)``, the period of the opening spring over 2 pi, of an opening.
    """
    _, k_a, _, _, _, f, gap = split(theta)
    return np.sqrt(gap / f if motion == "closing" else 1.0 / k_a)


def fastest_rate(theta: np.ndarray, *, free: bool = True) -> np.ndarray:
    """Return an upper bound on the rates of a mode with a free or closed contact,
    ``(..., p) -> (...)``, 1/ms: a bound on the norm of its matrix (see ``kernels``).
    """
    mu, k_a, k_b, gamma_a, gamma_b, *_ = split(theta)
    moved = 1.0 + mu * free
    with np.errstate(over="ignore"):  # an infinite rate is too fast as well
        return np.sqrt(k_a + k_b * moved) + gamma_a + gamma_b * moved
