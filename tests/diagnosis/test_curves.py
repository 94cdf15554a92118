"""Figures of estimates: an answer, the curves of a report, and records over a good one."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.diagnosis.curves import Panel, overlaid
from breaker.diagnosis.estimate import Given
from breaker.figures import style
from breaker.figures.records import answer
from breaker.figures.reports import curves
from breaker.model.parameters import NAMES
from breaker.records.currents import Currents
from tests.figures.drawn import assert_drawn, line_of

NAME = "North_400_kV_Bay_4_circuit_breaker_Q0_closing_after_overhaul_of_drive_and_linkage.csv"


@pytest.mark.parametrize(
    ("places", "change"), [([0, 1, 2, 3], {}), ([0], {"misfit": True, "draws": None})]
)
def test_an_answer_has_each_motion_next_to_the_nearest_shape(answers, places, change):
    """A record that was rejected has none."""
    some = [replace(answers[k], **change) for k in places]
    figure = answer(some, Given().sample_prior(some[0], 200, np.random.default_rng(1)))
    assert_drawn(figure)
    columns = len({item.record.motion for item in some})
    assert len(figure.axes) == 2 * columns + len(NAMES) + 1
    for above, below in zip(figure.axes[:columns], figure.axes[columns:], strict=False):
        record, nearest, left = (
            line_of(axis, colour)
            for axis, colour in (
                (above, style.MEASURED),
                (above, style.CHANGED),
                (below, style.MEASURED),
            )
        )
        there = np.isfinite(left.get_ydata())
        travel = np.interp(nearest.get_xdata(), record.get_xdata(), record.get_ydata())
        np.testing.assert_allclose(travel[there], nearest.get_ydata()[there], atol=0.5)
        assert np.abs(left.get_ydata()[there]).max() < 0.3


def channel(estimate, phase, kinds=(), size=np.nan, **change):
    """The estimate of a channel with other columns beside it, of a unit of a size, in a file of a
    long name.
    """
    operation = replace(estimate.record.operation, phase=phase, file=NAME)
    raw = estimate.record.raw
    channels = dict.fromkeys(kinds, raw.sure), dict.fromkeys(kinds, size)
    raw = replace(raw, currents=Currents(raw.time, *channels), **change)
    return replace(estimate, record=replace(estimate.record, operation=operation, raw=raw))


def panel(estimates, good=()):
    records = [estimate.record for estimate in estimates]
    return Panel(NAME, estimates, overlaid(records, [item.record for item in good]))


@pytest.mark.parametrize("channels", [1, 6])
def test_pictures_have_all_channels_in_panels_of_60_mm(answers, channels):
    phases = [f"travel of the interrupter unit $ {k}" for k in range(channels)]
    some = [channel(answers[0], phase, ["trigger", "contact"], 1.0) for phase in phases]
    pictures = [*curves([panel(some, good=some)])]
    assert len(pictures) == 4  # travel, resistance, coil, difference
    for figure in pictures:
        assert_drawn(figure)
        (axis,) = figure.axes
        texts = [*figure.legends[0].get_texts(), axis.xaxis.label, axis.yaxis.label]
        assert min(text.get_fontsize() for text in [*texts, *axis.get_yticklabels()]) >= 9.0
        assert figure.get_figwidth() <= 180.0 / 25.4  # between the margins of a page
        assert axis.get_position().height * figure.get_figheight() >= 60.0 / 25.4
