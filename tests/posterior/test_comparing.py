"""Two visits: their posterior is the exact one, its intervals hold, and both share their error."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from breaker.mechanism.curves import travel
from breaker.model.discrepancy import Discrepancy
from breaker.model.fisher import linearise
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.posterior.comparing import _highest, compare_visits
from breaker.posterior.visits import SHARES, Visits

TODAY = {"closing": np.array([False, True])}


@pytest.fixture(scope="module")
def settings(defaults):
    return defaults["correction"]


def a_model(prior, sensor, motion="closing"):
    """Its error is a step and a ramp, which hardly differ where a motion begins a little later."""
    times = sensor.times
    factor = np.stack([0.4 * np.tanh((times - 12.0) / 4.0), 0.2 * times / 60.0])
    left_out = Discrepancy(0.1 * factor[0], np.zeros((7, times.size)), factor)
    return Model(prior, replace(sensor, discrepancy=left_out), motion)


def records_of(model, before, today, rng, *, scatter=0.004):
    """Records of two visits at parameters ``(7,)``; the error is that of the drive, the same."""
    found, plain = [], model.sensor.noise_and_zero
    error = model.sensor.discrepancy.sample((1,), rng)
    for theta in (before, today):
        moved = theta * np.exp(scatter * rng.standard_normal(7))
        onset = plain.onset_sd * rng.standard_normal(1)
        curve = model.curves(np.append(moved, onset)[None])
        found.append(plain.corrupt(curve + error, rng)[0])
    return np.array(found)


def changed(model, rng):
    """Parameters of both visits, as the prior of a comparison has them."""
    while True:
        before = model.prior.sample(1, rng)[0]
        today = before * np.exp(np.clip(0.02 * rng.standard_cauchy(7), -0.5, 0.5))
        if model.prior.supported(today):
            return before, today


def metropolis(visits, start, cov, rng, *, own=False, chains=100, steps=1600):
    """Draws of the log changes by many chains, with all that is linear in one dense covariance.

    Written anew: one vector of both records, error, its change, zero and scatter in its covariance,
    and the onsets as unknowns.
    """
    (model,), (records,) = visits.models.values(), visits.records.values()
    plain, t = model.sensor.noise_and_zero, model.sensor.samples
    place = np.column_stack([np.array(visits.parameters(start[:14])), start[14:]])
    _, slopes = linearise(model.leaving_out(None), place)
    raw = np.linalg.solve(plain.whiten(np.eye(t)).T, np.swapaxes(slopes, 1, 2)).swapaxes(1, 2)
    scatter = 0.004 * raw[:, :7] / model.prior.log_sds[:, None]
    late = plain.times - plain.onset_sd * start[14:, None]
    known = np.vstack([model.sensor.discrepancy.mean, model.sensor.discrepancy.factor])
    moved = [np.array([np.interp(at, plain.times, row) for row in known]) for at in late]
    both = np.hstack([each[1:] for each in moved])
    mean, factor = np.hstack([each[0] for each in moved]), moved[1][1:]
    zeros = np.zeros_like(factor)
    roots = []
    for share in SHARES:
        changed = np.hstack([zeros, factor])
        loads = [both - changed, changed] if own else [both, share * changed]
        for r in range(2):
            one = np.vstack([scatter[r], plain.zero_sd * np.ones((1, t))])
            loads.append(np.hstack([one if k == r else 0.0 * one for k in range(2)]))
        loads = np.vstack(loads)
        roots.append(np.linalg.cholesky(plain.noise_sd**2 * np.eye(2 * t) + loads.T @ loads))

    def log_density(x):
        result = visits.log_prior(x[:, :14]) - 0.5 * np.square(x[:, 14:]).sum(axis=1)
        inside = np.isfinite(result)
        z = np.stack(visits.parameters(x[inside, :14]), axis=1)
        onset = plain.onset_sd * x[inside, 14:]
        theta = model.prior.destandardise(z).reshape(-1, 7)
        curves = travel(theta, plain.times, model.motion, onset=onset.ravel()).travel
        left = records.ravel() - curves.reshape(len(z), -1)
        left -= mean
        found = []
        for root in roots:
            whitened = solve_triangular(root, left.T, lower=True)
            log_det = np.log(root.diagonal()).sum()
            found.append(-0.5 * np.square(whitened).sum(axis=0) - log_det)
        result[inside] += np.logaddexp.reduce(found)
        return result

    root = 2.0 / np.sqrt(len(start)) * np.linalg.cholesky(cov)
    x = start + 0.3 * rng.standard_normal((chains, len(start))) @ np.linalg.cholesky(cov).T
    height, kept = log_density(x), []
    for step in range(steps):
        there = x + rng.standard_normal(x.shape) @ root.T
        found = log_density(there)
        moves = np.log(rng.random(chains)) < found - height
        x, height = np.where(moves[:, None], there, x), np.where(moves, found, height)
        if step >= steps // 4 and step % 5 == 0:
            kept.append(np.subtract(*visits.parameters(x[:, :14])[::-1]))
    return np.concatenate(kept) * model.prior.log_sds


def test_the_posterior_is_that_of_a_long_markov_chain(prior, sensor, settings):
    """Shares below a quantile are known to an effective size of 500 at least in both: of 21 shares
    one is 4.2 sd off with a probability below 1e-3.
    """
    model, rng = a_model(prior, sensor), generator(3, "test two visits")
    today = prior.medians * [1.0, 1.0, 1.0, 1.1, 1.0, 0.93, 1.0]
    records = {"closing": records_of(model, prior.medians, today, rng)}
    visits = Visits({"closing": model}, records, TODAY)
    (found,) = compare_visits(visits.models, records, TODAY, settings, rng)
    assert found.resolved
    y, look = _highest(visits)
    onsets = visits.columns["closing"][:, 14 + 4]
    some = [*range(14), *onsets]
    cov = np.linalg.inv(look.precision)[np.ix_(some, some)]
    chain = metropolis(visits, y[some], cov, rng)
    drawn = np.log(found.today / found.before)
    levels = np.array([0.05, 0.5, 0.95])[:, None]

    def off(other):
        below = drawn[None] < np.quantile(other, levels[:, 0], axis=0)[:, None]
        return np.abs(below.mean(axis=1) - levels) / np.sqrt(2.0 * levels * (1.0 - levels) / 500.0)

    assert off(chain).max() < 4.2
    # Planted: an error that each visit has for itself leaves more open.
    wide = metropolis(visits, y[some], 4.0 * cov, rng, own=True)
    assert off(wide).max() > 4.2


def coverage(prior, sensor, settings, *, noise=1.0, rigs=8):
    """Share of 90 % intervals of the change that hold, of all parameters of drives."""
    model, held = a_model(prior, sensor), []
    noisy = replace(model, sensor=replace(model.sensor, noise_sd=noise * sensor.noise_sd))
    for rig in range(rigs):
        rng = generator(5, "test coverage", rig)
        before, today = changed(model, rng)
        records = {"closing": records_of(noisy, before, today, rng)}
        (found,) = compare_visits({"closing": model}, records, TODAY, settings, rng, draws=500)
        low, high = np.quantile(found.today / found.before, [0.05, 0.95], axis=0)
        held.append((low <= today / before) & (today / before <= high))
    return np.mean(held)


def test_intervals_hold_the_change(prior, sensor, settings):
    """Of 56 intervals at 0.9, in 8 rigs of 7 that go together: if two each were one, the share had
    an sd of 0.057; 0.7 is 3.5 below. Planted: noise eight times as large as it is said to be.
    """
    assert coverage(prior, sensor, settings) > 0.7
    assert coverage(prior, sensor, settings, noise=8.0, rigs=4) < 0.7


def test_motions_that_disagree_are_compared_apart(prior, sensor, settings):
    rng = generator(7, "test apart")
    models = {m: Model(prior, sensor, m) for m in ("closing", "opening")}
    today = dict.fromkeys(models, np.array([False, True]))

    def records(shift):
        factor = {"closing": np.ones(7), "opening": np.exp(shift * prior.log_sds)}
        return {
            m: sensor.corrupt(
                each.curves(np.append(prior.medians * factor[m], 0.0)[None].repeat(2, 0)), rng
            )
            for m, each in models.items()
        }

    agreeing = compare_visits(models, records(0.0), today, settings, rng)
    assert [each.motions for each in agreeing] == [("closing", "opening")]
    assert agreeing[0].agreement > 0.001
    apart = compare_visits(models, records(1.5), today, settings, rng)
    assert [each.motions for each in apart] == [("closing",), ("opening",)]
    assert apart[0].agreement < 0.001


def test_missing_samples_and_sensors_without_onset_are_compared(prior, sensor, settings):
    rng = generator(9, "test missing")
    model = Model(prior, replace(sensor, onset_sd=0.0), "opening")
    theta = prior.medians * np.array([[1.0] * 7, [1.0, 0.85, *[1.0] * 5]])
    records = model.sensor.corrupt(model.curves(theta), rng)
    records[0, 40:60] = np.nan
    (found,) = compare_visits(
        {"opening": model}, {"opening": records}, {"opening": TODAY["closing"]}, settings, rng
    )
    assert found.resolved
    assert np.mean(found.today[:, 1] < 0.95 * found.before[:, 1]) > 0.9
    assert found.p_value > 1e-3
