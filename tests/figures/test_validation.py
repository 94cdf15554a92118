"""Figures of calibration, contraction, recovery and pairs: each quantity on its own axis."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures import pairs, style, validation
from breaker.mechanism.parameters import outputs
from breaker.model.randomness import generator
from breaker.validation import correlation, judge_draws, recovery, scores
from tests.figures.drawn import assert_nothing_overlaps, bands, line_of, segments, words
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


@pytest.mark.parametrize(("motion", "names"), [("closing", NAMES), ("opening", THREE)])
def test_sbc_draws_ranks_in_their_band(motion, names):
    judged = judge_draws(*inferred(names))
    figure = validation.sbc(judged, names, motion=motion)
    outcome = judged.words(style.symbols(names))
    title = f"{motion.capitalize()}, two-spring model: simulation-based calibration {outcome}"
    assert " ".join(figure.get_suptitle().split()) == title
    assert outcome.startswith("calibrated: all")
    assert len(figure.axes) == len(names)
    for i, (axis, name) in enumerate(zip(figure.axes, names, strict=True)):
        line = line_of(axis, style.COLOURS[name])
        np.testing.assert_array_equal(line.get_xdata(), judged.band.grid)
        np.testing.assert_array_equal(line.get_ydata(), judged.difference[:, i])
        assert line.get_drawstyle() == "steps-post"
        ends = judged.band.lower.min(), judged.band.upper.max()
        np.testing.assert_allclose(bands(axis)[0], ends)
        title = f"{style.OUTPUTS[name].symbol}   inside, p = {judged.p_values[i]:.2g}"
        assert axis.get_title() == title
    assert_nothing_overlaps(figure)


def test_failed_calibration_is_seen():
    """In the title and its colour, and in the panel that failed."""
    judged = judge_draws(*inferred(THREE, narrow=["f"]))
    figure = validation.sbc(
        judged, THREE, motion="closing", subject="calibration of files", of="family"
    )
    title = "Closing, family: calibration of files\nNOT calibrated: $f$ outside the band"
    assert title in figure.get_suptitle()
    assert figure._suptitle.get_color() == style.WARNING
    colours = [axis.title.get_color() for axis in figure.axes]
    assert colours == ["black", style.WARNING, "black"]
    assert f"outside by {judged.excess[1]:.3f}" in figure.axes[1].get_title()


def test_contraction_is_across_and_z_score_up():
    draws, truth = inferred(NAMES)
    found = scores(draws, truth, prior_sd=np.full(8, 0.2), log=np.full(8, True))
    figure = validation.contraction(found, NAMES, motion="closing", limit=np.linspace(0.3, 1, 8))
    for i, (axis, name) in enumerate(zip(figure.axes, NAMES, strict=True)):
        dots = line_of(axis, style.COLOURS[name])
        np.testing.assert_array_equal(dots.get_xdata(), found.contraction[:, i])
        np.testing.assert_array_equal(dots.get_ydata(), found.z[:, i])
        limit = np.linspace(0.3, 1, 8)[i]
        assert line_of(axis, style.MEASURED).get_xdata()[0] == limit
        text = f"mean {found.mean_contraction[i]:.2f}, limit {limit:.2f}"
        assert text in axis.get_title()
        assert f"z-score sd {found.z_sd[i]:.2f}" in axis.get_title()
    assert "best known: " in figure.get_suptitle()
    assert figure.axes[0].get_ylabel() == "z-score"
    assert figure.axes[4].get_xlabel() == "contraction"
    assert_nothing_overlaps(figure)
    few = scores(draws[..., :2], truth[..., :2], prior_sd=[0.2, 0.2], log=[True, True])
    small = validation.contraction(few, NAMES[:2], motion="opening")
    assert "limit" not in words(small)
    assert_nothing_overlaps(small)


def test_recovery_has_the_truth_across():
    found = recovery(*inferred(NAMES))
    figure = validation.recovery(found, NAMES, motion="closing")
    for i, (axis, name) in enumerate(zip(figure.axes, NAMES, strict=True)):
        dots, (bars,) = line_of(axis, style.COLOURS[name]), segments(axis, style.COLOURS[name])
        np.testing.assert_array_equal(dots.get_xdata(), found.truth[:, i])
        np.testing.assert_array_equal(dots.get_ydata(), found.median[:, i])
        np.testing.assert_array_equal(bars[..., 0], found.truth[:, i, None] + [0, 0])
        np.testing.assert_array_equal(bars[..., 1], found.interval_95[:, i])
        assert axis.get_xlabel() == f"true {style.OUTPUTS[name].label}"
        assert axis.get_ylabel() == f"inferred {style.OUTPUTS[name].label}"
        shares = f"{100 * found.covered_95[i]:.0f} %, in 50 %: {100 * found.covered_50[i]:.0f} %"
        stated = f"correlation {found.correlation[i]:.2f}\ntruth in 95 %: {shares}"
        assert axis.get_title().endswith(stated)
    assert "95 % intervals contain" in figure.get_suptitle()
    assert_nothing_overlaps(figure)


def test_pairs_have_column_across_and_row_up():
    draws, truth = inferred(FOUR)
    strength = correlation(draws[0], log=np.full(4, True))
    case = xr.Dataset(
        {"draws": (("draw", "output"), draws[0]), "truth": ("output", truth[0])},
        {"output": list(FOUR)},
    )
    figure = pairs.pairs(case, truth, motion="closing", correlation=strength)
    grid = np.reshape(figure.axes, (4, 4))
    for (row, column), axis in np.ndenumerate(grid):
        if row < column:
            text = f"{strength[row, column]:+.2f}".replace("-", "−")
            assert axis.texts[0].get_text() == text
        elif row > column:
            for colour, values in ((style.PRIOR, truth), (style.MODEL, draws[0])):
                cloud = line_of(axis, colour)
                np.testing.assert_array_equal(cloud.get_xdata(), values[:, column])
                np.testing.assert_array_equal(cloud.get_ydata(), values[:, row])
            at = [line.get_xydata()[0] for line in axis.lines if line.get_ls() == "--"]
            assert (at[0][0], at[1][1]) == (truth[0, column], truth[0, row])
        else:
            assert axis.lines[0].get_xdata()[0] == truth[0, row]
            assert axis.get_title() == style.OUTPUTS[FOUR[row]].symbol
    labels = [style.OUTPUTS[name].label for name in FOUR]
    assert [axis.get_xlabel() for axis in grid[3]] == labels
    assert [axis.get_ylabel() for axis in grid[1:, 0]] == labels[1:]
    assert_nothing_overlaps(figure)
