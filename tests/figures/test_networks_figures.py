"""Networks side by side: the table's row, and the figures of it and of missing samples."""

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex

from breaker.figures import style
from breaker.figures.networks import missing, networks
from breaker.mechanism.parameters import outputs
from breaker.model.randomness import generator
from breaker.posterior.predictive import validate
from breaker.posterior.tables import summary
from breaker.validation import draws_per_second, judge_draws, judge_ranks, network_row, over_curves
from tests.figures.test_figures import assert_nothing_overlaps, words
from tests.networks_fixtures import COUPLING_FLOW, MARKS, NETWORK, frozen, one_thread  # noqa: F401

pytestmark = MARKS

NAMES = [output.name for output in outputs(onset=True)]
NETWORKS = ["time_series_flow_matching", "time_series_coupling_flow", "deep_set_coupling_flow"]


# ---- the table -----------------------------------------------------------------------------------

COLUMNS = [
    *("network", "held_out_log_density", "held_out_log_density_se", "gap_nats", "gap_se"),
    *(
        "efficiency_median",
        "efficiency_10_percent",
        "calibration_p",
        "calibrated",
        "draws_per_second",
    ),
    *("training_seconds", "solver_steps", "weights"),
]


@pytest.fixture(scope="module", params=["flow_matching", "coupling_flow"])
def made(request):
    """A network, what belongs to it, and its row."""
    settings = {**NETWORK, "inference": COUPLING_FLOW}
    posterior = frozen(network=NETWORK if request.param == "flow_matching" else settings)
    posterior.solver_steps.fill_(3)
    data = validate(posterior, 12, 20, seed=4)
    curves = {
        "efficiency": ("curve", np.linspace(0.1, 1.0, 10)),
        "faulty_weights": ("curve", np.zeros(10, dtype=int)),
        "pareto_k": ("curve", np.zeros(10)),
        "divergence": ("curve", np.ones(10)),
        "truth_log_density": ("curve", np.ones(10)),
        "gap": ("curve", np.arange(10.0)),
        "resolved": ("curve", np.ones(10, dtype=bool)),
    }
    judged = xr.Dataset(curves, attrs={"motion": "closing"})
    corrected = judged[["efficiency", "resolved"]].assign(rounds=("curve", np.ones(10)))
    history = xr.Dataset(
        attrs={"held_out_log_density": 3.25, "held_out_log_density_se": 0.125, "best_step": 7}
    )
    training = pd.DataFrame({"s": [90.0], "mean_load": [97.0], "cpu_time": [87.5]})
    table = network_row("the_name", posterior, data, summary(judged, corrected), history, training)
    return posterior, data, table


def test_row_has_the_numbers_of_its_parts(made):
    posterior, data, table = made
    assert table.columns.tolist() == COLUMNS
    assert len(table) == 1
    found = table.iloc[0]
    expected = {
        "network": "the_name",
        "held_out_log_density": 3.25,
        "held_out_log_density_se": 0.125,
        "gap_nats": 4.5,
        "gap_se": np.arange(10.0).std(ddof=1) / np.sqrt(10),
        "efficiency_median": 0.55,
        "efficiency_10_percent": 0.19,
        "training_seconds": 87.5,
        "solver_steps": 3,
        "weights": sum(weight.detach().numpy().size for weight in posterior.parameters()),
    }
    for name, value in expected.items():
        assert found[name] == (value if isinstance(value, str) else pytest.approx(value)), name
    judged = judge_draws(data.draws.values, data.truth.values)
    assert found.calibration_p == pytest.approx(judged.p_value)
    assert found.calibrated == (not judged.outside.any())
    assert np.isfinite(found.draws_per_second)
    assert found.draws_per_second > 0


def test_uncalibrated_draws_show_in_their_row(made):
    posterior, data, _ = made
    data = data.isel(curve=slice(10))
    bad = data.assign(draws=data.draws + 1e6)
    empty = pd.DataFrame({name: [0.0] for name in COLUMNS})
    history = xr.Dataset(attrs={"held_out_log_density": 0.0, "held_out_log_density_se": 0.0})
    table = network_row("bad", posterior, bad, empty, history, pd.DataFrame({"cpu_time": [1.0]}))
    assert table.calibration_p.item() < 1e-9
    assert not table.calibrated.item()


