"""The figures of exactness and identifiability: their numbers, words, and where they are drawn."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex

from breaker.figures import style
from breaker.figures.exactness import exactness
from breaker.figures.identifiability import DRIVE, identifiability
from breaker.mechanism.parameters import outputs
from breaker.model.randomness import generator
from breaker.posterior.tables import summary
from breaker.validation import comparison
from tests.figures.test_figures import SIGHT, assert_nothing_overlaps, lab, words

NAMES = [output.name for output in outputs(onset=True)]
CURVES, JUDGED, DRAWS = 40, 30, 60


def posteriors(names=NAMES, curves=CURVES):
    """Amortised and corrected draws of simulated curves, in files' layout."""
    rng = generator(21, "test", "exactness")
    truth = rng.standard_normal((curves, len(names)))
    found = []
    for width in (0.30, 0.25):
        z = truth[:, None] + width * rng.standard_normal((curves, DRAWS, len(names)))
        found.append(z)
    log = np.array([name != "onset" for name in names])
    amortised, corrected, truth = (np.where(log, np.exp(each), each) for each in (*found, truth))
    rounds = 1 + (np.arange(curves) % 5 == 0) + (np.arange(curves) % 10 == 0)
    both = [
        xr.Dataset(
            {"draws": (("curve", "draw", "output"), each), "truth": (("curve", "output"), truth)},
            {"output": list(names)},
        )
        for each in (amortised, corrected)
    ]
    return both[0], both[1].assign(
        efficiency=("curve", rng.uniform(0.4, 0.7, curves)),
        pareto_k=("curve", rng.normal(0.2, 0.1, curves)),
        rounds=("curve", rounds),
        resolved=("curve", np.ones(curves, dtype=bool)),
    )


def judgement(corrected, curves=JUDGED):
    rng = generator(22, "test", "exactness")
    values = {
        "efficiency": rng.uniform(0.6, 0.95, curves),
        "faulty_weights": np.zeros(curves, dtype=int),
        "pareto_k": np.where(np.arange(curves) < 2, 0.8, rng.normal(0.2, 0.1, curves)),
        "divergence": rng.lognormal(-2.3, 0.5, curves),
        "gap": rng.normal(0.1, 0.5, curves),
        "truth_log_density": rng.standard_normal(curves),
        "resolved": corrected.resolved.values[:curves],
    }
    each = {name: ("curve", value) for name, value in values.items()}
    return xr.Dataset(each, attrs={"motion": "closing"})


def drawn(judged, amortised, corrected, motion="closing"):
    examples = comparison.examples(judged, amortised, corrected)
    row = summary(judged, corrected).iloc[0]
    return exactness(judged, corrected, examples, row, motion=motion), examples, row


@pytest.fixture(scope="module")
def usual():
    amortised, corrected = posteriors()
    judged = judgement(corrected)
    return judged, corrected, *drawn(judged, amortised, corrected)


def test_posteriors_are_compared_in_units_of_the_corrected_one():
    """By hand: an odd number of evenly spaced draws, whose median and quantiles are known."""
    line = np.linspace(-1.0, 1.0, 201)
    sd = line.std(ddof=1)
    corrected = np.stack([np.exp(3.0 + line), 0.3 + line], axis=1)
    amortised = np.stack([np.exp(3.5 + 2 * line), line], axis=1)
    found = comparison.compare(amortised, corrected, np.array([np.exp(2.0), 0.3]), ["mu", "onset"])
    expected = {
        "amortised": ([0.5, -0.3], [[-0.5, 1.5], [-0.8, 0.2]], [[-1.4, 2.4], [-1.25, 0.65]]),
        "corrected": ([0.0, 0.0], [[-0.5, 0.5]] * 2, [[-0.95, 0.95]] * 2),
    }
    for posterior, values in expected.items():
        one = found.sel(posterior=posterior)
        for name, value in zip(("median", "interval_50", "interval_95"), values, strict=True):
            np.testing.assert_allclose(one[name], np.array(value) / sd, atol=1e-12)
    np.testing.assert_allclose(found.truth, [-1.0 / sd, 0.0], atol=1e-12)


