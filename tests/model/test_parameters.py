"""Names, order and scale of what is inferred, and scale factors of drives."""

import numpy as np
import pytest

from breaker.model.equations import closed_rest, own_time, pressed, spring_compression
from breaker.model.parameters import NAMES, PARAMETERS, Size, powers
from breaker.model.quantities import QUANTITIES


def test_order_and_units():
    """The order is that of every array on disk: changing it is changing the format."""
    assert NAMES == ("mu", "k_a", "k_b", "gamma_a", "gamma_b", "f", "L")
    units = ("1", "1/ms²", "1/ms²", "1/ms", "1/ms", "mm/ms²", "mm")
    assert tuple(parameter.unit for parameter in PARAMETERS) == units


def test_drives_that_stay_pressed_are_a_half_space_of_the_standardised_prior(prior):
    theta = prior.medians * np.exp(0.5 * np.random.default_rng(1).standard_normal((200, 7)))
    theta[:, NAMES.index("f")] *= 0.6  # so that some do not press their contact
    holds = theta[:, 5] > theta[:, 1] * theta[:, 6]
    assert 0 < holds.sum() < len(holds)
    assert np.array_equal(pressed(theta), holds)
    slope, offset = prior.condition
    assert np.array_equal(prior.standardise(theta) @ slope + offset > 0, holds)


def test_factors_follow_from_units():
    size = Size(2.0, 4.0)
    assert [size.factor(unit) for unit in ("1", "mm", "ms", "mm/ms²")] == [1, 2, 4, 0.125]
    assert all(size.factor(quantity.unit) > 0 for quantity in QUANTITIES.values())
    assert np.exp(np.log([2.0, 4.0]) @ powers()) == pytest.approx(size.factors)


@pytest.mark.parametrize("wrong", [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_a_size_needs_positive_factors(wrong):
    with pytest.raises(ValueError, match="Give positive ones"):
        Size(*wrong)


def test_forces_cancel_in_the_closed_rest_position(prior):
    theta = prior.sample(5, np.random.default_rng(1))
    _, k_a, k_b, _, _, f, gap = theta.T
    held = closed_rest(theta)
    np.testing.assert_allclose(f - k_a * held - k_b * (held - gap), 0.0, atol=1e-14)
    np.testing.assert_allclose(spring_compression(theta), held - gap, rtol=1e-12)
    for motion, time in (("closing", np.sqrt(gap / f)), ("opening", 1 / np.sqrt(k_a))):
        np.testing.assert_allclose(own_time(theta, motion), time)
