"""The information in records: against matrices, and between its ends."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.parameters import MOTIONS, NAMES
from breaker.paper.joint_model import Model, contraction_limit, limit_over_prior
from tests.model.laws import covariance

P = len(NAMES)


@pytest.mark.parametrize("changes", [{}, {"onset_sd": 0.0, "zero_sd": 0.0}])
@pytest.mark.parametrize("motion", MOTIONS)
def test_limit_in_plain_matrices(prior, sensor, motion, changes):
    """From curves of the model, differences of 4th order and the covariance written out."""
    model, step = Model(prior, replace(sensor, **changes), motion), 1e-3
    values = np.column_stack(model.sample(10, generator(1, "test", "limit")))[:, : len(model.names)]
    q = P + model.sensor.infers_onset
    limits = contraction_limit(model, values)
    inverse = np.linalg.inv(covariance(model.sensor))

    def curves(z):
        return model.curves(model.destandardise(z))

    for place, limit in zip(model.standardise(values), limits, strict=True):
        slopes = sum(
            weight * (curves(place + s * step * np.eye(q)) - curves(place - s * step * np.eye(q)))
            for s, weight in ((1, 8 / 12), (2, -1 / 12))
        )
        fisher = slopes @ inverse @ slopes.T / step**2
        expected = 1 - np.diag(np.linalg.inv(fisher + np.eye(q)))
        np.testing.assert_allclose(limit, expected, rtol=0, atol=1e-5)
    over_prior = limit_over_prior(model, 10, generator(1, "test", "limit"))
    np.testing.assert_array_equal(over_prior.contraction, limits)
    assert over_prior.output.values.tolist() == [*NAMES, "onset"][:q]
