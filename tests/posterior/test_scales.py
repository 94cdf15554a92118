"""One network for every scale of what the model leaves out: batches, conditions, files, records."""

import numpy as np
import pytest
import torch
import xarray as xr
from safetensors import safe_open
from safetensors.torch import save_file
from scipy.stats import binom, chi2, kstest

from breaker.model.randomness import generator
from breaker.model.saved import ModelFileError
from breaker.posterior.batches import Rows, freeze_inputs
from breaker.posterior.estimator import SCALES, Posterior
from breaker.posterior.exactness import correct_validation, judge
from breaker.posterior.predictive import infer, predict, predictive_p_value, validate
from breaker.posterior.solver import records as records_of
from breaker.posterior.training import Trainer
from tests.networks_fixtures import (
    COMBINATIONS,
    DEEP_SET,
    MARKS,
    NETWORK,
    TRAINING,
    bank_of,
    certain_of,
    curved_model,
    exact_curves,
    frozen,
    left_out,
    noise_of,
    one_thread,  # noqa: F401
    settings,
    weights,
)

pytestmark = MARKS

KNOWN = left_out()


@pytest.fixture(scope="module")
def curved():
    """A network that depends on its record and on the scale, and records."""
    return curved_model(discrepancy=KNOWN)


def covariance(sensor, scale):
    """Of a record about its expected curve, written out."""
    t = sensor.samples
    error = scale**2 * KNOWN.factor.T @ KNOWN.factor
    return sensor.noise_sd**2 * np.eye(t) + sensor.zero_sd**2 * np.ones((t, t)) + error


def squares(residual, sensor, scale):
    """Squared Mahalanobis distances of residuals ``(n, t)``, by matrices."""
    return np.einsum("nt,ts,ns->n", residual, np.linalg.inv(covariance(sensor, scale)), residual)


def expected_curves(posterior, values, scale):
    """Curves with the mean of what the model leaves out, without the code under test."""
    z = posterior.standardise(values)[:, :7]
    return exact_curves(posterior, values) + scale * (KNOWN.mean + z @ KNOWN.slopes)


# ---- batches ------------------------------------------------------------------------------------


def p_value_of_batch(rows, posterior, n=3000):
    """p-value of the squares of a batch of one row under each record's own scale."""
    batch = rows.draw(torch.full((n,), 3), torch.Generator().manual_seed(1))
    z = batch.z[:1, :7].double().numpy()
    shift, scale = KNOWN.mean + z @ KNOWN.slopes, batch.scale.double().numpy()
    residual = batch.measured.double().numpy() - rows.travel[3].double().numpy() - scale * shift
    p_values = []
    for axes in (np.eye(residual.shape[1]), KNOWN.factor):  # all samples, and along the error
        wholes = [axes @ covariance(posterior.sensor, each) @ axes.T for each in scale[:, 0]]
        part = residual @ axes.T
        square = np.einsum("nt,nts,ns->n", part, np.linalg.inv(wholes), part)
        p_values.append(kstest(square, chi2(len(axes)).cdf).pvalue)
    return 2 * min(p_values)


def test_batches_have_the_covariance_of_their_scales():
    """Kolmogorov-Smirnov, false alarm 1e-3; so is the test of scales.

    Planted faults: the mean forgotten, and an error that is a tenth too small.
    """
    posterior = Posterior(settings(), discrepancy=KNOWN)
    rows = Rows.of(bank_of(posterior, 64), posterior, torch.device("cpu"))
    assert p_value_of_batch(rows, posterior) > 1e-3
    mean, factor = rows.left_out
    for wrong in ((0 * mean, factor), (mean, 0.9 * factor)):
        rows.left_out = wrong
        assert p_value_of_batch(rows, posterior) < 1e-4


def test_four_in_ten_scales_are_zero_and_the_others_are_uniform():
    posterior = Posterior(settings(), discrepancy=KNOWN)
    rows = Rows.of(bank_of(posterior, 8), posterior, torch.device("cpu"))
    chosen = torch.zeros(6000, dtype=torch.int64)
    scale = rows.draw(chosen, torch.Generator().manual_seed(1)).scale.numpy()[:, 0]
    none = (scale == 0).sum()
    assert binom.cdf(none, 6000, 0.4) > 5e-4  # 1e-3 together
    assert binom.sf(none - 1, 6000, 0.4) > 5e-4
    assert kstest(scale[scale > 0] / SCALES[-1], "uniform").pvalue > 1e-3


