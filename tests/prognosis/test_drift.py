"""The drift of the rate of wear: what a path tells of it, and how far it leads."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.prognosis.drift import Drift
from breaker.prognosis.path_fit import Block
from breaker.prognosis.tracker import Tracker

ONE = np.ones(1)


def worn(law, seed=1, size=20.0):
    """A path of three coordinates, worn by a law of the share of the life, 80 % of 500 records."""
    rng, share = np.random.default_rng(seed), np.arange(1, 401) / 500.0
    values = rng.standard_normal((400, 3)) + np.outer(size * law(share), [1.0, -0.5, 0.0])
    return Tracker().follow(np.arange(1, 401), [Block(values, np.full(3, 1e3))])


def drift(path, at=399):
    return Drift.of(path, np.array([at]), np.array([float(at)]), 1.0, 0.4, 1)


@pytest.mark.parametrize(
    ("law", "low", "high"),
    [
        (lambda u: u, -0.4, 0.4),
        (lambda u: u**2, 0.6, 1.3),
        (lambda u: -np.expm1(-1.6 * u) / -np.expm1(-1.6), -4.0, -0.6),
    ],
)
def test_a_path_that_bends_shows_its_drift(law, low, high):
    """A power of 2 has a drift of 1; what saturates like this one, of -1.28 at 80 % of its life.

    A parabola shows that larger than it is.
    """
    found = drift(worn(law))
    assert low < found.mean[0] < high
    assert 0.3 < found.sd[0] < 0.7


def test_a_path_that_shows_nothing_leaves_the_prior():
    found = drift(worn(lambda u: 0.0 * u))
    assert abs(found.mean[0]) < 0.8
    assert found.sd[0] > 0.4
    none = np.zeros((1, 3))
    still = SimpleNamespace(rate=none, bend=none, bend_variance=none + 1.0)
    assert Drift.of(still, np.array([0]), ONE, 0.7, 0.4, 1)[:2] == (0.0, pytest.approx(0.7))


@pytest.mark.parametrize("power", [-1.5, -1.0, -0.4, 0.0, 0.5, 2.0])
def test_operations_ahead_are_those_in_which_the_rate_adds_up(power):
    ahead, age = np.linspace(0.0, 700.0, 100001), 300.0
    rate = (1.0 + ahead / age) ** power
    made = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(ahead)))
    found = Drift(power * ONE, 0.0 * ONE, age * ONE, 1).operations(made[None, ::1000])
    np.testing.assert_allclose(found[0], ahead[::1000], rtol=1e-5, atol=1e-6)


def test_draws_are_drives_with_heavy_tails_and_what_never_comes_never_does():
    some = Drift(np.array([0.0, 1.0]), np.array([0.5, 0.5]), np.array([100.0, 200.0]), 1)
    draws = some.draws(200)
    np.testing.assert_allclose(draws[1] - draws[0], 1.0)
    np.testing.assert_array_equal(draws, some.draws(200))
    assert np.median(draws[0]) == pytest.approx(0.0, abs=0.01)
    assert draws[0].max() > 2.5  # 5 sd, of 200 draws
    assert np.isinf(some.operations(np.full((2, 200), np.inf))).all()
    assert not some.operations(np.zeros((2, 200))).any()
