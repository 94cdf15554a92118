"""Brent's method, against scipy's to the last bit."""

import numpy as np
import pytest
from scipy.optimize import brentq

from breaker.model import generator
from breaker.posterior.roots import root_between

CUBIC = ((0.0, 1.0), (-3.0, 2.0), (1.0, -4.0))


def tempering(i):
    """The function that ``corrections.temper`` asks for the root of."""
    rng = generator(1, "test roots", i)
    centred = -(10.0 ** rng.uniform(0, 8)) * rng.chisquare(8, 500)
    centred -= centred.max()

    def excess(power):
        weights = np.exp(power * centred)
        return weights.sum() ** 2 / np.square(weights).sum() - 100

    return excess


@pytest.mark.parametrize(
    "tolerance", [{"xtol": 1e-300, "rtol": 1e-3}, {"xtol": 1e-12, "rtol": 1e-14}]
)
def test_it_is_scipys_bit_for_bit(tolerance):
    """With as many calls, of which each is at the same place."""
    for i in range(300):
        found = []
        for solve in (root_between, brentq):
            places, function = [], tempering(i)

            def watched(x, places=places, function=function):
                places.append(x)
                return function(x)

            found.append([solve(watched, 0.0, 1.0, **tolerance), *places])
        assert found[0] == found[1]


@pytest.mark.parametrize(("low", "high"), CUBIC)
def test_other_functions_and_places(low, high):
    """Roots of x^3 - x / 2 - 0.1: what it takes is what scipy takes, both ways round."""

    def function(x):
        return x**3 - 0.5 * x - 0.1

    tolerance = {"xtol": 1e-12, "rtol": 1e-12}
    assert root_between(function, low, high, **tolerance) == brentq(
        function, low, high, **tolerance
    )


def test_ends_and_errors():
    tolerance = {"xtol": 1e-12, "rtol": 1e-12}
    assert root_between(lambda x: x, 0.0, 1.0, **tolerance) == 0.0
    assert root_between(lambda x: x - 1.0, 0.0, 1.0, **tolerance) == 1.0
    with pytest.raises(ValueError, match="same sign at 1 and 2"):
        root_between(lambda x: x, 1.0, 2.0, **tolerance)
    with pytest.raises(ArithmeticError, match="100 steps"):
        root_between(lambda x: 1.0 if x > 1e-200 else -1.0, 0.0, 1.0, xtol=1e-300, rtol=1e-14)