def test_draws_per_second_counts_processor_time(made, monkeypatch):
    """A clock that says two seconds; a few records, or fewer."""
    posterior, data, _ = made
    calls = []

    class Counting:
        outputs = posterior.outputs

        def sample(self, measured, noise):
            assert noise.shape == (len(measured), 500, 8)
            calls.append(len(measured))

    monkeypatch.setattr("breaker.validation.tables.process_time", lambda: 2.0 * len(calls))
    assert draws_per_second(Counting(), data.measured.values) == 10 * 500 / 2.0
    assert calls == [1, 10]
    assert draws_per_second(Counting(), data.measured.values[:4]) == 4 * 500 / 2.0


# ---- the figure of networks ----------------------------------------------------------------------


def table_of(**changes):
    numbers = {
        "network": NETWORKS,
        "held_out_log_density": [6.912, 6.95, 6.8],
        "held_out_log_density_se": [0.11, 0.12, 0.1],
        "gap_nats": [0.061, 0.1, 0.153],
        "gap_se": [0.02, 0.03, 0.04],
        "efficiency_median": [0.91, 0.8, 0.75],
        "efficiency_10_percent": [0.8, 0.6, 0.4],
        "calibration_p": [0.63, 0.0099, 0.06],
        "calibrated": [True, False, True],
        "draws_per_second": [4500.0, 110_000.0, 98_000.0],
        "training_seconds": [812.3, 1511.0, 99.7],
        "solver_steps": [8, 1, 1],
        "weights": [412_345, 398_123, 287_654],
    }
    return pd.DataFrame(numbers | changes)


MEASURES = {
    "held_out_log_density": ("held-out log density (nats)", ["6.91", "6.95", "6.80"]),
    "gap_nats": ("gap to the exact posterior (nats)", ["0.061", "0.10", "0.15"]),
    "efficiency_median": ("median efficiency", ["0.91", "0.80", "0.75"]),
    "calibration_p": ("calibration, p of all outputs", ["0.63", "0.0099", "0.06"]),
    "draws_per_second": ("draws per second, one core", ["4,500", "110,000", "98,000"]),
    "training_seconds": ("training, s of processor time", ["812", "1,511", "100"]),
    "weights": ("weights", ["412,345", "398,123", "287,654"]),
}


@pytest.fixture(scope="module")
def side_by_side():
    return networks(table_of(), motion="closing")


def marks(axis):
    """Where the dots are, ``(n, 2)``, and their colours."""
    (dots,) = (each for each in axis.collections if isinstance(each, PathCollection))
    return np.asarray(dots.get_offsets()), [to_hex(c).upper() for c in dots.get_facecolors()]


def bars(axis):
    """Ends of the error bars by row."""
    parts = [each for each in axis.collections if isinstance(each, LineCollection)]
    segments = [segment for part in parts for segment in part.get_segments() if len(segment)]
    return {segment[0, 1]: (segment[0, 0], segment[1, 0]) for segment in segments}


def test_each_measure_has_a_panel(side_by_side):
    labels = [axis.get_xlabel() for axis in side_by_side.axes]
    assert labels == [label for label, _ in MEASURES.values()]
    scales = [axis.get_xscale() for axis in side_by_side.axes]
    assert scales == ["linear"] * 4 + ["log"] + ["linear"] * 2
    for axis, (_, numbers) in zip(side_by_side.axes, MEASURES.values(), strict=True):
        assert [text.get_text() for text in axis.texts] == numbers
    for i, axis in enumerate(side_by_side.axes):
        names = [label.get_text() for label in axis.get_yticklabels()]
        assert names == (
            [name.replace("_", " ") for name in NETWORKS] if i in (0, 4) else ["", "", ""]
        )


def test_dots_and_bars_are_the_data(side_by_side):
    """One row a network, from the top down; bars are two standard errors to either side."""
    table = table_of()
    for axis, name in zip(side_by_side.axes, MEASURES, strict=True):
        places, _ = marks(axis)
        np.testing.assert_allclose(places[:, 0], table[name])
        np.testing.assert_array_equal(places[:, 1], [2, 1, 0])
        np.testing.assert_array_equal(axis.get_yticks(), [2, 1, 0])
        low, high = axis.get_xlim()
        assert (places[:, 0] > low).all()
        assert (places[:, 0] < high).all()
    for axis, name in zip(side_by_side.axes[:2], ("held_out_log_density", "gap_nats"), strict=True):
        error = table["gap_se" if name == "gap_nats" else f"{name}_se"]
        found = bars(axis)
        for place, value, each in zip([2, 1, 0], table[name], error, strict=True):
            assert found[place] == pytest.approx((value - 2 * each, value + 2 * each))
    assert not any(bars(axis) for axis in side_by_side.axes[2:])