def test_samples_are_missing_as_ever():
    network = {"summary": DEEP_SET, "inference": NETWORK["inference"]}
    posterior = Posterior(settings(network=network), discrepancy=KNOWN)
    rows = Rows.of(bank_of(posterior, 64), posterior, torch.device("cpu"))
    batch = rows.draw(torch.arange(64), torch.Generator().manual_seed(1))
    assert 0.1 < batch.measured.isnan().double().mean() < 0.4
    assert batch.scale.isfinite().all()
    assert np.isfinite(posterior.loss(*batch).detach().numpy()).all()


# ---- one network for all scales -----------------------------------------------------------------


def test_a_posterior_at_a_scale_shares_the_weights(curved):
    posterior, records = curved
    half = posterior.at(0.5)
    assert (posterior.scale, half.scale) == (0.0, 0.5)
    assert half.inference is posterior.inference
    np.testing.assert_array_equal(half.sensor.discrepancy.factor, 0.5 * KNOWN.factor)
    assert posterior.sensor.discrepancy is None
    assert half.at(0.0).sensor.discrepancy is None
    assert half.at(0).sensor == posterior.sensor
    noise = noise_of(posterior, 5, 20)
    draws = [posterior.at(scale).sample(records, noise) for scale in (0.0, 0.5, 2.0)]
    np.testing.assert_array_equal(draws[0], posterior.sample(records, noise))
    assert not np.any(draws[0] == draws[1])
    assert not np.any(draws[1] == draws[2])
    # And so do densities, at the same points.
    density = [posterior.at(scale).log_prob(draws[0], records) for scale in (0.0, 2.0)]
    assert np.abs(density[0] - density[1]).min() > 0
    # A network after all: a little more of the scale changes a little.
    near = posterior.at(0.5001).sample(records, noise)
    np.testing.assert_allclose(near, draws[1], rtol=1e-2, atol=1e-3)


def test_scales_that_a_network_does_not_take_are_refused(curved):
    posterior, _ = curved
    for scale in (-0.1, 2.1, np.nan):
        with pytest.raises(ValueError, match=r"takes scales from 0 to 2, not"):
            posterior.at(scale)
    plain = Posterior(settings())
    assert plain.at(0.0).sensor == plain.sensor
    with pytest.raises(ValueError, match=r"of closing .* set endurance.discrepancy to 0"):
        plain.at(1.0)


def test_without_discrepancy_networks_are_told_nothing():
    plain, told = Posterior(settings()), Posterior(settings(), discrepancy=KNOWN)
    scale = torch.tensor([[0.0], [1.0]])
    assert plain.conditions(scale) == ()
    (numbers,) = told.conditions(scale)
    assert numbers.shape == (2, 2)
    assert (numbers[0] == 0).all()
    count = [sum(each.numel() for each in p.parameters()) for p in (plain, told)]
    assert count[1] > count[0]


def test_another_grid_is_refused():
    with pytest.raises(ValueError, match="of 30 samples"):
        Posterior(settings(), discrepancy=left_out(30))


def test_frozen_inputs_know_each_scale():
    """At every scale few fresh records are unlike the bank, and at 0 those of scale 2 are.

    The 0.9999 quantile of 2,048 records lies between their two largest distances, and between
    scales it is interpolated: seven of 500 beyond it have a probability below 1e-4.
    """
    posterior = Posterior(settings(), discrepancy=left_out(size=1.5))
    bank = bank_of(posterior, 2048)
    freeze_inputs(posterior, bank, generator(1, "test components"))
    assert (np.diff(posterior.margin.numpy()) > 0).all()
    rows = bank_of(posterior, 500, seed=9)
    far = {scale: records_of(posterior.at(scale), rows, 1) for scale in (0.0, 0.5, 1.0, 1.5, 2.0)}
    for scale, records in far.items():
        assert (posterior.at(scale).distance(records) > 1).sum() < 7
    assert (posterior.distance(far[2.0]) > 1).mean() > 0.3


@pytest.mark.parametrize("name", COMBINATIONS)
def test_every_combination_trains_with_scales(tmp_path, name):
    """A nat on fixed records of all scales. Planted: a training that does not move gains none."""
    gains = []
    for rate in (2e-2, 0.0):
        posterior = frozen(network=COMBINATIONS[name], curves=400, discrepancy=KNOWN).train()
        bank, device = bank_of(posterior, 400), torch.device("cpu")
        more = {"steps": 60, "batch": 48, "ema": 0.8, "evaluate_every": 60, "learning_rate": rate}
        trainer = Trainer(
            posterior=posterior,
            rows=Rows.of(bank.isel(curve=slice(24, None)), posterior, device),
            validation=Rows.of(bank.isel(curve=slice(24)), posterior, device),
            settings=TRAINING | more,
            seed=1,
            checkpoint=tmp_path / "state.pt",
            fingerprint=f"{rate}",
        )
        batch = trainer.fixed_batch
        assert (batch.scale > 0).any()
        with torch.no_grad():
            start = -posterior.log_density(*batch[:3], steps=8).mean().item()
        gains.append(start - float(trainer.run().validation_loss[-1]))
    assert gains[0] > 1.0
    assert gains[1] == pytest.approx(0.0, abs=1e-5)


