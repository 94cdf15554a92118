"""Remaining life against brute force: lines drawn from a known normal, walked step by step."""

import numpy as np
import pytest
from scipy.stats import norm

from breaker.mechanism.limits import Limit
from breaker.mechanism.parameters import NAMES
from breaker.mechanism.quantities import evaluate
from breaker.model.randomness import generator
from breaker.wear.hypotheses import Hypotheses
from breaker.wear.lifetime import Horizon, Remaining, remaining_life

P = len(NAMES)
F, GAP, K_A = (NAMES.index(name) for name in ("f", "L", "k_a"))
QUANTILES = [0.05, 0.5, 0.95]


def limit(motion="closing", **sides):
    return Limit.from_settings({"name": "limit", "motion": motion, **sides})


WEAK = limit(lower={"f": 0.735})  # 2 % below the prior's median
SLOW = limit(upper={"touch_time": 10.25})  # 10.09 ms at the prior's medians
FAST_WEAR = {"slope": -4.0, "slope_sd": 0.8, "level_sd": 0.05}


def hypotheses(mean, cov, weight=(1.0,)):
    """Hypotheses with means ``(h, 2 p)``, covariances ``(h, 2 p, 2 p)`` and weights."""
    h = len(weight)
    mean, cov = np.broadcast_to(mean, (h, 2 * P)), np.broadcast_to(cov, (h, 2 * P, 2 * P))
    whole = np.zeros(h), np.full(h, -1), np.zeros(h, dtype=int), np.zeros(h)
    return Hypotheses(0, np.log(weight), mean.copy(), cov.copy(), *whole)


def wearing(slope=-0.6, slope_sd=0.2, level_sd=0.08, correlation=0.9):
    """A closing force that falls, standardised, with its level and slope known in part.

    Everything else is known less well, is correlated with the force, and drifts a little.
    """
    rng = generator(1, "test", "lines")
    root = 0.02 * rng.standard_normal((2 * P, 2 * P))
    pair = np.ix_([F, P + F], [F, P + F])
    cov = root @ root.T
    off = correlation * level_sd * slope_sd
    cov[pair] += [[level_sd**2, off], [off, slope_sd**2]]
    mean = np.zeros(2 * P)
    mean[P + F] = slope
    return mean, cov


def normals(d, name="normals"):
    return generator(2, "test", name).standard_normal((d, 2 * P))


def walked(mean, cov, limits, prior, *, n, last):
    """Operations until the level is beyond all limits at once, ``(n,)``; inf after ``last``."""
    lines = generator(0, "test", "brute force").multivariate_normal(mean, cov, n, method="eigh")
    lives, alive = np.full(n, np.inf), np.arange(n)
    for o in range(last + 1):
        theta = prior.destandardise(lines[alive, :P] + o / 1000.0 * lines[alive, P:])
        over = np.all([each.exceeded(each.evaluate(theta)) for each in limits], axis=0)
        lives[alive[over]] = o
        alive = alive[~over]
    return lives


def agree(lives, others):
    """Kolmogorov-Smirnov, two samples: false alarm below 1e-3. Lives may be off by one in 50."""
    grid = np.unique(others[np.isfinite(others)])
    error = 1.95 * np.sqrt(1 / len(lives) + 1 / len(others))
    early, late = (np.mean(lives[:, None] <= each, axis=0) for each in (0.98 * grid, 1.02 * grid))
    truth = np.mean(others[:, None] <= grid, axis=0)
    return bool(np.all((early - error <= truth) & (truth <= late + error)))


# ---- against brute force ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def weak_lives(prior):
    return walked(*wearing(), [WEAK], prior, n=4000, last=1500)


def test_limit_on_a_parameter(prior, weak_lives):
    """And quantiles: their probabilities are within the same error of what they should be."""
    horizon = Horizon(1500, normals(4000))
    left = remaining_life(hypotheses(*wearing()), [WEAK], prior, horizon)
    assert agree(left.lives[0], weak_lives)
    ends = left.quantiles(QUANTILES)[0]
    assert np.all(np.diff(ends) > 50)
    share = np.mean(weak_lives[:, None] <= ends, axis=0)
    np.testing.assert_allclose(share, QUANTILES, atol=1.95 * np.sqrt(2 / 4000))


@pytest.mark.parametrize("fault", ["lines known", "level and slope independent", "level known"])
def test_faults_are_seen(fault, prior, weak_lives):
    mean, cov = wearing()
    if fault == "lines known":
        cov = np.zeros_like(cov)
    elif fault == "level and slope independent":
        cov[:P, P:] = cov[P:, :P] = 0.0
    else:
        cov[:P] = cov[:, :P] = 0.0
    left = remaining_life(hypotheses(mean, cov), [WEAK], prior, Horizon(1500, normals(4000)))
    assert not agree(left.lives[0], weak_lives)


