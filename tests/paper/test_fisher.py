"""The information in records: against matrices, and between its ends."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.parameters import MOTIONS, NAMES
from breaker.paper.joint_model import Model, contraction_limit, limit_over_prior, linearise
from tests.model.laws import covariance

P = len(NAMES)
PAPER = {"onset_sd": 0.0, "zero_sd": 0.0}


def model_of(prior, sensor, motion, **changes):
    return Model(prior, replace(sensor, **changes), motion)


def outputs_of(model, n):
    """Standardised outputs drawn from the prior, ``(n, q)``."""
    rng = generator(1, "test", "identifiability")
    z = np.column_stack([model.prior.standardise(model.prior.sample(n, rng)), np.zeros(n)])
    z[:, P] = rng.standard_normal(n)
    return z[:, : len(model.names)]


@pytest.mark.parametrize("changes", [{}, PAPER], ids=["default", "paper"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_limit_in_plain_matrices(prior, sensor, motion, changes):
    """From curves of the model, differences of 4th order and the covariance written out.

    Rounding and order leave some 1e-9 mm, and events that the steps carry across a sample more,
    here 1e-4 of the noise at most.
    """
    model = model_of(prior, sensor, motion, **changes)
    z, step, weights = outputs_of(model, 10), 1e-3, (8 / 12, -1 / 12)
    q = z.shape[1]
    assert q == P + model.sensor.infers_onset
    whitened = linearise(model, z)[1]
    limits = contraction_limit(model, model.destandardise(z))
    inverse = np.linalg.inv(covariance(model.sensor))
    for place, result, limit in zip(z, whitened, limits, strict=True):
        slopes = sum(
            weight * (model.curves(model.destandardise(place + s * step * np.eye(q))) - behind)
            for s, weight in enumerate(weights, start=1)
            for behind in [model.curves(model.destandardise(place - s * step * np.eye(q)))]
        )
        slopes /= step
        np.testing.assert_allclose(result, model.sensor.whiten(slopes), rtol=0, atol=1e-3)
        fisher = slopes @ inverse @ slopes.T
        np.testing.assert_allclose(result @ result.T, fisher, rtol=1e-4, atol=1e-3)
        expected = 1 - np.diag(np.linalg.inv(fisher + np.eye(q)))
        np.testing.assert_allclose(limit, expected, rtol=0, atol=1e-5)
    over_prior = limit_over_prior(model, 10, generator(1, "test", "limit"))
    theta, onset = model.sample(10, generator(1, "test", "limit"))
    expected = contraction_limit(model, np.column_stack([theta, onset])[:, :q])
    np.testing.assert_array_equal(over_prior.contraction, expected)
    assert over_prior.output.values.tolist() == [*NAMES, "onset"][:q]
