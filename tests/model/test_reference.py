"""The reference drive is that of the defaults."""

import pytest

from breaker.mechanism.parameters import MOTIONS
from breaker.model.prior import Prior
from breaker.model.reference import reference_model
from breaker.model.sensor import Sensor
from breaker.shipped import DEFAULTS
from breaker.workflow.configuration import read


@pytest.mark.parametrize("motion", MOTIONS)
def test_it_is_that_of_the_defaults(motion):
    model, defaults = reference_model(motion), read(DEFAULTS)
    prior = Prior.from_settings(defaults["prior"])
    assert model.motion == motion
    assert model.prior.medians == pytest.approx(prior.medians)
    assert model.prior.log_sds == pytest.approx(prior.log_sds)
    assert model.sensor.settings() == Sensor.from_settings(defaults["sensor"]).settings()
    assert model.sensor.discrepancy.factor.shape == (20, 151)
    assert reference_model(motion, 0.0).sensor.discrepancy is None
    twice = reference_model(motion, 2.0).sensor.discrepancy
    assert twice.sd == pytest.approx(2.0 * model.sensor.discrepancy.sd)
