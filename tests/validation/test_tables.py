"""Tables of the quality, on posteriors that are known in closed form."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.model.randomness import generator
from breaker.validation.calibration import judge_draws
from breaker.validation.tables import quality, quality_words
from tests.validation.made import exact_posteriors

NAMES = ["mu", "L", "onset"]
LOG = np.array([True, True, False])
PRIOR_SD = np.array([0.2, 0.05, 0.3])
CONTRACTION = np.array([0.4, 0.8, 0.95])
N, D = 800, 199


def validation(*, seed=1, bias=0.0, width=1.0):
    """Exact posteriors of normal observations, in the layout of a validation.

    ``bias`` is in posterior sds, ``width`` times the posterior sd; both of the second output.
    """
    fault = {"bias": np.array([0, bias, 0]), "width": np.array([1, width, 1])}
    known = {"prior_sd": PRIOR_SD, "contraction": CONTRACTION}
    draws, truth = exact_posteriors(generator(seed, "test quality"), N, D, **known, **fault)
    return xr.Dataset(
        {
            "draws": (("curve", "draw", "output"), np.where(LOG, 10 * np.exp(draws), draws)),
            "truth": (("curve", "output"), np.where(LOG, 10 * np.exp(truth), truth)),
        },
        coords={"output": NAMES},
    )


def judged(data=None, reader=None):
    data = validation() if data is None else data
    reader = validation(seed=2) if reader is None else reader
    return quality(data, reader, CONTRACTION, prior_sd=PRIOR_SD, log=LOG)


@pytest.fixture(scope="module")
def exact():
    return judged()


def test_columns(exact):
    assert exact.output.tolist() == NAMES
    np.testing.assert_array_equal(exact.contraction_limit, CONTRACTION)
    np.testing.assert_allclose(exact.shortfall, CONTRACTION - exact.contraction, atol=1e-15)


@pytest.mark.parametrize(
    ("fault", "column", "low", "high"),
    [
        ({"bias": 0.5}, "z_mean", 0.3, 0.7),
        ({"width": 0.8}, "z_sd", 1.15, 1.35),
        ({"width": 0.8}, "coverage_50", 0.3, 0.45),
        ({"width": 0.8}, "coverage_95", 0.85, 0.92),
        ({"width": 1.25}, "z_sd", 0.7, 0.87),
        ({"width": 1.25}, "shortfall", 0.05, 0.2),
    ],
)
def test_faults_show_in_their_output_alone(exact, fault, column, low, high):
    table = judged(validation(**fault))
    assert table.calibration_p[1] < 1e-4
    assert low < table[column][1] < high
    np.testing.assert_array_equal(table.iloc[[0, 2]], exact.iloc[[0, 2]])
    np.testing.assert_array_equal(table.calibration_p_reader, exact.calibration_p_reader)


def test_without_a_reader_its_column_is_unknown(exact):
    """And all others are as they were; the words leave it out."""
    table = quality(validation(), None, CONTRACTION, prior_sd=PRIOR_SD, log=LOG)
    assert table.columns.tolist() == exact.columns.tolist()
    assert table.calibration_p_reader.isna().all()
    assert table.calibrated_reader.isna().all()
    others = exact.columns.drop(["calibration_p_reader", "calibrated_reader"])
    pd.testing.assert_frame_equal(table[others], exact[others])
    assert "files" not in quality_words(table)


def test_logarithms_are_taken_where_they_are_said_to_be(exact):
    """Planted fault: judged in plain units, contraction is nonsense."""
    plain = quality(
        validation(), validation(seed=2), CONTRACTION, prior_sd=PRIOR_SD, log=np.zeros(3, bool)
    )
    assert (plain.contraction[:2] < -1).all()
    assert plain.contraction[2] == exact.contraction[2]


def test_words_name_the_worst_output_and_what_fails(exact):
    text = quality_words(exact)
    worst = exact.loc[exact.shortfall.idxmax()]
    assert f"{worst.shortfall:.3f} ({worst.output})" in text
    assert f"{exact.z_sd.min():.3f} to {exact.z_sd.max():.3f}" in text
    assert text.startswith(f"calibrated (smallest p {exact.calibration_p.min():.2g} of 3); through")
    wide, read = judged(validation(width=1.25)), judged(reader=validation(seed=2, bias=0.5))
    assert "(L)" in quality_words(wide)
    assert quality_words(wide).startswith("NOT calibrated: L (")
    assert "calibrated (" in quality_words(read)
    assert "through files NOT calibrated: L (" in quality_words(read)


def test_tables_figures_and_words_judge_alike():
    """One criterion: what leaves the band of all outputs together fails in the table."""
    data = validation(width=0.8)
    found = judge_draws(data.draws.values, data.truth.values)
    table = judged(data)
    np.testing.assert_array_equal(table.calibrated, ~found.outside)
    np.testing.assert_array_equal(table.calibration_p, found.p_values)
    assert found.words(NAMES).startswith("NOT calibrated: L outside the band")
