"""Linear modes against matrix exponentials, and zeros of polynomials."""

import numpy as np
import pytest
from scipy.linalg import expm

from breaker.common.randomness import generator
from breaker.model import kernels
from breaker.model.equations import fastest_rate

TERMS = 24


def system(mode):
    """Matrix (4, 4) of a mode."""
    m0, m1, m2, m3, m4, m5 = mode.m
    return np.array([[0, 1, 0, 0], [-m0, -m1, m2, m3], [0, 0, 0, 1], [m4, m5, -m4, -m5]])


def mode_of(theta, free):
    """The mode of a drive, closed or free, without a force."""
    rates = np.array([fastest_rate(theta, free=each) for each in (False, True)])
    return kernels.mode_of(theta, rates, free, 0.0)


def buffers():
    shapes = (3, 4, TERMS), (4, 4), (4, 4), TERMS, TERMS
    return kernels.Buffers(*(np.empty(shape) for shape in shapes))


@pytest.mark.parametrize("free", [True, False])
def test_rows_and_exponentials(prior, free):
    """The norm of A h in coordinates scaled by mass is at most 1.8; so rounding is some 1e-15 times
    exp(1.8), times the scale of a speed against a position."""
    u, made = np.linspace(-1, 1, 7), buffers()
    for theta in prior.sample(10, generator(1, "test", "modes")):
        mode = mode_of(theta, free)
        margin = kernels.Margin(0.3, 0.7, -0.2, 0.0, True)
        kernels.propagate(mode, margin, made)
        matrix = system(mode)
        np.testing.assert_allclose(made.half, expm(matrix * mode.h), rtol=0, atol=1e-13)
        np.testing.assert_allclose(made.whole, expm(2 * matrix * mode.h), rtol=0, atol=1e-13)
        y = np.array([1.0, -0.5, 2.0, 0.3])
        path = expm(matrix * (mode.h * u)[:, None, None]) @ y
        for i, weights in enumerate(([1, 0, 0, 0], [0, 0, 1, 0], [0.3, 0.7, -0.2, 0])):
            kernels.coefficients(made.rows, i, tuple(y), 0.25, made.position)
            values = np.polynomial.polynomial.polyval(u, made.position)
            np.testing.assert_allclose(values, path @ weights + 0.25, atol=1e-13)


def test_rates_bound_the_systems(prior):
    """In coordinates scaled by mass, and speeds by the root of the stiffness."""
    for theta in prior.sample(50, generator(1, "test", "rates")):
        mu, k_a, k_b = theta[:3]
        for free in (True, False):
            omega = np.sqrt(k_a + k_b * (1 + mu * free))
            scale = np.array([omega, 1, omega / np.sqrt(mu), 1 / np.sqrt(mu)])
            matrix = system(mode_of(theta, free)) * scale[:, None] / scale
            kept = slice(None) if free else slice(2)  # a closed contact stands still
            assert np.linalg.norm(matrix[kept, kept], 2) <= fastest_rate(theta, free=free) * (
                1 + 1e-12
            )


def polynomial(roots, leading):
    """Coefficients (k,) of a polynomial with given roots."""
    out = np.zeros(TERMS)
    out[: len(roots) + 1] = leading * np.polynomial.polynomial.polyfromroots(roots)
    return out


@pytest.mark.parametrize(
    ("roots", "leading", "above", "first"),
    [
        ([0.3], -1.0, 0.0, 0.3),
        ([-0.9, 0.2, 0.7], -1.0, 0.0, -0.9),
        ([0.51, 0.52], 1.0, 0.0, 0.51),  # a dip between two nodes
        ([0.5, 0.5], 1.0, 1e-9, np.inf),  # a dip that stays positive
        ([-1.2, 0.1], 1.0, 0.0, -1.0),  # not positive from the start
        ([1.3], -1.0, 0.0, np.inf),
        ([0.25, 1.5], 1.0, 0.0, 0.25),  # at a node
        ([], 1.0, 0.0, np.inf),
    ],
)
def test_first_zero(roots, leading, above, first):
    margin = polynomial(roots, leading)
    margin[0] += above
    assert kernels.first_zero(margin) == pytest.approx(first, abs=1e-13)
