"""Rows to train on, frozen inputs; after a training solver steps, and held-out density."""

from functools import partial

import numpy as np
import pytest
import torch
from scipy.stats import ks_2samp, norm

from breaker.common.randomness import generator
from breaker.paper.bank import principal_components, truth
from breaker.paper.posterior import Posterior
from breaker.paper.training import (
    OnlineRows,
    Rows,
    convergence,
    freeze_inputs,
    held_out_log_density,
    records,
    split,
)
from tests.model.laws import covariance, covariance_p_value
from tests.networks_fixtures import bank_of, frozen, perturb, pin, settings


@pytest.fixture(scope="module")
def posterior():
    return Posterior(settings())


@pytest.fixture(scope="module")
def bank(posterior):
    return bank_of(posterior, 2048)


@pytest.mark.parametrize("onset", [True, False])
def test_rows_are_what_the_posterior_infers(onset):
    posterior = Posterior(settings(onset=onset))
    bank = bank_of(posterior, 6)
    values = np.column_stack([bank.parameters.values, bank.onset.values])[:, : 8 if onset else 7]
    rows = Rows.of(bank, posterior)
    np.testing.assert_allclose(rows.z, posterior.model.standardise(values), rtol=0, atol=1e-6)
    np.testing.assert_array_equal(rows.travel, bank.travel.values)
    assert split(2048, 100, 48) == [slice(0, 1900), slice(1900, 2000), slice(2000, 2048)]


def test_batches_have_fresh_noise_of_the_sensor(bank, posterior):
    rows, rng = Rows.of(bank, posterior), torch.Generator().manual_seed(1)
    first, second = (rows.draw(torch.full((3000,), 3), rng) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        assert torch.equal(one, other) == (one is first.z)
    assert (first.noise.shape, first.time.shape) == ((3000, 2, 8), (3000, 2, 1))
    assert torch.equal(first.noise[:, 0], -first.noise[:, 1])
    assert ((first.time >= 0) & (first.time <= 1)).all()
    noise = (first.measured - rows.travel[3]).double().numpy()
    assert covariance_p_value(noise, covariance(posterior.sensor)) > 1e-3


def test_inputs_are_frozen_by_the_bank(bank):
    """The highway starts with the components, and the convolutions see unit variance."""
    posterior, travel = Posterior(settings()), bank.travel.values.astype(np.float64)
    freeze_inputs(posterior, bank, generator(1, "test components"))
    mean, weights = principal_components(travel, posterior.sensor, 8)
    summary = posterior.summary
    np.testing.assert_allclose(summary.centre, mean, rtol=1e-6)
    np.testing.assert_allclose(summary.highway.weight.detach(), weights.T, rtol=1e-6)
    assert summary.scale.item() == pytest.approx((travel - mean).std(), rel=1e-5)
    # One in 10,000 records of the bank is as far as that.
    records = posterior.sensor.corrupt(travel, generator(2, "test records"))
    assert 0.5 < np.quantile(posterior.distance(records), 0.999) < 1.0


def test_online_rows_are_new_operations_of_the_prior(posterior):
    """Kolmogorov-Smirnov of each parameter, false alarm 1e-3 in all; no row is seen twice."""
    rows, rng = OnlineRows(posterior), torch.Generator().manual_seed(1)
    z = torch.cat([rows.batch(step, 500, rng).z for step in range(4)])
    assert z.unique(dim=0).shape == z.shape
    known = Rows.of(bank_of(posterior, 5000), posterior).z
    p_values = [ks_2samp(one, other).pvalue for one, other in zip(z.T, known.T, strict=True)]
    assert min(p_values) > 1e-3 / z.shape[1]


STEPS = [1, 2, 4]


def test_the_fewest_steps_within_the_tolerance_are_chosen():
    """For draws and for densities, each by its own difference; the most if none is within it.
    Differences of draws are in posterior sds."""
    curved = frozen()
    perturb(curved.inference, 0.15)
    measured = records(curved, bank_of(curved, 3, seed=7), 1)
    choose = partial(convergence, curved, measured, 1, candidates=STEPS, reference=16)
    result = choose(tolerance=1e3)
    noise = generator(1, "solver", "closing").standard_normal((3, 100, 8))
    by = {}
    for steps in (16, 2):
        curved.solver_steps.fill_(steps)
        by[steps] = curved.model.standardise(curved.sample(measured, noise))
    expected = np.abs(by[2] - by[16]) / by[16].std(axis=1, ddof=1)[:, None]
    two = result.sel(solver_steps=2)
    assert float(two.mean_difference) == pytest.approx(expected.mean(), rel=1e-12)
    assert float(two.max_difference) == pytest.approx(expected.max(), rel=1e-12)
    draws, densities = result.mean_difference.values, result.density_difference.values
    for tolerance in (1e3, draws[1], densities[1], 1e-12):
        result = choose(tolerance=tolerance)
        for values, key in ((draws, "chosen_steps"), (densities, "chosen_density_steps")):
            expected = next((k for k, x in zip(STEPS, values, strict=True) if x <= tolerance), 4)
            assert result.attrs[key] == expected
        assert curved.solver_steps == result.attrs["chosen_steps"]
        assert curved.density_solver_steps == result.attrs["chosen_density_steps"]


def test_held_out_density_of_a_gaussian_model():
    """In standardised outputs: the mean of normal log densities of the truth."""
    posterior = frozen()
    mean, sd = np.linspace(-0.4, 0.4, len(posterior.outputs)), 0.8
    pin(posterior, mean, sd)
    rows = bank_of(posterior, 40, seed=8)
    z = posterior.model.standardise(truth(rows, posterior.model))
    expected = norm(mean, sd).logpdf(z).sum(axis=1)
    density, error = held_out_log_density(posterior, records(posterior, rows, 1), rows)
    assert density == pytest.approx(expected.mean(), abs=1e-4)
    assert error == pytest.approx(expected.std(ddof=1) / np.sqrt(40), rel=1e-4)
