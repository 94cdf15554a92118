"""Simulated lives: what they promise of themselves, and the standard error that sets the change."""

from dataclasses import fields

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.mechanism.curves import travel
from breaker.mechanism.limits import Limit
from breaker.mechanism.parameters import NAMES
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.model.sensor import Sensor
from breaker.synthetic import lives
from breaker.synthetic.lives import WINDOW, simulate_life, slope_error

P = len(NAMES)
SEED, NUMBERS = 3, range(8)
SIGNS = {"f": -1, "k_a": -1, "gamma_a": 1, "L": 1, "k_b": -1}


@pytest.fixture(scope="module")
def settings(defaults):
    return defaults["lives"] | {"operations": 1000}


@pytest.fixture(scope="module")
def drawn(models, settings):
    return [simulate_life(models, settings, SEED, number) for number in NUMBERS]


def same(one, other):
    return all(
        np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for field in fields(one)
    )


# ---- lives -----------------------------------------------------------------------------------


def test_a_life_depends_on_seed_and_number_alone(models, settings, drawn):
    """Not on those before it, nor on how many there are."""
    again = simulate_life(models, settings | {"lives": 1, "lives_per_job": 1}, SEED, 5)
    assert same(again, drawn[5])
    assert not same(simulate_life(models, settings, SEED + 1, 5), again)
    pairs = [(i, j) for i in range(len(drawn)) for j in range(i)]
    assert not any(np.array_equal(drawn[i].theta[0], drawn[j].theta[0]) for i, j in pairs)


def test_draws_of_lives_are_independent_of_each_other(models, settings):
    """Ranks of 40 ratios, drawn first: no correlation of neighbours, false alarm below 1e-3."""
    ratios = np.array([simulate_life(models, settings, 7, k).ratio for k in range(40)])
    low, high = np.log(settings["ratio"])
    u = (np.log(ratios) - low) / (high - low)
    assert np.all((u >= 0) & (u <= 1))
    assert abs(np.corrcoef(u[1:], u[:-1])[0, 1]) < 3.5 / np.sqrt(39)
    # Uniform: Kolmogorov-Smirnov, 1.95 / sqrt(n).
    steps = np.arange(1, 41) / 40
    assert np.abs(np.sort(u) - steps + 0.5 / 40).max() < 1.95 / np.sqrt(40) + 0.5 / 40


def test_numbers_of_a_life(settings, drawn):
    n, every = settings["operations"], settings["every"]
    for life in drawn:
        assert n * settings["change"][0] <= life.change <= n * settings["change"][1]
        assert life.change % every == 0
        assert settings["ratio"][0] <= life.ratio <= settings["ratio"][1]
        assert life.change + 2 * WINDOW * n <= life.failure <= 2 * n
        np.testing.assert_array_equal(life.operations, np.arange(1, life.failure + 1))
        assert life.theta.shape == life.trend.shape == (life.failure, P)
        scatter = np.array(settings["scatter"]) / 100.0
        assert np.all((life.scatter >= 0.7 * scatter[0]) & (life.scatter <= 1.4 * scatter[1]))
    assert len({life.changed for life in drawn}) > 1


def test_the_trend_bends_in_one_parameter_at_the_change(drawn):
    for life in drawn:
        bend = np.diff(life.trend, n=2, axis=0)  # about operation 2 first
        bent = np.abs(bend) > 1e-9
        expected = np.zeros_like(bent)
        expected[life.change - 2, NAMES.index(life.changed)] = True
        np.testing.assert_array_equal(bent, expected)
        assert np.sign(bend[expected]) == SIGNS[life.changed]


def test_wear_before_the_change(settings, models, drawn):
    """One or two kinds, each in its direction, by a share of the parameter within its range."""
    prior = models["closing"].prior
    for life in drawn:
        drift = (life.trend[1] - life.trend[0]) * settings["operations"] * prior.log_sds * 100.0
        moving = np.flatnonzero(np.abs(drift) > 1e-9)
        assert moving.size in (1, 2)
        assert all(np.sign(drift[i]) == SIGNS[NAMES[i]] for i in moving)
        low, high = settings["drift"]
        assert np.all((np.abs(drift[moving]) > low - 1e-6) & (np.abs(drift[moving]) < high + 1e-6))


