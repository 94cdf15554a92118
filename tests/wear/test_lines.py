"""Gaussian lines that learn, against closed forms in covariances; and how hypotheses thin out."""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from breaker.model.randomness import generator
from breaker.wear.lines import evidence, thin, update

LEARN = -np.inf  # log evidence of an outlier: never one


def covariance(rng, n, rank=None):
    factor = rng.standard_normal((n, n if rank is None else rank))
    return factor @ factor.T


def closed_form(mean, cov, weight, slope):
    """Log of the mean of ``exp(s . x - x' W x / 2)`` over a Gaussian, of an invertible W.

    That is a measurement ``W^-1 s`` with the covariance ``W^-1``, up to its constant.
    """
    noise = np.linalg.inv(weight)
    seen = noise @ slope
    constant = 0.5 * slope @ seen + 0.5 * np.linalg.slogdet(2 * np.pi * noise)[1]
    return constant + multivariate_normal.logpdf(seen, mean, cov + noise)


def conditioned(mean, cov, weight, slope):
    """Mean and covariance of a state whose first half is measured so, by Kalman's formulas."""
    p = slope.size
    noise = np.linalg.inv(weight)
    gain = cov[:, :p] @ np.linalg.inv(cov[:p, :p] + noise)
    return mean + gain @ (noise @ slope - mean[:p]), cov - gain @ cov[:p]


# ---- evidence --------------------------------------------------------------------------------


@pytest.mark.parametrize("p", [1, 2, 7])
def test_evidence_of_invertible_information(p):
    rng = generator(1, "test", "lines", "evidence", p)
    for _ in range(20):
        mean, slope = rng.standard_normal(p), 3 * rng.standard_normal(p)
        weight = covariance(rng, p) + 0.1 * np.eye(p)
        for cov in (covariance(rng, p), covariance(rng, p, 1), np.zeros((p, p))):
            found = evidence(mean, cov, weight, slope)
            assert found == pytest.approx(closed_form(mean, cov, weight, slope), abs=1e-8)


def test_evidence_of_singular_information_is_a_limit():
    """A direction of which nothing is said: as if it were measured ever less well."""
    rng = generator(1, "test", "lines", "singular")
    p = 7
    mean, cov = rng.standard_normal(p), covariance(rng, p)
    factor = rng.standard_normal((3, p))
    weight, slope = factor.T @ factor, factor.T @ rng.standard_normal(3)
    found = evidence(mean, cov, weight, slope)
    off = []
    for least in (1e-2, 1e-3, 1e-4):
        off.append(closed_form(mean, cov, weight + least * np.eye(p), slope) - found)
    assert np.abs(off[2]) < 1e-2
    np.testing.assert_allclose(np.array(off[:2]) / off[1:], 10.0, rtol=0.2)  # in proportion
    # Three measurements with unit noise are the same, seen in their own space.
    y = np.linalg.solve(factor @ factor.T, factor @ slope)
    log_density = multivariate_normal.logpdf(y, factor @ mean, factor @ cov @ factor.T + np.eye(3))
    constant = 0.5 * y @ y + 1.5 * np.log(2 * np.pi)
    assert found == pytest.approx(constant + log_density, abs=1e-9)


def test_evidence_of_nothing_and_of_a_slope_alone():
    rng = generator(1, "test", "lines", "nothing")
    mean, cov, slope = rng.standard_normal(3), covariance(rng, 3), rng.standard_normal(3)
    none = np.zeros((3, 3))
    assert evidence(mean, cov, none, np.zeros(3)) == 0.0
    # Then it is the Gaussian's cumulant function.
    wanted = slope @ mean + 0.5 * slope @ cov @ slope
    assert evidence(mean, cov, none, slope) == pytest.approx(wanted, abs=1e-12)


def test_evidence_needs_pivots():
    """Where the first pivot of ``I + W P`` is zero, though W and P are covariances."""
    weight = np.array([[1.0, 2.0], [2.0, 4.0]])
    cov = np.array([[1.0, -1.0], [-1.0, 1.0]])
    assert (np.eye(2) + weight @ cov)[0, 0] == 0.0
    found = evidence(np.zeros(2), cov, weight, np.array([1.0, 2.0]))
    # One measurement 1 of (1, 2) . x, whose variance is 1.
    assert found == pytest.approx(0.5 - 0.5 * np.log(2.0) - 0.25, abs=1e-12)


# ---- learning --------------------------------------------------------------------------------


