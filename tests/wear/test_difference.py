"""True parameters from apparent ones, against the dense posterior of one linear model."""

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.stats import chi2

from breaker.mechanism.parameters import NAMES
from breaker.model.randomness import generator
from breaker.wear.changepoint import PER
from breaker.wear.difference import Difference, split_off
from breaker.wear.learned import Learned, by_phase

P, N, T = len(NAMES), 4, 60
SLOPE_SD = 2.0
OPERATIONS = np.arange(0, 1000, 10)


@pytest.fixture(scope="module")
def linear():
    """Derivatives ``(p, t)``, basis ``(n, t)`` and what was learned, in units of the noise."""
    rng = generator(1, "test difference")
    slopes, basis = 3.0 * rng.standard_normal((P, T)), rng.standard_normal((N, T))
    root = rng.standard_normal((P + N, P + N)) / np.sqrt(P + N)
    wear = root @ root.T + 0.1 * np.eye(P + N)
    new = 4.0 * np.diag([1.0, 0.5, 0.3, 0.2])
    return slopes, basis, Learned({"closing": basis}, {}, new, wear, 0.0)


def truth(learned, rng):
    """Level and slope of parameters, ``(p,)``, and of the difference, ``(n,)``."""
    level, new = rng.standard_normal(P), np.linalg.cholesky(learned.new) @ rng.standard_normal(N)
    worn = np.linalg.cholesky(learned.wear) @ rng.standard_normal(P + N)
    return level, worn[:P], new, worn[P:]


def said(linear, true, rng):
    """Information of each operation about parameters and difference, matrix and slopes."""
    slopes, basis, _ = linear
    level, drift, new, change = true
    way = OPERATIONS[:, None] / PER
    records = (level + way * drift) @ slopes + (new + way * change) @ basis
    design = np.vstack([slopes, basis])
    records = records + rng.standard_normal(records.shape)
    return design @ design.T, records @ design.T


def apparent(matrix, slopes, gain, learned):
    """Exact posterior of the apparent line: mean ``(2 p,)`` and covariance, at the last operation.

    With the prior that a trend begins with.
    """
    prior = block_diag(np.eye(P) + gain @ learned.new @ gain.T, SLOPE_SD**2 * np.eye(P))
    information, total = np.linalg.inv(prior), np.zeros(2 * P)
    for operation, slope in zip(OPERATIONS, slopes, strict=True):
        design, found = np.array([1.0, operation / PER]), split_off(matrix, slope)
        information = information + np.kron(np.outer(design, design), found.held)
        total = total + np.kron(design, found.held @ found.mean)
    cov = np.linalg.inv(information)
    move = np.kron([[1.0, OPERATIONS[-1] / PER], [0.0, 1.0]], np.eye(P))
    return move @ cov @ total, move @ cov @ move.T


def read_off(linear, true, rng):
    """Mean and covariance of the true line, the apparent one, and the data."""
    learned = linear[2]
    matrix, slopes = said(linear, true, rng)
    difference = Difference.begin(learned, np.zeros(N), matrix, 0)
    for operation, slope in zip(OPERATIONS.tolist(), slopes, strict=True):
        difference = difference.learn(operation, matrix, slope)
    line = apparent(matrix, slopes, difference.gain, learned)
    readout = difference.readout(learned, int(OPERATIONS[-1]), line[0][P:], SLOPE_SD)
    mean, cov = readout.apply(line[0][None], line[1][None])
    return mean[0], cov[0], line, (matrix, slopes, difference)


def test_split_information_is_that_of_both(linear):
    """Apparent parameters and the rest: as probable, whatever the difference."""
    rng = generator(2, "test difference")
    matrix, slopes = said(linear, truth(linear[2], rng), rng)
    found = split_off(matrix, slopes[0])
    for _ in range(5):
        z, d = rng.standard_normal(P), rng.standard_normal(N)
        state = np.append(z, d)
        whole = slopes[0] @ state - 0.5 * state @ matrix @ state
        off = z + found.gain @ d - found.mean
        parts = -0.5 * off @ found.held @ off + found.left @ d - 0.5 * d @ found.rest @ d
        constant = 0.5 * found.mean @ found.held @ found.mean
        assert whole == pytest.approx(parts + constant, rel=1e-4)