def test_change_of_the_slope_is_the_ratio_of_its_error(models, settings, drawn):
    prior = models["closing"].prior
    for life in drawn:
        i, at = NAMES.index(life.changed), life.change - 1
        slopes = np.diff(life.trend[at - 1 : at + 2, i]) * 1000.0
        scatter = life.scatter / prior.log_sds
        error = slope_error(models, life.trend[at], scatter, life.change, settings)[i]
        assert abs(slopes[1] - slopes[0]) / error == pytest.approx(life.ratio, rel=1e-6)


def test_failure_is_the_first_operation_beyond_the_limit(models, settings, drawn):
    """Of the trend, whatever single operations do; the limit is where it is at the nominal end."""
    prior = models["closing"].prior
    for life in drawn:
        trend = life.limit.evaluate(prior.destandardise(life.trend))
        over = life.limit.exceeded(trend)
        assert over.argmax() == len(over) - 1 == life.failure - 1
        assert over[-1]
        excess = life.limit.excess(trend)[:, 0]
        assert life.failure == settings["operations"] + 1
        np.testing.assert_allclose(excess[-2], 0.0, atol=1e-8)
        assert excess[life.change - 1] < excess[-2]  # after the change it is approached


def scatter_of(theta, life, prior):
    """Sum of squares of operations before the change in units of the scatter, and its number."""
    off = np.log(theta / prior.destandardise(life.trend)) / life.scatter
    off = off[: life.change]
    return np.square(off).sum(), off.size


def test_operations_scatter_as_stated(models, drawn):
    """Chi-square over all lives, two-sided: false alarm 1e-3; 5 % more scatter is seen."""
    prior = models["closing"].prior
    total, size = np.sum([scatter_of(life.theta, life, prior) for life in drawn], axis=0)
    low, high = chi2.ppf([0.0005, 0.9995], size)
    assert low < total < high
    assert not low < 1.05**2 * total < high
    assert all(prior.supported(life.theta).all() for life in drawn)


def without_onset(model):
    sensor = Sensor(**model.sensor.settings() | {"onset_sd": 0.0})
    return Model(model.prior, sensor, model.motion)


def test_records(models, settings, drawn):
    """Every fifth operation; noise and zero of the sensor about the exact curve, in chi-square."""
    life, every = max(drawn, key=lambda life: life.scatter.mean()), settings["every"]
    sensor = models["closing"].sensor
    still = without_onset(models["closing"])
    rng = generator(1, "test", "records")
    operations, records = life.records(still, every, rng)
    np.testing.assert_array_equal(operations, np.arange(every, life.failure + 1, every))
    assert records.shape == (operations.size, sensor.samples)
    exact = still.curves(life.theta[operations - 1])
    square, size = still.sensor.chi_square(records, exact).sum(), records.size
    low, high = chi2.ppf([0.0005, 0.9995], size)  # false alarm 1e-3
    assert low < square < high
    before = still.curves(life.theta[operations - 2])  # not those of the operation before
    assert still.sensor.chi_square(records, before).sum() > high


def test_records_have_an_onset_of_their_own(models, settings, drawn):
    """With the onset they are reproducible, and vary more than noise and zero explain."""
    life, model = drawn[1], models["opening"]
    twice = [
        life.records(model, settings["every"], generator(1, "test", "records"))[1] for _ in "12"
    ]
    np.testing.assert_array_equal(*twice)
    operations = life.operations[life.operations % settings["every"] == 0]
    curves = travel(life.theta[operations - 1], model.sensor.times, "opening").travel
    assert model.sensor.chi_square(twice[0], curves).sum() > 1.2 * twice[0].size


