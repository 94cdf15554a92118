"""Two posteriors on one scale, examples, and contraction relative to its limit."""

import numpy as np
import pytest
import xarray as xr

from breaker.paper import validation as comparison
from tests.paper.made import NAMES, contractions, judgement, posteriors


def test_posteriors_are_compared_in_units_of_the_corrected_one():
    """By hand: an odd number of evenly spaced draws, whose median and quantiles are known."""
    line = np.linspace(-1.0, 1.0, 201)
    sd = line.std(ddof=1)
    corrected = np.stack([np.exp(3.0 + line), 0.3 + line], axis=1)
    amortised = np.stack([np.exp(3.5 + 2 * line), line], axis=1)
    result = comparison.compare(amortised, corrected, np.array([np.exp(2.0), 0.3]), ["mu", "onset"])
    expected = {
        "amortised": ([0.5, -0.3], [[-0.5, 1.5], [-0.8, 0.2]], [[-1.4, 2.4], [-1.25, 0.65]]),
        "corrected": ([0.0, 0.0], [[-0.5, 0.5]] * 2, [[-0.95, 0.95]] * 2),
    }
    for posterior, values in expected.items():
        one = result.sel(posterior=posterior)
        for name, value in zip(("median", "interval_50", "interval_95"), values, strict=True):
            np.testing.assert_allclose(one[name], np.array(value) / sd, atol=1e-12)
    np.testing.assert_allclose(result.truth, [-1.0 / sd, 0.0], atol=1e-12)


def test_examples_are_the_lowest_median_and_highest():
    amortised, corrected = posteriors()
    judged = judgement(corrected, 9)
    judged["efficiency"] = ("curve", [0.5, 0.9, np.nan, 0.1, 0.7, 0.95, 0.6, 0.05, 0.99])
    corrected.draws[8] = np.nan
    corrected.draws[7] = corrected.draws[7, :1]  # one draw again and again
    corrected.resolved[3] = False
    judged["resolved"] = corrected.resolved[:9]
    result = comparison.examples(judged, amortised, corrected)
    assert result.place.values.tolist() == ["lowest", "median", "highest"]
    assert result.curve.values.tolist() == [3, 6, 5]  # of 3 0 6 4 1 5, the lower of the middle two
    assert result.efficiency.values.tolist() == [0.1, 0.6, 0.95]
    assert result.resolved.values.tolist() == [False, True, True]
    draws = [item.draws.values[6] for item in (amortised, corrected)]
    alone = comparison.compare(*draws, amortised.truth.values[6], NAMES)
    xr.testing.assert_allclose(result.isel(example=1)[list(alone)], alone)
    judged["efficiency"] = np.nan * judged.efficiency
    assert comparison.examples(judged, amortised, corrected).sizes["example"] == 0


def test_reached_is_sorted_by_the_limit():
    values = contractions()
    result = comparison.reached(values, NAMES)
    order = ["gamma_a", "onset", "f", "k_a", "gamma_b", "k_b", "mu", "L"]
    assert result.output.values.tolist() == order
    known = ["known from this motion"] * 5 + ["partly known"] + ["the prior decides"] * 2
    assert result.known.values.tolist() == known
    assert result.curves.values.tolist() == [200, 50, 48]
    for source, value in values.items():
        for name in NAMES:
            one, column = result.sel(source=source, output=name), value[:, NAMES.index(name)]
            expected = [column.mean(), *np.quantile(column, [0.05, 0.95])]
            computed = [one[key].item() for key in ("mean", "lower", "upper")]
            assert computed == pytest.approx(expected)