# ---- model files --------------------------------------------------------------------------------


def test_a_model_file_keeps_what_the_model_leaves_out(curved, tmp_path):
    posterior, records = curved
    posterior.at(1.0).save(tmp_path / "m.safetensors")
    loaded = Posterior.load(tmp_path / "m.safetensors")
    assert loaded.scale == 0.0
    for name in ("mean", "slopes", "factor"):
        np.testing.assert_array_equal(getattr(loaded.discrepancy, name), getattr(KNOWN, name))
    noise = noise_of(posterior, 5, 20)
    for scale in (0.0, 1.0):
        one, other = posterior.at(scale), loaded.at(scale)
        draws = one.sample(records, noise)
        np.testing.assert_array_equal(other.sample(records, noise), draws)
        np.testing.assert_array_equal(other.log_prob(draws, records), one.log_prob(draws, records))
        np.testing.assert_array_equal(other.distance(records), one.distance(records))
    assert weights_of(loaded).keys() == weights_of(posterior).keys()


def weights_of(posterior):
    return weights(type("Training", (), {"posterior": posterior}))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.pop("discrepancy.mean"), "KeyError: 'mean'"),
        (
            lambda t: t.update({"discrepancy.lag_sd": torch.ones((), dtype=torch.float64)}),
            "KeyError: 'lag_mean'",
        ),
        (
            lambda t: t.update({"discrepancy.more": torch.ones(3, dtype=torch.float64)}),
            "discrepancy.more is not known",
        ),
        (lambda t: t.update({"discrepancy.mean": torch.zeros(30)}), "is of float32"),
        (
            lambda t: t.update({"discrepancy.mean": torch.zeros(30, dtype=torch.float64)}),
            "do not describe a model",
        ),
        (
            lambda t: [t.pop(f"discrepancy.{name}") for name in ("mean", "slopes", "factor")],
            "has the shape",
        ),
    ],
)
def test_a_file_whose_discrepancy_does_not_fit_is_refused(curved, tmp_path, change, message):
    curved[0].save(tmp_path / "m.safetensors")
    with safe_open(str(tmp_path / "m.safetensors"), framework="pt") as file:
        tensors, header = {n: file.get_tensor(n) for n in file.keys()}, file.metadata()  # noqa: SIM118
    change(tensors)
    del header["checksum"]  # else any change is noticed by it, whatever it is
    save_file(tensors, tmp_path / "broken.safetensors", metadata=header)
    with pytest.raises(ModelFileError, match=message):
        Posterior.load(tmp_path / "broken.safetensors")


# ---- records, predictions, exactness ------------------------------------------------------------


@pytest.mark.parametrize("make", ["validate", "solver"])
def test_records_are_of_the_scale(make):
    """Chi-square with a false alarm of 1e-3. Planted faults: another scale, the mean forgotten."""
    posterior = frozen(discrepancy=KNOWN)
    at = posterior.at(1.0)
    if make == "validate":
        data = validate(at, 60, 4, seed=11)
        values, measured = data.truth.values, data.measured.values
    else:
        bank = bank_of(posterior, 60, seed=11)
        values = np.column_stack([bank.parameters.values, bank.onset.values])
        measured = records_of(at, bank, 1)
    low, high = chi2.interval(1 - 1e-3, measured.size)
    sensor = posterior.sensor
    residual = measured - expected_curves(posterior, values, 1.0)
    assert low < squares(residual, sensor, 1.0).sum() < high
    assert squares(residual, sensor, 0.5).sum() > high
    assert squares(measured - exact_curves(posterior, values), sensor, 1.0).sum() > high


def test_validation_at_scale_zero_is_that_of_a_model_that_is_right():
    """The same records, bit for bit."""
    plain, told = frozen(), frozen(discrepancy=KNOWN)
    one, other = validate(plain, 6, 4, seed=11), validate(told.at(0.0), 6, 4, seed=11)
    np.testing.assert_array_equal(one.measured, other.measured)
    np.testing.assert_array_equal(one.truth, other.truth)


