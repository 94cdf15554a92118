"""The page of two visits: a row for everything, and its words."""

import numpy as np
import pytest

from breaker.figures.visits import visits
from tests.figures.drawn import written


def row(name, change, verdict, **more):
    about = {"name": name, "unit": "mm", "motion": "", "kind": "parameter", "verdict": verdict}
    about |= {"before": [1.0, 2.0, 3.0], "today": [1.0, 2.0, 3.0], "change": change}
    return about | {"beyond": 0.3, "worse": None, "measured": None} | more


def document(rows):
    part = {"motions": ["closing"], "changes": rows}
    return {
        "headline": "Changed: $f$ a lot",
        "trust": ["closing: fits"],
        "settings": {"share": 0.05, "prior_beyond": 0.24},
        "records": {"closing": {"before": 1, "today": 2}},
        "comparisons": [part],
    }


@pytest.fixture
def figure():
    rows = [
        row("f", [-12.0, -10.0, -8.0], "changed", worse=0.9),
        row("mu", [-2.0, 0.0, 2.0], "not told"),
        row("wipe", [-90.0, -70.0, -60.0], "changed", kind="quantity"),
        row("stroke", [None] * 3, "not told", kind="quantity"),
        row(
            "touch_time",
            [1.0, 2.0, 3.0],
            "did not change",
            kind="quantity",
            measured={"change": [1.0, 2.5, 4.0]},
        ),
    ]
    return visits(document(rows))


def test_every_known_row_is_named_with_its_numbers(figure):
    left, _, right = figure.axes
    texts = written(left)
    assert "f (mm)" in texts
    assert "touch_time (mm)" in texts
    assert "stroke (mm)" not in texts
    assert "0.90" in written(right)
    assert r"Changed: \$f\$ a lot" in written(figure.subfigs[0])


def test_changes_beyond_the_axis_are_pointed_to(figure):
    axis = figure.axes[1]
    assert "-70 %" in written(axis)
    assert axis.get_xlim() == (-40.0, 40.0)
    crosses = [line for line in axis.lines if line.get_marker() == "x"]
    assert np.ravel([line.get_xdata() for line in crosses]).tolist() == [2.5]