def lines_that_learn(p, purpose, h=5, k=3):
    """Lines, what they learn from, and constants, all at random."""
    rng = generator(1, "test", "lines", purpose, p)
    mean, cov = rng.standard_normal((h, 2 * p)), np.array([covariance(rng, 2 * p)] * h)
    cov *= 1.0 + np.arange(h)[:, None, None]
    weights = np.array([covariance(rng, p) + 0.1 * np.eye(p) for _ in range(k)])
    slopes, base = rng.standard_normal((k, p)), rng.standard_normal(k)
    return mean, cov, rng.integers(k, size=h), weights, slopes, base


@pytest.mark.parametrize("p", [1, 2, 7])
def test_learning_is_conditioning(p):
    """Level and slope, each from the information of its own group."""
    mean, cov, group, weights, slopes, base = lines_that_learn(p, "learning")
    new_mean, new_cov = mean.copy(), cov.copy()
    found = update(new_mean, new_cov, group, weights, slopes, base, np.full(3, LEARN))
    assert len(set(group)) > 1
    for i, g in enumerate(group):
        wanted = closed_form(mean[i, :p], cov[i, :p, :p], weights[g], slopes[g])
        assert found[i] == pytest.approx(base[g] + wanted, abs=1e-8)
        learnt = conditioned(mean[i], cov[i], weights[g], slopes[g])
        np.testing.assert_allclose(new_mean[i], learnt[0], atol=1e-8)
        np.testing.assert_allclose(new_cov[i], learnt[1], atol=1e-7)
        np.testing.assert_array_equal(new_cov[i], new_cov[i].T)


def test_of_an_outlier_nothing_is_learnt():
    """A line learns where it explains the operation no worse than an outlier does."""
    mean, cov, group, weights, slopes, base = lines_that_learn(2, "outlier", h=6)
    group = np.array([0, 0, 1, 1, 2, 2])
    learning = mean.copy(), cov.copy()
    log_in = update(*learning, group, weights, slopes, base, np.full(3, LEARN))
    # Between the two lines of a group, above both, and exactly at one of them.
    log_out = np.array([log_in[:2].mean(), log_in[2:4].max() + 1.0, log_in[4]])
    new_mean, new_cov = mean.copy(), cov.copy()
    found = update(new_mean, new_cov, group, weights, slopes, base, log_out)
    np.testing.assert_array_equal(found, log_in)
    learns = log_in >= log_out[group]
    assert learns[:4].tolist().count(True) == 1
    assert learns[4]
    for i in range(6):
        np.testing.assert_array_equal(new_mean[i], (learning[0] if learns[i] else mean)[i])
        np.testing.assert_array_equal(new_cov[i], (learning[1] if learns[i] else cov)[i])


# ---- thinning --------------------------------------------------------------------------------


UNLIKELY = -60.0


def grown(steps, *, hopeless, young, rng, kinds=(0, 1), scatters=(0, 1)):
    """Yield hypotheses before and after each thinning: a new one of each kind at each step."""
    first = [(-np.log(2.0), 0, -1, q) for q in scatters]
    for now in range(1, steps + 1):
        if now > 1:
            first += [(UNLIKELY, now - 1, kind, q) for kind in kinds for q in scatters]
        log_weight, start, kind, scatter = (np.array(c) for c in zip(*first, strict=True))
        log_weight = log_weight + 0.3 * rng.standard_normal(log_weight.size)
        log_weight -= logsumexp(log_weight)
        order = np.lexsort((start, kind, scatter))
        before = log_weight[order], start[order], kind[order], scatter[order]
        weight = log_weight[order].copy()
        lines = np.zeros((weight.size, 2)), np.zeros((weight.size, 2, 2))
        begun, variance = start[order].astype(float), np.zeros(weight.size)
        line = weight, *lines, begun, *before[2:], variance
        kept = thin(*line, float(now - 1), hopeless, young)
        yield now - 1, (before[0], begun, *before[2:]), kept, weight
        after = weight[kept], begun[kept], *(each[kept] for each in before[2:])
        first = [tuple(row) for row in zip(*(each.tolist() for each in after), strict=True)]


