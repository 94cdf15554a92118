"""Modes of posteriors: reached from the prior's centre, at any noise, size and support."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model.parameters import MOTIONS, NAMES, Size
from breaker.paper.correction import correct
from studies.peers.mode import approximate, mode
from tests.corrections import from_prior

RECORDS = 6


def with_noise(model, noise_sd):
    return replace(model, sensor=replace(model.sensor, noise_sd=noise_sd))


def simulated(model, *purpose):
    rng = generator(1, "test mode", model.motion, *purpose)
    values = from_prior(model, RECORDS, rng)
    return model.standardise(values), model.sensor.corrupt(model.curves(values), rng)


@pytest.mark.parametrize("noise_sd", [0.003, 0.3])
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_mode_is_no_lower_than_the_truth(models, motion, noise_sd):
    """Twice what is gained over the truth is a chi-square of up to 8 degrees of freedom."""
    model, size = with_noise(models[motion], noise_sd), Size(10.0, 4.0)
    model = replace(model, prior=model.prior.sized(size), sensor=model.sensor.sized(size))
    for z, record in zip(*simulated(model), strict=True):
        highest, precision = mode(model, record)
        there, truth = model.log_joint(np.stack([highest, z]), record)
        assert truth - 1.0 < there < truth + 25.0
        assert np.all(np.linalg.eigvalsh(precision) > 0)


@pytest.mark.parametrize("motion", MOTIONS)
def test_no_step_from_the_mode_gains(models, motion):
    """Along each axis of the curvature, 0.3 sd either way; away from the mode some do."""
    model = models[motion]
    for record in simulated(model)[1]:
        highest, precision = mode(model, record)
        sds, axes = np.linalg.eigh(np.linalg.inv(precision))
        steps = 0.3 * np.sqrt(sds)[:, None] * axes.T
        around = np.concatenate([highest + steps, highest - steps])
        height = model.log_joint(highest[None], record)
        assert np.all(model.log_joint(around, record) < height)
        moved = highest + 3.0 * steps[-1]
        assert np.any(model.log_joint(moved + around - highest, record) > height - 0.4)


def test_a_mode_on_the_border_of_the_support_is_inside(models):
    """Of a prior whose opening spring is as strong as the closing force, and a record without."""
    model = models["opening"]
    medians = model.prior.medians.copy()
    medians[NAMES.index("f")] *= 0.62
    model = replace(model, prior=replace(model.prior, medians=medians))
    rng = generator(1, "test mode", "border")
    slope, offset = model.prior.condition
    for record in simulated(model)[1]:
        highest, _ = mode(model, record)
        assert slope @ highest[: len(slope)] + offset > 0
        found = correct(model, record, approximate(model, record, 200, rng), rng)
        assert found.resolved, found.reason


def test_draws_are_wider_than_the_curvature(models):
    """By the Student-t of 5: variance 5/3, within 10 %. And they repeat with their generator."""
    model = models["closing"]
    _, records = simulated(model)
    highest, precision = mode(model, records[0])
    rng = generator(1, "test mode", "draws")
    draws = approximate(model, records[0], 20_000, rng)
    z = (model.standardise(draws) - highest) @ np.linalg.cholesky(precision)
    np.testing.assert_allclose(z.T @ z / len(z), 5 / 3 * np.eye(8), atol=1 / 6)
    again = approximate(model, records[0], 20_000, generator(1, "test mode", "draws"))
    np.testing.assert_array_equal(draws, again)
