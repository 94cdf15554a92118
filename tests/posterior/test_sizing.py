"""Drives of any size from their files: the size that is read, and posteriors that scale with it."""

import numpy as np
import pytest
from scipy.stats import binom

from breaker.files.manifest import Operation
from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.mechanism.size import Size
from breaker.model.randomness import generator
from breaker.model.reference import reference_model
from breaker.posterior.corrections import correct
from breaker.posterior.laplace import approximate
from breaker.posterior.sizing import at_size, network_remarks, read_drive
from breaker.records.export import write_curve

STEP = 0.08  # ms, of the drive of size 1: a fifth of the grid's
SIZES = [Size(10.35, 4.5), Size(0.6, 0.75)]


@pytest.fixture(scope="module")
def models():
    return {motion: reference_model(motion) for motion in MOTIONS}


def written(folder, size, theta, *, noise=0.05, step=STEP, seed=1):
    """Files of both motions of a drive, ``size`` times that of the parameters, by motion."""
    operations = {}
    for motion in MOTIONS:
        rng = generator(seed, "test", "sizing", motion)
        time = np.arange(0.0, 90.0, step)
        curve = travel(theta[None], time, motion, onset=20.0).travel[0]
        curve = curve + noise * rng.standard_normal(time.size)
        file = folder / f"{motion}.csv"
        write_curve(file, time * size.times, size.lengths * curve, motion=motion, operation=1)
        operations[motion] = [Operation(1, file)]
    return operations


@pytest.fixture(scope="module")
def theta(models):
    return models["closing"].prior.sample(1, generator(3, "test", "sizing"))[0]


@pytest.fixture(scope="module")
def small(tmp_path_factory, theta, models):
    return read_drive(written(tmp_path_factory.mktemp("small"), Size(), theta), {}, models)


@pytest.mark.parametrize("size", SIZES)
def test_all_that_is_read_of_a_drive_scales_with_it(small, size, tmp_path, theta, models):
    """Within 2 %: rests and bursts are looked for over times that are the same for all drives."""
    large = read_drive(written(tmp_path, size, theta), {}, models)
    assert large.size.lengths == pytest.approx(size.lengths * small.size.lengths, rel=0.02)
    assert large.size.times == pytest.approx(size.times * small.size.times, rel=0.02)
    assert large.noise_sd == pytest.approx(size.lengths * small.noise_sd, rel=0.02)
    for motion in MOTIONS:
        assert large.curves[motion].accepted.all()
        sensor, curves = large.models[motion].sensor, large.curves[motion]
        assert np.array_equal(curves.time, sensor.times)
        assert sensor.noise_sd == large.noise_sd


def test_the_posterior_of_a_scaled_record_is_the_scaled_posterior(small, defaults):
    """Draw by draw, to rounding; with the noise of the other size it is another one."""
    size, motion = Size(10.35, 4.46), "closing"
    model = reference_model(motion)
    record = small.curves[motion].travel.values[0]
    found = []
    for lengths, each, noise_sd in (
        (1.0, Size(), 0.05),
        (size.lengths, size, 0.05 * size.lengths),
        (size.lengths, size, 0.05),
    ):
        known = at_size(model, each, 0.3, noise_sd)
        rng = generator(1, "test", "scaled posterior")
        draws = approximate(known, lengths * record, 200, rng)
        found.append(correct(known, lengths * record, draws, defaults["correction"], rng).draws)
    factors = np.append(size.factors, size.times)
    np.testing.assert_allclose(found[1], factors * found[0], rtol=1e-5, atol=1e-6)
    assert np.abs(found[2] / (factors * found[0]) - 1).max() > 0.01


def test_a_size_and_noise_that_are_known_are_taken(tmp_path, theta, models):
    operations = written(tmp_path, Size(), theta)
    own = read_drive(operations, {}, models, size=Size(), noise_sd=0.1)
    assert own.size == Size()
    assert own.said == ()
    for motion, model in own.models.items():
        assert model.sensor.noise_sd == own.noise_sd
        assert len(model.prior.shared) == 0
        assert np.array_equal(model.prior.medians, models[motion].prior.medians)


def test_files_that_cannot_be_read_keep_their_reason(tmp_path, theta, models):
    operations = written(tmp_path, Size(), theta)
    operations["opening"] = [Operation(1, tmp_path / "closing.csv"), *operations["opening"]]
    found = read_drive(operations, {}, models).curves["opening"]
    assert found.accepted.values.tolist() == [False, True]
    assert "which is no opening" in found.reason.values[0]
    nothing = read_drive({"opening": operations["opening"][:1]}, {}, models)
    assert nothing.size == Size()
    assert not nothing.curves["opening"].accepted.any()


def test_a_network_is_said_to_be_of_another_noise_or_rate(small, models):
    sensor = models["closing"].sensor.sized(Size(10.0, 4.0))
    curves = small.curves["closing"]
    assert network_remarks(sensor, 1.2, curves) == []
    (noise,) = network_remarks(sensor, 0.1, curves)
    assert "the network knows 1 mm" in noise
    assert "start from the mode" in noise
    slow = curves.assign(missing=curves.missing + 60)
    (rate,) = network_remarks(sensor, 1.0, slow)
    assert "40%" in rate
    assert "deep_set" in rate


# ---- calibration --------------------------------------------------------------------------------

RECORDS, SPREAD = 60, 0.1


def covered(unknown, settings):
    """Of records of drives whose size scatters by a tenth, in how many the 90 % interval contains
    the truth, by parameter; with the model's own error, at the size of 1."""
    reference = reference_model("closing")
    model = at_size(reference, Size(), unknown, None)
    inside = np.zeros((RECORDS, len(NAMES)), dtype=bool)
    for i in range(RECORDS):
        rng = generator(1, "test", "unknown size", i)
        true = reference.sized(Size(*np.exp(SPREAD * rng.standard_normal(2))))
        theta = true.prior.sample(1, rng)
        values = np.column_stack([theta, true.sensor.onset_sd * rng.standard_normal((1, 1))])
        curve = true.curves(values) + true.sensor.discrepancy.sample((1,), rng)
        whole = np.interp(model.sensor.times, true.sensor.times, curve[0])
        record = model.sensor.noise_and_zero.corrupt(whole[None], rng)[0]
        found = correct(model, record, approximate(model, record, 300, rng), settings, rng)
        low, high = np.quantile(found.draws[:, : len(NAMES)], [0.05, 0.95], axis=0)
        inside[i] = (low <= theta[0]) & (theta[0] <= high)
    return inside.sum(axis=0)


def test_a_size_that_is_not_known_is_allowed_for(defaults):
    """By each of seven parameters 90 % of 60 records, with a false alarm of 1e-3 in all. The prior
    of one size fails: it takes drives of other sizes for odd ones of its own."""
    least = binom.ppf(1e-3 / len(NAMES), RECORDS, 0.9)
    assert (covered(SPREAD, defaults["correction"]) >= least).all()
    assert (covered(0.0, defaults["correction"]) < least).any()