def test_no_life_is_a_word(models, settings, monkeypatch):
    monkeypatch.setattr(lives, "_draw", lambda *_: None)
    with pytest.raises(RuntimeError, match="life 4 of seed 3: no limit was reached"):
        simulate_life(models, settings, 3, 4)


# ---- the error of the slope ------------------------------------------------------------------


CHANGE = 300
SCATTER = np.array([0.02, 0.03, 0.02, 0.015, 0.01, 0.04, 0.03])


def precision(models, centre):
    """Information of one operation, ``(p, p)``, from finite differences of curves.

    Each record's covariance holds noise, zero and onset in full.
    """
    total, step = np.zeros((P, P)), 1e-4
    for model in models.values():
        at = np.append(centre, 0.0)
        ends = [at + sign * step * np.eye(P + 1) for sign in (1, -1)]
        high, low = (model.curves(model.destandardise(end)) for end in ends)
        slopes = (high - low).T / (2 * step)  # (t, p + 1)
        sensor, t = model.sensor, len(slopes)
        cov = sensor.noise_sd**2 * np.eye(t) + sensor.zero_sd**2 * np.ones((t, t))
        cov += np.outer(slopes[:, P], slopes[:, P])  # the onset, of sd one here
        total += slopes[:, :P].T @ np.linalg.solve(cov, slopes[:, :P])
    return total


def fitted(models, centre, scatter, i, operations):
    """Standard error of the bend of parameter i: weighted least squares, design written out."""
    cov = np.linalg.inv(precision(models, centre)) + np.diag(np.square(scatter))
    n, since = len(operations), (operations - CHANGE) / 1000.0
    design = np.zeros((n, P, 2 * P + 1))  # level and slope of all, bend of one
    design[:, np.arange(P), np.arange(P)] = 1.0
    design[:, np.arange(P), P + np.arange(P)] = since[:, None]
    design[:, i, -1] = np.maximum(since, 0.0)
    root = np.linalg.inv(np.linalg.cholesky(cov))  # whitens one operation
    r = np.linalg.qr((root @ design).reshape(n * P, -1)).R
    return np.linalg.norm(np.linalg.inv(r)[-1])


@pytest.fixture(scope="module")
def centre(models):
    return models["closing"].prior.standardise(
        models["closing"].prior.sample(1, generator(5, "test", "centre"))
    )[0]


def seen(settings):
    """Operations on record until 3 % of the life after the change."""
    last = CHANGE + round(WINDOW * settings["operations"])
    return np.array([o for o in range(1, last + 1) if o % settings["every"] == 0])


def test_slope_error_is_that_of_the_fit(models, settings, centre):
    found = slope_error(models, centre, SCATTER, CHANGE, settings)
    expected = [fitted(models, centre, SCATTER, i, seen(settings)) for i in range(P)]
    np.testing.assert_allclose(found, expected, rtol=1e-3)
    # Of one motion alone, of more scatter, of fewer records, it is larger.
    one = {"opening": models["opening"]}
    for wider in (
        slope_error(one, centre, SCATTER, CHANGE, settings),
        slope_error(models, centre, 2 * SCATTER, CHANGE, settings),
        slope_error(models, centre, SCATTER, CHANGE, settings | {"every": 10}),
    ):
        assert np.all(wider > found)


def test_slope_error_without_an_onset(models, settings, centre):
    """A sensor whose trigger is right knows more."""
    still = {motion: without_onset(model) for motion, model in models.items()}
    found = slope_error(still, centre, SCATTER, CHANGE, settings)
    assert np.all(found < slope_error(models, centre, SCATTER, CHANGE, settings))


def test_limits_are_of_what_changes(drawn):
    """A life ends at a limit of one part that Limit itself accepts, by name."""
    for life in drawn:
        assert isinstance(life.limit, Limit)
        assert len(life.limit.parts) == 1
        motion, quantity = life.limit.motion, life.limit.quantities[0]
        assert (motion, quantity) in lives._LIMITS[life.changed]
