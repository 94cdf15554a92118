"""Dates of cells and names, and phases in names."""

from pathlib import Path

import pytest

from breaker.records.dates import cell_date, dates_of, earlier, one_date
from breaker.records.words import phases_in_names

STAMPS = ["closing_20-11-2024_15-13-07", "20241120T151307", "x_20.11.2024 15.13.07"]
STAMPS += ["11-20-2024_15-13-07", "2024_11_20__15_13_07", "20-11-2024_0007"]
NONE = ["op_0007", "10kHz_7", "2024", "99-99-2024", "20-11-24", "2024-11-20_to_2024-11-21"]


def test_dates_in_names():
    assert [{*dates_of(e).values()} for e in STAMPS] == [{"2024-11-20"}] * len(STAMPS)
    assert [item for item in NONE if dates_of(item)] == []


@pytest.mark.parametrize(
    ("text", "iso"),
    [
        ("2024-11-20 15:13:07.5", "2024-11-20T15:13:07"),
        ("2024-11-20T15:13:07+01:00", "2024-11-20T15:13:07+01:00"),
        ("3.4.2024 15:13:07", "2024-04-03T15:13:07"),
        ("11/20/2024 3:13 PM", "2024-11-20T15:13:00"),
        ("04/04/2024", "2024-04-04"),
    ],
)
def test_dates_of_cells_become_iso(text, iso):
    assert cell_date(text) == iso


@pytest.mark.parametrize(
    "text",
    [
        *("20.11.24", "2024-13-01", "2024-02-30", "x 20.11.2024", "2024-11-20T25:00", "today"),
        *("٢٠٢٤-11-20", "2024-W47-3", "", "03/04/2024", "31/31/2024", "20.11.2024 25:00", "12"),
    ],
)
def test_other_dates_are_refused(text):
    with pytest.raises(ValueError, match="2024-11-20T15:13:07"):
        cell_date(text)


def test_the_table_goes_before_the_header_and_the_header_before_the_name():
    name, either = "x_20-11-2024_15-13.csv", ("2024-04-03", "2024-03-04")
    assert one_date("2024-01-01", ("2024-01-02",), name) == "2024-01-01"
    assert one_date("", ("2024-01-02",), name) == "2024-01-02"
    assert one_date("", (), name) == "2024-11-20"
    assert one_date("", either, name) == one_date("", (), "3-4-2024.csv") == ""


def test_only_another_day_is_earlier():
    summer, winter = "2024-10-27T02:50:00+02:00", "2024-10-27T02:10:00+01:00"
    assert not earlier(summer, winter)
    assert earlier("2024-10-28", "2024-10-27T11:00:00")
    assert not any(earlier(*days) for days in (("2024-10-27T11", "2024-10-28"), ("2024-10-27", "")))


# ---- phases

PHASES = {
    "108-R 24-12-2020|108-Y 24-12-2020|108-B 24-12-2020": "R|Y|B",
    "108-R-1|108-R-2|108-Y-1|108-Y-2": "R|R|Y|Y",  # a counter
    "R-1 CT|R-2 CT|X-1 CT": "",
}


@pytest.mark.parametrize(("stems", "phases"), PHASES.items())
def test_names_that_differ_in_a_phase_state_it(stems, phases):
    result = phases_in_names(map(Path, stems.split("|")))
    assert "|".join(result.values()) == phases
