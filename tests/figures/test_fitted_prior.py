"""The figure of a fitted prior: a panel for each parameter, with its breakers."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures import style
from breaker.figures.fitted_prior import fitted_prior
from breaker.mechanism.parameters import NAMES
from tests.figures.drawn import assert_nothing_overlaps, line_of, segments, words

MEDIANS = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])


def data_of(breakers):
    middle = MEDIANS * np.exp(0.05 * np.arange(breakers))[:, None]
    return xr.Dataset(
        {
            "median": (("kind", "parameter"), np.array([1.1 * MEDIANS, MEDIANS])),
            "log_sd": (("kind", "parameter"), np.full((2, 7), 0.1)),
            "low": (("breaker", "parameter"), 0.9 * middle),
            "middle": (("breaker", "parameter"), middle),
            "high": (("breaker", "parameter"), 1.1 * middle),
        },
        {
            "kind": ["fitted", "default"],
            "breaker": [f"Q{i}" for i in range(breakers)],
            "parameter": list(NAMES),
        },
    )


@pytest.mark.parametrize("breakers", [1, 3, 40])
def test_nothing_overlaps(breakers):
    figure = fitted_prior(data_of(breakers))
    assert len(figure.axes) == len(NAMES)
    assert_nothing_overlaps(figure)


def test_marks_are_where_the_data_are():
    data = data_of(3)
    figure = fitted_prior(data)
    gap = figure.axes[-1]
    (intervals,) = segments(gap, style.MODEL)
    np.testing.assert_allclose(intervals[:, 0, 0], data.low.sel(parameter="L"))
    np.testing.assert_allclose(intervals[:, 1, 0], data.high.sel(parameter="L"))
    default = line_of(gap, style.PRIOR)
    assert default.get_xdata()[default.get_ydata().argmax()] == pytest.approx(10.0, rel=0.01)
    assert [tick.get_text() for tick in gap.get_yticklabels()] == ["Q0", "Q1", "Q2"]
    assert "L$ (mm)" in words(figure)
    assert "from 3 breakers" in words(figure)
