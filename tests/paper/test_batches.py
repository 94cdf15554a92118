"""Batches: rows set apart, fresh zero and noise of the right covariance, frozen inputs."""

import numpy as np
import pytest
import torch
from scipy.stats import ks_2samp

from breaker.common.randomness import generator
from breaker.paper.bank import truth
from breaker.paper.posterior import Posterior
from breaker.paper.training import OnlineRows, Rows, freeze_inputs, split
from tests.model.laws import covariance, covariance_p_value
from tests.networks_fixtures import SENSOR, bank_of, settings


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
    np.testing.assert_array_equal(truth(bank, posterior.model), values)
    rows = Rows.of(bank, posterior, torch.device("cpu"))
    np.testing.assert_allclose(
        rows.z.numpy(), posterior.model.standardise(values), rtol=0, atol=1e-6
    )
    np.testing.assert_array_equal(rows.travel.numpy(), bank.travel.values)
    assert split(2048, 100, 48) == [slice(0, 1900), slice(1900, 2000), slice(2000, 2048)]


def test_noise_is_fresh_and_has_the_covariance_of_the_sensor(bank, posterior):
    rows = Rows.of(bank, posterior, torch.device("cpu"))
    drawn = rows.draw(torch.full((3000,), 3), torch.Generator().manual_seed(1)).measured
    noise = (drawn - rows.travel[3]).double().numpy()
    assert covariance_p_value(noise, covariance(posterior.sensor)) > 1e-3
    assert np.unique(noise[:, 0]).size > 2900


def test_batches_follow_their_generator(bank, posterior):
    rows, chosen = Rows.of(bank, posterior, torch.device("cpu")), torch.tensor([5, 0, 5, 9])
    rng = torch.Generator().manual_seed(1)
    first, second = rows.draw(chosen, rng), rows.draw(chosen, rng)
    again = rows.draw(chosen, torch.Generator().manual_seed(1))
    for one, other, same in zip(first, second, again, strict=True):
        assert torch.equal(one, same)
        assert torch.equal(one, other) == (one is first.z)
    assert torch.equal(first.z, rows.z[chosen])
    assert first.measured.shape == (4, SENSOR["samples"])
    assert (first.noise.shape, first.time.shape) == ((4, 2, 8), (4, 2, 1))
    assert torch.equal(first.noise[:, 0], -first.noise[:, 1])
    assert ((first.time >= 0) & (first.time <= 1)).all()
    assert not torch.equal(first.measured[0], first.measured[2])


def test_frozen_inputs_give_highway_outputs_of_unit_variance(bank):
    """Over records of the bank, noise included.

    Their mean squares are one but for the noise of n records, of standard deviation
    sqrt(4 v + 2) / (1 + v) / sqrt(n), at most sqrt(2 / n), for a signal of variance v. Eight
    components within 4 standard deviations: false-alarm probability 5e-4.
    """
    posterior = Posterior(settings())
    travel = bank.travel.values.astype(np.float64)
    freeze_inputs(posterior, bank, generator(1, "test components"))
    records = posterior.sensor.corrupt(travel, generator(2, "test records"))
    with torch.no_grad():
        centred = torch.from_numpy(records).float() - posterior.summary.centre
        outputs = posterior.summary.highway(centred).double().numpy()
    bound = 4 * np.sqrt(2 / len(travel))
    assert np.abs(np.square(outputs).mean(axis=0) - 1).max() < bound
    # The convolutions see the curves centred and of unit variance.
    assert posterior.summary.scale.item() == pytest.approx(
        (travel - travel.mean(0)).std(), rel=1e-5
    )
    np.testing.assert_allclose(posterior.summary.centre.numpy(), travel.mean(0), atol=1e-5)


def test_online_rows_are_new_operations_of_the_prior(posterior):
    """Kolmogorov-Smirnov of each parameter, false alarm 1e-3 in all; other rows at each step."""
    rows, rng = OnlineRows(posterior), torch.Generator().manual_seed(1)
    z = [rows.batch(step, 500, rng).z for step in range(4)]
    again = rows.batch(0, 500, torch.Generator().manual_seed(1)).z
    assert torch.equal(again, z[0])
    known = Rows.of(bank_of(posterior, 5000), posterior).z
    together = torch.cat(z)
    assert together.unique(dim=0).shape == together.shape
    for one, other in zip(together.T, known.T, strict=True):
        assert ks_2samp(one, other).pvalue > 1e-3 / together.shape[1]
    assert ks_2samp(1.5 * together[:, 0], known[:, 0]).pvalue < 1e-6
