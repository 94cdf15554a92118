"""The figure of detectors: lines, the ring of the model, names beside their lines."""

import numpy as np
import pandas as pd
import pytest

from breaker.figures.detectors import detectors
from tests.figures.drawn import assert_nothing_overlaps, written

RATES = np.array([0.0, 0.5, 1.0, 2.0, 4.0])
NAMES = ("model", "CUSUM, closing", "EWMA, opening", "multivariate EWMA", "slope test")


def table(names=NAMES, never=()):
    rows = [
        {
            "detector": name,
            "level": level,
            "false_alarms": rate,
            "found_from_5": 0.9 - 0.1 * i + 0.01 * rate,
            "found_3_to_5": 0.5 - 0.1 * i + 0.01 * rate,
            "delay_from_5": np.inf if name in never else 30.0 * (1 + i) - rate,
        }
        for i, name in enumerate(names)
        for rate, level in zip(RATES, (0.999, 0.97, 0.9, 0.7, 0.5), strict=True)
    ]
    return pd.DataFrame(rows)


def test_lines_ring_and_names():
    data = table()
    figure = detectors(data, lives=50, alarm_level=0.9)
    assert_nothing_overlaps(figure)
    assert "50 simulated lives" in figure.get_suptitle()
    names = written(figure.axes[2])
    assert names == ["model", "raw times,\nseveral charts", "multivariate EWMA", "slope test"]
    found, weak, delay = figure.axes
    for axis, column, unit in (
        (found, "found_from_5", 100),
        (weak, "found_3_to_5", 100),
        (delay, "delay_from_5", 1),
    ):
        *lines, ring = axis.lines
        assert len(lines) == len(NAMES)
        for line, (_, rows) in zip(lines, data.groupby("detector", sort=False), strict=True):
            np.testing.assert_array_equal(line.get_xdata(), RATES)
            np.testing.assert_allclose(line.get_ydata(), unit * rows[column])
        own = data[(data.detector == "model") & (data.level == 0.9)]
        assert ring.get_xdata() == own.false_alarms.values
        np.testing.assert_allclose(ring.get_ydata(), unit * own[column])


def test_what_is_never_noticed_has_no_delay_and_its_name_on_top():
    figure = detectors(table(never=("slope test", "EWMA, opening")), lives=5, alarm_level=0.9)
    assert np.isnan(figure.axes[2].lines[4].get_ydata()).all()
    assert written(figure.axes[2])[-2:] == ["slope test", "raw times,\nseveral charts"]
    assert_nothing_overlaps(figure)


def test_more_detectors_than_markers_are_refused():
    with pytest.raises(ValueError, match="markers for 4 detectors, not 5"):
        detectors(table(("model", *"abcde")), lives=5, alarm_level=0.9)