def test_limit_on_what_is_simulated(prior):
    mean, cov = wearing(**FAST_WEAR)
    lives = walked(mean, cov, [SLOW], prior, n=1000, last=130)
    horizon = Horizon(130, normals(2000))
    left = remaining_life(hypotheses(mean, cov), [SLOW], prior, horizon)
    assert 0.5 < np.isfinite(lives).mean() < 1.0
    assert agree(left.lives[0], lives)
    left = remaining_life(hypotheses(mean, np.zeros_like(cov)), [SLOW], prior, horizon)
    assert not agree(left.lives[0], lives)


@pytest.mark.parametrize(("value", "touch"), [(0.70, 10.15), (0.74, 10.40)])
def test_region_is_crossed_where_both_hold(value, touch, prior):
    """One part holds long before the other: the later one decides, whichever that is."""
    parts = limit(lower={"f": value}), limit(upper={"touch_time": touch})
    region = limit(lower={"f": value}, upper={"touch_time": touch})
    mean, cov = wearing(**FAST_WEAR)
    lives = walked(mean, cov, parts, prior, n=700, last=250)
    left = remaining_life(
        hypotheses(mean, cov), [region, *parts], prior, Horizon(250, normals(1000))
    )
    assert agree(left.lives[0], lives)
    assert np.all(left.lives[0] >= left.lives[1:].max(axis=0) - 1.0)
    assert not agree(left.lives[1:].min(axis=0), lives)


@pytest.mark.parametrize("slope", [-4.0, -0.5, -0.1])
def test_one_line_in_closed_form(slope, prior):
    """The first whole operation beyond: the one after the crossing, in logs exact."""
    mean, cov = wearing(slope=slope)
    left = remaining_life(hypotheses(mean, 0 * cov), [WEAK], prior, Horizon(10_000, normals(3)))
    crossing = np.log(0.735 / 0.75) / (prior.log_sds[F] * slope / 1000.0)
    np.testing.assert_allclose(left.lives, np.floor(crossing) + 1.0, rtol=0.03)
    assert np.all(left.lives == left.lives.round())
    np.testing.assert_allclose(left.now, 0.75)


def test_hypotheses_count_by_their_weight(prior):
    """Three lines of ten are of the first: the mixture, exactly."""
    mean, cov = wearing()
    draws = normals(10)
    held = hypotheses(mean, np.stack([cov, 0.2 * cov]), (0.3, 0.7))
    mixed = remaining_life(held, [WEAK], prior, Horizon(800, draws)).lives
    first = remaining_life(hypotheses(mean, cov), [WEAK], prior, Horizon(800, draws[:3])).lives
    other = hypotheses(mean, 0.2 * cov)
    second = remaining_life(other, [WEAK], prior, Horizon(800, draws[3:])).lives
    np.testing.assert_array_equal(mixed, np.concatenate([first, second], axis=1))


# ---- ends ------------------------------------------------------------------------------------


def test_exceeded_already(prior):
    """No operation is left, in all of the draws."""
    mean, cov = wearing()
    gone = limit(lower={"f": 0.80})
    left = remaining_life(hypotheses(mean, cov), [gone], prior, Horizon(500, normals(50)))
    np.testing.assert_array_equal(left.quantiles(QUANTILES), 0.0)
    assert (left.beyond[0], left.toward[0]) == (1.0, 1.0)


@pytest.mark.parametrize("value", [0.73, 0.745, 0.75, 0.755])
def test_no_life_is_left_as_probably_as_the_level_is_beyond(value, prior):
    """By construction, of the quantities shown; a normal level, binomial, false alarm 1e-3."""
    d, (mean, cov) = 2000, wearing()
    left = remaining_life(
        hypotheses(mean, cov), [limit(lower={"f": value})], prior, Horizon(500, normals(d))
    )
    assert left.beyond[0] == np.mean(left.lives == 0) == np.mean(left.now[:, 0] < value)
    sd = prior.log_sds[F] * np.sqrt(cov[F, F])
    expected = norm.cdf(np.log(value / 0.75) / sd)
    error = 3.3 * np.sqrt(expected * (1 - expected) / d) + 1e-3
    assert left.beyond[0] == pytest.approx(expected, abs=error)


def test_nothing_is_known_before_the_first_record():
    nothing = Remaining(np.zeros((1, 4)), np.ones(1), np.zeros((4, 1))).unknown()
    for each in (nothing.beyond, nothing.toward, nothing.quantiles(QUANTILES)):
        assert np.isnan(each).all()


