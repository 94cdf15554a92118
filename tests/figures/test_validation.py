"""Figures of calibration, contraction, recovery and pairs."""

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.figures import pairs, validation
from breaker.paper.validation.calibration import judge_draws
from breaker.paper.validation.diagnostics import REGIONS, correlation, recovery, regions, scores
from breaker.quantities.parameters import outputs
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
    figure = validation.sbc(judge_draws(*inferred(names)), names, motion="closing")
    assert_drawn(figure, f"calibration of {len(names)}")


def test_failed_calibration_is_seen():
    """In the title and its colour, and in the panel that failed."""
    judged = judge_draws(*inferred(THREE, narrow=["f"]))
    about = {"motion": "closing", "subject": "calibration of files", "of": "family"}
    assert_drawn(validation.sbc(judged, THREE, **about), "calibration that failed")


def test_contraction_is_across_and_z_score_up():
    draws, truth = inferred(NAMES)
    found = scores(draws, truth, prior_sd=np.full(8, 0.2), log=np.full(8, True))
    figure = validation.contraction(found, NAMES, motion="closing", limit=np.linspace(0.3, 1, 8))
    assert_drawn(figure, "contraction")
    few = scores(draws[..., :2], truth[..., :2], prior_sd=[0.2, 0.2], log=[True, True])
    assert_drawn(validation.contraction(few, NAMES[:2], motion="opening"), "contraction of 2")


def test_recovery_has_the_truth_across():
    figure = validation.recovery(recovery(*inferred(NAMES)), NAMES, motion="closing")
    assert_drawn(figure, "recovery")


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
    about = {"motion": "closing", "correlation": strength, "regions": regions(draws[0])}
    assert_drawn(pairs.pairs(case, truth, **about), "pairs")
