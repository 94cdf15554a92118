"""Pages of a test report."""

import numpy as np
import pytest

from breaker.documents.parts import Cell, Table
from breaker.drive.answers.picture_data import Marked, Panel
from breaker.drive.answers.reference_curve import Overlay
from breaker.drive.answers.test_report import Report
from breaker.figures.overlay import overlay
from breaker.figures.report import pages
from tests.figures.drawn import assert_nothing_overlaps

NAME = "North_400_kV_Bay_4_circuit_breaker_Q0_closing_after_overhaul_of_drive_and_linkage.csv"
TIME = np.linspace(0.0, 100.0, 201)
WAY = 178.0 * np.clip((TIME - 20.0) / 50.0, 0.0, 1.0)


def outside(figure):
    """Texts that run out of a page."""
    page = figure.bbox
    found = [(text.get_text(), text.get_window_extent()) for text in figure.texts]
    return [t for t, box in found if box.x0 < page.x0 or box.x1 > page.x1 or box.y0 < page.y0]


def over(phase, *, leaves=None):
    about = 1, "closing", phase, NAME, f"visits/{NAME}"
    return Overlay(*about, TIME - 20.0, WAY, 0.97 * WAY, 8.9, 0.05, leaves, (60.0, 9.3))


def report(channels, rows=8, motions=2):
    """A report of long names."""
    phases = [f"travel of the interrupter unit {k}" for k in range(channels)]
    head = ("measured", "unit", *phases, "limit", "result")
    row = ("travel_time", "ms", *["142.25*"] * channels, "≥ 178.2", "FAIL")
    table = Table(head, [row] * rows, f"closing: {NAME}", ["a note that is not short $ " * 12])
    about = (20.0, 0.0), (60.0, 150.0), False, (0.0, 178.0), [(30.0, 40.0)]
    curves = [Marked(phase, TIME, WAY, *about) for phase in phases]
    overlays = [over(phase, leaves=(40.0, 9.0)) for phase in phases]
    panels = [Panel(f"closing: {NAME}", "closing", curves, overlays)] * motions
    plate = [("Breaker", NAME), ("Test date", "2021-03-14"), ("Files", ""), ("Odd", "$5")]
    summary = [Cell("WARNING: another bay", "bad"), Cell("FAIL: slow", "bad")]
    return Report("Test report", plate, summary, [table] * motions, panels)


@pytest.mark.parametrize("channels", [1, 3, 6])
def test_a_visit_has_two_pages_and_nothing_runs_out_of_them(channels):
    first, second = pages(report(channels))
    assert outside(first) == outside(second) == []
    assert_nothing_overlaps(second)
    assert len(second.axes) == 4


def test_a_long_table_goes_on_with_its_head():
    tables = list(pages(report(3, rows=100, motions=1)))
    assert [len(page.axes) for page in tables] == [0, 2]  # the curve has room below the rest
    for page in tables:
        assert outside(page) == []
        assert [text.get_text() for text in page.texts].count("measured") == 1
    assert tables[0].texts[-1].get_text().endswith("page 1 of 2")


def test_six_records_over_a_good_one_fit_their_figure():
    figure = overlay([over(f"unit {k}", leaves=(40.0, 9.0)) for k in range(6)])
    assert len(figure.axes) == 12
    assert_nothing_overlaps(figure)
