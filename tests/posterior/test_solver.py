"""After a training: solver steps by convergence, and the density of held-out rows."""

import numpy as np
import pytest
from scipy.stats import norm

from breaker.common.randomness import generator
from breaker.paper.bank import truth
from breaker.paper.training import convergence, held_out_log_density, records
from tests.networks_fixtures import COUPLING_FLOW, NETWORK, bank_of, frozen, perturb, pin

SOLVER = {"candidates": [8, 1, 2, 4], "reference": 32, "curves": 6, "draws": 30, "tolerance": 10.0}
SOLVER["density_tolerance"] = 1e3


@pytest.fixture
def curved():
    posterior = frozen()
    perturb(posterior.inference, 0.15)
    return posterior


@pytest.fixture
def measured(curved):
    return records(curved, bank_of(curved, 6, seed=7), 1)


def test_the_fewest_steps_within_the_tolerance_are_chosen(curved, measured):
    result = convergence(curved, measured, SOLVER, 1)
    means = result.mean_difference.values
    assert result.solver_steps.values.tolist() == [1, 2, 4, 8]
    assert np.all(np.diff(means) < 0)
    assert np.all(result.max_difference.values > means)
    assert (result.attrs["chosen_steps"], curved.steps) == (1, 1)
    for k, steps in enumerate([1, 2, 4, 8]):
        result = convergence(curved, measured, SOLVER | {"tolerance": float(means[k])}, 1)
        assert (result.attrs["chosen_steps"], curved.steps) == (steps, steps)
        np.testing.assert_array_equal(result.mean_difference.values, means)
    assert result.attrs["reference_steps"] == 32


def test_differences_are_in_posterior_sds_of_standardised_outputs(curved, measured):
    result = convergence(curved, measured, SOLVER, 1)
    noise = generator(1, "solver", "closing").standard_normal((6, 30, 8))
    draws = {}
    for steps in (2, 32):
        curved.solver_steps.fill_(steps)
        draws[steps] = curved.model.standardise(curved.sample(measured, noise))
    sd = draws[32].std(axis=1, ddof=1)
    expected = np.abs(draws[2] - draws[32]) / sd[:, None]
    found = result.sel(solver_steps=2)
    assert float(found.mean_difference) == pytest.approx(expected.mean(), rel=1e-12)
    assert float(found.max_difference) == pytest.approx(expected.max(), rel=1e-12)
    first = convergence(curved, measured[:2], SOLVER, 1)
    assert convergence(curved, measured, SOLVER | {"curves": 2}, 1).identical(first)


def test_density_has_steps_of_its_own_by_its_own_tolerance(curved, measured):
    result = convergence(curved, measured, SOLVER, 1)
    found = result.density_difference.values
    assert np.all(np.diff(found) < 0)
    for k, steps in enumerate([1, 2, 4, 8]):
        settings = SOLVER | {"density_tolerance": float(found[k])}
        attrs = convergence(curved, measured, settings, 1).attrs
        assert (attrs["chosen_density_steps"], curved.density_steps) == (steps, steps)
        assert (attrs["chosen_steps"], curved.steps) == (1, 1)
    # By hand: log densities of every fifth of the finest draws.
    noise = generator(1, "solver", "closing").standard_normal((6, 30, 8))
    curved.solver_steps.fill_(32)
    points, density = curved.sample(measured, noise)[:, ::5], {}
    for steps in (2, 32):
        curved.density_solver_steps.fill_(steps)
        density[steps] = curved.log_prob(points, measured)
    expected = np.abs(density[2] - density[32]).mean()
    assert float(result.density_difference.sel(solver_steps=2)) == pytest.approx(expected, rel=1e-4)
    for key in ("tolerance", "density_tolerance"):
        message = (
            rf"no candidate of solver.candidates is within solver.{key} = 1e-12; .* more steps"
        )
        with pytest.raises(ValueError, match=message):
            convergence(curved, measured, SOLVER | {key: 1e-12}, 1)


def test_a_network_without_solver_takes_one_step(measured):
    """The same layout, differences of zero by construction, and said so."""
    network = {**NETWORK, "inference": COUPLING_FLOW}
    posterior = frozen(network=network)
    perturb(posterior.inference, 0.15)
    posterior.solver_steps.fill_(7)
    result = convergence(posterior, measured, SOLVER, 1)
    assert posterior.steps == 1
    assert result.solver_steps.values.tolist() == [1]
    assert float(result.mean_difference[0]) == float(result.max_difference[0]) == 0.0
    assert result.attrs["solves"] == 0
    assert {result.attrs[key] for key in result.attrs if key.endswith("_steps")} == {1}
    assert posterior.density_steps == 1
    with_solver = convergence(frozen(), measured, SOLVER, 1)
    assert with_solver.attrs["solves"] == 1
    assert set(with_solver.attrs) == set(result.attrs)
    assert set(with_solver.data_vars) == set(result.data_vars)
    rows = bank_of(posterior, 20, seed=8)
    assert np.isfinite(held_out_log_density(posterior, records(posterior, rows, 1), rows)).all()


@pytest.mark.parametrize("onset", [True, False])
def test_held_out_density_of_a_gaussian_model(onset):
    """In standardised outputs: the mean of normal log densities of the truth."""
    posterior = frozen(onset=onset)
    mean, sd = np.linspace(-0.4, 0.4, len(posterior.outputs)), 0.8
    pin(posterior, mean, sd)
    rows = bank_of(posterior, 40, seed=8)
    z = posterior.model.standardise(truth(rows, posterior.model))
    expected = norm(mean, sd).logpdf(z).sum(axis=1)
    found, error = held_out_log_density(posterior, records(posterior, rows, 1), rows)
    assert found == pytest.approx(expected.mean(), abs=1e-4)
    assert error == pytest.approx(expected.std(ddof=1) / np.sqrt(40), rel=1e-4)
