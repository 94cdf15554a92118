"""Dates and times in names and cells."""

from datetime import datetime

import pytest

from breaker.records.dates import moments
from breaker.records.operations import iso_date

WHEN = datetime(2024, 11, 20, 15, 13, 7)


@pytest.mark.parametrize(
    "text",
    [
        "closing_20-11-2024_15-13-07",
        "2024-11-20T15-13-07_closing",
        "20241120T151307",
        "20241120151307",
        "x_20.11.2024 15.13.07",
        "11-20-2024_15-13-07",
        "20-Nov-2024_151307",
        "2024_11_20__15_13_07",
        "20-11-24_15-13-07",
        "20.11.2024 15h13m07s",
    ],
)
def test_a_date_with_a_time_is_found_in_a_name(text):
    assert [each.when for each in moments(text)] == [WHEN]


def test_a_date_without_a_time_is_no_time():
    (found,) = moments("op_0007_2024-11-20_closing")
    assert found.when == datetime(2024, 11, 20)


@pytest.mark.parametrize("text", ["op_0007", "10kHz_7", "32-13-2024x", "2024", "99-99-99"])
def test_other_numbers_are_no_dates(text):
    assert moments(text) == []


@pytest.mark.parametrize(
    ("text", "iso"),
    [
        ("2024-11-20", "2024-11-20"),
        ("2024-11-20T15:13", "2024-11-20T15:13:00"),
        ("2024-11-20 15:13:07.5", "2024-11-20T15:13:07.500000"),
        ("2024-11-20T15:13:07+01:00", "2024-11-20T15:13:07+01:00"),
        ("2024-11-20T15:13:07Z", "2024-11-20T15:13:07+00:00"),
        ("20.11.2024", "2024-11-20"),
        ("20.11.2024 15:13:07", "2024-11-20T15:13:07"),
    ],
)
def test_dates_of_cells_become_iso(text, iso):
    assert iso_date(text) == iso


@pytest.mark.parametrize(
    "text",
    [
        "11/20/2024",
        "20.11.24",
        "2024-13-01",
        "2024-02-30",
        "20241120",
        "2024-11-20T25:00",
        "today",
        "٢٠٢٤-11-20",
        "2024-W47-3",
        "",
    ],
)
def test_other_dates_are_refused(text):
    with pytest.raises(ValueError, match="is no date"):
        iso_date(text)