@pytest.fixture(scope="module")
def drawn():
    """A posterior at scale 1, with values, expected curves and records."""
    posterior = frozen(discrepancy=KNOWN).at(1.0)
    bank = bank_of(posterior, 400, seed=12)
    values = np.column_stack([bank.parameters.values, bank.onset.values])
    return (
        posterior,
        values,
        expected_curves(posterior, values, 1.0),
        records_of(posterior, bank, 2),
    )


def test_p_values_are_nominal_under_the_error(drawn):
    """Uniform at the truth, with a false alarm of 1e-3, also where samples are missing.

    Planted fault: judged by the model that is right, nearly every record is impossible.
    """
    posterior, values, _, records = drawn
    lost = np.random.default_rng(1).random(records.shape) < 0.2
    for each in (records, np.where(lost, np.nan, records)):
        found = [
            predictive_p_value(posterior.model, record, row[None])
            for record, row in zip(each, values, strict=True)
        ]
        assert kstest(found, "uniform").pvalue > 1e-3
    plain = posterior.at(0.0).model
    pairs = zip(records, values, strict=True)
    wrong = [predictive_p_value(plain, record, row[None]) for record, row in pairs]
    assert np.mean(np.array(wrong) < 1e-3) > 0.9


def test_bands_follow_the_errors_that_a_repetition_shares(drawn):
    """Median and ends by the normal conditional in matrices.

    Bounds as in the test of zero and noise alone: 4.4 standard errors of quantiles of 2,000
    replicates. Planted fault: the shared errors not followed, so that bands are about the mean.
    """
    posterior, values, curves, records = (each[:3] if k else each for k, each in enumerate(drawn))
    band = predict(posterior.model, records, certain_of(values, 2000), seed=1)
    whole, noise = covariance(posterior.sensor, 1.0), posterior.sensor.noise_sd**2
    shared = whole - noise * np.eye(len(whole))
    gain = np.linalg.solve(whole, shared).T
    mean = curves + (records - curves) @ gain.T
    sd = np.sqrt(noise + np.diag(shared - gain @ shared))
    for name, expected, error in (
        ("median", mean, 1.25),
        ("lower", mean - 1.959964 * sd, 2.7),
        ("upper", mean + 1.959964 * sd, 2.7),
    ):
        off = np.abs(band[name].values - expected) / (sd * error / np.sqrt(2000))
        assert off.max() < 4.4, name
    assert np.abs(curves - mean).max() > 5 * sd.max()


@pytest.mark.filterwarnings("ignore:overflow encountered")  # of the fault: far from any record
def test_corrections_reach_the_exact_posterior_of_the_scale():
    """Simulation-based calibration of corrected draws, at scale 1, from a prior's worth of draws.

    Ranks of the truth of 40 records are uniform: Kolmogorov-Smirnov over 8 outputs with a false
    alarm of 1e-3 together. Planted fault: corrected under the model that is right.
    """
    posterior = frozen(discrepancy=left_out(size=0.6)).at(1.0)
    data = validate(posterior, 40, 200, seed=13)
    correction = {
        "round_draws": 500,
        "efficiency": 0.5,
        "fit_size": 100,
        "draws": 600,
        "smallest_size": 100,
        "largest_k": 0.7,
    }

    def p_value(model, rounds):
        found = correct_validation(model, data, correction | {"rounds": rounds}, seed=1)
        ranks = (found.draws.values < found.truth.values[:, None]).mean(axis=1)
        return 8 * min(kstest(column, "uniform").pvalue for column in ranks.T), found

    right, found = p_value(posterior.model, 20)
    assert right > 1e-3
    assert found.resolved.values.mean() > 0.9
    wrong, _ = p_value(posterior.at(0.0).model, 4)
    assert wrong < 1e-6
    # The gap of a network that is the prior is its distance from these posteriors: many nats.
    judged = judge(posterior, data.isel(curve=slice(10)), found)
    assert np.isfinite(judged.gap.values).all()
    assert judged.gap.values.mean() > 1.0


def test_measured_curves_are_inferred_at_the_scale(drawn):
    """What fits with the error is a misfit without."""
    posterior, _, _, records = (each[:4] if k else each for k, each in enumerate(drawn))
    curves = xr.Dataset(
        {
            "travel": (("operation", "time"), records),
            "accepted": ("operation", np.ones(4, dtype=bool)),
            "reason": ("operation", np.full(4, "", dtype=str)),
            "file": ("operation", np.array(list("abcd"))),
        },
        coords={"operation": [1, 2, 3, 4], "time": posterior.sensor.times},
    )
    common = {"draws": 30, "seed": 1, "misfit_p_value": 1e-3}
    one, other = (infer(posterior.at(scale), curves, **common) for scale in (1.0, 0.0))
    assert (one.p_value > other.p_value).all()
    assert (one.distance != other.distance).all()
