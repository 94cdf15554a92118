"""The figure of exactness: shares, gap, rounds and examples, each where it belongs."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from breaker.figures import style
from breaker.figures.exactness import exactness
from breaker.posterior.tables import summary
from breaker.validation import comparison
from tests.figures.drawn import assert_nothing_overlaps, line_of, segments, words, written
from tests.validation.made import CURVES, JUDGED, NAMES, judgement, posteriors


def drawn(judged, amortised, corrected, motion="closing"):
    examples = comparison.examples(judged, amortised, corrected)
    row = summary(judged, corrected).iloc[0]
    return exactness(judged, corrected, examples, row, motion=motion), examples, row


@pytest.fixture(scope="module")
def usual():
    amortised, corrected = posteriors()
    judged = judgement(corrected)
    return judged, corrected, *drawn(judged, amortised, corrected)


def test_exactness_says_what_came_out(usual):
    judged, corrected, figure, examples, row = usual
    text = words(figure)
    assert figure.get_suptitle().endswith(f"posterior\n{comparison.exactness_words(row)}")
    expected = [
        f"network: median {100 * np.median(judged.efficiency):.0f} %",
        f"correction: median {100 * np.median(corrected.efficiency):.0f} %",
        *("network: 28 of 30 below 0.7", "correction: 40 of 40 below 0.7"),
        f"up to {judged.divergence.values.max():.2f}",
        f"mean (true values): {row['gap_nats']:.2f} ± {row['gap_se']:.2f} nats",
        *("resolved: 40 of 40", "not resolved: 0 of 40"),
        f"median efficiency: simulated curve {int(examples.curve[1]) + 1}",
        f"k {float(examples.pareto_k[1]):.2f}",
    ]
    assert [each for each in expected if each not in text] == []


def share_at(line, value):
    """Where a line of steps is, just beside a value of the data."""
    x, y = line.get_data()
    if line.get_drawstyle() == "steps-pre":
        return y[np.searchsorted(x, value, side="left")]
    return y[np.searchsorted(x, value, side="right") - 1]


def test_shares_are_those_of_the_data(usual):
    judged, corrected, figure, _, row = usual
    at_least, k, gap = ([*axis.lines] for axis in figure.axes[:3])
    for lines, name, unit in ((at_least, "efficiency", 100), (k, "pareto_k", 1)):
        pairs = ((judged, style.AMORTISED), (corrected, style.CORRECTED))
        for line, (data, colour) in zip(lines, pairs, strict=False):
            values = unit * data[name].values
            assert line.get_color() == colour
            for value in np.quantile(values, [0.0, 0.13, 0.5, 0.87, 1.0]):
                inside = values >= value if name == "efficiency" else values <= value
                assert share_at(line, value) == pytest.approx(100 * inside.mean())
    assert k[2].get_xdata()[0] == 0.7
    divergence = judged.divergence.values
    assert share_at(gap[0], np.median(divergence)) == pytest.approx(50, abs=2)
    axis = figure.axes[2]
    assert line_of(axis, style.MEASURED).get_xdata()[0] == pytest.approx(row["gap_nats"])
    band = axis.collections[0].get_datalim(axis.transData)
    ends = row["gap_nats"] - row["gap_se"], row["gap_nats"] + row["gap_se"]
    assert (band.x0, band.x1) == pytest.approx(ends)


def test_a_curve_far_away_does_not_dwarf_the_others(usual):
    judged, corrected, *_ = usual
    amortised, _ = posteriors()
    judged = judged.copy(deep=True)
    judged.divergence[4] = 50.0
    figure, *_ = drawn(judged, amortised, corrected)
    # One of 30 is more than 3 % and stays in; with 40 judged curves it goes out.
    assert figure.axes[2].get_xlim()[1] > 50.0
    judged = judgement(corrected, 40)
    judged.divergence[4] = 50.0
    figure, *_ = drawn(judged, amortised, corrected)
    assert figure.axes[2].get_xlim()[1] < 5.0
    assert "up to 50.00" in words(figure)


def bars(axis):
    """Height, colour, label below and number above of each bar."""
    labels = [label.get_text() for label in axis.get_xticklabels()]
    rows = zip(axis.patches, labels, written(axis), strict=True)
    return [(bar.get_height(), to_hex(bar.get_facecolor()).upper(), *rest) for bar, *rest in rows]


def test_bars_count_the_rounds(usual):
    assert bars(usual[2].axes[3]) == [
        (32, style.CORRECTED, "1", "32"),
        (4, style.CORRECTED, "2", "4"),
        (4, style.CORRECTED, "3", "4"),
        (0, style.WARNING, "not\nresolved", "0"),
    ]


@pytest.mark.parametrize("resolved", [0, 3])
def test_unresolved_curves_stand_apart(resolved):
    amortised, corrected = posteriors(NAMES[:2])
    corrected["resolved"] = ("curve", np.arange(CURVES) % 10 < resolved)
    judged = judgement(corrected)
    if not resolved:
        judged["resolved"] = ("curve", np.arange(JUDGED) < 2)  # a mean needs some
    figure, examples, _ = drawn(judged, amortised, corrected)
    share = resolved * CURVES // 10
    found = bars(figure.axes[3])
    unresolved = CURVES - share
    assert found[-1] == (unresolved, style.WARNING, "not\nresolved", str(unresolved))
    assert sum(bar[0] for bar in found[:-1]) == share
    assert f"{share} of {CURVES} curves resolved" in figure.get_suptitle()
    for axis, good in zip(figure.axes[4:], examples.resolved.values, strict=True):
        assert axis.get_title().endswith("not resolved") == (not good)
        assert axis.title.get_color() == ("black" if good else style.WARNING)


def test_posteriors_are_drawn_where_they_are(usual):
    _, _, figure, examples, _ = usual
    for i, axis in enumerate(figure.axes[4:]):
        one = examples.isel(example=i)
        colours = {"amortised": style.AMORTISED, "corrected": style.CORRECTED}
        places = {}
        for posterior, colour in colours.items():
            each = one.sel(posterior=posterior)
            dots = line_of(axis, colour)
            np.testing.assert_allclose(dots.get_xdata(), each["median"])
            places[posterior] = np.asarray(dots.get_ydata())
            lines = segments(axis, colour)
            assert len(lines) == 2
            for drawn_at, interval in zip(lines, ("interval_95", "interval_50"), strict=True):
                np.testing.assert_allclose(drawn_at[..., 0], each[interval])
                np.testing.assert_allclose(drawn_at[..., 1], places[posterior][:, None] + [0, 0])
        truth = line_of(axis, style.MEASURED)
        np.testing.assert_allclose(truth.get_xdata(), one.truth)
        # One row an output, from the top down, the two posteriors on either side of its middle.
        rows = np.arange(len(NAMES))
        np.testing.assert_array_equal(truth.get_ydata(), rows)
        assert np.all(places["amortised"] < rows)
        assert np.all(places["corrected"] > rows)
        assert axis.get_ylim()[0] > axis.get_ylim()[1]
    symbols = [label.get_text() for label in figure.axes[4].get_yticklabels()]
    assert symbols == style.symbols(NAMES)
    assert_nothing_overlaps(figure)


def test_exactness_without_onset_and_with_faulty_curves():
    """The paper's own setting, few curves, weights that say nothing, infinite ones."""
    amortised, corrected = posteriors(NAMES[:7], curves=10)
    corrected.draws[1] = np.nan
    for name in ("efficiency", "pareto_k"):
        corrected[name][1] = np.nan
    corrected.resolved[1] = False
    judged = judgement(corrected, 10)
    for name in ("efficiency", "pareto_k", "divergence"):
        judged[name][4] = np.nan
    judged.pareto_k[5], judged.divergence[6] = np.inf, np.inf
    figure, *_ = drawn(judged, amortised, corrected, motion="opening")
    text = words(figure)
    assert figure.get_suptitle().startswith("Opening: ")
    assert "median efficiency not known" in text
    assert "network: median not known, 1 without" in text
    assert "network: 6 of 10 below 0.7, 1 without" in text  # two at 0.8, inf and nan
    assert "correction: 9 of 10 below 0.7, 1 without" in text
    assert "nan" not in text
    assert max(figure.axes[0].lines[0].get_ydata()) == 90.0  # nan counts as no efficiency
    assert len(figure.axes[4].get_yticklabels()) == 7
    assert_nothing_overlaps(figure)


def test_exactness_without_any_example():
    amortised, corrected = posteriors(NAMES[:2])
    corrected.draws[:] = np.nan
    figure, *_ = drawn(judgement(corrected), amortised, corrected)
    assert len(figure.axes) == 4
    assert_nothing_overlaps(figure)
