"""What the model leaves out, as one more Gaussian: against matrices written out and integrals."""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import chi2, kstest, multivariate_normal, norm

from breaker.model import Discrepancy, Model, Sensor, generator
from breaker.model.fisher import contraction_limit, information, linearise
from tests.model.laws import covariance, covariance_p_value
from tests.networks_fixtures import PRIOR, left_out

SAMPLES = 12
KNOWN = left_out(SAMPLES)
SENSOR = {
    "start": -1.0,
    "stop": 10.0,
    "samples": SAMPLES,
    "noise_sd": 0.2,
    "onset_sd": 0.3,
    "zero_sd": 0.1,
}


@pytest.fixture(scope="module")
def sensor():
    return Sensor(**SENSOR, discrepancy=KNOWN)


@pytest.fixture(scope="module")
def model():
    settings = {"prior": PRIOR, "sensor": {**SENSOR, "stop": 40.0}, "motion": "closing"}
    return Model.from_settings(settings, KNOWN)


def some_missing(n, *, seed=2):
    """Residuals ``(n, t)``, of which some samples are missing: in most rows others."""
    rng = np.random.default_rng(seed)
    residual = rng.standard_normal((n, SAMPLES))
    residual[rng.random(residual.shape) < 0.3] = np.nan
    residual[:2] = np.nan_to_num(residual[:2])  # and in two of them none
    residual[-1, 5:] = np.nan
    return residual


# ---- the distribution ---------------------------------------------------------------------------


def test_scaling_and_shift():
    z = np.random.default_rng(1).standard_normal((4, 7))
    expected = np.array([KNOWN.mean + sum(row[i] * KNOWN.slopes[i] for i in range(7)) for row in z])
    np.testing.assert_allclose(KNOWN.shift(z), expected, atol=1e-14)
    half = KNOWN.scaled(0.5)
    np.testing.assert_allclose(half.shift(z), 0.5 * expected, atol=1e-14)
    np.testing.assert_allclose(half.sd, 0.5 * KNOWN.sd, atol=1e-14)
    np.testing.assert_allclose(KNOWN.sd, np.sqrt(np.diag(KNOWN.factor.T @ KNOWN.factor)))
    assert KNOWN.scaled(0.0) is None
    assert KNOWN.scaled(0) is None


@pytest.mark.parametrize(
    "change",
    [{"mean": np.zeros(5)}, {"slopes": np.zeros(SAMPLES)}, {"factor": np.zeros((3, SAMPLES + 1))}],
)
def test_arrays_that_do_not_fit_are_refused(change):
    arrays = {name: getattr(KNOWN, name) for name in ("mean", "slopes", "factor")}
    with pytest.raises(ValueError, match=r"mean \(t,\), slopes \(p, t\) and factor"):
        Discrepancy(**(arrays | change))


def test_another_grid_is_refused():
    with pytest.raises(ValueError, match=r"of 12 samples.*the sensor has 13"):
        Sensor(**{**SENSOR, "samples": 13}, discrepancy=KNOWN)


# ---- the sensor, against matrices ---------------------------------------------------------------


@pytest.mark.parametrize("components", [1, 3, 20])
def test_whitening_is_a_root_of_the_inverse(components):
    """Also of more components than samples."""
    sensor = Sensor(**SENSOR, discrepancy=left_out(SAMPLES, components=components))
    white = sensor.whiten(np.eye(SAMPLES))
    np.testing.assert_allclose(white @ white.T, np.linalg.inv(covariance(sensor)), atol=1e-10)
    batch = np.random.default_rng(1).standard_normal((2, 3, SAMPLES))
    np.testing.assert_allclose(sensor.whiten(batch), batch @ white, atol=1e-12)