def test_what_cannot_be_compared_is_refused():
    good, truth = np.exp(np.linspace([-1.0], [1.0], 11)), np.ones(1)
    bad = good.copy()
    bad[3] = -1.0
    with pytest.raises(ValueError, match="positive"):
        comparison.compare(bad, good, truth, ["mu"])
    comparison.compare(bad, good, truth, ["onset"])  # which may be negative
    with pytest.raises(ValueError, match="finite"):
        comparison.compare(np.full_like(good, np.nan), good, truth, ["mu"])
    with pytest.raises(ValueError, match="no width"):
        comparison.compare(good, np.ones_like(good), truth, ["mu"])
    with pytest.raises(ValueError, match=r"must be \(d, 2\)"):
        comparison.compare(good, good, truth, ["mu", "k_a"])


def test_examples_are_the_lowest_median_and_highest():
    amortised, corrected = posteriors()
    judged = judgement(corrected, 9)
    judged["efficiency"] = ("curve", [0.5, 0.9, np.nan, 0.1, 0.7, 0.95, 0.6, 0.05, 0.99])
    corrected.draws[8] = np.nan
    corrected.draws[7] = corrected.draws[7, :1]  # one draw again and again
    corrected.resolved[3] = False
    judged["resolved"] = corrected.resolved[:9]
    found = comparison.examples(judged, amortised, corrected)
    assert found.place.values.tolist() == ["lowest", "median", "highest"]
    assert found.curve.values.tolist() == [3, 6, 5]  # of 3 0 6 4 1 5, the lower of the middle two
    assert found.efficiency.values.tolist() == [0.1, 0.6, 0.95]
    assert found.resolved.values.tolist() == [False, True, True]
    draws = [each.draws.values[6] for each in (amortised, corrected)]
    alone = comparison.compare(*draws, amortised.truth.values[6], NAMES)
    xr.testing.assert_allclose(found.isel(example=1)[list(alone)], alone)


@pytest.mark.parametrize(
    ("count", "places"), [(0, []), (1, ["median"]), (2, ["lowest", "highest"])]
)
def test_few_examples(count, places):
    amortised, corrected = posteriors(["mu", "onset"])
    judged = judgement(corrected, 5)
    judged.efficiency[count:] = np.nan
    found = comparison.examples(judged, amortised, corrected)
    assert found.sizes["example"] == count
    if count:
        assert found.place.values.tolist() == places


def test_words_of_exactness():
    row = {"resolved": 0.998, "corrected_curves": 1000, "efficiency_median": 0.861}
    row |= {"gap_nats": 0.0912, "gap_se": 0.0187}
    expected = "median efficiency 86 %, gap 0.09 ± 0.02 nats, 998 of 1000 curves resolved"
    assert comparison.exactness_words(row) == expected
    faulty = comparison.exactness_words(row | {"efficiency_median": np.nan, "gap_nats": np.nan})
    assert faulty == "median efficiency not known, gap not known, 998 of 1000 curves resolved"
    assert comparison.plus_minus(-0.2, np.nan) == "-0.20 nats (one curve)"
    assert comparison.plus_minus(np.inf, np.nan) == "infinite"
    assert [comparison.percent(x) for x in (0.0, 0.0034, 0.1, 1.0)] == [
        "0 %",
        "0.34 %",
        "10 %",
        "100 %",
    ]


