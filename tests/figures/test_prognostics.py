"""The figure of simulated lives: delays, shares, coverage and accuracy."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures.prognostics import prognostics
from breaker.model.randomness import generator
from tests.figures.drawn import assert_nothing_overlaps, words
from tests.figures.test_operations import BOUNDS

IDEAL = np.array([[0.88, 0.9, 0.91, 0.9, 0.92], [0.9] * 5, [0.65] * 5, [0.4] * 5])


def scores_data(lives=200, methods=("model", "closing time", "CUSUM", "EWMA")):
    rng = generator(33, "test", "scores")
    ratio = rng.lognormal(1.5, 0.7, lives)
    slower = np.array([0.12, 0.3, 0.24, 0.28, 0.3])[: len(methods)]
    delay = slower / ratio[:, None] * rng.lognormal(0, 0.5, (lives, len(methods)))
    delay[rng.random(delay.shape) < np.exp(-0.4 * ratio)[:, None]] = np.nan
    lower = np.array([0.0, 2.0, 3.0, 5.0, 8.0])
    coverage = np.array([0.84, 0.87, 0.905, 0.895, 0.925])
    return xr.Dataset(
        {
            "ratio": ("life", ratio),
            "delay": (("life", "method"), delay),
            "found": (("bin", "method"), rng.random((5, len(methods)))),
            "bin_lower": ("bin", lower),
            "bin_upper": ("bin", np.array([*lower[1:], np.inf])),
            "coverage": ("fraction", coverage),
            "coverage_interval": (("fraction", "bound"), coverage[:, None] + [-0.05, 0.03]),
            "alpha_lambda": ("fraction", [0.41, 0.58, 0.74, 0.83, 0.9]),
            "width": ("fraction", [1.1, 0.31, 0.23, 0.28, 0.52]),
            "ideal_coverage": (("observer", "fraction"), IDEAL[:2]),
            "ideal_width": (("observer", "fraction"), IDEAL[2:]),
        },
        {"method": list(methods), "fraction": [0.1, 0.25, 0.5, 0.75, 0.9], "bound": BOUNDS}
        | {"observer": ["an ideal observer", "one that is told"]},
    )


@pytest.mark.parametrize(
    ("lives", "methods"),
    [(200, ("model", "closing time", "CUSUM", "EWMA")), (20, ("model", "closing time"))],
)
def test_prognostics_shows_the_scores(lives, methods):
    data = scores_data(lives, methods)
    figure = prognostics(data)
    assert_nothing_overlaps(figure)
    assert figure.get_suptitle().endswith(f"{lives} simulated lives")
    assert [name for name in methods if name not in words(figure)] == []
    delays, found, coverage, accuracy, width = figure.axes
    for i in range(len(methods)):
        delay = 100 * data.delay.values[:, i]
        points, medians = delays.lines[2 * i : 2 * i + 2]
        np.testing.assert_array_equal(points.get_xdata(), data.ratio)
        shown, missed = points.get_ydata(), np.isnan(delay)
        np.testing.assert_array_equal(shown[~missed], delay[~missed])
        assert np.all((shown[missed] > 100) & (shown[missed] < delays.get_ylim()[1]))
        expected = []
        for lower, upper in zip(data.bin_lower.values, data.bin_upper.values, strict=True):
            each = np.sort(delay[(data.ratio >= lower) & (data.ratio < upper)])  # nan at the end
            expected += [each[len(each) // 2]] if each.size else []
        drawn = np.where(np.array(medians.get_ydata()) > 100, np.nan, medians.get_ydata())
        np.testing.assert_allclose(drawn, expected)
        np.testing.assert_array_equal(found.lines[i].get_ydata(), 100 * data.found[:, i])
    labels = [label.get_text() for label in found.get_xticklabels()]
    assert labels == ["below 2", "2 to 3", "3 to 5", "5 to 8", "from 8"]
    targets = [(box.x0, box.x1, box.y0) for box in (each.get_bbox() for each in found.patches)]
    assert np.allclose(targets, [(0.6, 0.8, 90), (0.8, 1.0, 90)])  # from a ratio of 5 on
    np.testing.assert_allclose(coverage.lines[1].get_ydata(), 100 * data.coverage)
    bars = np.array(coverage.collections[-1].get_segments())
    np.testing.assert_allclose(bars[..., 1], 100 * data.coverage_interval)
    band = coverage.patches[0].get_bbox()
    assert (band.y0, band.y1) == (85, 95)
    np.testing.assert_allclose(accuracy.lines[0].get_ydata(), 100 * data.alpha_lambda)
    np.testing.assert_allclose(width.lines[0].get_ydata(), data.width)
    for axis, values in ((coverage, 100 * data.ideal_coverage), (width, data.ideal_width)):
        beside = [line.get_ydata() for line in axis.lines[-2:]]
        np.testing.assert_allclose(beside, values)
    assert "of an ideal observer" in words(figure)


def test_poor_coverage_stays_in_sight_and_methods_have_markers():
    data = scores_data(20, ("model",))
    data.coverage_interval[0] = [0.02, 0.1]
    assert prognostics(data).axes[2].get_ylim()[0] < 2
    with pytest.raises(ValueError, match="markers for 7 methods, not 8"):
        prognostics(scores_data(20, ("a", "b")).isel(method=[0, 1] * 4))
