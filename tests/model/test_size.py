"""Models of drives of another size: the same density, whatever the unit of lengths and times."""

import numpy as np
import pytest

from breaker.mechanism.size import Size
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.model.sensor import Sensor

SIZE = Size(10.0, 4.0)
SENSOR = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_the_joint_density_scales(prior, motion):
    """The density of a scaled record differs by the unit of travel alone, at all outputs."""
    rng = generator(1, "test", "joint", motion)
    small = Model(prior, SENSOR, motion)
    large = small.sized(SIZE)
    assert large.prior.medians == pytest.approx(prior.medians * SIZE.factors)
    z = 0.5 * rng.standard_normal((20, 8))
    record = SENSOR.corrupt(small.curves(small.destandardise(z[:1])), rng)[0]
    difference = small.log_joint(z, record) - large.log_joint(z, SIZE.lengths * record)
    assert np.ptp(difference) < 1e-6
    assert difference[0] == pytest.approx(151 * np.log(SIZE.lengths))