def test_records_of_any_pattern_are_judged_by_their_samples(sensor):
    """Distance, density and whitened length of each are those of its own submatrix."""
    residual = some_missing(40)
    curves = np.random.default_rng(3).normal(5.0, 1.0, residual.shape)
    square = sensor.chi_square(residual + curves, curves)
    density = sensor.log_likelihood(residual + curves, curves)
    white = sensor.whiten(residual)
    assert not white[np.isnan(residual)].any()
    whole = covariance(sensor)
    for i, row in enumerate(residual):
        there = ~np.isnan(row)
        part = whole[np.ix_(there, there)]
        expected = row[there] @ np.linalg.solve(part, row[there])
        assert square[i] == pytest.approx(expected, rel=1e-9)
        assert white[i] @ white[i] == pytest.approx(expected, rel=1e-9)
        logpdf = multivariate_normal(np.zeros(there.sum()), part).logpdf(row[there])
        assert density[i] == pytest.approx(logpdf, rel=1e-9)
        # One record against many curves, as a posterior's draws are.
        one = sensor.log_likelihood(row, np.zeros((5, SAMPLES)))
        np.testing.assert_allclose(one, logpdf, rtol=1e-9)
    # Planted fault: missing samples taken for measured ones without a residual.
    assert np.abs(sensor.chi_square(np.nan_to_num(residual), 0.0) - square).max() > 1.0


def test_one_record_alone(sensor):
    """A record without other axes, whole and with samples missing."""
    for row in some_missing(3):
        batch = sensor.log_likelihood(row[None], np.zeros((1, SAMPLES)))
        assert sensor.log_likelihood(row, np.zeros(SAMPLES)) == pytest.approx(batch[0], rel=1e-14)


def test_the_density_is_normalised():
    """That of two samples sums to one, and so does that of one if the other is missing.

    Planted fault: without the modes in the determinant, as if the error came for nothing.
    """
    known = Discrepancy(np.zeros(2), np.zeros((7, 2)), np.array([[0.6, -0.2]]))
    sensor = Sensor(-1.0, 1.0, 2, noise_sd=0.2, onset_sd=0.0, zero_sd=0.1, discrepancy=known)
    grid = np.linspace(-6.0, 6.0, 401)
    step = grid[1] - grid[0]
    records = np.stack(np.meshgrid(grid, grid), axis=-1)
    density = sensor.log_likelihood(records, np.zeros(2))
    assert np.exp(density).sum() * step**2 == pytest.approx(1.0, abs=1e-6)
    records[..., 1] = np.nan
    one = sensor.log_likelihood(records[0], np.zeros(2))
    assert np.exp(one).sum() * step == pytest.approx(1.0, abs=1e-6)
    faulty = -0.5 * (sensor.chi_square(np.stack(np.meshgrid(grid, grid), -1), np.zeros(2)))
    faulty += sensor.noise_and_zero.log_likelihood(np.zeros(2), np.zeros(2))
    assert abs(np.exp(faulty).sum() * step**2 - 1.0) > 0.5


def test_the_error_is_integrated(sensor):
    """The density is the integral over the components and the zero, here by the trapezium rule."""
    known = Discrepancy(KNOWN.mean, KNOWN.slopes, KNOWN.factor[:1])
    sensor = Sensor(**SENSOR, discrepancy=known)
    record = np.random.default_rng(5).normal(0.0, 0.3, SAMPLES)
    x = np.linspace(-8.0, 8.0, 201)
    component, zero = (each.ravel() for each in np.meshgrid(x, x))
    curves = component[:, None] * known.factor[0] + sensor.zero_sd * zero[:, None]
    terms = norm.logpdf(component) + norm.logpdf(zero)
    terms += norm.logpdf(record - curves, scale=sensor.noise_sd).sum(axis=1)
    expected = logsumexp(terms) + 2 * np.log(x[1] - x[0])
    assert sensor.log_likelihood(record, np.zeros(SAMPLES)) == pytest.approx(expected, abs=1e-8)