def test_thinning_is_bounded_and_keeps_the_weight():
    """Unlikely starts of a kind and scatter are a fifth of their age apart: ages fall by 0.8.

    Over N operations that leaves no more than 2 + log(N) / log(1 / 0.8) clusters of each. Where no
    hypothesis is hopeless, nothing of the weight is lost.
    """
    steps, most = 1000, 0
    rng = generator(1, "test", "lines", "thin")
    for now, (log_weight, start, kind, scatter), kept, weight in grown(
        steps, hopeless=np.inf, young=50.0, rng=rng
    ):
        most = max(most, kept.sum())
        if now % 100 and now > 20:
            continue
        assert logsumexp(weight[kept]) == pytest.approx(logsumexp(log_weight), abs=1e-10)
        for group in {(k, q) for k, q in zip(kind, scatter, strict=True)}:
            mine = (kind == group[0]) & (scatter == group[1])
            # Of each kind and scatter by itself, too: none takes another's.
            assert logsumexp(weight[mine & kept]) == pytest.approx(
                logsumexp(log_weight[mine]), abs=1e-10
            )
            left = start[mine & kept]
            # One of a cluster stays, anywhere in it: the next but one is of the next but one.
            assert np.all(left[2:] - left[:-2] >= 0.2 * (now - left[2:]) - 1e-9)
        if now <= 5:
            assert kept.all()
    bound = 2 * (1 + 2 * (2 + np.log(steps) / np.log(1.25)))
    assert 0.5 * bound < most < bound


def test_neighbours_become_one_of_their_mean_and_covariance():
    """The line and its start, in one dimension, by the formula of a mixture."""
    begun, same = np.array([0.0, 4.0, 10.0]), np.zeros(3, dtype=np.int64)
    centres, variances = np.array([1.0, 3.0, 8.0]), np.array([0.5, 2.0, 1.0])
    for weights, stays in (
        ([0.2, 0.5, 0.3], [False, True, True]),
        ([0.5, 0.2, 0.3], [True, False, True]),
    ):
        weight, mean, cov = (
            np.log(weights),
            centres[:, None].copy(),
            variances[:, None, None].copy(),
        )
        start, variance = begun.copy(), np.array([1.0, 2.0, 0.0])
        kept = thin(weight, mean, cov, start, same, same, variance, 100.0, 25.0, 50.0)
        assert kept.tolist() == stays
        np.testing.assert_allclose(np.exp(weight[kept]), [0.7, 0.3])
        share = np.array(weights[:2]) / 0.7
        middle = share @ centres[:2]
        spread = share @ (variances[:2] + (centres[:2] - middle) ** 2)
        np.testing.assert_allclose(mean[kept][:, 0], [middle, 8.0])
        np.testing.assert_allclose(cov[kept][:, 0, 0], [spread, 1.0])
        early = share @ begun[:2]
        wide = share @ ([1.0, 2.0] + (begun[:2] - early) ** 2)
        np.testing.assert_allclose(start[kept], [early, 10.0])
        np.testing.assert_allclose(variance[kept], [wide, 0.0])
    # Unless they are not of the same kind, or scatter; likely ones are told apart from 5 on.
    other = np.array([0, 1, 1])
    for kind, scatter in ((other, same), (same, other)):
        lines = np.zeros((3, 1)), np.zeros((3, 1, 1))
        none = np.zeros(3)
        assert thin(np.log(weights), *lines, begun, kind, scatter, none, 100.0, 25.0, 50.0).all()


def test_the_unlikely_become_one_sooner_than_the_likely():
    start, same = np.array([0.0, 10.0]), np.zeros(2, dtype=np.int64)
    for log_weight, kept in ((-8.5, [True, True]), (-9.5, [True, False])):
        line = np.array([0.0, log_weight]), np.zeros((2, 1)), np.zeros((2, 1, 1)), start.copy()
        found = thin(*line, same, same, np.zeros(2), 100.0, 25.0, 50.0)
        assert found.tolist() == kept


def test_the_hopeless_are_dropped_but_not_the_young_nor_the_first():
    """What is dropped is exp(-25) of the best each, at most."""
    start, kind = np.array([0.0, 0, 20, 49, 50, 90]), np.array([-1, 0, 0, 1, 2, 3])
    scatter, log_weight = np.zeros(6, dtype=np.int64), np.array([-60.0, -60, 0, -60, -60, -60])
    weight, lines = log_weight.copy(), (np.zeros((6, 1)), np.zeros((6, 1, 1)))
    kept = thin(weight, *lines, start, kind, scatter, np.zeros(6), 100.0, 25.0, 50.0)
    assert kept.tolist() == [True, False, True, False, True, True]
    np.testing.assert_array_equal(weight[kept], log_weight[kept])
    lines, same = (np.zeros((2, 1)), np.zeros((2, 1, 1))), np.zeros(2, dtype=np.int64)
    just = np.array([0.0, -24.9]), *lines, np.array([0.0, 30.0]), same, same, np.zeros(2)
    assert thin(*just, 100.0, 25.0, 50.0).all()