def test_a_trend_that_leads_away(prior):
    mean, cov = wearing(slope=0.6, slope_sd=0.05, level_sd=0.02)
    horizon, limits = Horizon(10_000, normals(500)), [limit(lower={"f": 0.70})]
    limits.append(limit(upper={"f": 0.9}))
    left = remaining_life(hypotheses(mean, cov), limits, prior, horizon)
    assert left.toward.tolist() == [0.0, 1.0]
    assert left.beyond.tolist() == [0.0, 0.0]
    assert np.isinf(left.lives[0]).all()
    assert np.isfinite(left.lives[1]).mean() > 0.98


def test_share_of_lines_that_lead_to_a_limit(prior):
    """A slope one sd below zero: Phi(1) of the lines, binomial, false alarm below 1e-3."""
    d = 2000
    mean, cov = wearing(slope=-0.1, slope_sd=0.1)
    sd = np.sqrt(cov[P + F, P + F])
    left = remaining_life(hypotheses(mean, cov), [WEAK], prior, Horizon(500, normals(d)))
    expected = norm.cdf(0.1 / sd)
    error = 3.3 * np.sqrt(expected * (1 - expected) / d)
    assert left.toward[0] == pytest.approx(expected, abs=error)


def test_lives_end_at_the_horizon(prior):
    """A longer one changes nothing before it, but for the places where lines are simulated."""
    held, draws = hypotheses(*wearing()), normals(500)
    near = remaining_life(held, [WEAK], prior, Horizon(300, draws)).lives
    far = remaining_life(held, [WEAK], prior, Horizon(1500, draws)).lives
    assert 0.2 < np.isfinite(near).mean() < 0.8
    soon = np.isfinite(near)
    np.testing.assert_allclose(far[soon], near[soon], rtol=0.01, atol=1.0)
    assert far[~soon].min() >= 299


def test_nothing_is_predicted_beyond_the_prior(prior):
    """Limits past five sds of the prior: lines lead there, but are not followed."""
    mean, cov = wearing(slope_sd=0.02, level_sd=0.02)
    values = 0.75 * np.exp(prior.log_sds[F] * np.array([-4.5, -5.2, -6.0]))
    limits = [limit(lower={"f": float(value)}) for value in values]
    horizon = Horizon(50_000, normals(50))
    left = remaining_life(hypotheses(mean, 0.01 * cov), limits, prior, horizon)
    assert np.isfinite(left.lives).mean(axis=1).tolist() == [1.0, 0.0, 0.0]
    assert left.toward.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("sides", [{"upper": {"touch_time": 59.0}}, {"lower": {"f": 0.1}}])
def test_a_drive_that_comes_to_nothing(sides, prior):
    """Where the touch does not exist any more it is beyond its limit; the force is not."""
    mean, cov = wearing(slope=-5.0)
    mean[[K_A, F]] = 3.0, -1.5  # too weak to reach the gap after 450 operations or so
    horizon = Horizon(600, normals(50))
    left = remaining_life(hypotheses(mean, 0.01 * cov), [limit(**sides)], prior, horizon)
    assert left.lives.min() > 300
    assert np.isfinite(left.lives).all() == ("upper" in sides)
    assert np.isfinite(left.now).all()


# ---- form ------------------------------------------------------------------------------------


def test_limits_do_not_disturb_each_other(prior):
    """Both motions, in any order: the row of each limit and the columns of its parts."""
    limits = [
        limit("opening", lower={"opening_speed": 1.2}),
        limit(upper={"touch_time": 9.8}, lower={"f": 0.735}),
        limit("opening", upper={"L": 10.1}),
        SLOW,
    ]
    mean, cov = wearing(slope=-1.0)
    mean[P + K_A] = -1.0
    held, horizon = hypotheses(mean, cov), Horizon(300, normals(30))
    left = remaining_life(held, limits, prior, horizon)
    assert left.lives.shape == (4, 30)
    assert left.now.shape == (30, 5)
    at = 0
    for i, each in enumerate(limits):
        alone = remaining_life(held, [each], prior, horizon)
        np.testing.assert_array_equal(left.lives[i], alone.lives[0])
        assert (left.toward[i], left.beyond[i]) == (alone.toward[0], alone.beyond[0])
        width = len(each.parts)
        np.testing.assert_allclose(left.now[:, at : at + width], alone.now)
        at += width
    lines = mean[:P] + normals(30) @ np.zeros((2 * P, P))
    medians = [evaluate(e.quantities, prior.destandardise(lines), e.motion)[0] for e in limits]
    np.testing.assert_allclose(np.median(left.now, axis=0), np.concatenate(medians), rtol=0.02)
