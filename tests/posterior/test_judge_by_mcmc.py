"""Corrected posteriors of the breaker against ensemble MCMC, which shares nothing with them.

emcee's affine-invariant sampler walks in physical units, with a density written out here: no
standardised outputs, no map, no weights, the zero's covariance as a matrix.
"""

from dataclasses import dataclass, replace

import emcee
import numpy as np
import pytest
from scipy.stats import norm

from breaker.common.randomness import generator, seed_integer
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.paper.correction import correct
from tests.corrections import from_prior

CURVES = 3  # of each motion
WALKERS, BURN_IN, STEPS = 160, 80, 320  # autocorrelation times are about 25 steps
FALSE_ALARM = 1e-3  # of all comparisons of both motions together
COMPARISONS = CURVES * len(MOTIONS) * 8 * 2 * 2  # means and sds, from either start
D = 2000  # draws


@dataclass
class Moments:
    """Means and standard deviations ``(8,)`` of the outputs, each with its Monte-Carlo error."""

    mean: np.ndarray
    mean_error: np.ndarray
    sd: np.ndarray
    sd_error: np.ndarray


def of_draws(draws, size):
    """Moments of draws ``(d, 8)`` that are worth so many independent ones."""
    mean, sd = draws.mean(0), draws.std(0)
    square = ((draws - mean) ** 2 - sd**2) / (2 * sd)  # what each draw adds to the sd
    return Moments(mean, sd / np.sqrt(size), sd, square.std(0) / np.sqrt(size))


def by_correction(model, record, start, rng):
    """Corrected draws, from others ``(d, 8)``, and their moments.

    The errors are those of the weights and of the resampling to d draws together.
    """
    result = correct(model, record, start, rng)
    assert result.resolved, result.reason
    size = 1 / (1 / result.importance.size + 1 / len(start))
    return result.draws, of_draws(result.draws, size)


def log_posterior(model, record):
    """Unnormalised log density of outputs in physical units, ``(n, 8) -> (n,)``, for emcee."""
    sensor = model.sensor
    covariance = sensor.noise_sd**2 * np.eye(record.size) + sensor.zero_sd**2
    inverse_root = np.linalg.inv(np.linalg.cholesky(covariance))

    def evaluate(values):
        result = model.prior.log_prob(values[:, :7])
        result += norm.logpdf(values[:, 7], scale=sensor.onset_sd)
        inside = np.isfinite(result)
        theta, onset = values[inside, :7], values[inside, 7]
        curves = travel(theta, sensor.times, model.motion, onset=onset).travel
        result[inside] -= 0.5 * np.square((record - curves) @ inverse_root.T).sum(1)
        return result

    return evaluate


def by_mcmc(log_density, start, seed):
    """Moments of an emcee chain that starts at given draws.

    By differential evolution: the chain of its snooker is a fifth too narrow.
    """
    move = emcee.moves.DEMove()
    sampler = emcee.EnsembleSampler(
        WALKERS, start.shape[1], log_density, vectorize=True, moves=move
    )
    sampler.random_state = np.random.RandomState(seed % 2**32).get_state()
    sampler.run_mcmc(start[:WALKERS], BURN_IN + STEPS)
    chain = sampler.get_chain(discard=BURN_IN)
    mean, sd = chain.mean((0, 1)), chain.std((0, 1))
    square = ((chain - mean) ** 2 - sd**2) / (2 * sd)
    return Moments(mean, chain_error(chain), sd, chain_error(square))


def chain_error(chain):
    """Monte-Carlo error of a mean over steps and walkers, ``(s, w, 8) -> (8,)``.

    By the autocorrelation time, emcee's own estimate, or by the scatter between walkers where
    that is larger: a walker that stays in a tail for long hardly shows in the former.
    """
    steps, walkers, _ = chain.shape
    times = emcee.autocorr.integrated_time(chain, tol=0)
    assert np.max(times) < steps / 8  # long enough
    by_time = chain.std((0, 1)) * np.sqrt(times / (steps * walkers))
    by_walker = chain.mean(0).std(0, ddof=1) / np.sqrt(walkers)
    return np.maximum(by_time, by_walker)


def largest_score(one, other):
    """Largest difference of a mean or sd, in joint Monte-Carlo errors."""
    means = (one.mean - other.mean) / np.hypot(one.mean_error, other.mean_error)
    sds = (one.sd - other.sd) / np.hypot(one.sd_error, other.sd_error)
    return np.max(np.abs([means, sds]))


LARGEST = norm.isf(FALSE_ALARM / COMPARISONS / 2)


@pytest.fixture(params=MOTIONS)
def model(request, models):
    return models[request.param]


def simulated(model, i):
    """A record; the first one's zero is raised by 0.15 mm, so that leaving it out shows."""
    rng = generator(1, "test mcmc", model.motion, i)
    record = model.sensor.corrupt(model.curves(from_prior(model, 1, rng)), rng)[0]
    return record + (0.15 if i == 0 else 0.0), rng


@pytest.mark.parametrize("i", range(CURVES))
def test_corrected_posteriors_are_those_of_mcmc(model, i):
    """All 192 comparisons of the six curves together: false alarm 1e-3 (Bonferroni).

    Corrected from draws of the prior, and from independent ones that are 1.3 times as wide as the
    posterior. The errors are small enough to tell: below 15 per cent of a posterior sd. The faults,
    on the first curve: a likelihood without the zero, from either start, and draws that are not
    corrected.
    """
    record, rng = simulated(model, i)
    draws, corrected = by_correction(model, record, from_prior(model, D, rng), rng)
    seed = seed_integer(1, "test mcmc", model.motion, i)
    chain = by_mcmc(log_posterior(model, record), draws, seed)
    wide = chain.mean + 1.3 * chain.sd * rng.standard_normal((D, 8))
    _, from_wide = by_correction(model, record, wide, rng)
    for moments in (corrected, from_wide, chain):
        assert np.all(moments.mean_error < 0.15 * moments.sd)
        assert np.all(moments.sd_error < 0.15 * moments.sd)
    assert largest_score(corrected, chain) < LARGEST
    assert largest_score(from_wide, chain) < LARGEST
    if i == 0:
        faulty = replace(model, sensor=replace(model.sensor, zero_sd=0.0))
        for start in (from_prior(model, D, rng), wide):
            _, without_zero = by_correction(faulty, record, start, rng)
            assert largest_score(without_zero, chain) > 2 * LARGEST
        assert largest_score(of_draws(wide, D), chain) > LARGEST
