"""Figures of calibration, contraction, recovery and pairs."""

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.figures import calibration, pairs, style
from breaker.model.parameters import outputs
from breaker.paper.calibration import judge_draws
from breaker.paper.validation import REGIONS, correlation, recovery, regions, scores
from tests.figures.drawn import assert_drawn
from tests.validation.made import exact_posteriors

NAMES = [output.name for output in outputs(onset=True)]
THREE = ["mu", "f", "onset"]
FOUR = ["mu", "k_a", "f", "onset"]


def inferred(names, curves=200, draws=40, *, narrow=()):
    """Draws and truth from exact normal posteriors in logarithms; some outputs too narrow."""
    rng = generator(4, "test", "figures")
    ones, half = np.ones(len(names)), np.full(len(names), 0.5)
    width = np.array([0.5 if name in narrow else 1.0 for name in names])
    known = {"prior_sd": ones, "contraction": half, "width": width}
    values, truth = exact_posteriors(rng, curves, draws, **known)
    return np.exp(0.2 * values), np.exp(0.2 * truth)


@pytest.mark.parametrize("names", [NAMES, THREE], ids=len)
def test_sbc_draws_ranks_in_their_band(names):
    judged = judge_draws(*inferred(names))
    figure = calibration.sbc(judged, names, about="Closing")
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        np.testing.assert_array_equal(axis.lines[1].get_ydata(), judged.difference[:, k])


def test_failed_calibration_is_seen():
    """In the title and its colour, and in the panel that failed."""
    judged = judge_draws(*inferred(THREE, narrow=["f"]))
    figure = calibration.sbc(judged, THREE, about="Closing")
    assert_drawn(figure)
    assert [axis.title.get_color() == style.WARNING for axis in figure.axes] == [False, True, False]


def test_contraction_is_across_and_z_score_up():
    draws, truth = inferred(NAMES)
    found = scores(draws, truth, prior_sd=np.full(8, 0.2), log=np.full(8, True))
    figure = calibration.contraction(found, NAMES, about="Closing", limit=np.linspace(0.3, 1, 8))
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        shown = [found.contraction[:, k], found.z[:, k]]
        np.testing.assert_array_equal(axis.lines[0].get_data(), shown)
    few = scores(draws[..., :2], truth[..., :2], prior_sd=[0.2, 0.2], log=[True, True])
    assert_drawn(calibration.contraction(few, NAMES[:2], about="Opening"))


def test_recovery_has_the_truth_across():
    found = recovery(*inferred(NAMES))
    figure = calibration.recovery(found, NAMES, about="Closing")
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        np.testing.assert_array_equal(
            axis.lines[0].get_data(), [found.truth[:, k], found.median[:, k]]
        )


def test_regions_hold_their_share_of_the_draws():
    draws = generator(5, "test", "regions").standard_normal((2000, 3)) * [1.0, 5.0, 0.0]
    found = regions(draws)
    assert set(found) == {(0, 1)}  # the third does not vary
    x, y, density, levels = found[0, 1]
    area = (x[1] - x[0]) * (y[1] - y[0])
    shares = [density[density >= level].sum() * area for level in levels]
    assert shares == pytest.approx(REGIONS, abs=0.05)
    wide, high = (each[density.max(axis=k) >= levels[0]].max() for k, each in enumerate((x, y)))
    assert high > 3.0 * wide  # the second output is up


def test_pairs_have_column_across_and_row_up():
    draws, truth = inferred(FOUR)
    strength = correlation(draws[0], log=np.full(4, True))
    case = xr.Dataset(
        {"draws": (("draw", "output"), draws[0]), "truth": ("output", truth[0])},
        {"output": list(FOUR)},
    )
    about = {"about": "Closing", "correlation": strength, "regions": regions(draws[0])}
    figure = pairs.pairs(case, truth, **about)
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        row, column = divmod(k, len(FOUR))
        if row > column:
            across, up = [line for line in axis.lines if len(line.get_xdata()) == 2][:2]
            assert set(across.get_xdata()) == {truth[0, column]}
            assert set(up.get_ydata()) == {truth[0, row]}
