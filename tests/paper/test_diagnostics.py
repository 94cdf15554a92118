"""z-score, contraction and recovery on posteriors that are known in closed form."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.paper.validation import (
    REGIONS,
    prior_check,
    recovery,
    regions,
    scores,
    share_inside,
)
from tests.paper.made import exact_posteriors

PRIOR_SD = np.array([0.2, 0.4, 0.3])
CONTRACTION = np.array([0.9, 0.3, 0.6])
LOG = np.array([True, True, False])
CENTRE = np.array([0.05, 10.0, 1.0])


def posteriors(n=1000, draws=200, **fault):
    """Draws (n, d, 3) and truth (n, 3): normal in log for two outputs, in plain units for one."""
    rng = generator(3, "test", "posteriors")
    known = {"prior_sd": PRIOR_SD, "contraction": CONTRACTION}
    both = exact_posteriors(rng, n, draws, **known, **fault)
    return [to_units(each) for each in both]


def to_units(values):
    return np.where(LOG, CENTRE * np.exp(values), values)


def to_normal(values):
    return np.stack([np.log(values[:, 0]), np.log(values[:, 1]), values[:, 2]], axis=1)


@pytest.mark.parametrize(
    ("fault", "z_mean", "z_sd"),
    [
        ({}, 0.0, 1.0),
        ({"width": 0.7}, 0.0, 1 / 0.7),
        ({"width": 1.4}, 0.0, 1 / 1.4),
        ({"bias": 0.3}, 0.3, 1.0),
    ],
)
def test_scores_show_what_is_wrong(fault, z_mean, z_sd):
    """Bounds of 4.5 standard errors: 9 normal numbers, false alarm below 1e-4. The faults are 9 of
    them (bias) and 12 (width) or more away from exact, so the power is above 0.999."""
    n, d = 1000, 200
    draws, truth = posteriors(n, d, **fault)
    judged = scores(draws, truth, prior_sd=PRIOR_SD, log=LOG)
    assert judged.z.shape == judged.contraction.shape == (n, 3)
    # The posterior's mean and variance are estimated from d draws: 1/d more variance.
    np.testing.assert_allclose(judged.z_mean, z_mean, atol=4.5 * z_sd / np.sqrt(n) + 0.01)
    np.testing.assert_allclose(judged.z_sd, z_sd, atol=z_sd * (4.5 / np.sqrt(2 * n) + 2 / d))
    expected = 1 - fault.get("width", 1.0) ** 2 * (1 - CONTRACTION)
    np.testing.assert_allclose(judged.mean_contraction, expected, atol=0.02)


def test_recovery():
    n = 1000
    draws, truth = posteriors(n, 200)
    summary = recovery(draws, truth)
    np.testing.assert_array_equal(summary.median, np.median(draws, axis=1))
    # Correlation of the posterior mean with the truth is the root of the contraction; in log
    # parameters here, where the outputs are normal. 4.5 sd of its Fisher transform.
    pairs = zip(to_normal(summary.median).T, to_normal(truth).T, strict=True)
    in_logs = np.array([np.corrcoef(*pair)[0, 1] for pair in pairs])
    error = np.arctanh(in_logs) - np.arctanh(np.sqrt(CONTRACTION))
    assert np.abs(error).max() < 4.5 / np.sqrt(n) + 0.02
    assert summary.correlation[2] == pytest.approx(in_logs[2])
    low, high = np.moveaxis(summary.interval_95, -1, 0)
    inside = np.mean((low <= truth) & (truth <= high), axis=0)
    for share, level in ((summary.covered_50, 0.5), (summary.covered_95, 0.95), (inside, 0.95)):
        allowed = 4.5 * np.sqrt(level * (1 - level) / n) + 1 / 200  # 200 draws: within 1/(d+1)
        np.testing.assert_allclose(share, level, atol=allowed)


def test_the_band_of_the_prior_holds_95_percent_at_each_time():
    curves = np.arange(201.0)[:, None] * [1.0, 2.0]
    check = prior_check(curves, [[100.0, 400.0], [np.nan, 100.0]])
    for band, at in ((check.median, 100), (check.lower, 5), (check.upper, 195)):
        np.testing.assert_allclose(band, [at, 2 * at])
    assert check.inside.tolist() == [0.5, 1.0]


def test_share_inside():
    values = np.array([[0.0, 1.0, 2.0, np.nan], [5.0, 1.0, 1.0, 1.0]])
    lower, upper = np.full(4, 0.5), np.full(4, 2.0)
    assert share_inside(values, lower, upper).tolist() == [2 / 3, 0.75]  # NaN does not count
    where = [False, True, True, False]
    assert share_inside(values, lower, upper, where=where).tolist() == [1.0, 1.0]


def test_regions_contain_their_share_of_the_draws():
    draws = generator(5, "test", "regions").standard_normal((2000, 3)) * [1.0, 5.0, 0.0]
    pairs = regions(draws)
    assert set(pairs) == {(0, 1)}  # the third does not vary
    x, y, density, levels = pairs[0, 1]
    area = (x[1] - x[0]) * (y[1] - y[0])
    shares = [density[density >= level].sum() * area for level in levels]
    assert shares == pytest.approx(REGIONS, abs=0.05)
    wide, high = (each[density.max(axis=k) >= levels[0]].max() for k, each in enumerate((x, y)))
    assert high > 3.0 * wide  # the second output is up


def test_unusable_input_is_refused():
    draws, truth = posteriors(5, 20)
    for faulty, words in ((-draws, "must be positive"), (draws * 0 + truth[:, None], "no width")):
        with pytest.raises(ValueError, match=words):
            scores(faulty, truth, prior_sd=PRIOR_SD, log=LOG)
    with pytest.raises(ValueError, match="1 of 15 values of truth"):
        recovery(draws, np.where(truth == truth[0, 0], np.nan, truth))
