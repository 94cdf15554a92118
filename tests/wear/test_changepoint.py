"""Change points against all configurations of a short series, and known truths."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import chi2, multivariate_normal

from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator
from breaker.wear.changepoint import KINDS, Tracker
from breaker.wear.rows import start_quantiles

P = len(NAMES)
ALL, SEVERAL = KINDS.index("all"), KINDS.index("several")
FIRST = -1


@pytest.fixture
def tracker(defaults, prior):
    return Tracker.from_settings(defaults["wear_model"], prior.log_sds)


def follow(tracker, operations, matrices, slopes, *, hypotheses=None):
    """Go through operations; yield number, hypotheses, log evidence and outlier probability."""
    hypotheses = tracker.begin(operations[0]) if hypotheses is None else hypotheses
    for operation, matrix, slope in zip(operations, matrices, slopes, strict=True):
        hypotheses = tracker.predict(hypotheses, operation)
        hypotheses, log_evidence, outlier = tracker.learn(hypotheses, matrix, slope, np.zeros(P))
        yield operation, hypotheses, log_evidence, outlier


def worn(tracker, n, rng, *, sd=0.05, scatter=0.002, changes=(), jumps=(), slope=0.0, level=None):
    """Information of ``n`` operations in which each parameter is seen with an error ``sd``.

    Args:
        changes: ``(operation, name, slope)``: after it, so much more a thousand operations.
        jumps: ``(first, last, size)``: so much off, from one operation to another.
        slope, level: Of the first segment, one or ``(p,)``; a level of 0 by default.
    """
    level = np.zeros(P) if level is None else level
    slope = np.broadcast_to(slope, P).copy()
    matrix, slopes = np.eye(P) / np.square(sd), []
    for operation in range(1, n + 1):
        state = level.copy()
        for first, last, size in jumps:
            state += size * (first <= operation <= last)
        state += scatter / tracker.log_sds * rng.standard_normal(P)
        slopes.append(matrix @ (state + sd * rng.standard_normal(P)))
        for after, name, more in changes:
            slope[NAMES.index(name)] += more * (after == operation)
        level = level + slope / 1000.0
    return list(range(1, n + 1)), [matrix] * n, slopes


def test_settings_are_in_percent(tracker, prior, defaults):
    settings = defaults["wear_model"]
    np.testing.assert_array_equal(tracker.log_sds, prior.log_sds)
    assert tracker.hazard * settings["operations_between_changes"] == pytest.approx(1.0)
    assert tracker.step_sd * 100 == pytest.approx(settings["step_sd"])
    np.testing.assert_allclose(tracker.scatters * 100, settings["scatters"])


# ---- all configurations ------------------------------------------------------------------------


def short_series(tracker, operations, purpose, *, rows=4):
    """Factors ``(n, rows, p)``, scaled measurements ``(n, rows)`` and places ``(n, p)``.

    A drive whose everything changes after the fourth operation. No operation sees all of it.
    """
    rng = generator(1, "test", "change points", purpose)
    n = len(operations)
    factors, places = rng.standard_normal((n, rows, P)), 0.3 * rng.standard_normal((n, P))
    level, slope = rng.standard_normal(P), tracker.slope_sd * rng.standard_normal(P)
    measured = np.empty((n, rows))
    for i, operation in enumerate(operations):
        if i:
            level = level + (operation - operations[i - 1]) * slope / 1000.0
        if i == 4:
            level = level + tracker.step_sd / tracker.log_sds * rng.standard_normal(P)
            slope = slope + tracker.slope_sd * rng.standard_normal(P)
        state = level + tracker.scatters[1] / tracker.log_sds * rng.standard_normal(P)
        measured[i] = factors[i] @ (state - places[i]) + rng.standard_normal(rows)
    return factors, measured, places


def configurations(tracker, operations):
    """Yield start, kind and prior probability of at most one change, the first segment included."""
    gaps = np.diff(operations)
    one = (1.0 - tracker.several - tracker.whole) / P
    odds = [*[one] * P, tracker.several, tracker.whole]
    stay = (1.0 - tracker.hazard) ** gaps
    yield operations[0], FIRST, stay.prod()
    for i, start in enumerate(operations[:-1]):
        for kind, odd in enumerate(odds):
            others = np.delete(stay, i).prod()
            yield start, kind, (1.0 - stay[i]) * odd * others


def regression(tracker, operations, series, start, kind, scatter):
    """One joint Gaussian regression: log evidence, and mean and covariance of the last state.

    The unknowns are level and slope of the first segment, and what a change adds to either.
    """
    factors, measured, places = series
    added = np.zeros((2, P))  # variances
    if kind == ALL:
        added[0] = np.square(tracker.step_sd / tracker.log_sds)
    if kind >= 0:
        added[1, range(P) if kind in (SEVERAL, ALL) else kind] = np.square(tracker.slope_sd)
    variance = np.concatenate([np.ones(P), np.full(P, np.square(tracker.slope_sd)), *added])

    def level_at(operation):
        since = max(operation - start, 0) / 1000.0
        parts = 1.0, (operation - operations[0]) / 1000.0, float(operation > start), since
        return np.hstack([part * np.eye(P) for part in parts])

    design = np.vstack([f @ level_at(o) for f, o in zip(factors, operations, strict=True)])
    noise = np.square(scatter / tracker.log_sds)
    r = len(factors[0])
    cov = design * variance @ design.T + np.eye(len(design))
    for i, factor in enumerate(factors):
        rows = slice(i * r, (i + 1) * r)
        cov[rows, rows] += factor * noise @ factor.T
    seen = np.concatenate([m + f @ z for m, f, z in zip(measured, factors, places, strict=True)])
    # Information is a density up to that of the measurement at its own value.
    constant = 0.5 * np.square(measured).sum() + 0.5 * seen.size * np.log(2 * np.pi)
    last = level_at(operations[-1])
    slope = np.hstack([np.zeros((P, P)), np.eye(P), np.zeros((P, P)), np.eye(P)])
    state = np.vstack([last, slope])
    cross = state * variance @ design.T
    gain = np.linalg.solve(cov, cross.T).T
    return (
        constant + multivariate_normal.logpdf(seen, cov=cov),
        gain @ seen,
        state * variance @ state.T - gain @ cross.T,
    )


@pytest.mark.parametrize(
    "operations", [[1, 2, 3, 4, 5, 6, 7], [1, 4, 6, 8, 9, 12, 13, 14]], ids=["even", "uneven"]
)
def test_short_series_are_exact(prior, operations):
    """Every hypothesis against its own regression: weight, mean, covariance; and the evidence.

    Starts are kept where neighbours are a fifth of their age apart, as all of these are. The hazard
    is so small that a second change would add less than 1e-5 to anything.
    """
    tracker = Tracker(
        log_sds=prior.log_sds,
        hazard=1e-11,
        slope_sd=100.0,
        step_sd=0.1,
        scatters=np.array([0.02, 0.04, 0.06]),
        outliers=0.0,
        whole=0.3,
        several=0.2,
    )
    series = short_series(tracker, operations, "short")
    hypotheses, total = tracker.begin(operations[0]), 0.0
    for operation, factor, seen, place in zip(operations, *series, strict=True):
        hypotheses = tracker.predict(hypotheses, operation)
        hypotheses, log_evidence, outlier = tracker.learn(
            hypotheses, factor.T @ factor, factor.T @ seen, place
        )
        total += log_evidence
        assert outlier == 0.0
    found = {
        key: i
        for i, key in enumerate(
            zip(hypotheses.start, hypotheses.kind, hypotheses.scatter, strict=True)
        )
    }
    k = len(tracker.scatters)
    assert len(found) == len(hypotheses.start) == k * (1 + len(KINDS) * (len(operations) - 1))
    exact, log_weights = {}, {}
    for start, kind, probability in configurations(tracker, operations):
        for q, scatter in enumerate(tracker.scatters):
            exact[start, kind, q] = regression(tracker, operations, series, start, kind, scatter)
            log_weights[start, kind, q] = np.log(probability / k) + exact[start, kind, q][0]
    assert exact.keys() == found.keys()
    evidence = logsumexp(list(log_weights.values()))
    assert total == pytest.approx(evidence, abs=1e-5)
    # The data tell the hypotheses apart, and no scatter is so unlikely that it would be held up.
    assert np.ptp([each[0] for each in exact.values()]) > 5.0
    for q in range(k):
        assert hypotheses.weight[hypotheses.scatter == q].sum() > 1e-5
    for key, (_, mean, cov) in exact.items():
        i = found[key]
        assert hypotheses.log_weight[i] == pytest.approx(log_weights[key] - evidence, abs=1e-5)
        np.testing.assert_allclose(hypotheses.mean[i, :P], mean[:P], atol=1e-5)
        np.testing.assert_allclose(hypotheses.mean[i, P:], mean[P:], atol=1e-5 * tracker.slope_sd)
        np.testing.assert_allclose(hypotheses.cov[i, :P, :P], cov[:P, :P], atol=1e-5)
        np.testing.assert_allclose(hypotheses.cov[i, P:], cov[P:], atol=1e-5 * tracker.slope_sd**2)
    weights = np.exp(np.array([log_weights[key] for key in exact]) - evidence)
    means = np.array([each[1] for each in exact.values()])
    level, spread = hypotheses.level()
    np.testing.assert_allclose(level, weights @ means, atol=1e-5 * tracker.slope_sd)
    apart = means - weights @ means
    wanted = np.einsum("k,kij->ij", weights, [each[2] for each in exact.values()])
    wanted = wanted + (weights[:, None] * apart).T @ apart
    np.testing.assert_allclose(spread, wanted, atol=1e-5 * tracker.slope_sd**2)


def test_any_number_of_parameters_is_followed(tracker):
    """Two quantities instead of seven parameters: the same arithmetic, and the change named.

    The slope changes by some fifty standard errors.
    """
    two = replace(tracker, log_sds=tracker.log_sds[:2])
    n, rng = 200, generator(1, "test", "change points", "two")
    hypotheses = two.begin(1)
    for operation in range(1, n + 1):
        level = np.array([0.0, 6.0 * max(operation - 100, 0) / 1000.0])
        seen = level + 0.02 * rng.standard_normal(2)
        hypotheses = two.predict(hypotheses, operation)
        matrix = np.eye(2) / 0.02**2
        hypotheses, *_ = two.learn(hypotheses, matrix, matrix @ seen, np.zeros(2))
    kinds = np.bincount(hypotheses.kind + 1, hypotheses.weight, 5)
    assert np.argmax(kinds) == 2  # the second quantity alone; the last is everything
    assert hypotheses.level()[0][3] == pytest.approx(6.0, rel=0.2)


# ---- memory, and going on ----------------------------------------------------------------------


def test_memory_is_bounded(tracker):
    """Of each kind 2 + log(N) / log(1 / 0.8) starts, as neighbours thin out with their age.

    Over 1,000 operations that is 300 hypotheses for a scatter, and without thinning it would be
    9,000. What an operation costs is in proportion: it does not grow in the second half.
    """
    n = 1000
    one = replace(tracker, scatters=tracker.scatters[[2]])
    bound = 1 + len(KINDS) * (2 + math.log(n) / math.log(1.25))
    series = worn(one, n, generator(1, "test", "change points", "memory"))
    counts = np.array([hypotheses.start.size for _, hypotheses, *_ in follow(one, *series)])
    assert counts.max() < bound < 300
    assert counts[n // 2 :].max() < 1.1 * counts[n // 4 : n // 2].max()


def learnt(tracker):
    """The first segment, for each scatter, after forty operations."""
    still = replace(tracker, hazard=0.0)
    series = worn(still, 40, generator(1, "test", "change points", "learnt"), slope=1.0)
    *_, (_, hypotheses, *_) = follow(still, *series)
    assert set(hypotheses.kind) == {FIRST}
    return hypotheses


@pytest.mark.filterwarnings("error")
def test_a_gap_of_many_changes_leaves_every_weight_finite(tracker):
    tracker = replace(tracker, hazard=0.0005)
    found = tracker.predict(tracker.begin(1), 1_000_000)
    assert np.isfinite(found.log_weight).all()


def test_a_gap_is_as_long_as_its_operations(tracker):
    """Without changes, five operations of which nothing is seen are one step of five.

    With changes, what is equal is the mean, the lines that go on, and their probability. When in a
    gap a change was is not asked: it counts from the last operation seen, and there is one at most,
    so that covariance and number of hypotheses are others.
    """
    hypotheses = learnt(tracker)
    for each in (replace(tracker, hazard=0.0), tracker):
        one, five = each.predict(hypotheses, 45), hypotheses
        for operation in range(41, 46):
            five = each.predict(five, operation)
        assert one.operation == five.operation == 45
        first, its = one.kind == FIRST, five.kind == FIRST
        for name in ("mean", "cov", "log_weight", "scatter"):
            wanted = getattr(one, name)[first]
            np.testing.assert_allclose(getattr(five, name)[its], wanted, atol=1e-12)
        np.testing.assert_allclose(five.level()[0], one.level()[0], atol=1e-12)
        gone = (1.0 - each.hazard) ** 5
        for grown in (one, five):
            assert grown.weight.sum() == pytest.approx(1.0, rel=1e-12)
            assert grown.weight[grown.kind == FIRST].sum() == pytest.approx(gone, rel=1e-12)
            assert grown.began_after(39) == pytest.approx(1.0 - gone, abs=1e-12)
        if not each.hazard:
            assert first.all()
            assert its.all()
            continue
        assert set(one.start[~first]) == {40}
        assert set(five.start[~its]) == {40, 41, 42, 43, 44}
        assert not np.allclose(five.level()[1], one.level()[1], rtol=1e-6)


# ---- known truths --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["f", "gamma_a"])
def test_a_change_of_one_slope_is_found_and_named(tracker, name):
    """A change of some twenty standard errors, by the end.

    The truth lies within the 90 % interval and its width on either side, five sds of a normal.
    """
    n, after = 240, 120
    rng = generator(1, "test", "change points", "slope", name)
    series = worn(tracker, n, rng, changes=[(after, name, 6.0)])
    before, noticed = None, None
    for operation, hypotheses, *_ in follow(tracker, *series):
        changed = hypotheses.began_after(1)
        if operation == after:
            before = changed
        if noticed is None and changed > 0.95:
            noticed = operation
    assert before < 0.5
    assert after < noticed < after + 60
    kinds = np.bincount(hypotheses.kind + 1, hypotheses.weight, 1 + len(KINDS))[1:]
    assert NAMES[np.argmax(kinds)] == name
    assert kinds.max() > 0.9
    # The beginning as of the alarm: later there may be others.
    began = hypotheses.weight * (hypotheses.start <= noticed) * (hypotheses.kind != FIRST)
    low, _, high = start_quantiles(hypotheses, began, 1, n)
    assert low - (high - low) <= after <= high + (high - low)
    assert high - low < 60
    assert hypotheses.level()[0][P + NAMES.index(name)] == pytest.approx(6.0, rel=0.2)


def test_what_is_known_of_a_change_is_calibrated(tracker):
    """Slopes after twelve changes, and when they were.

    Of the slopes a chi-square of 12, two-sided, and of the central 90 % of the starts those that
    hold the truth: 7 of 12 at least, a binomial. Together a false-alarm probability of 1e-3.
    """
    known = replace(tracker, scatters=np.array([0.002]))
    n, after, slope, times = 200, 100, P + NAMES.index("f"), 12
    square, held = 0.0, 0
    for i in range(times):
        rng = generator(1, "test", "change points", "calibrated", i)
        size = 4.0 * rng.choice([-1.0, 1.0])
        *_, (_, hypotheses, *_) = follow(known, *worn(known, n, rng, changes=[(after, "f", size)]))
        mean, cov = hypotheses.level()
        square += (mean[slope] - size) ** 2 / cov[slope, slope]
        changed = hypotheses.weight * (hypotheses.kind != FIRST)
        ends = start_quantiles(hypotheses, changed, 1, n)[[0, 2]]
        held += ends[0] <= after <= ends[1]
    low, high = chi2.ppf([3e-4, 1 - 3e-4], df=times)
    assert low < square < high
    assert held >= 7  # of a binomial with 0.9, fewer have a probability of 5.4e-4


def test_no_change_is_found_where_none_is(tracker):
    """As long as there is no change, the odds of one are a submartingale.

    Of each start they are a likelihood ratio, which keeps its expectation, and each operation adds
    the hazard. So they reach 1 among n operations with a probability of n times the hazard at most
    (Doob), whatever is merged on the way: here 2e-4, of lines and scatters drawn from the model.
    The planted fault is a change.
    """
    n = 200
    rare = replace(tracker, hazard=1e-6, outliers=0.0)
    rng = generator(1, "test", "change points", "none")
    known = {
        "level": rng.standard_normal(P),
        "slope": rare.slope_sd * rng.standard_normal(P),
        "scatter": rng.choice(rare.scatters),
    }
    steady = worn(rare, n, rng, **known)
    odds = [hypotheses.began_after(1) for _, hypotheses, *_ in follow(rare, *steady)]
    assert max(odds) < 0.5
    assert min(odds[2:]) > 0.0
    changing = worn(rare, n, rng, **known, changes=[(100, "f", 6.0)])
    *_, (_, hypotheses, *_) = follow(rare, *changing)
    assert hypotheses.began_after(1) > 0.5


def test_one_outlier_is_no_change_and_several_are(tracker):
    """Twenty errors off, once; and from then on."""
    n, at = 100, 60
    for last in (at, n):
        rng = generator(1, "test", "change points", "outlier")
        series = worn(tracker, n, rng, jumps=[(at, last, 0.5 * np.ones(P))])
        states = {o: (s, outlier) for o, s, _, outlier in follow(tracker, *series)}
        hypotheses, outlier = states[at]
        assert outlier > 0.9
        assert states[at - 1][1] < 0.01
        if last == at:
            assert hypotheses.began_after(at - 2) < 0.1
            assert states[at + 1][1] < 0.01
            assert max(s.began_after(1) for s, _ in states.values()) < 0.5
            # Nothing was learnt of it.
            ahead = np.abs(
                hypotheses.level()[0] - tracker.predict(states[at - 1][0], at).level()[0]
            )
            assert ahead[:P].max() < 0.05
        else:
            found = states[at + 5][0]
            assert found.began_after(at - 2) > 0.99
            kinds = np.bincount(found.kind + 1, found.weight, 1 + len(KINDS))
            assert np.argmax(kinds) == 1 + ALL
            assert found.start[np.argmax(found.weight)] == at - 1
            np.testing.assert_allclose(states[n][0].level()[0][:P], 0.5, atol=0.15)


@pytest.mark.parametrize("truth", [0.001, 0.004, 0.016])
def test_scatter_is_found(tracker, truth):
    """Candidates are a factor of two apart.

    Errors are 0.05 to 0.4 % of a parameter. Of 700 values, a scatter of 0.1 % is then known to
    better than 10 %, and the next candidates are out by more than five sds.
    """
    rng = generator(1, "test", "change points", "scatter", str(truth))
    series = worn(tracker, 100, rng, sd=0.01, scatter=truth)
    *_, (_, hypotheses, *_) = follow(tracker, *series)
    weights = np.bincount(hypotheses.scatter, hypotheses.weight, len(tracker.scatters))
    assert weights[np.isclose(tracker.scatters, truth)] > 0.99
    assert weights.min() >= 0.9e-6  # none is given up, for it may change
