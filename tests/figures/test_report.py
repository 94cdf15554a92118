"""Curves of a test report, and records over a good one."""

import numpy as np
import pytest

from breaker.diagnosis.curves import Marked, Overlay, Panel
from breaker.figures.records import overlay
from breaker.figures.reports import curves
from tests.figures.drawn import assert_drawn

NAME = "North_400_kV_Bay_4_circuit_breaker_Q0_closing_after_overhaul_of_drive_and_linkage.csv"
TIME = np.linspace(0.0, 100.0, 201)
WAY = 178.0 * np.clip((TIME - 20.0) / 50.0, 0.0, 1.0)


def over(phase, *, leaves=None):
    about = 1, "closing", phase, NAME, f"visits/{NAME}"
    return Overlay(*about, TIME - 20.0, WAY, 0.97 * WAY, 8.9, 0.05, leaves, (60.0, 9.3))


def panel(phases, *, timed=False, overlays=(), **beside):
    """A closing of some channels, its file of a long name."""
    about = (20.0, 0.0), (60.0, 150.0), timed, (0.0, 178.0), [(30.0, 40.0)], beside
    channels = [Marked(phase, TIME, WAY, *about) for phase in phases]
    return Panel(f"closing: {NAME}", "closing", channels, list(overlays))


def keys(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.parametrize("channels", [1, 3, 6])
def test_a_picture_has_all_channels(channels):
    phases = [f"travel of the interrupter unit $ {k}" for k in range(channels)]
    over_good = [over(phase, leaves=(40.0, 9.0)) for phase in phases]
    (figure,) = curves([panel(phases, overlays=over_good, trigger=WAY / 178.0)])
    assert len(figure.axes) == 3
    assert_drawn(figure)


def test_a_channel_has_the_same_colour_in_every_picture():
    first, second = curves([panel(["R", "S"]), panel(["S"])])
    assert len(first.axes) == len(second.axes) == 1
    _, colour = (each.get_color() for each in first.legends[0].get_lines()[:2])
    assert second.legends[0].get_lines()[0].get_color() == colour


def test_the_legend_names_what_is_drawn_and_no_more():
    (bare,) = curves([panel([""])])
    (more,) = curves([panel([""], timed=True, overlays=[over("")], contact=WAY, trigger=WAY)])
    assert len({*keys(bare)}) == 5  # channel, motion, touch, points, rests
    assert len({*keys(more)} - {*keys(bare)}) == 4  # touch as measured, contact, coil, reference


def test_letters_of_a_picture_are_printed_in_9_pt_at_least():
    (figure,) = curves([panel(["R"], overlays=[over("R")])])
    texts = [*figure.legends[0].get_texts()]
    for axis in figure.axes:
        texts += [axis.xaxis.label, axis.yaxis.label, *axis.get_yticklabels()]
    assert min(each.get_fontsize() for each in texts) >= 9.0
    assert figure.get_figwidth() <= 180.0 / 25.4  # between the margins of a page


def test_six_records_over_a_good_one_have_two_panels_each():
    figure = overlay([over(f"unit {k}", leaves=(40.0, 9.0)) for k in range(6)])
    assert len(figure.axes) == 12
    assert_drawn(figure)
