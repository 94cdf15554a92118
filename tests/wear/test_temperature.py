"""Friction by temperature: a season is no wear, what it says of the grease, and gaps."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.randomness import generator
from breaker.wear.events import Event
from breaker.wear.temperature import FRICTION, Felt, Warmth
from breaker.wear.trend import Follower
from tests.wear.parts import assert_goes_on, part, recorded

P = len(NAMES)
COUNT = 90
OPERATIONS = 1 + 10 * np.arange(COUNT)
EFFECT = -5.0  # percent of gamma_a for 10 K
SLOPE = 0.4  # of gamma_a, standardised in 1,000 operations
SCATTER = 0.002  # share of a parameter; one of the model's candidates
FAR = from_list([{"name": "far", "motion": "closing", "upper": {"L": 30.0}}], MOTIONS)


@pytest.fixture(scope="module")
def settings(defaults):
    return defaults["wear_model"] | {"baseline": 20, "settle": 20, "lines": 2}


@pytest.fixture(scope="module")
def follower(models, settings):
    return Follower.from_settings(models, FAR, settings, 1)


@pytest.fixture(scope="module")
def seasons(models):
    """A year takes 500 operations, from 3 below zero to 27 °C; every ninth has no temperature."""
    rng = generator(1, "test temperature")
    temperature = 12.0 - 15.0 * np.cos(2.0 * np.pi * OPERATIONS / 500.0)
    z = np.zeros((COUNT, P))
    z[:, FRICTION] = SLOPE * (OPERATIONS - 1) / 1000
    sds = models["closing"].prior.log_sds
    z[:, FRICTION] += EFFECT / 100 / sds[FRICTION] * (temperature - 12.0) / 10.0
    temperature[::9] = np.nan
    return recorded(models, OPERATIONS, z, rng, scatter=SCATTER, temperature=temperature)


@pytest.fixture(scope="module")
def followed(follower, seasons):
    return follower.follow(follower.begin(seasons), seasons)


def test_a_season_is_no_wear(follower, followed, seasons):
    """Level, slope and effect at the end, by stated intervals: false alarm 1e-3."""
    state, found = followed
    last, prior = found.isel(operation=-1, parameter=FRICTION), follower.prior
    bound = norm.isf(0.5e-3 / 3)
    effect, sd = found.temperature_effect.values[-1]
    assert abs(effect - EFFECT) < bound * sd
    assert sd < 0.5
    slope = 100 * prior.log_sds[FRICTION] * SLOPE
    ends = last.slope_interval.values
    assert abs(last.slope - slope) < bound * np.ptp(ends) / 2 / 1.6449
    assert np.ptp(ends) < 8
    # The level at T0, the mean temperature of the reference.
    used = seasons.alike(np.arange(20))
    assert state.warmth.reference == pytest.approx(seasons.temperature[used].mean())
    level = np.log(prior.destandardise(np.zeros(P))[FRICTION]) + slope / 100 * 0.89
    level += EFFECT / 100 * (state.warmth.reference - 12.0) / 10.0
    ends = np.log(last.level_interval.values)
    assert abs(np.log(last.level) - level) < bound * np.ptp(ends) / 2 / 1.6449
    assert not found.alarm.any()


def test_without_temperatures_the_season_is_taken_for_wear(models, settings, seasons):
    """The fault: a drive that is not told the temperature changes its wear twice a year."""
    blind = replace(part(seasons, slice(0, 60)), temperature=None)
    follower = Follower.from_settings(models, FAR, settings | {"agreement_p_value": 0.0}, 1)
    _, found = follower.follow(follower.begin(blind), blind)
    assert found.alarm.any()
    assert np.isnan(found.temperature_effect).all()


def test_an_effect_of_none_is_not_looked_for(models, settings, seasons):
    """Bit by bit what is found without temperatures, where prior mean and sd are 0."""
    short = part(seasons, slice(0, 12))
    off = Follower.from_settings(models, FAR, settings | {"friction_by_temperature": [0, 0]}, 1)
    alike = off.begin(short)
    found = off.follow(alike, short)
    blind = off.follow(alike, replace(short, temperature=None))
    xr.testing.assert_identical(found[1], blind[1])


def test_a_known_effect_is_not_learnt(models, settings, seasons):
    short = part(seasons, slice(0, 12))
    known = Follower.from_settings(models, FAR, settings | {"friction_by_temperature": [-5, 0]}, 1)
    _, found = known.follow(known.begin(short), short)
    np.testing.assert_allclose(found.temperature_effect, [[-5.0, 0.0]] * 12, atol=1e-9)


def test_a_stored_state_goes_on_as_if_never_interrupted(follower, followed, seasons):
    """Bit by bit, between temperatures, with an operation without one first."""
    assert_goes_on(follower, seasons, 45, followed)


def test_other_grease_has_another_effect(follower, seasons):
    short = part(seasons, slice(0, 40))
    greased = replace(short, events={301: Event.from_text("greased")})
    _, found = follower.follow(follower.begin(greased), greased)
    sds = found.temperature_effect.values[:, 1]
    assert sds[29] < 0.2 * sds[30]


def test_the_reference_is_about_as_warm(seasons):
    places = np.arange(50)
    chosen = seasons.temperature[seasons.alike(places)]
    assert np.abs(chosen - 12.0).max() < 8.0
    assert len(chosen) >= 8
    unknown = replace(seasons, temperature=np.full(COUNT, np.nan))
    assert seasons.alike(places[:0]).size == 0
    assert unknown.alike(places).tolist() == places.tolist()


def test_what_an_unknown_temperature_leaves_of_what_is_said():
    """Against the covariance with the friction's variance added."""
    rng = generator(2, "test temperature")
    root = rng.standard_normal((P, P))
    matrix, slope = root @ root.T + np.eye(P), rng.standard_normal(P)
    wide = np.linalg.inv(matrix)
    wide[FRICTION, FRICTION] += 0.3
    found, said = Felt(variance=0.3).blurred(matrix, slope)
    np.testing.assert_allclose(found, np.linalg.inv(wide), rtol=1e-9)
    np.testing.assert_allclose(said, np.linalg.solve(wide, np.linalg.solve(matrix, slope)))
    known = Felt().blurred(matrix, slope)
    assert known[0] is matrix


def test_temperatures_so_far():
    warmth = Warmth(20.0)
    assert warmth.apart(np.nan) == (0.0, 1.0)
    assert warmth.apart(35.0) == (1.5, 0.0)
    for each in (35.0, np.nan, 25.0):
        warmth = warmth.learn(each)
    mean, variance = warmth.apart(np.nan)
    assert mean == pytest.approx(2.0 / 3)
    assert variance == pytest.approx(3.5 / 3 - (2.0 / 3) ** 2)