def test_records_have_the_covariance(sensor):
    """False alarm 1e-3. Planted fault: the error of the model left out."""
    exact = np.zeros((4000, SAMPLES))
    records = sensor.corrupt(exact, generator(1, "test records"))
    assert covariance_p_value(records, covariance(sensor)) > 1e-3
    plain = sensor.noise_and_zero.corrupt(exact, generator(1, "test records"))
    assert covariance_p_value(plain, covariance(sensor)) < 1e-9


@pytest.mark.parametrize("lost", [0, 5, SAMPLES - 1])
def test_what_a_repetition_shares(sensor, lost):
    """Zero and error given a record are normal: mean and covariance by matrices.

    20,000 draws, 13 two-sided tests of squares along the axes and of normality together with a
    false alarm of 1e-3. The axes of no variance, those that are not the zero's or a component's,
    are left out. Planted fault: the noise forgotten, so that a record were followed exactly.
    """
    record = np.random.default_rng(6).normal(0.0, 0.5, SAMPLES)
    record[np.random.default_rng(7).permutation(SAMPLES)[:lost]] = np.nan
    there = ~np.isnan(record)
    whole = covariance(sensor)
    shared = whole - sensor.noise_sd**2 * np.eye(SAMPLES)
    gain = np.linalg.solve(whole[np.ix_(there, there)], shared[there]).T
    mean, left = gain @ record[there], shared - gain @ shared[there]
    records = np.tile(record, (20_000, 1))
    draws = sensor.sample_shared(records, np.zeros_like(records), generator(1, "test shared"))
    assert draws.shape == records.shape
    variances, vectors = np.linalg.eigh(left)
    axes = vectors[:, variances > 1e-9]
    assert axes.shape[1] == 1 + len(KNOWN.factor)
    within = axes.T @ left @ axes
    assert covariance_p_value((draws - mean) @ axes, within) > 1e-3
    across = (draws - mean) @ vectors[:, variances <= 1e-9]
    assert np.abs(across).max() < 1e-9
    certain = Sensor(**{**SENSOR, "noise_sd": 1e-3}, discrepancy=KNOWN)
    wrong = certain.sample_shared(records, np.zeros_like(records), generator(1, "test shared"))
    assert covariance_p_value((wrong - mean) @ axes, within) < 1e-9


def test_what_many_records_share_is_that_of_each(sensor):
    """A batch with other samples missing in each row: finite, and each near its own mean."""
    residual = some_missing(500)
    draws = sensor.sample_shared(residual, np.zeros_like(residual), generator(2, "test shared"))
    assert np.isfinite(draws).all()
    whole = covariance(sensor)
    shared = whole - sensor.noise_sd**2 * np.eye(SAMPLES)
    squares = []
    for row, draw in zip(residual, draws, strict=True):
        there = ~np.isnan(row)
        gain = np.linalg.solve(whole[np.ix_(there, there)], shared[there]).T
        left = shared - gain @ shared[there]
        deviation = draw - gain @ row[there]
        squares.append(deviation @ np.linalg.pinv(left, rcond=1e-8, hermitian=True) @ deviation)
    freedom = 1 + len(KNOWN.factor)
    assert kstest(squares, chi2(freedom).cdf).pvalue > 1e-3  # the false alarm's probability


# ---- the model ----------------------------------------------------------------------------------


def test_no_error_is_the_model_bit_for_bit(model):
    settings = {"prior": PRIOR, "sensor": model.sensor.settings(), "motion": "closing"}
    plain, none = Model.from_settings(settings), Model.from_settings(settings, KNOWN, 0.0)
    assert none.sensor == plain.sensor == model.leaving_out(None).sensor
    z = np.random.default_rng(1).standard_normal((20, 8)) * 0.5
    values = plain.destandardise(z)
    np.testing.assert_array_equal(none.curves(values), plain.curves(values))
    record = plain.curves(values[:1])[0]
    np.testing.assert_array_equal(none.log_joint(z, record), plain.log_joint(z, record))
    none_drawn = none.sensor.corrupt(record, generator(1, "test"))
    np.testing.assert_array_equal(none_drawn, plain.sensor.corrupt(record, generator(1, "test")))


