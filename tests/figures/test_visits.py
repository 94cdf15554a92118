"""The page of two visits: measured first, a row for everything, and its words."""

import numpy as np

from breaker.figures.visits import visits
from tests.figures.drawn import written


def row(name, change, verdict, kind="parameter", motion="", **more):
    about = {"name": name, "unit": "mm", "meaning": f"a {kind}", "motion": motion, "kind": kind}
    about |= {"verdict": verdict, "change": change, "unchanged": 0.4, "beyond": 0.3, "worse": None}
    if kind == "measured":
        about |= {"before": 100.0, "today": 101.5, "unchanged": None}
    return about | more


def drawn(parameters="told"):
    measured = [row("stroke", [1.0, 1.5, 2.0], "did not change", "measured", "closing")]
    inferred = [
        row("f", [-12.0, -10.0, -8.0], "changed", worse=0.9),
        row("mu", [-2.0, 0.0, 2.0], "not told"),
        row("touch_time", [-90.0, -70.0, -60.0], "changed", "time", "closing"),
    ]
    return visits(
        {
            "warnings": [],
            "headline": "Measured: no change\nChanged: $f$ a lot",
            "trust": ["drives look alike"],
            "parameters": parameters,
            "settings": {"share": 0.05},
            "records": {"closing": {"before": 1, "today": 2}},
            "changes": measured + (inferred if parameters == "told" else []),
        }
    )


def test_measured_rows_come_first_with_values_and_inferred_ones_with_probabilities():
    figure = drawn()
    left, middle, right = figure.axes
    texts = {text.get_text(): text.get_position()[1] for text in left.texts}
    assert texts["measured"] < texts["stroke, closing (mm)"] < texts["inferred"] < texts["f"]
    assert texts["100"] == texts["101.5"] == texts["stroke, closing (mm)"]
    assert {"mu", "a parameter", "touch_time, closing"} <= texts.keys()
    assert written(right).count("0.40") == 3
    assert "0.90" in written(right)
    assert "Measured: no change\nChanged: \\$f\\$ a lot" in written(figure.subfigs[0])
    # A change beyond the axis is pointed to.
    assert "-70 %" in written(middle)
    assert middle.get_xlim() == (-40.0, 40.0)
    squares = [line.get_xdata() for line in middle.lines if line.get_marker() == "s"]
    assert np.ravel(squares).tolist() == [1.5]


def test_withheld_parameters_are_said_to_be_so():
    left, *_ = drawn("withheld").axes
    assert "parameters are withheld: the drive is of no family that ships" in written(left)
