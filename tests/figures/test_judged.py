"""The figure of judged rigs: marks where the tables say, sets and scales apart."""

import numpy as np
import pandas as pd
import pytest

from breaker.figures.judged import judged
from breaker.mechanism.parameters import NAMES
from tests.figures.drawn import assert_nothing_overlaps

FAULTS = ["closing damper halved", "2 ms of bounce", "nothing"]


def row(value, **place):
    return place | {"value": value, "lower_95": value - 0.1, "upper_95": value + 0.05, "n": 40}


def every(score, quantities, **place):
    return [
        row(0.9 if scale else 0.3, set=name, scale=scale, score=score, quantity=each, **place)
        for name in ("held_back", "foreign")
        for scale in (1.0, 0.0)
        for each in quantities
    ]


@pytest.fixture(scope="module")
def figure():
    lives = [
        *every("coverage, level", NAMES),
        *every("coverage, slope", NAMES),
        *every("coverage, remaining", [0.25, 0.5, 0.75]),
    ]
    faults = [row(0.2 * k, score="reported", quantity=name) for k, name in enumerate(FAULTS)]
    return judged(*(pd.DataFrame(rows) for rows in (lives, faults)))


def test_shares_are_where_the_tables_say(figure):
    for k, count in ((1, 7), (2, 7), (3, 3)):
        marks = [line for line in figure.axes[k].lines if line.get_marker() == "o"]
        assert len(marks) == 4
        for line, value in zip(marks, (90.0, 90.0, 30.0, 30.0), strict=True):
            np.testing.assert_allclose(line.get_ydata(), value)
            assert len(line.get_xdata()) == count
        empty = [line.get_markerfacecolor() == "white" for line in marks]
        assert empty == [False, False, True, True]  # as the scale is
    bars = [bar.get_width() for bar in figure.axes[0].patches if bar.get_height() < 1]
    np.testing.assert_allclose(bars, [0.0, 20.0, 40.0], atol=1e-9)
    assert_nothing_overlaps(figure)
