"""Figures show the numbers that they were given; the workflow's own run draws every one."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import defaults
from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.explanations import Explanation
from breaker.diagnosis.inspection_change import InspectionChange
from breaker.family.curve_file import write_curve
from breaker.family.endurance import EnduranceTest
from breaker.figures import calibration, pairs, style
from breaker.figures.endurance import evolution
from breaker.figures.exactness import exactness, identifiability
from breaker.figures.life import (
    changes,
    coverage,
    health,
    remaining_life,
)
from breaker.figures.records import record
from breaker.figures.reports import comparison
from breaker.figures.verdict import verdict
from breaker.model.parameters import NAMES as PARAMETERS
from breaker.paper import validation
from breaker.paper.calibration import judge_draws
from breaker.paper.run_numbers import blocks_of, held
from breaker.prognosis.states import states_of
from breaker.records.proposal import inspect_file
from tests.figures.drawn import assert_drawn, line_of, words
from tests.lives import LIMITS, a_life
from tests.paper.made import NAMES, contractions, exact_posteriors, judgement, posteriors

MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])

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


@pytest.mark.parametrize("count", [8, 2])
def test_contraction_and_recovery_have_their_axes(count):
    """Contraction is across and the z-score up; the truth is across and the median up."""
    draws, truth = (item[..., :count] for item in inferred(NAMES))
    z, known = validation.scores(draws, truth, prior_sd=np.full(count, 0.2), log=[True] * count)
    limit = np.linspace(0.3, 1, 8) if count == 8 else None
    scatter = calibration.contraction(z, known, NAMES[:count], about="Closing", limit=limit)
    summary = validation.recovery(draws, truth)
    recovery = calibration.recovery(summary, truth, NAMES[:count], about="Closing")
    for figure, (across, up) in (
        (scatter, (known, z)),
        (recovery, (truth, summary.median)),
    ):
        assert_drawn(figure)
        for k, axis in enumerate(figure.axes[:count]):
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


def exactness_case(case):
    """What is judged, amortised and corrected: as usual, or few curves of which some fail."""
    amortised, corrected = posteriors(NAMES if case == "usual" else NAMES[:7], 10)
    if case == "none resolved":
        corrected["resolved"] = corrected.resolved & False
    judged = judgement(corrected, 10)
    if case == "faulty":
        corrected.draws[1], corrected.resolved[1] = np.nan, False
        for name in ("efficiency", "pareto_k"):
            corrected[name][1] = judged[name][4] = np.nan
        judged.divergence[4], judged.pareto_k[5], judged.divergence[6] = np.nan, np.inf, np.inf
    elif case == "no example":
        corrected.draws[:] = np.nan
    return judged, amortised, corrected


@pytest.mark.parametrize("case", ["usual", "none resolved", "faulty", "no example"])
def test_exactness_is_drawn(case):
    judged, amortised, corrected = exactness_case(case)
    chosen = validation.examples(judged, amortised, corrected)
    row = validation.summary(judged, corrected).iloc[0]
    assert_drawn(exactness(judged, corrected, chosen, row, motion="opening"))


def test_a_posterior_wider_than_its_prior_is_in_sight():
    values = contractions(NAMES[:7], shift=0.5)
    result = validation.reached(values, NAMES[:7])
    figure = identifiability(result, motion="closing")
    assert_drawn(figure)
    assert figure.axes[0].get_xlim()[0] <= result.lower.values.min() < 0.0


# ---- a life --------------------------------------------------------------------------------------


def short_life(operations=200, changes=("rate",)):
    """A life that reaches the first of two limits at operation 180, and its states."""
    life = a_life((180.0, np.inf), operations=np.arange(1, operations + 1), changes=changes)
    return life, states_of(life, defaults()["planning"])


def test_a_life_is_drawn_with_and_without_truth():
    life, standing = short_life()
    figure = health(life, standing)
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        shown = line_of(axis, style.MODEL).get_ydata()
        assert np.isin(shown[np.isfinite(shown)], standing.p_exceeded.isel(limit=k)).all()
    true = {"failure": ("limit", [180.0, 300])}
    true |= {"held": ("limit", [0.9, 0.72])}
    truth = xr.Dataset(true, {"limit": list(LIMITS)})
    assert_drawn(remaining_life(life, standing, truth))
    assert "72 % to 90 %" in words(remaining_life(life, standing, truth))
    assert "truth" not in words(remaining_life(life, standing))
    values = life.changed.sel(quantile=0.5).rename(asked="operation") * 1.5
    assert_drawn(changes(life, values))
    assert "truth" not in words(changes(life))
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


def test_evolution_shows_all_values():
    number = np.arange(1, 201)
    theta = xr.DataArray(
        MEDIANS * np.ones((200, 1)),
        {"operation": number, "parameter": list(PARAMETERS)},
        ("operation", "parameter"),
    )
    blocks = {}
    for by, (shift, width) in {"paper": (0.3, 0.05), "family": (0.0, 0.1)}.items():
        logs = width * generator(1, "evolution", by).standard_normal((200, 50, 7))
        logs += shift + width * np.linspace(0.0, 1.0, 200)[:, None, None]
        logs[10:15] = np.nan  # the third block has no posterior
        draws = xr.DataArray(MEDIANS * np.exp(logs), dims=("operation", "draw", "output"))
        draws = draws.assign_coords(operation=number, output=list(PARAMETERS))
        blocks[by] = blocks_of(draws.to_dataset(name="draws"))
    shares = {by: held(one, theta) for by, one in blocks.items()}
    figure = evolution(blocks, theta, shares, motion="closing")
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        drawn = [one["value"].values[:, k].ravel() for one in blocks.values()]
        drawn = np.concatenate([*drawn, theta[:, k]])
        low, high = axis.get_ylim()
        assert low < np.nanmin(drawn) < np.nanmax(drawn) < high
    assert "truth" not in words(evolution(blocks, motion="opening"))


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


# ---- one drive -----------------------------------------------------------------------------------


def row(name, change, changed, motion="", **more):
    about = {"name": name, "unit": "mm", "meaning": "a quantity", "motion": motion}
    about |= {"p_unchanged": 0.4, "p_worse": None, "changed": changed}
    return QuantityChange(**about | {"change": change, "if_changed": change} | more)


@pytest.mark.parametrize("estimated", [True, False])
def test_two_inspections_are_drawn(estimated):
    """A row for each quantity; names are not mathematics. The change of a value that was less than
    its error is stated in mm, as tables state it.
    """
    small = {"before": 0.02, "today": 0.01, "difference": -0.01, "sd": 0.02}
    estimates = [
        row("f", [-12.0, -10.0, -8.0], True, p_worse=0.9),
        row("L", [-90.0, -70.0, -60.0], True, p_worse=0.0),
        row("mu", [0.0, 0.0, 0.0], False, identifiable=False),
    ]
    change = InspectionChange(
        state="estimated" if estimated else "beyond_wear",
        family="medium_voltage",
        matches={"closing": {name: {"p_value": 0.5} for name in ("before", "today")}},
        agreement={"p_value": 1.0, "parameter": ""},
        settings={"seed": 1, "misfit_p_value": 0.02},
        records={"closing": {"before": 1, "today": 2}},
        rejected=(),
        differences=(),
        explanations=[Explanation("none", "", 1.0, [0.0] * 3)],
        measured=[
            row("stroke", [1.0, 1.5, 2.0], False, "closing", before=100.0, today=101.5),
            row("over_travel", [-200.0, -50.0, 100.0], False, "closing", **small),
        ],
        inferred=estimates if estimated else [],
        limits=(),
        doubts=["a $f$ in a name"],
    )
    figure = comparison(change)
    assert_drawn(figure)
    texts = [text.get_text() for text in figure.subfigs[1].axes[1].get_yticklabels()]
    assert len(texts) == (5 if estimated else 3)
    assert ["−0.01 mm (−0.043 to +0.023)" in text for text in texts[:3]] == [False, False, True]


@pytest.fixture(scope="module")
def close_and_open():
    """Close and open in one record, 100 ms apart: times, ms, and travel, mm."""
    drive = EnduranceTest.from_settings(simulated_test(defaults()), 1).new
    time = np.arange(0.0, 220.0, 0.1)
    closing, opening = drive.travel("closing", time - 20.0), drive.travel("opening", time - 120.0)
    travel = np.where(time < 120.0, closing, opening)
    return time, travel + 0.05 * np.random.default_rng(1).standard_normal(time.size)


def proposal_of(file, time, travel):
    write_curve(file, time, travel, motion="closing", operation=1)
    sensor = {"start": -2.0, "stop": 58.0, "samples": 151, "noise_sd": 0.1}
    return inspect_file(file, sensor)


def test_a_record_is_drawn_with_its_motions_and_doubtful_samples(close_and_open, tmp_path):
    time, travel = close_and_open
    spiked = travel.copy()
    spiked[300] = 40.0
    proposal = proposal_of(tmp_path / "record.csv", time, spiked)
    figure = record(proposal)
    expected = travel.round(3)
    expected[300] = np.nan
    drawn = line_of(figure.axes[0], style.MEASURED).get_ydata()
    np.testing.assert_allclose(drawn, expected, atol=1e-9)
    assert line_of(figure.axes[0], style.WARNING, "x").get_xdata() == pytest.approx([30.0])
    moves = [motion.record.moves for motion in proposal.motions]
    assert moves == pytest.approx([20.0, 120.0], abs=0.6)
    lines = [line.get_xdata() for line in figure.axes[0].lines]
    assert [xs[0] for xs in lines if len(xs) == 2 and xs[0] == xs[1]] == moves


def test_what_could_not_be_read_is_drawn_as_it_is(close_and_open, tmp_path):
    time, travel = (item[:1100] for item in close_and_open)
    proposal = proposal_of(tmp_path / "record.csv", time, travel)
    refused = [motion._replace(result=None, said=("no",)) for motion in proposal.motions]
    figure = record(replace(proposal, motions=refused))
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), travel.round(3), atol=1e-9)
