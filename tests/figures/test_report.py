"""Pages of a test report."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from breaker.documents.parts import Cell, Letterhead, Table
from breaker.drive.answers.picture_data import Marked, Panel
from breaker.drive.answers.reference_curve import Overlay
from breaker.drive.answers.test_report import Report
from breaker.figures.encoding import encoded
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
    return Report("Test report", plate, summary, [table] * motions, panels=panels)


@pytest.mark.parametrize("channels", [1, 3, 6])
def test_a_visit_has_few_pages_and_nothing_runs_out_of_them(channels):
    found = list(pages(report(channels)))
    assert len(found) <= 3
    for page in found:
        assert outside(page) == []
        assert_nothing_overlaps(page)
    assert sum(len(page.axes) for page in found) == 4


@pytest.mark.parametrize("channels", [1, 3])
def test_letters_of_tables_are_large(channels):
    first = next(iter(pages(report(channels))))
    cells = [each for each in first.texts if each.get_text() in ("travel_time", "142.25*", "FAIL")]
    assert len(cells) > 2 * channels
    assert min(each.get_fontsize() for each in cells) >= 9.0


def test_a_letterhead_has_its_logo_remarks_and_lines_to_sign():
    picture = Figure(figsize=(1.0, 0.4))
    logo = encoded([picture], "png")
    around = Letterhead("A $ company", logo, "After $5 overhaul", ["tested by: name, date"])
    with_it = replace(report(1), letterhead=around)
    found, without = list(pages(with_it)), list(pages(report(1)))
    first, last = found[0], found[-1]
    drawn = [sum(len(page.axes) for page in each) for each in (found, without)]
    assert drawn[0] == drawn[1] + 1  # the logo
    words = [text.get_text().replace("\\$", "$") for page in found for text in page.texts]
    assert {"A $ company", "After $5 overhaul", "tested by: name, date"} <= {*words}
    assert outside(first) == outside(last) == []


def test_a_long_table_goes_on_with_its_head():
    tables = list(pages(report(3, rows=100, motions=1)))
    assert sum(len(page.axes) for page in tables) == 2
    for page in tables:
        assert outside(page) == []
        heads = [text.get_text() for text in page.texts].count("measured")
        assert heads == 1 or (heads == 0 and page.axes)
    assert tables[0].texts[-1].get_text().endswith(f"page 1 of {len(tables)}")


def test_six_records_over_a_good_one_fit_their_figure():
    figure = overlay([over(f"unit {k}", leaves=(40.0, 9.0)) for k in range(6)])
    assert len(figure.axes) == 12
    assert_nothing_overlaps(figure)
