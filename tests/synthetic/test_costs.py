"""What each error of a record costs: each one some of what is known, and none gives it back."""

import numpy as np

from breaker.mechanism.parameters import NAMES
from breaker.model.discrepancy import Discrepancy
from breaker.model.joint import Model
from breaker.synthetic.costs import contraction_by_error


def test_every_error_costs_contraction(prior, sensor):
    ramp = np.linspace(0.0, 1.0, sensor.samples)
    left_out = Discrepancy(0.0 * ramp, np.zeros((7, sensor.samples)), ramp[None])
    model = Model(prior, sensor, "closing").leaving_out(left_out)
    cost = contraction_by_error(model, 20, 1)
    assert cost["error"].values.tolist() == ["noise", "zero", "onset", "left out"]
    assert cost["parameter"].values.tolist() == list(NAMES)
    steps = np.diff(cost.contraction.values, axis=0)
    assert steps.max() < 1e-9
    assert (steps.min(axis=1) < -1e-3).all()


def test_without_what_is_left_out_its_step_is_none(prior, sensor):
    cost = contraction_by_error(Model(prior, sensor, "opening"), 5, 1)
    onset, left_out = (cost.contraction.sel(error=name) for name in ("onset", "left out"))
    np.testing.assert_array_equal(onset, left_out)
