"""The figure of what the model leaves out: bands, examples, components and costs where they are."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures import style
from breaker.figures.discrepancy import discrepancy
from breaker.mechanism.parameters import NAMES
from tests.figures.drawn import assert_nothing_overlaps, bands, line_of, words

TIME = np.linspace(-2.0, 58.0, 31)
ERRORS = ["noise", "zero", "onset", "left out"]


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(1)
    ramp = np.linspace(0.0, 1.0, 31)
    new = -ramp + 0.2 * rng.standard_normal((5, 1)) * ramp
    learned = xr.Dataset(
        {
            "mean": ("time", -ramp),
            "factor": (("component", "time"), np.outer([-0.3, 0.2, 0.1, 0.05, 0.01], ramp)),
            "spread": (("condition", "time"), np.outer([0.4, 0.1], ramp)),
            "examples": (("condition", "drive", "time"), np.stack([new, new + 0.05 * ramp])),
        },
        {"time": TIME, "condition": ["new", "worn"]},
    )
    values = np.linspace(0.9, 0.1, 28).reshape(4, 7)
    cost = xr.Dataset(
        {"contraction": (("error", "parameter"), values)},
        {"error": ERRORS, "parameter": list(NAMES)},
    )
    return learned, cost, discrepancy(learned, cost, motion="opening", noise_sd=0.1)


def test_bands_and_examples_are_where_they_are(drawn):
    learned, _, figure = drawn
    new, change, components, _ = figure.axes
    np.testing.assert_allclose(bands(new)[0], (-1.8, 0.0))
    np.testing.assert_allclose(bands(change)[0], (-0.2, 0.2))
    np.testing.assert_array_equal(line_of(new, style.MODEL).get_ydata(), learned["mean"])
    examples = [line for line in new.lines if line.get_color() == style.REFERENCE]
    assert len(examples) == 5
    changes = [line for line in change.lines if line.get_color() == style.REFERENCE]
    for line in changes:
        np.testing.assert_allclose(line.get_ydata(), 0.05 * np.linspace(0.0, 1.0, 31), atol=1e-12)
    largest = [line.get_ydata().max() for line in components.lines]
    np.testing.assert_allclose(largest, [0.3, 0.2, 0.1, 0.05])  # turned upwards


def test_costs_are_marked_for_every_parameter(drawn):
    _, cost, figure = drawn
    axis = figure.axes[3]
    assert len(axis.lines) == 4
    for line, error in zip(axis.lines, ERRORS, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), cost.contraction.sel(error=error))
        assert np.all(np.abs(np.asarray(line.get_ydata()) - np.arange(7)) < 0.3)


def test_the_figure_says_how_large_it_is(drawn):
    figure = drawn[2]
    text = words(figure)
    assert text.startswith("Opening: what the model leaves out")
    assert f"up to {np.hypot(1.0, 0.4):.2f} mm" in text
    assert "noise of 0.1 mm" in text
    assert_nothing_overlaps(figure)
