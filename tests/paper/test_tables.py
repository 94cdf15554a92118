"""Tables of the quality, of drives and of families, on posteriors known in closed form."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.paper.calibration import judge_draws
from breaker.paper.validation import (
    family_quality,
    quality,
    with_width,
)
from tests.paper.made import exact_posteriors

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
    return dataset(
        NAMES, *exact_posteriors(generator(seed, "test quality"), N, D, **known, **fault)
    )


def dataset(names, draws, truth):
    """Normal draws and truths as parameters, but for the last output, which is a time."""
    both = {"draws": (("curve", "draw", "output"), draws), "truth": (("curve", "output"), truth)}
    units = {key: (dims, np.where(LOG, 10 * np.exp(a), a)) for key, (dims, a) in both.items()}
    return xr.Dataset(units, {"output": names})


def judged(data=None, reader=None):
    data = validation() if data is None else data
    reader = validation(seed=2) if reader is None else reader
    return quality(data, reader, CONTRACTION, prior_sd=PRIOR_SD, log=LOG)


@pytest.fixture(scope="module")
def exact():
    return judged()


@pytest.mark.parametrize(
    ("fault", "bounds"),
    [
        ({"bias": 0.5}, {"z_mean": (0.3, 0.7)}),
        (
            {"width": 0.8},
            {"z_sd": (1.15, 1.35), "coverage_50": (0.3, 0.45), "coverage_95": (0.85, 0.92)},
        ),
        ({"width": 1.25}, {"z_sd": (0.7, 0.87), "shortfall": (0.05, 0.2)}),
    ],
)
def test_faults_show_in_their_output_alone(exact, fault, bounds):
    table = judged(validation(**fault))
    assert table.calibration_p[1] < 1e-4
    for column, (low, high) in bounds.items():
        assert low < table[column][1] < high
    np.testing.assert_array_equal(table.iloc[[0, 2]], exact.iloc[[0, 2]])
    np.testing.assert_array_equal(table.calibration_p_reader, exact.calibration_p_reader)


def test_without_a_reader_its_column_is_unknown(exact):
    """And all others are as they were."""
    table = quality(validation(), None, CONTRACTION, prior_sd=PRIOR_SD, log=LOG)
    assert table.columns.tolist() == exact.columns.tolist()
    assert table.calibration_p_reader.isna().all()
    assert table.calibrated_reader.isna().all()
    others = exact.columns.drop(["calibration_p_reader", "calibrated_reader"])
    pd.testing.assert_frame_equal(table[others], exact[others])


def test_tables_and_figures_judge_by_one_criterion():
    """What leaves the band of all outputs together fails in the table."""
    data = validation(width=0.8)
    judgement = judge_draws(data.draws.values, data.truth.values)
    table = judged(data)
    assert table.output.tolist() == NAMES
    np.testing.assert_allclose(table.shortfall, CONTRACTION - table.contraction, atol=1e-15)
    np.testing.assert_array_equal(table.calibrated, ~judgement.outside)
    np.testing.assert_array_equal(table.calibration_p, judgement.p_values)
    assert judgement.outside.tolist() == [False, True, False]


# ---- networks of a family ------------------------------------------------------------------------


def held_out(**fault):
    """Posteriors of 1,000 drives, whose variance is half of the prior's, which is one."""
    known = {"prior_sd": np.ones(3), "contraction": np.full(3, 0.5)}
    both = exact_posteriors(generator(3, "test family"), 1000, 200, **known, **fault)
    return dataset(["f", "L", "later closing"], *both)


def test_right_posteriors_of_a_family_pass():
    """All outputs inside the band at 99 %, seed fixed: false alarm 1e-2 once, never again."""
    table = family_quality(held_out(), log=True)
    assert table.calibrated.all()
    # 90 % of 1,000: beyond 0.033 from it with a probability of 5e-4 in each of three.
    assert (abs(table.coverage_90 - 0.9) < 0.033).all()
    assert table.contraction.to_numpy() == pytest.approx(0.5, abs=0.1)
    assert table.half_width.to_numpy() == pytest.approx(1.645 * np.sqrt(0.5), rel=0.05)


@pytest.mark.parametrize("fault", [{"width": 0.8}, {"bias": 0.4}])
def test_wrong_posteriors_of_a_family_are_noticed(fault):
    assert not family_quality(held_out(**fault), log=True).calibrated.any()


def test_draws_that_are_all_the_same_have_no_score():
    """As of an unresolved record, of which one weight has all of the sum."""
    data = validation()
    draws = data.draws.values.copy()
    draws[:3] = draws[:3, :1]
    some = data.assign(draws=(data.draws.dims, draws))
    assert with_width(some).sizes["curve"] == N - 3
    table, usual = judged(some), judged(data)
    assert table.z_sd.to_numpy() == pytest.approx(usual.z_sd.to_numpy(), rel=0.02)
    assert with_width(data).identical(data)
    with pytest.raises(ValueError, match="no width"):
        judged(data.isel(curve=slice(0, 3)).assign(draws=(data.draws.dims, draws[:3])))
