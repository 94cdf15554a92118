"""The information in records: against matrices, the exact likelihood, and many records."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import chi2

from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.fisher import (
    climb,
    contraction_limit,
    information,
    limit_over_prior,
    linearise,
    pool,
)
from breaker.model.joint import Model
from breaker.model.randomness import generator
from tests.model.laws import covariance

P = len(NAMES)
ALPHA = 1e-3  # false-alarm probability of a chi-square, both tails together
PAPER = {"onset_sd": 0.0, "zero_sd": 0.0}


def model_of(prior, sensor, motion, **changes):
    return Model(prior, replace(sensor, **changes), motion)


def outputs_of(model, n):
    """Standardised outputs drawn from the prior, ``(n, q)``."""
    rng = generator(1, "test", "identifiability")
    z = np.column_stack([model.prior.standardise(model.prior.sample(n, rng)), np.zeros(n)])
    z[:, P] = rng.standard_normal(n)
    return z[:, : len(model.names)]


# ---- limit -----------------------------------------------------------------------------------


@pytest.mark.parametrize("changes", [{}, {"onset_sd": 0.0}, PAPER], ids=["all", "zero", "paper"])
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
    for place, found, limit in zip(z, whitened, limits, strict=True):
        slopes = sum(
            weight * (model.curves(model.destandardise(place + s * step * np.eye(q))) - behind)
            for s, weight in enumerate(weights, start=1)
            for behind in [model.curves(model.destandardise(place - s * step * np.eye(q)))]
        )
        slopes /= step
        np.testing.assert_allclose(found, model.sensor.whiten(slopes), rtol=0, atol=1e-3)
        fisher = slopes @ inverse @ slopes.T
        np.testing.assert_allclose(found @ found.T, fisher, rtol=1e-4, atol=1e-3)
        expected = 1 - np.diag(np.linalg.inv(fisher + np.eye(q)))
        np.testing.assert_allclose(limit, expected, rtol=0, atol=1e-5)


def test_limit_between_nothing_and_everything_known(prior, sensor):
    def limit(**changes):
        model = model_of(prior, sensor, "closing", **changes)
        return contraction_limit(model, model.destandardise(outputs_of(model, 20)))

    np.testing.assert_allclose(limit(noise_sd=1e6), 0.0, atol=1e-8)
    keen, usual = limit(noise_sd=1e-4), limit()
    assert np.all((keen > 0.99) & (keen < 1))
    assert np.all((usual > 0) & (usual < keen))


@pytest.mark.parametrize("changes", [{}, PAPER], ids=["default", "paper"])
def test_limit_over_the_prior(prior, sensor, changes):
    """At draws of parameters and onsets, in this order."""
    model = model_of(prior, sensor, "opening", **changes)
    limit = limit_over_prior(model, 20, generator(1, "test", "limit"))
    rng = generator(1, "test", "limit")
    values = np.column_stack([prior.sample(20, rng), sensor.onset_sd * rng.standard_normal(20)])
    expected = contraction_limit(model, values[:, : len(model.names)])
    np.testing.assert_array_equal(limit.contraction, expected)
    assert limit.contraction.dims == ("curve", "output")
    assert limit.output.values.tolist() == [*NAMES, "onset"][: len(model.names)]
    assert limit.attrs["motion"] == "opening"


# ---- one record ------------------------------------------------------------------------------


def exact_log_likelihood(model, record, z, around, *, onset=None):
    """Log likelihood of parameters ``(m, p)``, the onset integrated on a grid, nan is missing.

    The grid is 1.2 onset sds wide, twelve or more of what a record leaves open, and its steps are
    a tenth of that: the trapezoid rule is exact to round-off. An ``onset`` is taken as known.
    """
    known = 0.5 * np.square(z).sum(-1)  # log_joint less the prior of the parameters
    if not model.sensor.infers_onset:
        return model.log_joint(z, record) + known
    nodes = around + np.linspace(-0.6, 0.6, 121) if onset is None else np.array([onset])
    points = np.column_stack([np.repeat(z, nodes.size, 0), np.tile(nodes, len(z))])
    values = model.log_joint(points, record).reshape(len(z), nodes.size)
    return logsumexp(values, axis=1) + known


def differences(log_likelihood, centre, directions, *, step=0.03):
    """Slopes and curvatures ``(k,)`` of a function of ``(m, p)`` along directions ``(k, p)``."""
    ahead, behind = (log_likelihood(centre + s * step * directions) for s in (1, -1))
    here = log_likelihood(centre[None])
    return (ahead - behind) / (2 * step), -(ahead + behind - 2 * here) / step**2


def distance(found, centre, log_likelihood):
    """How far information is from the exact likelihood: of slope and curvature, in posterior sds.

    Along the axes of the posterior, each as long as its sd, where ``J + I`` is the identity.
    """
    values, vectors = np.linalg.eigh(found.matrix[0])
    axes = (vectors / np.sqrt(values + 1.0)).T
    slope, curvature = differences(log_likelihood, centre, axes)
    assert slope.shape == (P,)
    return (
        np.abs(axes @ found.slope[0] - slope).max(),
        np.abs(values / (values + 1.0) - curvature).max(),
    )


def truths(prior, n, *purpose):
    """Standardised parameters, ``(n, p)``."""
    return prior.standardise(prior.sample(n, generator(1, "test", "information", *purpose)))


@pytest.mark.parametrize("onset", [0.0, 0.3, -0.8, 1.5, -2.0])
@pytest.mark.parametrize("motion", MOTIONS)
def test_information_is_the_likelihood_at_the_truth(prior, sensor, motion, onset):
    """On a curve without noise, with it, and with samples missing.

    What Laplace's method leaves out of the slope is half that of the log of the onset's curvature,
    0.002 posterior sds here. The matrix has no second derivatives of the curve; they count where
    there is a residual, which an onset at its most probable value does not leave.
    """
    model = model_of(prior, sensor, motion)
    z = truths(prior, 1, motion)[0]
    curve = model.curves(model.destandardise(np.append(z, onset)[None]))
    noisy = sensor.corrupt(curve, generator(1, "test", "information", motion, "noise"))
    lacking = noisy.copy()
    lacking[:, 40:60] = lacking[:, ::7] = np.nan
    for record in (curve, noisy, lacking):
        found = information(model, record, z[None], np.zeros(1))

        def exact(points, record=record[0]):
            return exact_log_likelihood(model, record, points, onset)

        slope, curvature = distance(found, z, exact)
        assert slope < 0.005
        if record is curve:
            # The prior pulls an onset to 0, by as much less as the record says more.
            assert abs(found.onset[0] - onset) < 0.01
            assert onset != 0.0 or curvature < 0.01


@pytest.mark.parametrize("motion", MOTIONS)
def test_an_onset_taken_as_known_would_be_noticed(prior, sensor, motion):
    """The planted fault of the test above: the likelihood with the onset at its true value."""
    model = model_of(prior, sensor, motion)
    z = truths(prior, 1, motion)[0]
    record = model.curves(model.destandardise(np.append(z, 0.0)[None]))[0]
    found = information(model, record[None], z[None], np.zeros(1))

    def known(points):
        return exact_log_likelihood(model, record, points, 0.0, onset=0.0)

    assert distance(found, z, known)[1] > 0.1


@pytest.mark.parametrize("motion", MOTIONS)
def test_information_without_an_onset(prior, sensor, motion):
    """The slope is exact away from the truth, too, and the onset given is ignored."""
    model = model_of(prior, sensor, motion, onset_sd=0.0)
    z = truths(prior, 1, motion, "no onset")[0]
    curve = model.curves(prior.destandardise(z[None]))
    found = information(model, curve, z[None], np.full(1, np.nan))
    np.testing.assert_array_equal(found.onset, 0.0)
    slope, curvature = distance(
        found, z, lambda points: exact_log_likelihood(model, curve[0], points, 0.0)
    )
    assert slope < 0.001  # of the curve's bend; the slope itself is zero
    assert curvature < 0.01
    record = sensor.corrupt(curve, generator(1, "test", "information", motion, "noise"))
    found = information(model, record, z[None], np.zeros(1))
    slope, _ = differences(
        lambda points: exact_log_likelihood(model, record[0], points, 0.0), z, np.eye(P), step=1e-5
    )
    np.testing.assert_allclose(found.slope[0], slope, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("motion", MOTIONS)
def test_one_step_of_the_onset_does_from_nearby(prior, sensor, motion):
    model = model_of(prior, sensor, motion)
    z = truths(prior, 4, motion, "steps")
    rng = generator(1, "test", "information", "steps", motion)
    outputs = np.column_stack([z, rng.standard_normal(4)])
    records = sensor.corrupt(model.curves(model.destandardise(outputs)), rng)
    far = information(model, records, z, np.zeros(4), steps=8)
    again = information(model, records, z, far.onset, steps=0)
    near = information(model, records, z, far.onset + 0.05, steps=1)
    default = information(model, records, z, outputs[:, P] + 0.5)
    for name in ("matrix", "slope", "onset"):
        wanted = getattr(far, name)
        size = np.abs(wanted).max()
        np.testing.assert_allclose(getattr(again, name), wanted, rtol=0, atol=1e-6 * size)
        np.testing.assert_allclose(getattr(near, name), wanted, rtol=0, atol=1e-3 * size)
        np.testing.assert_allclose(getattr(default, name), wanted, rtol=0, atol=1e-3 * size)


# ---- many records ----------------------------------------------------------------------------


def stretch(model, z, n, rng):
    """Records ``(n, t)`` of constant parameters, and their onsets ``(n,)``."""
    onset = rng.standard_normal(n)
    outputs = np.column_stack([np.tile(z, (n, 1)), onset])
    return model.sensor.corrupt(model.curves(model.destandardise(outputs)), rng), onset


def posterior_means(models, records, onsets, z):
    """Mean over operations of the means of their posteriors: the prior is counted each time."""
    n = len(next(iter(records.values())))
    matrix, slope = np.tile(np.eye(P), (n, 1, 1)), np.tile(-z, (n, 1))
    for motion, model in models.items():
        found = information(model, records[motion], np.tile(z, (n, 1)), onsets[motion])
        matrix, slope = matrix + found.matrix, slope + found.slope
    return z + np.linalg.solve(matrix, slope[..., None])[..., 0].mean(axis=0)


def chi_square(models, records, onsets, estimate, truth):
    """Squared error of an estimate, in units of what all records and one prior leave open."""
    matrix = np.eye(P)
    for motion, model in models.items():
        places = np.tile(estimate, (len(records[motion]), 1))
        matrix += information(model, records[motion], places, onsets[motion]).matrix.sum(axis=0)
    return (estimate - truth) @ matrix @ (estimate - truth)


@pytest.mark.parametrize("motions", [("closing",), ("opening",), MOTIONS], ids="+".join)
def test_pooled_records_are_unbiased_and_count_the_prior_once(prior, sensor, motions):
    """Truths are drawn from the prior, so that the error is that of the posterior exactly.

    Five times a chi-square of 7, of 200 records each. The search starts from the mean of the
    operations' posterior means, as a trend does, which by itself has to fail: the planted fault.
    """
    models = {motion: model_of(prior, sensor, motion) for motion in motions}
    right, wrong, lives = 0.0, 0.0, 5
    for i, z in enumerate(truths(prior, lives, "pool", *motions)):
        rng = generator(1, "test", "information", "pool", *motions, i)
        drawn = {motion: stretch(model, z, 200, rng) for motion, model in models.items()}
        records, onsets = ({m: each[k] for m, each in drawn.items()} for k in (0, 1))
        start = posterior_means(models, records, onsets, z)
        pooled = pool(models, records, start, onsets)
        right += chi_square(models, records, onsets, pooled, z)
        wrong += chi_square(models, records, onsets, start, z)
    low, high = chi2.ppf([ALPHA / 2, 1 - ALPHA / 2], df=lives * P)
    assert low < right < high
    assert wrong > high


def test_climbing_leads_to_modes(prior, sensor):
    """There the slope of likelihoods and normal is zero, along every axis of the posterior.

    To 0.05 posterior sds after eight moves; with the normal's pull reversed it is not.
    """
    models = {motion: model_of(prior, sensor, motion) for motion in MOTIONS}
    z, rng = truths(prior, 3, "climb"), generator(1, "test", "climb")
    onsets = {motion: np.zeros(3) for motion in MOTIONS}
    records = {
        motion: sensor.corrupt(model.curves(model.destandardise(np.c_[z, onsets[motion]])), rng)
        for motion, model in models.items()
    }
    mean, precision = np.full(P, 0.5), 2.0 * np.eye(P)
    place, matrix, slope = climb(models, records, z + 0.2, onsets, mean, precision, moves=8)
    for found, push, at in zip(matrix, slope, place, strict=True):
        axes = np.linalg.inv(np.linalg.cholesky(found + precision))
        assert np.abs(axes @ (push - precision @ (at - mean))).max() < 0.05
        assert np.abs(axes @ (push + precision @ (at - mean))).max() > 0.05