def test_the_joint_density_holds_mean_and_covariance(model):
    rng = np.random.default_rng(2)
    z = 0.5 * rng.standard_normal((6, 8))
    plain = model.leaving_out(None)
    values = model.destandardise(z)
    expected = plain.curves(values) + KNOWN.mean + z[:, :7] @ KNOWN.slopes
    np.testing.assert_allclose(model.curves(values), expected, atol=1e-12)
    record = expected[0] + rng.standard_normal(SAMPLES)
    normal = multivariate_normal(np.zeros(SAMPLES), covariance(model.sensor))
    density = model.log_prior(z) + normal.logpdf(record - expected)
    np.testing.assert_allclose(model.log_joint(z, record), density, rtol=1e-10)
    # Planted fault: the mean forgotten.
    wrong = model.log_prior(z) + normal.logpdf(record - plain.curves(values))
    assert np.abs(wrong - density).max() > 0.5


def slopes_of(model, z):
    """Derivatives of expected curves by standardised outputs, by differences, ``(n, q, t)``."""
    step = 1e-5 * np.eye(z.shape[1])
    up, down = (
        np.stack([model.curves(model.destandardise(z + s * each)) for each in step], axis=1)
        for s in (1, -1)
    )
    return (up - down) / 2e-5


def test_limits_and_information_know_the_error(model):
    """Against Fisher's matrix written out; the slope of the density at a record, by differences."""
    z = 0.3 * np.random.default_rng(3).standard_normal((5, 8))
    slopes, inverse = slopes_of(model, z), np.linalg.inv(covariance(model.sensor))
    fisher = slopes @ inverse @ slopes.swapaxes(1, 2)
    curves, white = linearise(model, z)
    np.testing.assert_allclose(curves, model.curves(model.destandardise(z)), atol=1e-9)
    np.testing.assert_allclose(white @ white.swapaxes(1, 2), fisher, rtol=1e-3, atol=1e-3)
    expected = 1 - np.linalg.inv(fisher + np.eye(8)).diagonal(axis1=1, axis2=2)
    limit = contraction_limit(model, model.destandardise(z))
    np.testing.assert_allclose(limit, expected, atol=1e-4)
    # Planted fault: the change of the error's mean with the parameters forgotten.
    flat = model.leaving_out(Discrepancy(KNOWN.mean, 0 * KNOWN.slopes, KNOWN.factor))
    without_slopes = contraction_limit(flat, model.destandardise(z))
    assert np.abs(without_slopes - expected).max() > 1e-2
    # An error whose mean stays costs contraction, everywhere.
    plain = contraction_limit(model.leaving_out(None), model.destandardise(z))
    assert (plain > without_slopes).all()


def test_information_of_records_with_missing_samples(model):
    """Slope and matrix of the parameters, the onset integrated: by Schur's complement."""
    z = 0.3 * np.random.default_rng(4).standard_normal((4, 8))
    records = model.curves(model.destandardise(z)) + 0.1 * some_missing(4)
    found = information(model, records, z[:, :7], z[:, 7], steps=8)
    for i, record in enumerate(records):
        at = np.append(z[i, :7], found.onset[i])[None]
        there = ~np.isnan(record)
        inverse = np.linalg.inv(covariance(model.sensor)[np.ix_(there, there)])
        slopes = slopes_of(model, at)[0][:, there]
        left = (record - model.curves(model.destandardise(at))[0])[there]
        matrix, slope = slopes @ inverse @ slopes.T, slopes @ inverse @ left
        matrix[7, 7] += 1.0
        slope[7] -= at[0, 7]
        share = matrix[:7, 7] / matrix[7, 7]
        expected = matrix[:7, :7] - np.outer(share, matrix[7, :7])
        np.testing.assert_allclose(found.matrix[i], expected, rtol=1e-3, atol=1e-3)
        np.testing.assert_allclose(found.slope[i], slope[:7] - share * slope[7], atol=1e-2)