def test_exactness_says_what_came_out(usual):
    judged, corrected, figure, examples, row = usual
    text = words(figure)
    assert len(figure.axes) == 7
    assert figure.get_suptitle() == (
        f"Closing: the network against the exact posterior\n{comparison.exactness_words(row)}"
    )
    expected = [
        f"network: median {100 * np.median(judged.efficiency):.0f} %",
        f"correction: median {100 * np.median(corrected.efficiency):.0f} %",
        "network: 28 of 30 below 0.7",
        "correction: 40 of 40 below 0.7",
        "weights do not settle",
        f"up to {judged.divergence.values.max():.2f}",
        f"mean (true values): {row['gap_nats']:.2f} ± {row['gap_se']:.2f} nats",
        "resolved: 40 of 40",
        "not resolved: 0 of 40",
        *("efficiency (%)", "Pareto k", "divergence (nats)", "rounds of adaptation"),
        *("corrected sd", "amortised", "corrected by importance sampling", "truth"),
        *("50 % interval", "95 % interval"),
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
    judged, corrected, figure, *_ = usual
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


def test_the_mean_gap_and_its_error_are_drawn(usual):
    *_, figure, _, row = usual
    axis = figure.axes[2]
    mean = next(line for line in axis.lines if line.get_color() == style.MEASURED)
    assert mean.get_xdata()[0] == pytest.approx(row["gap_nats"])
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
    numbers = [text.get_text() for text in axis.texts]
    rows = zip(axis.patches, labels, numbers, strict=True)
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
            dots = next(line for line in axis.lines if line.get_color() == colour)
            np.testing.assert_allclose(dots.get_xdata(), each["median"])
            places[posterior] = np.asarray(dots.get_ydata())
            lines = [
                np.array(part.get_segments())
                for part in axis.collections
                if isinstance(part, LineCollection)
                and to_hex(part.get_color()[0]).upper() == colour
            ]
            assert len(lines) == 2
            for drawn_at, interval in zip(lines, ("interval_95", "interval_50"), strict=True):
                np.testing.assert_allclose(drawn_at[..., 0], each[interval])
                np.testing.assert_allclose(drawn_at[..., 1], places[posterior][:, None] + [0, 0])
        truth = next(line for line in axis.lines if line.get_color() == style.MEASURED)
        np.testing.assert_allclose(truth.get_xdata(), one.truth)
        # One row an output, from the top down, the two posteriors on either side of its middle.
        rows = np.arange(len(NAMES))
        np.testing.assert_array_equal(truth.get_ydata(), rows)
        assert np.all(places["amortised"] < rows)
        assert np.all(places["corrected"] > rows)
        assert axis.get_ylim()[0] > axis.get_ylim()[1]
    symbols = [label.get_text() for label in figure.axes[4].get_yticklabels()]
    assert symbols == [output.symbol for output in outputs(onset=True)]


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


def test_nothing_overlaps(usual):
    assert_nothing_overlaps(usual[2])


# ---- identifiability -------------------------------------------------------------------------


def contractions(names=NAMES, shift=0.0):
    """Contraction of the limit, and of amortised and corrected posteriors, around set means."""
    rng = generator(23, "test", "identifiability")
    centre = np.array([0.4, 0.87, 0.6, 0.95, 0.85, 0.88, 0.3, 0.93])[: len(names)]
    sizes = {"limit": 200, "amortised": 50, "corrected": 48, "drive": 20}
    found = {
        name: centre - shift + 0.04 * rng.uniform(-1, 1, (n, len(names)))
        for name, n in sizes.items()
    }
    found["drive"][:, 0] += 0.5  # this drive is known where the prior decides on average
    return found


def test_reached_is_sorted_and_says_the_verdict():
    values = contractions()
    found = comparison.reached(values, NAMES)
    order = ["gamma_a", "onset", "f", "k_a", "gamma_b", "k_b", "mu", "L"]
    assert found.output.values.tolist() == order
    known = ["known from this motion"] * 5 + ["partly known"] + ["the prior decides"] * 2
    assert found.known.values.tolist() == known
    assert found.curves.values.tolist() == [200, 50, 48, 20]
    for source, each in values.items():
        for name in NAMES:
            one, column = found.sel(source=source, output=name), each[:, NAMES.index(name)]
            expected = [column.mean(), *np.quantile(column, [0.05, 0.95])]
            found_here = [one[key].item() for key in ("mean", "lower", "upper")]
            assert found_here == pytest.approx(expected)
    assert comparison.identifiability_words(found) == (
        r"over the prior: the prior decides $\mu$ and $L$; $k_b$ partly known"
        "\n"
        "this drive, first 20 operations: the prior decides $L$; $k_b$ partly known"
    )


@pytest.mark.parametrize(
    ("means", "expected"),
    [
        ([0.9, 0.8, 0.85], "the prior decides nothing"),
        ([0.9, 0.5, 0.79], r"the prior decides nothing; $k_b$ and $k_a$ partly known"),
        ([0.1, 0.49, 0.3], r"the prior decides $k_a$, $k_b$ and $\mu$"),
    ],
)
def test_words_of_identifiability_at_the_edges(means, expected):
    """0.8 is known and 0.5 partly; named from the best known down."""
    limit = np.array([means])
    found = comparison.reached({"limit": limit}, ["mu", "k_a", "k_b"])
    assert comparison.identifiability_words(found) == f"over the prior: {expected}"


def test_unusable_contractions_are_refused():
    values = contractions()
    with pytest.raises(ValueError, match="limit must be"):
        comparison.reached(values | {"limit": values["limit"][0]}, NAMES)
    with pytest.raises(ValueError, match="corrected must be finite"):
        comparison.reached(values | {"corrected": np.full((3, 8), np.nan)}, NAMES)


@pytest.fixture(scope="module")
def identified():
    found = comparison.reached(contractions(), NAMES)
    return found, identifiability(found, motion="closing")


def test_contractions_are_drawn_where_they_are(identified):
    found, figure = identified
    axis = figure.axes[0]
    rows = np.arange(8)
    limit = found.sel(source="limit")
    for patch, low, high, row in zip(axis.patches, limit.lower, limit.upper, rows, strict=True):
        box = patch.get_bbox()
        assert (box.x0, box.x1) == pytest.approx((float(low), float(high)))
        assert box.y0 < row < box.y1
    lines = {
        to_hex(part.get_color()[0]).upper(): np.array(part.get_segments())
        for part in axis.collections
    }
    np.testing.assert_allclose(
        lines[style.MEASURED][..., 0], limit["mean"].values[:, None] + [0, 0]
    )
    colours = {"amortised": style.AMORTISED, "corrected": style.CORRECTED, "drive": DRIVE}
    for source, colour in colours.items():
        one = found.sel(source=source)
        marks = next(line for line in axis.lines if line.get_color() == colour)
        np.testing.assert_allclose(marks.get_xdata(), one["mean"])
        ends = np.stack([one.lower, one.upper], axis=1)
        np.testing.assert_allclose(lines[colour][..., 0], ends)
        np.testing.assert_allclose(lines[colour][:, 0, 1], marks.get_ydata())
        assert np.all(np.abs(np.asarray(marks.get_ydata()) - rows) < 0.36)  # inside the band
    thresholds = {line.get_xdata()[0] for line in axis.lines if line.get_linestyle() == ":"}
    assert thresholds == {0.5, 0.8}
    assert axis.get_xlim() == (0.0, 1.0)


def test_each_row_has_its_name_numbers_and_verdict(identified):
    found, figure = identified
    axis, table = figure.axes
    by_name = {output.name: output for output in outputs(onset=True)}
    for row, name in enumerate(found.output.values):
        label = axis.get_yticklabels()[row].get_text()
        assert label == f"{by_name[name].meaning}   {by_name[name].symbol}"
        beside = [text.get_text() for text in table.texts if text.get_position()[1] == row]
        one = found.sel(output=name)
        numbers = [f"{one['mean'].sel(source=each).item():.3f}" for each in found.source.values]
        assert beside == [*numbers, one.known.item()]
    above = [text.get_text() for text in table.texts if text.get_position()[1] < 0]
    assert above == ["limit", "amortised", "corrected", "drive", "over the prior"]


def test_identifiability_says_what_came_out(identified):
    text = words(identified[1])
    expected = [
        "Closing: how well the curve determines each parameter\nover the prior",
        "90 % of 200 draws of the prior",
        "amortised (network alone): mean and 90 % of 50 simulated curves",
        "corrected (exact posterior): mean and 90 % of 48 simulated curves",
        "this drive: mean and 90 % of its first 20 operations",
        "0: nothing learnt, the prior stays;  1: known exactly",
    ]
    assert [each for each in expected if each not in text] == []
    assert_nothing_overlaps(identified[1])


def test_identifiability_without_onset_and_below_zero():
    """A posterior wider than its prior stays in sight."""
    found = comparison.reached(contractions(NAMES[:7], shift=0.5), NAMES[:7])
    figure = identifiability(found, motion="opening")
    assert len(figure.axes[0].get_yticklabels()) == 7
    assert "$t_0$" not in "".join(t.get_text() for t in figure.axes[0].get_yticklabels())
    assert figure.axes[0].get_xlim()[0] <= found.lower.values.min() < 0
    assert figure.get_suptitle().startswith("Opening: ")
    assert_nothing_overlaps(figure)


@pytest.mark.parametrize("sight", SIGHT)
def test_posteriors_stay_apart_in_colour(sight):
    """As the colours of the parameters: 15 CIELAB units, from what is in the same figures."""
    used = ["AMORTISED", "CORRECTED", "WARNING", "MEASURED", "PRIOR", "REFERENCE", "MODEL"]
    seen = {name: lab(getattr(style, name), SIGHT[sight]) for name in used}
    pairs = [pair for pair in combinations(used, 2) if {*pair} & {"AMORTISED", "CORRECTED"}]
    distances = {(a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in pairs}
    assert {pair: distance for pair, distance in distances.items() if distance < 15} == {}
