"""After a training: solver steps by convergence, and the density of held-out rows."""

import numpy as np
import pytest
from scipy.stats import norm

from breaker.common.randomness import generator
from breaker.paper.bank import truth
from breaker.paper.training import convergence, held_out_log_density, records
from tests.networks_fixtures import COUPLING_FLOW, NETWORK, bank_of, frozen, perturb, pin

STEPS = [1, 2, 4]


@pytest.fixture(scope="module")
def curved():
    posterior = frozen()
    perturb(posterior.inference, 0.15)
    return posterior


@pytest.fixture(scope="module")
def measured(curved):
    return records(curved, bank_of(curved, 3, seed=7), 1)


def chosen(posterior, measured, tolerance):
    more = {"candidates": STEPS, "reference": 16, "tolerance": tolerance}
    return convergence(posterior, measured, 1, **more)


def test_the_fewest_steps_within_the_tolerance_are_chosen(curved, measured):
    """For draws and for densities, each by its own difference; the most if none is within it.
    Differences of draws are in posterior sds."""
    result = chosen(curved, measured, 1e3)
    assert result.solver_steps.values.tolist() == STEPS
    assert result.attrs["reference_steps"] == 16
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
    assert (np.diff(draws) < 0).all()
    assert (np.diff(densities) < 0).all()
    for tolerance in (1e3, draws[1], densities[1], 1e-12):
        result = chosen(curved, measured, tolerance)
        for values, key, steps in (
            (draws, "chosen_steps", curved.steps),
            (densities, "chosen_density_steps", curved.density_steps),
        ):
            expected = next((k for k, x in zip(STEPS, values, strict=True) if x <= tolerance), 4)
            assert result.attrs[key] == steps == expected


def test_a_network_without_solver_takes_one_step(measured):
    """Differences are zero by construction."""
    posterior = frozen(network={**NETWORK, "inference": COUPLING_FLOW})
    posterior.solver_steps.fill_(7)
    result = chosen(posterior, measured, 0.01)
    assert posterior.steps == posterior.density_steps == 1
    assert result.solver_steps.values.tolist() == [1]
    assert not any(result[name].values.any() for name in result.data_vars)
    assert result.attrs["solves"] == 0


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
