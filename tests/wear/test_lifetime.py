"""Remaining life against brute force: lines drawn from a known normal, walked step by step."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from breaker.mechanism.limits import Limit
from breaker.mechanism.parameters import NAMES
from breaker.mechanism.quantities import evaluate
from breaker.model.randomness import generator
from breaker.wear.changepoint import Hypotheses, Tracker
from breaker.wear.lifetime import Horizon, horizon_grid, reached, remaining_life

P = len(NAMES)
F, GAP, K_A = (NAMES.index(name) for name in ("f", "L", "k_a"))
SCATTER = 0.003


def limit(motion="closing", **sides):
    return Limit.from_settings({"name": "limit", "motion": motion, **sides})


WEAK = limit(lower={"f": 0.735})  # 2 % below the prior's median
SLOW = limit(upper={"touch_time": 10.25})  # 10.09 ms at the prior's medians
FAST_WEAR = {"slope": -4.0, "slope_sd": 0.8, "level_sd": 0.05}


@pytest.fixture(scope="module")
def tracker(defaults, prior):
    tracker = Tracker.from_settings(defaults["wear_model"], prior.log_sds)
    return replace(tracker, hazard=0.0, scatters=np.array([SCATTER]))


def hypotheses(mean, cov, weight=(1.0,), scatter=None):
    """Hypotheses with means ``(h, 2 p)``, covariances ``(h, 2 p, 2 p)`` and weights."""
    h = len(weight)
    scatter = np.zeros(h, dtype=int) if scatter is None else np.array(scatter)
    mean, cov = np.broadcast_to(mean, (h, 2 * P)), np.broadcast_to(cov, (h, 2 * P, 2 * P))
    whole = np.zeros(h, dtype=int), np.full(h, -1), scatter
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


def walked(mean, cov, limits, prior, *, n, last, scatter=SCATTER, seed=0):
    """Operations until all limits are exceeded at once, ``(n,)``; inf after ``last``."""
    rng = generator(seed, "test", "brute force")
    lines = rng.multivariate_normal(mean, cov, size=n, method="eigh")
    lives, alive = np.full(n, np.inf), np.arange(n)
    for o in range(1, last + 1):
        z = lines[alive, :P] + o / 1000.0 * lines[alive, P:]
        z = z + scatter / prior.log_sds * rng.standard_normal(z.shape)
        over = np.ones(len(alive), dtype=bool)
        theta = prior.destandardise(z)
        for each in limits:
            over &= each.exceeded(evaluate(each.quantities, theta, each.motion))
        lives[alive[over]] = o
        alive = alive[~over]
    return lives


def agrees(grid, cdf, lives, d):
    """Kolmogorov-Smirnov, two samples, on a grid: false alarm below 1e-3.

    Between nodes of the grid nothing is said, so a distribution may be ahead by one interval.
    """
    error = 1.95 * np.sqrt(1 / d + 1 / len(lives))
    truth = np.mean(lives[:, None] <= grid, axis=0)
    early = np.append(truth[1:], 1.0)
    return bool(np.all((truth - error <= cdf) & (cdf <= early + error)))


# ---- against brute force ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def weak_lives(prior):
    return walked(*wearing(), [WEAK], prior, n=4000, last=1500)


def test_limit_on_a_parameter(tracker, prior, weak_lives):
    """And quantiles: their probabilities are within the same error of what they should be."""
    horizon = Horizon(1500, normals(4000))
    left = remaining_life(tracker, hypotheses(*wearing()), [WEAK], prior, horizon)
    assert agrees(horizon.grid, left.cdf[0], weak_lives, 4000)
    q = np.array([0.05, 0.5, 0.95])
    ends = reached(horizon.grid, left.cdf[0], q)
    assert np.all(np.diff(ends) > 50)
    share = np.mean(weak_lives[:, None] <= ends, axis=0)
    np.testing.assert_allclose(share, q, atol=1.95 * np.sqrt(2 / 4000) + 0.02)


def faulty(fault, tracker):
    """Tracker and lines of which one thing is wrong."""
    mean, cov = wearing()
    if fault == "scatter ignored":
        tracker = replace(tracker, scatters=np.array([1e-6]))
    elif fault == "scatter twice":
        tracker = replace(tracker, scatters=np.array([2 * SCATTER]))
    elif fault == "lines known":
        cov = np.zeros_like(cov)
    elif fault == "level and slope independent":
        cov[:P, P:] = cov[P:, :P] = 0.0
    elif fault == "level known":
        cov[:P] = cov[:, :P] = 0.0
    return tracker, hypotheses(mean, cov)


@pytest.mark.parametrize(
    "fault",
    [
        "scatter ignored",
        "scatter twice",
        "lines known",
        "level and slope independent",
        "level known",
    ],
)
def test_faults_are_seen(fault, tracker, prior, weak_lives):
    horizon = Horizon(1500, normals(4000))
    wrong, held = faulty(fault, tracker)
    left = remaining_life(wrong, held, [WEAK], prior, horizon)
    assert not agrees(horizon.grid, left.cdf[0], weak_lives, 4000)
    if fault.startswith("scatter"):
        later = reached(horizon.grid, left.cdf[0], [0.5])[0] > np.median(weak_lives)
        assert later == (fault == "scatter ignored")


def test_limit_on_what_is_simulated(tracker, prior):
    mean, cov = wearing(**FAST_WEAR)
    lives = walked(mean, cov, [SLOW], prior, n=1000, last=130)
    horizon = Horizon(130, normals(2000))
    left = remaining_life(tracker, hypotheses(mean, cov), [SLOW], prior, horizon)
    assert 0.5 < np.isfinite(lives).mean() < 1.0
    assert agrees(horizon.grid, left.cdf[0], lives, 2000)
    known = hypotheses(mean, np.zeros_like(cov))
    left = remaining_life(tracker, known, [SLOW], prior, horizon)
    assert not agrees(horizon.grid, left.cdf[0], lives, 2000)
    steady = replace(tracker, scatters=np.array([1e-6]))
    left = remaining_life(steady, hypotheses(mean, cov), [SLOW], prior, horizon)
    assert not agrees(horizon.grid, left.cdf[0], lives, 2000)


@pytest.mark.parametrize(("value", "touch"), [(0.70, 10.15)])
def test_region_is_crossed_where_both_hold(value, touch, tracker, prior):
    """One part holds long before the other: the later one decides, whichever that is."""
    parts = limit(lower={"f": value}), limit(upper={"touch_time": touch})
    region = limit(lower={"f": value}, upper={"touch_time": touch})
    mean, cov = wearing(**FAST_WEAR)
    lives = walked(mean, cov, parts, prior, n=700, last=250)
    horizon = Horizon(250, normals(1000))
    left = remaining_life(tracker, hypotheses(mean, cov), [region, *parts], prior, horizon)
    assert agrees(horizon.grid, left.cdf[0], lives, 1000)
    assert np.all(left.cdf[0] <= left.cdf[1:].min(axis=0) + 1e-12)
    assert not agrees(horizon.grid, left.cdf[1:].max(axis=0), lives, 1000)


def test_one_line_in_closed_form(tracker, prior):
    """The product over operations of the probability to stay above, in logs, where it is exact."""
    mean, cov = wearing(slope=-4.0)
    horizon = Horizon(100, normals(3))
    left = remaining_life(tracker, hypotheses(mean, 0 * cov), [WEAK], prior, horizon)
    level = np.log(0.75) + prior.log_sds[F] * mean[P + F] * horizon.grid / 1000.0
    short = (level - np.log(0.735)) / SCATTER
    expected = 1.0 - np.cumprod(norm.cdf(short))
    q = [0.05, 0.5, 0.95]
    np.testing.assert_allclose(
        reached(horizon.grid, left.cdf[0], q), reached(horizon.grid, expected, q), rtol=0.02
    )
    np.testing.assert_allclose(left.now, 0.75)
    # Of a scatter four times smaller, operations stay above until later.
    calm = replace(tracker, scatters=np.array([SCATTER / 4]))
    later = remaining_life(calm, hypotheses(mean, 0 * cov), [WEAK], prior, horizon)
    assert np.all(later.cdf[0] <= left.cdf[0] + 1e-3)
    ends = [reached(horizon.grid, each.cdf[0], [0.5])[0] for each in (later, left)]
    assert ends[0] > 1.15 * ends[1]


def test_hypotheses_count_by_their_weight(tracker, prior):
    """Three lines of ten are of the first: the mixture, exactly, each with its own scatter."""
    mean, cov = wearing()
    both = replace(tracker, scatters=np.array([0.001, 0.006]))
    draws = normals(10)
    held = hypotheses(mean, np.stack([cov, 0.2 * cov]), (0.3, 0.7), scatter=(1, 0))
    mixed = remaining_life(both, held, [WEAK], prior, Horizon(800, draws)).cdf[0]
    one = hypotheses(mean, cov, scatter=(1,))
    other = hypotheses(mean, 0.2 * cov, scatter=(0,))
    first = remaining_life(both, one, [WEAK], prior, Horizon(800, draws[:3])).cdf[0]
    second = remaining_life(both, other, [WEAK], prior, Horizon(800, draws[3:])).cdf[0]
    np.testing.assert_allclose(mixed, 0.3 * first + 0.7 * second, atol=1e-9)
    assert np.abs(first - second).max() > 0.2


# ---- ends ------------------------------------------------------------------------------------


def test_exceeded_already(tracker, prior):
    mean, cov = wearing()
    gone = limit(lower={"f": 0.80})
    horizon = Horizon(500, normals(50))
    left = remaining_life(tracker, hypotheses(mean, cov), [gone], prior, horizon)
    assert left.cdf[0, 0] > 0.999
    assert np.all(reached(horizon.grid, left.cdf[0], [0.05, 0.5, 0.95]) <= 1.0)
    assert left.beyond[0] == 1.0
    assert left.toward[0] == 1.0


def test_a_trend_that_leads_away(tracker, prior):
    mean, cov = wearing(slope=0.6, slope_sd=0.05, level_sd=0.02)
    horizon, limits = Horizon(10_000, normals(500)), [limit(lower={"f": 0.70})]
    limits.append(limit(upper={"f": 0.9}))
    left = remaining_life(tracker, hypotheses(mean, cov), limits, prior, horizon)
    assert left.cdf[0, -1] < 1e-6
    assert left.toward.tolist() == [0.0, 1.0]
    assert left.beyond.tolist() == [0.0, 0.0]
    assert left.cdf[1, -1] > 0.98
    np.testing.assert_array_equal(
        reached(horizon.grid, left.cdf[0], [0.05, 0.5, 0.95]), [np.inf] * 3
    )


def test_share_of_lines_that_lead_to_a_limit(tracker, prior):
    """A slope one sd below zero: Phi(1) of the lines, binomial, false alarm below 1e-3."""
    d = 2000
    mean, cov = wearing(slope=-0.1, slope_sd=0.1)
    sd = np.sqrt(cov[P + F, P + F])
    left = remaining_life(tracker, hypotheses(mean, cov), [WEAK], prior, Horizon(500, normals(d)))
    expected = norm.cdf(0.1 / sd)
    error = 3.3 * np.sqrt(expected * (1 - expected) / d)
    assert left.toward[0] == pytest.approx(expected, abs=error)


def test_mass_ends_at_the_horizon(tracker, prior, weak_lives):
    """What does not happen up to it is left out, and a longer one changes nothing before it."""
    held, draws = hypotheses(*wearing()), normals(4000)
    near = remaining_life(tracker, held, [WEAK], prior, Horizon(300, draws)).cdf[0]
    error = 1.95 * np.sqrt(2 / 4000)  # as in ``agrees``
    assert near[-1] == pytest.approx(np.mean(weak_lives <= 300), abs=error + 0.02)
    assert 0.2 < near[-1] < 0.8
    far = remaining_life(tracker, held, [WEAK], prior, Horizon(1500, draws))
    assert far.cdf[0, -1] > 0.95
    grid = horizon_grid(1500)
    np.testing.assert_allclose(np.interp(300, grid, far.cdf[0]), near[-1], atol=0.02)


def test_nothing_is_predicted_beyond_the_prior(tracker, prior):
    """Limits past five sds of the prior: lines lead there, but are not followed, nor held there
    for the scatter to exceed the nearer one in thousands of operations at last."""
    mean, cov = wearing(slope_sd=0.02, level_sd=0.02)
    values = 0.75 * np.exp(prior.log_sds[F] * np.array([-4.5, -5.2, -6.0]))
    limits = [limit(lower={"f": float(value)}) for value in values]
    horizon = Horizon(50_000, normals(50))
    left = remaining_life(tracker, hypotheses(mean, 0.01 * cov), limits, prior, horizon)
    assert left.cdf[0, -1] > 0.99
    assert left.cdf[1, -1] < 0.05
    assert left.cdf[2, -1] < 1e-6
    assert left.toward.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("sides", [{"upper": {"touch_time": 59.0}}, {"lower": {"f": 0.1}}])
def test_a_drive_that_comes_to_nothing(sides, tracker, prior):
    """Where the touch does not exist any more it is beyond its limit; the force is not."""
    mean, cov = wearing(slope=-5.0)
    mean[[K_A, F]] = 3.0, -1.5  # too weak to reach the gap after 450 operations or so
    horizon = Horizon(600, normals(50))
    left = remaining_life(tracker, hypotheses(mean, 0.01 * cov), [limit(**sides)], prior, horizon)
    cdf = left.cdf[0]
    assert np.isfinite(cdf).all()
    assert cdf[horizon.grid <= 300].max() < 1e-6
    assert cdf[-1] == pytest.approx(1.0 if "upper" in sides else 0.0, abs=1e-6)
    assert np.isfinite(left.now).all()


# ---- form ------------------------------------------------------------------------------------


@pytest.mark.parametrize("horizon", [1, 7, 100, 101, 150, 10_000])
def test_horizon_grid(horizon):
    grid = horizon_grid(horizon)
    assert grid.dtype.kind == "i"
    assert (grid[0], grid[-1]) == (1, horizon)
    assert np.all(np.diff(grid) >= 1)
    first = min(horizon, 100)
    np.testing.assert_array_equal(grid[:first], np.arange(1, first + 1))
    assert np.all(np.diff(grid) <= np.maximum(1, 0.035 * grid[1:]))
    assert grid.size <= 260
    np.testing.assert_array_equal(Horizon(horizon, normals(1)).grid, grid)


def test_limits_do_not_disturb_each_other(tracker, prior):
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
    left = remaining_life(tracker, held, limits, prior, horizon)
    assert left.cdf.shape == (4, horizon.grid.size)
    assert left.now.shape == (30, 5)
    at = 0
    for i, each in enumerate(limits):
        alone = remaining_life(tracker, held, [each], prior, horizon)
        np.testing.assert_allclose(left.cdf[i], alone.cdf[0], atol=1e-12)
        assert (left.toward[i], left.beyond[i]) == (alone.toward[0], alone.beyond[0])
        width = len(each.parts)
        np.testing.assert_allclose(left.now[:, at : at + width], alone.now)
        at += width
    assert np.all((left.cdf >= 0) & (left.cdf <= 1))
    assert np.all(np.diff(left.cdf, axis=1) >= -1e-12)
    lines = mean[:P] + normals(30) @ np.zeros((2 * P, P))
    medians = [evaluate(e.quantities, prior.destandardise(lines), e.motion)[0] for e in limits]
    np.testing.assert_allclose(np.median(left.now, axis=0), np.concatenate(medians), rtol=0.02)
