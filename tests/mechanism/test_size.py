"""Sizes: the mechanism moves on the same curve, whatever the units of length and time."""

import numpy as np
import pytest

from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS, PARAMETERS
from breaker.mechanism.quantities import QUANTITIES
from breaker.mechanism.size import Size, powers


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("size", [Size(0.44, 0.1), Size(10.35, 4.46), Size(14.8, 38.0)])
def test_curves_scale_exactly(prior, motion, size):
    theta, times = prior.medians, np.linspace(-2.0, 58.0, 151)
    plain = travel(theta[None], times, motion, onset=0.3)
    large = travel(theta[None] * size.factors, times * size.times, motion, onset=0.3 * size.times)
    assert np.abs(large.travel / size.lengths - plain.travel).max() < 1e-9
    assert large.switching == pytest.approx(plain.switching * size.times, rel=1e-9)


def test_factors_follow_from_units():
    size = Size(2.0, 4.0)
    assert [size.factor(unit) for unit in ("1", "mm", "ms", "mm/ms²")] == [1, 2, 4, 0.125]
    for quantity in (*PARAMETERS, *QUANTITIES.values()):
        assert size.factor(quantity.unit) > 0
    assert np.exp(np.log([2.0, 4.0]) @ powers()) == pytest.approx(size.factors)


@pytest.mark.parametrize("wrong", [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_no_size(wrong):
    with pytest.raises(ValueError, match="must be positive"):
        Size(*wrong)
