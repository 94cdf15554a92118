"""The figure of the sensitivity: every interval, p-value and probability where it is."""

import numpy as np
import pandas as pd
import pytest

from breaker.figures import style
from breaker.figures.sensitivity import sensitivity
from breaker.mechanism import NAMES
from tests.figures.drawn import assert_nothing_overlaps, segments, words

SCALES, OPERATIONS = (0.0, 1.0), (1, 40, 2000)


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(1)
    rows = []
    for scale in SCALES:
        for operation in OPERATIONS:
            of_operation = {
                "scale": scale,
                "operation": operation,
                "p_value": 0.3 if scale else 1e-20,
                "resolved": not (scale == 0 and operation == 40),
            }
            for name in (*NAMES, "onset"):
                lower, middle, upper = np.sort(rng.normal(size=3))
                z = {"lower_z": lower, "median_z": middle, "upper_z": upper}
                rows.append({**of_operation, "kind": "parameter", "name": name, **z})
            limit = {"kind": "limit", "name": "slow_closing", "probability": rng.random()}
            rows.append({**of_operation, **limit})
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def figure(table):
    return sensitivity(table, motion="closing", misfit_p_value=1e-3)


def marks(axis):
    """Places ``(n, 2)`` of all marks of a panel."""
    lines = [line for line in axis.lines if line.get_marker() not in ("None", None)]
    return np.concatenate([line.get_xydata() for line in lines])


def test_every_value_is_drawn_in_its_place(table, figure):
    panels = {axis.get_title("left").split("   ")[0]: axis for axis in figure.axes}
    assert len(panels) == 7 + 1 + 1
    for name in NAMES:
        axis, rows = panels[style.parameter(name).symbol], table[table.name == name]
        ends = np.concatenate(
            [each[..., 1] for each in (np.array(c.get_segments()) for c in axis.collections)]
        )
        np.testing.assert_allclose(np.sort(ends, axis=0), np.sort(rows[["lower_z", "upper_z"]], 0))
        np.testing.assert_allclose(np.sort(marks(axis)[:, 1]), np.sort(rows.median_z))
        assert (np.abs(marks(axis)[:, 0] - np.round(marks(axis)[:, 0])) < 0.4).all()
    limit = table[table.kind == "limit"]
    drawn = marks(panels["limit: slow_closing"])[:, 1]
    np.testing.assert_allclose(np.sort(drawn), np.sort(limit.probability))
    p_values = marks(panels["does the record fit?"])[:, 1]
    assert set(p_values) == {1e-12, 0.3}  # the smallest at the foot
    assert figure.axes[0].get_xticklabels()[1].get_text() == "40"


def test_what_is_not_resolved_is_empty_and_said(figure):
    faces = [line.get_markerfacecolor() for line in figure.axes[0].lines if len(line.get_xdata())]
    assert "white" in faces
    text = words(figure)
    for part in ("s = 0: the model is right", "s = 1", "not resolved", "misfit below"):
        assert part in text
    assert_nothing_overlaps(figure)


def test_the_truth_is_a_line_at_each_operation(table):
    truth = {(operation, name): 0.1 * i for i, name in enumerate(NAMES) for operation in OPERATIONS}
    keys = zip(table.operation, table.name, strict=True)
    known = table.assign(truth_z=[truth.get(key, np.nan) for key in keys])
    figure = sensitivity(known, motion="closing", misfit_p_value=1e-3)
    (lines,) = segments(figure.axes[3], style.MEASURED)
    np.testing.assert_allclose(lines[:, 0, 1], 0.3)
    np.testing.assert_allclose(lines[..., 0].mean(axis=1), [0, 1, 2])
    assert "truth of the stand-in" in words(figure)
    assert_nothing_overlaps(figure)


def test_one_scale_alone(table):
    """As in the paper's setting: no error, all resolved."""
    one = table[(table.scale == 1.0)]
    text = words(sensitivity(one, motion="opening", misfit_p_value=1e-3))
    assert "not resolved" not in text
    assert text.startswith("Opening: how conclusions move")