def test_true_parameters_are_those_of_the_dense_posterior(linear):
    """All records stacked: parameters, slopes, difference and its change as one Gaussian."""
    learned, rng = linear[2], generator(3, "test difference")
    mean, cov, line, (matrix, slopes, difference) = read_off(linear, truth(learned, rng), rng)
    size = difference.wear(learned, line[0][P:])
    response = np.linalg.solve(learned.wear[:P, :P], learned.wear[:P, P:]).T
    rest = size * (learned.wear[P:, P:] - response @ learned.wear[:P, P:])
    expected = response @ np.linalg.solve(np.eye(P) + difference.gain @ response, line[0][P:])
    prior = block_diag(np.eye(P), learned.new, SLOPE_SD**2 * np.eye(P), rest)
    information = np.linalg.inv(prior)
    total = information @ np.concatenate([np.zeros(P + N + P), expected])
    for operation, slope in zip(OPERATIONS, slopes, strict=True):
        design = np.array([1.0, operation / PER])
        information = information + np.kron(np.outer(design, design), matrix)
        total = total + np.kron(design, slope)
    dense = np.linalg.inv(information)
    move = np.kron([[1.0, OPERATIONS[-1] / PER], [0.0, 1.0]], np.eye(P + N))
    dense, centre = move @ dense @ move.T, move @ dense @ total
    place = np.concatenate([np.arange(P), P + N + np.arange(P)])
    sd = np.sqrt(np.diag(dense)[place])
    np.testing.assert_allclose(np.sqrt(np.diag(cov)), sd, rtol=0.02)
    assert np.abs((mean - centre[place]) / sd).max() < 0.05


def test_true_levels_are_calibrated_and_apparent_ones_are_not(linear):
    """Squared errors of 40 drives over their covariance: chi-square, false alarm 1e-3.

    Planted: apparent parameters taken for true ones.
    """
    squares, planted = 0.0, 0.0
    for i in range(40):
        rng = generator(4, "test difference", i)
        true = truth(linear[2], rng)
        mean, cov, line, _ = read_off(linear, true, rng)
        level = true[0] + OPERATIONS[-1] / PER * true[1]
        for (centre, spread), sums in (((mean, cov), "right"), (line, "planted")):
            off = centre[:P] - level
            square = off @ np.linalg.solve(spread[:P, :P], off)
            squares, planted = (
                (squares + square, planted) if sums == "right" else (squares, planted + square)
            )
    law = chi2(40 * P)
    assert law.ppf(5e-4) < squares < law.ppf(1 - 5e-4)
    assert planted > 2 * law.ppf(1 - 5e-4)


def test_more_records_do_not_undo_what_components_leave_out(linear):
    """With a rough error as large as the noise a line knows no more than one record does."""
    slopes, basis, learned = linear
    rough = Learned(learned.basis, {}, learned.new, learned.wear, 1.0)
    rng = generator(5, "test difference")
    _, cov, _, (matrix, _, _) = read_off((slopes, basis, rough), truth(learned, rng), rng)
    single = np.linalg.inv(matrix + block_diag(np.eye(P), np.linalg.inv(learned.new)))[:P, :P]
    assert np.all(np.diag(cov)[:P] > 0.9 * np.diag(single))


def test_a_step_leaves_the_difference_as_unknown_as_that_of_a_new_drive(linear):
    rng = generator(6, "test difference")
    _, _, line, (_, _, difference) = read_off(linear, truth(linear[2], rng), rng)
    last, drift = int(OPERATIONS[-1]), line[0][P:]
    same, other = (
        difference.renewed(linear[2], last, drift, stepped=stepped) for stepped in (False, True)
    )
    before = difference.now(linear[2], last, drift)[1][:N, :N]
    np.testing.assert_allclose(np.linalg.inv(same.prior), before, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(np.linalg.inv(other.prior), before + linear[2].new, rtol=1e-6)


def test_phases_of_a_curve():
    times = np.linspace(-2.0, 10.0, 121)
    curve = np.clip(times, 0.0, 8.0)
    sizes = by_phase(np.where(times > 6.5, 2.0, 0.0), curve, times, "closing")
    assert sizes[0] == 0.0
    assert sizes[1] < 0.1
    assert sizes[2] > 1.5