def test_a_poor_p_value_is_a_warning(side_by_side):
    """Where calibration fails, and on its own panel alone."""
    for i, axis in enumerate(side_by_side.axes):
        _, colours = marks(axis)
        second = style.WARNING if i == 3 else style.AMORTISED
        assert colours == [style.AMORTISED, second, style.AMORTISED]
    assert "not calibrated" in words(side_by_side)
    good = networks(table_of(calibrated=[True] * 3), motion="closing")
    assert "not calibrated" not in words(good)
    assert set(marks(good.axes[3])[1]) == {style.AMORTISED}


def test_title_names_the_highest_density(side_by_side):
    title = (
        "Closing: networks side by side\nhighest held-out log density: time series coupling flow"
    )
    assert side_by_side.get_suptitle() == title
    assert "two standard errors" in words(side_by_side)
    other = networks(table_of(held_out_log_density=[9.0, 7.0, np.nan]), motion="opening")
    assert other.get_suptitle().startswith("Opening: ")
    assert other.get_suptitle().endswith("density: time series flow matching")


def test_the_gap_is_seen_from_zero(side_by_side):
    axis = side_by_side.axes[1]
    assert any(list(line.get_xdata()) == [0.0, 0.0] for line in axis.lines)
    for gap in ([0.06, 0.1, 0.15], [-0.06, -0.1, -0.02]):
        low, high = networks(table_of(gap_nats=gap), motion="closing").axes[1].get_xlim()
        assert low < 0.0 < high


UNKNOWN = {
    "held_out_log_density": [np.nan, -np.inf, -50.0],
    "gap_nats": [np.nan, 0.1, np.nan],
    "gap_se": [np.nan] * 3,
    "efficiency_median": [np.nan] * 3,
    "calibration_p": [1.1e-93, 1.0, 0.0],
    "draws_per_second": [4500.0, 4600.0, 4700.0],
}


def test_what_is_not_known_is_said():
    figure = networks(table_of(**UNKNOWN), motion="closing")
    numbers = [[text.get_text() for text in axis.texts] for axis in figure.axes[:4]]
    assert numbers == [
        ["not known", "-inf", "-50.0"],
        ["not known", "0.10", "not known"],
        ["not known"] * 3,
        ["1.1e-93", "1.00", "0"],
    ]
    assert figure.get_suptitle().endswith("density: deep set coupling flow")
    assert_nothing_overlaps(figure)
    nothing = networks(table_of(held_out_log_density=[np.nan] * 3), motion="closing")
    assert nothing.get_suptitle().endswith("density: not known")


@pytest.mark.parametrize("count", [1, 3, 6])
def test_networks_do_not_overlap(side_by_side, count):
    table = pd.concat([table_of(), table_of(weights=[1, 22, 333])]).iloc[:count]
    figure = side_by_side if count == 3 else networks(table, motion="opening")
    assert_nothing_overlaps(figure)
    for axis in figure.axes:
        assert_numbers_stay_apart(axis)


def assert_numbers_stay_apart(axis):
    """Numbers stay inside their panel and off each other; so do the labels of its ticks."""
    panel = axis.get_window_extent().padded(1.0)
    boxes = [text.get_window_extent() for text in axis.texts]
    for box in boxes:
        assert panel.x0 <= box.x0
        assert box.x1 <= panel.x1
        assert box.y1 <= panel.y1
    low, high = axis.get_xlim()
    ticks = axis.get_xticklabels(which="both")
    shown = [
        tick.get_window_extent()
        for tick in ticks
        if tick.get_text() and low <= tick.get_position()[0] <= high
    ]
    shown.sort(key=lambda box: box.x0)
    assert shown or not axis.get_xticks().size
    for left, right in pairwise(shown):
        assert left.x1 < right.x0
    for i, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[i + 1 :])


# ---- the figure of missing samples ---------------------------------------------------------------


