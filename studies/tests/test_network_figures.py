"""Figures of networks side by side, and of missing samples."""

import numpy as np
import pandas as pd
from matplotlib.collections import PathCollection
from matplotlib.colors import to_hex

from breaker.common.randomness import generator
from breaker.figures import style
from breaker.paper.validation.calibration import judge_ranks
from breaker.quantities.parameters import outputs
from studies.networks.figures import missing, networks
from studies.networks.missing import over_curves
from tests.figures.drawn import assert_nothing_overlaps, bands, line_of, segments, words, written

NAMES = [output.name for output in outputs(onset=True)]


def table_of(**changes):
    numbers = {
        "network": ["time_series_flow_matching", "time_series_coupling_flow", "deep_set_flow"],
        "held_out_log_density": [6.912, 6.95, 6.8],
        "held_out_log_density_se": [0.11, 0.12, 0.1],
        "gap_nats": [0.061, 0.1, 0.153],
        "gap_se": [0.02, 0.03, 0.04],
        "efficiency_median": [0.91, 0.8, 0.75],
        "calibration_p": [0.63, 0.0099, 0.06],
        "calibrated": [True, False, True],
        "draws_per_second": [4500.0, 110_000.0, 98_000.0],
        "training_seconds": [812.3, 1511.0, 99.7],
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


def test_each_measure_has_a_panel_with_its_numbers():
    """One row a network, from the top down; bars are two standard errors to either side. A
    network that is not calibrated stands out on the panel of the p-value alone."""
    table = table_of()
    figure = networks(table, motion="closing")
    best = "highest held-out log density: time series coupling flow"
    assert figure.get_suptitle() == f"Closing: networks side by side\n{best}"
    errors = {"held_out_log_density": "held_out_log_density_se", "gap_nats": "gap_se"}
    for axis, (name, (label, numbers)) in zip(figure.axes, MEASURES.items(), strict=True):
        assert axis.get_xlabel() == label
        assert written(axis) == numbers
        assert axis.get_xscale() == ("log" if name == "draws_per_second" else "linear")
        (dots,) = (each for each in axis.collections if isinstance(each, PathCollection))
        places = np.asarray(dots.get_offsets())
        np.testing.assert_allclose(places, np.stack([table[name], [2, 1, 0]], axis=1))
        colours = [to_hex(colour).upper() for colour in dots.get_facecolors()]
        second = style.WARNING if name == "calibration_p" else style.AMORTISED
        assert colours == [style.AMORTISED, second, style.AMORTISED]
        if name in errors:
            (bars,) = segments(axis, style.REFERENCE)
            ends = table[name].to_numpy()[:, None] + 2 * np.outer(table[errors[name]], [-1, 1])
            np.testing.assert_allclose(bars[..., 0], ends)
    low, high = figure.axes[1].get_xlim()
    assert low < 0.0 < high
    assert "not calibrated" in words(figure)
    assert_nothing_overlaps(figure)


def test_what_is_not_known_is_said():
    unknown = {
        "held_out_log_density": [np.nan, -np.inf, -50.0],
        "gap_nats": [np.nan, 0.1, np.nan],
        "gap_se": [np.nan] * 3,
        "efficiency_median": [np.nan] * 3,
        "calibration_p": [1.1e-93, 1.0, 0.0],
    }
    figure = networks(table_of(**unknown), motion="opening")
    assert [written(axis) for axis in figure.axes[:4]] == [
        ["not known", "-inf", "-50.0"],
        ["not known", "0.10", "not known"],
        ["not known"] * 3,
        ["1.1e-93", "1.00", "0"],
    ]
    assert figure.get_suptitle().endswith("density: deep set flow")
    assert_nothing_overlaps(figure)


def test_missing_samples_show_ranks_and_widths():
    """One row an output, from the top down, the network above the exact posterior."""
    rank = generator(1, "test networks", "ranks").integers(0, 61, (200, 8))
    rank[:, 2] = np.maximum(rank[:, 2] - 20, 0)
    judged = judge_ranks(rank, 60)
    rng = generator(1, "test networks", "ratios")
    ratios = [np.exp(np.linspace(0, 0.3, 8) + 0.05 * rng.standard_normal((n, 8))) for n in (9, 7)]
    both = [over_curves(each) for each in ratios]
    figure = missing(judged, *both, NAMES, motion="closing", share=0.3)
    title = "Closing: 30 % of the samples missing at random\nNOT calibrated: $k_b$ outside"
    assert figure.get_suptitle().startswith(title)
    left, right = figure.axes
    for i, name in enumerate(NAMES):
        line = line_of(left, style.OUTPUTS[name].colour)
        np.testing.assert_array_equal(line.get_ydata(), judged.difference[:, i])
    np.testing.assert_allclose(bands(left)[0], (judged.band.lower.min(), judged.band.upper.max()))
    rows = np.arange(8)[::-1]
    places = []
    for values, colour in zip(ratios, (style.AMORTISED, style.CORRECTED), strict=True):
        dots, (bars,) = line_of(right, colour), segments(right, colour)
        np.testing.assert_allclose(dots.get_xdata(), np.median(values, axis=0))
        np.testing.assert_allclose(bars[..., 0], np.quantile(values, [0.05, 0.95], axis=0).T)
        places.append(np.asarray(dots.get_ydata()) - rows)
    assert np.all(np.abs(places) < 0.5)
    assert np.all(places[0] > 0)
    assert np.all(places[1] < 0)
    assert [label.get_text() for label in right.get_yticklabels()] == style.symbols(NAMES)
    assert "exact posterior: median, 5 to 95 % (7 curves)" in words(figure)
    assert_nothing_overlaps(figure)


def test_missing_samples_without_an_exact_posterior():
    judged = judge_ranks(np.tile(np.arange(20)[:, None], (1, 7)), 19)
    ratios = [over_curves(np.full((5, 7), value)) for value in (1.2, np.nan)]
    figure = missing(judged, *ratios, NAMES[:7], motion="opening", share=0.125)
    assert "12.5 % of the samples" in figure.get_suptitle()
    assert "(0 curves)" in words(figure)
    assert_nothing_overlaps(figure)
