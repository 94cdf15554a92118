"""Figures show the numbers that they were given; the workflow's own run draws every one."""

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults
from breaker.figures import calibration, pairs, style
from breaker.figures.exactness import exactness
from breaker.figures.life import changes, coverage, health, remaining_life
from breaker.figures.verdict import verdict
from breaker.paper import validation
from breaker.paper.calibration import judge_draws
from breaker.prognosis.limit_states import states_of
from tests.figures.drawn import assert_drawn, line_of
from tests.lives import LIMITS, a_life
from tests.paper.made import NAMES, corrected_curves, exact_posteriors, judgement

# ---- posteriors of simulated records -------------------------------------------------------------


def inferred(names, *, narrow=()):
    """Draws and truth from exact normal posteriors in logarithms; some outputs too narrow."""
    width = np.array([0.5 if name in narrow else 1.0 for name in names])
    known = {"prior_sd": np.ones(len(names)), "contraction": np.full(len(names), 0.5)}
    both = exact_posteriors(generator(4, "test", "figures"), 200, 40, **known, width=width)
    return [np.exp(0.2 * item) for item in both]


def test_ranks_and_a_failed_calibration_are_seen():
    judged = judge_draws(*inferred(NAMES, narrow=["f"]))
    figure = calibration.sbc(judged, NAMES, about="Closing")
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        np.testing.assert_array_equal(axis.lines[1].get_ydata(), judged.difference[:, k])
    red = [axis.title.get_color() == style.WARNING for axis in figure.axes[: len(NAMES)]]
    assert red == [name == "f" for name in NAMES]


def test_contraction_and_recovery_have_their_axes():
    """Contraction is across and the z-score up; the truth is across and the median up."""
    draws, truth = inferred(NAMES)
    q = len(NAMES)
    z, known = validation.scores(draws, truth, prior_sd=np.full(q, 0.2), log=[True] * q)
    limit, summary = np.linspace(0.3, 1, q), validation.recovery(draws, truth)
    scatter = calibration.contraction(z, known, NAMES, about="Closing", limit=limit)
    recovery = calibration.recovery(summary, truth, NAMES, about="Closing")
    for figure, across, up in ((scatter, known, z), (recovery, truth, summary.median)):
        assert_drawn(figure)
        for k, axis in enumerate(figure.axes[:q]):
            np.testing.assert_array_equal(axis.lines[0].get_data(), [across[:, k], up[:, k]])


def test_pairs_have_column_across_and_row_up():
    names = ["mu", "k_a", "f", "onset"]
    draws, truth = (item[0] for item in inferred(names))
    both = {"draws": (("draw", "output"), draws), "truth": ("output", truth)}
    figure = pairs.pairs(
        xr.Dataset(both, {"output": names}),
        truth[None],
        about="Closing",
        correlation=validation.correlation(draws, log=[True] * 4),
        regions=validation.regions(draws),
    )
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        row, column = divmod(k, len(names))
        if row > column:
            across, up = [line for line in axis.lines if len(line.get_xdata()) == 2][:2]
            assert set(across.get_xdata()) == {truth[column]}
            assert set(up.get_ydata()) == {truth[row]}


@pytest.mark.parametrize("case", ["none resolved", "faulty"])
def test_exactness_is_drawn_of_curves_that_fail(case):
    corrected = corrected_curves(10)
    judged = judgement(corrected, 10)
    if case == "none resolved":
        corrected["resolved"] = corrected.resolved & False
    else:
        for name in ("efficiency", "pareto_k"):
            corrected[name][1] = judged[name][4] = np.nan
        judged.divergence[4], judged.pareto_k[5], judged.divergence[6] = np.nan, np.inf, np.inf
    row = validation.summary(judged, corrected).iloc[0]
    assert_drawn(exactness(judged, corrected, row, motion="opening"))


# ---- a life --------------------------------------------------------------------------------------


def short_life():
    """A life that reaches the first of two limits at operation 180, and its states."""
    life = a_life((180.0, np.inf), operations=np.arange(1, 201))
    return life, states_of(life, defaults()["planning"])


def test_a_life_is_drawn_with_and_without_truth():
    life, standing = short_life()
    figure = health(life, standing)
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        shown = line_of(axis, style.MODEL).get_ydata()
        assert np.isin(shown[np.isfinite(shown)], standing.p_exceeded.isel(limit=k)).all()
    true = {"failure": ("limit", [180.0, 300]), "held": ("limit", [0.9, 0.72])}
    with_truth = remaining_life(life, standing, xr.Dataset(true, {"limit": list(LIMITS)}))
    values = life.changed.sel(quantile=0.5).rename(asked="operation") * 1.5
    without = remaining_life(life, standing), changes(life)
    for figure in (with_truth, changes(life, values), *without):
        assert_drawn(figure)
        labels = {line.get_label() for axis in figure.axes for line in axis.lines}
        assert ("truth" in labels) == (figure not in without)
    standing["state"][:], standing["p_exceeded"][:] = 1, np.nan
    standing["certain"][:], standing["crossed"][:] = np.nan, np.nan
    assert_drawn(health(life, standing))


def test_coverage_counts_reports_before_the_failure():
    """The first limit's band is 0.5 to 1.5 times what is left to 180; the other goes on."""
    life, _ = short_life()
    for failure, share in ((180.0, 1.0), (900.0, 0.0), (np.nan, np.nan), (5.0, np.nan)):
        assert coverage(life, [failure] * 2)[0] == pytest.approx(share, nan_ok=True)
    asked = life.asked.values
    asked = asked[(asked >= life.attrs["reported_from"]) & (asked < 150)]
    inside = (0.5 * (180 - asked) <= 150 - asked) & (150 - asked <= 1.5 * (180 - asked))
    assert 0.0 < inside.mean() < 1.0
    assert coverage(life, [150.0] * 2)[0] == pytest.approx(inside.mean())


@pytest.mark.parametrize(
    ("value", "new", "drawn"),
    [
        ([0.2, 0.4, 1.3], 0.0, False),  # wider than the way to the limit
        ([1.2, 2.0, 3.5], 0.0, True),  # so is this, and past the limit
        ([np.nan] * 3, 0.0, False),
        ([2.0, 2.1, 2.2], 1.5, False),  # beyond the limit when new
    ],
)
def test_a_verdict_has_a_bar_where_the_state_is_known(value, new, drawn):
    life, standing = short_life()
    life.value[:, 0], life.new[0] = value, new
    figure = verdict(life, standing, ("One.", "Two.", "Three."))
    assert_drawn(figure)
    rows = [part.get_segments()[0][0, 1] for part in figure.axes[0].collections]
    assert (0 in rows) == drawn