def judged(names=NAMES, *, off=(), curves=200, draws=60):
    """Uniform ranks, of which some outputs' are shifted, judged."""
    rank = generator(1, "test networks", "ranks").integers(0, draws + 1, (curves, len(names)))
    for name in off:
        at = names.index(name)
        rank[:, at] = np.maximum(rank[:, at] - draws // 3, 0)
    return judge_ranks(rank, draws)


def ratios(names=NAMES, curves=200):
    rng = generator(1, "test networks", "ratios")
    centre = np.linspace(0.0, 0.3, len(names))
    return [np.exp(centre + sd * rng.standard_normal((curves, len(names)))) for sd in (0.08, 0.05)]


def drawn(names=NAMES, *, off=(), motion="closing", share=0.3, exact=None):
    amortised, other = ratios(names)
    exact = other if exact is None else exact
    both = over_curves(amortised), over_curves(exact)
    return missing(judged(names, off=off), *both, names, motion=motion, share=share)


@pytest.fixture(scope="module")
def usual():
    return drawn(off=["k_b", "L"])


def test_missing_says_what_came_out(usual):
    text = words(usual)
    p_values = judged(off=["k_b", "L"]).p_values
    symbols = [output.symbol for output in outputs(onset=True)]
    expected = [
        "Closing: 30 % of the samples missing at random\nNOT calibrated: $k_b$, $L$ outside",
        *("rank of the truth / (draws + 1)", "ECDF difference", "calibrated?"),
        *("posterior sd with missing samples / with all", "wider where it should be?"),
        "simultaneous 95 % band, all 8 outputs together",
        "network: median, 5 to 95 % (200 curves)",
        "exact posterior: median, 5 to 95 % (200 curves)",
        *(f"{symbol}, p = {p:.2g}" for symbol, p in zip(symbols, p_values, strict=True)),
    ]
    assert [each for each in expected if each not in text] == []


def test_lines_and_band_are_the_verdict(usual):
    expected = judged(off=["k_b", "L"])
    left = usual.axes[0]
    for i, name in enumerate(NAMES):
        (line,) = (each for each in left.lines if each.get_color() == style.COLOURS[name])
        np.testing.assert_array_equal(line.get_xdata(), expected.band.grid)
        np.testing.assert_array_equal(line.get_ydata(), expected.difference[:, i])
        assert line.get_drawstyle() == "steps-post"
    band = left.collections[0].get_datalim(left.transData)
    assert band.y0 == pytest.approx(expected.band.lower.min())
    assert band.y1 == pytest.approx(expected.band.upper.max())


def test_ratios_are_drawn_where_they_are(usual):
    """One row an output, from the top down, the network above the exact posterior."""
    right = usual.axes[1]
    np.testing.assert_array_equal(right.get_yticks(), np.arange(8)[::-1])
    symbols = [label.get_text() for label in right.get_yticklabels()]
    assert symbols == [output.symbol for output in outputs(onset=True)]
    places = {}
    for values, colour in zip(ratios(), (style.AMORTISED, style.CORRECTED), strict=True):
        (dots,) = (line for line in right.lines if line.get_color() == colour)
        np.testing.assert_allclose(dots.get_xdata(), np.median(values, axis=0))
        places[colour] = np.asarray(dots.get_ydata())
        (lines,) = (
            np.array(each.get_segments())
            for each in right.collections
            if to_hex(each.get_color()[0]).upper() == colour
        )
        ends = np.quantile(values, [0.05, 0.95], axis=0).T
        np.testing.assert_allclose(lines[..., 0], ends)
        np.testing.assert_allclose(lines[..., 1], places[colour][:, None] + [0, 0])
    rows = np.arange(8)[::-1]
    assert np.all(places[style.AMORTISED] > rows)
    assert np.all(places[style.CORRECTED] < rows)
    assert np.all(np.abs(np.stack(list(places.values())) - rows) < 0.5)


def test_all_outputs_inside():
    figure = drawn(NAMES[:7], motion="opening", share=0.125)
    title = "Opening: 12.5 % of the samples missing at random\ncalibrated: all 7 outputs inside"
    assert figure.get_suptitle().startswith(title)
    assert "$t_0$" not in words(figure)
    assert_nothing_overlaps(figure)


def test_curves_without_a_ratio_are_counted():
    _, exact = ratios()
    exact[::4] = np.nan
    figure = drawn(exact=exact)
    assert "exact posterior: median, 5 to 95 % (150 curves)" in words(figure)
    assert "network: median, 5 to 95 % (200 curves)" in words(figure)
    dots = next(line for line in figure.axes[1].lines if line.get_color() == style.CORRECTED)
    expected = np.median(exact[np.isfinite(exact[:, 0])], axis=0)
    np.testing.assert_allclose(dots.get_xdata(), expected)
    none = drawn(exact=np.full_like(exact, np.nan))
    assert "(0 curves)" in words(none)
    assert_nothing_overlaps(none)


def test_missing_does_not_overlap(usual):
    """Nor does the legend of the lines lie on any of them."""
    assert_nothing_overlaps(usual)
    left, right = usual.axes
    legend = left.get_legend().get_window_extent()
    assert left.get_window_extent().x1 <= legend.x0
    assert legend.x1 <= right.get_tightbbox().x0
