"""The ideal observer: calibrated where all is as it holds, told or not, and better if told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator
from breaker.synthetic.ideal import Observer
from breaker.synthetic.lives import Life, simulate_life
from breaker.wear.lifetime import quantiles_of

NORMALS = generator(3, "test", "normals").standard_normal((60, 2 * len(NAMES)))


@pytest.fixture(scope="module")
def settings(defaults):
    return defaults["lives"]


@pytest.fixture(scope="module")
def drawn(models, settings):
    """Lives, each scattered anew three times, so that many are cheap."""
    lives = []
    for number in range(6):
        life = simulate_life(models, settings, 4, number)
        prior = models["closing"].prior
        for again in range(3):
            rng = generator(5, "test", "scatter", number, again)
            z = life.trend + life.scatter / prior.log_sds * rng.standard_normal(life.trend.shape)
            lives.append(replace(life, theta=prior.destandardise(z)))
    return lives


def observed(models, life: Life, settings, number):
    return Observer.of(models, life, settings, generator(6, "test", "observer", number))


def intervals(models, settings, drawn, share, told):
    """90 % intervals, and the truth, at a share of the way from change to failure."""
    ends = []
    for number, life in enumerate(drawn):
        now = round(life.change + share * (life.failure - life.change))
        lives = observed(models, life, settings, number).lives(now, NORMALS, 10_000, told=told)
        ends.append([*quantiles_of(lives, [0.05, 0.95]), life.failure - now])
    return np.array(ends).T


def test_who_is_told_of_the_change_covers_and_knows_more(models, settings, drawn):
    """Of 18 lives a 90 % interval holds 11 or more: false alarm below 1e-3; a fifth of it not."""
    lower, upper, truth = intervals(models, settings, drawn, 0.5, told=True)
    fewest = binom.ppf(1e-3, len(truth), 0.9)
    assert np.sum((lower <= truth) & (truth <= upper)) >= fewest
    assert np.sum(np.abs(truth - (lower + upper) / 2) <= (upper - lower) / 10) < fewest
    early = [intervals(models, settings, drawn, 0.1, told=told) for told in (True, False)]
    width = [np.median((np.minimum(upper, 1e4) - lower) / truth) for lower, upper, truth in early]
    assert width[0] < width[1]


def test_long_after_the_change_both_know_the_same(models, settings, drawn):
    life = max(drawn, key=lambda each: each.ratio)
    observer = observed(models, life, settings, 0)
    now = life.failure - 50
    medians = [np.median(observer.lives(now, NORMALS, 10_000, told=t)) for t in (True, False)]
    np.testing.assert_allclose(*medians, rtol=0.3)
    assert medians[0] == pytest.approx(51, rel=0.8)
