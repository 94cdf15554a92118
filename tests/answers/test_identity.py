"""Copies count once, records of two drives have no common mean, dates and phases are in order."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.drive.answers.evidence import DriveRecord
from breaker.drive.answers.identity import (
    doubts_about,
    mixed,
    swapped,
    visits_in_order,
    without_copies,
)
from breaker.drive.family.record_inputs import normalise_record
from breaker.reading.files.operations_table import Operation
from breaker.reading.files.preamble import Preamble
from tests.raws import raw_of

STEP = 0.05


def record(number=1, *, stroke=14.0, slow=1.0, seed=None, phase="", **more):
    """A closing with noise, as it is read from a file of its own."""
    rng = np.random.default_rng([40, number if seed is None else seed])
    time = STEP * np.arange(2400)
    share = np.clip((time - 30.0) / (12.0 * slow), 0.0, 1.0)
    way = stroke * share**2 * (3.0 - 2.0 * share) + 0.05 * rng.standard_normal(time.size)
    return of(raw_of(way, STEP, 29.0), number, phase, **more)


def of(raw, number=1, phase="", date="", serial="", bay=""):
    """A record of samples."""
    operation = Operation(number, f"{number}{phase}.csv", phase=phase, date=date)
    shape, seen = normalise_record(raw)
    stated = Preamble(serial=serial, bay=bay)
    return DriveRecord(
        operation, "closing", stated, "", replace(raw, operation=operation), shape, seen
    )


def exported(one, change):
    """The samples of a record, as a change makes them."""
    way, step, late = change(one.raw.whole)
    return of(raw_of(way, step, one.raw.moves - late), 2)


EXPORTS = {
    "same": lambda way: (way, STEP, 0.0),
    "decimals": lambda way: (way.round(2), STEP, 0.0),
    "zero": lambda way: (way + 3.0, STEP, 0.0),
    "cut": lambda way: (way[200:2000], STEP, 200 * STEP),
    "every second": lambda way: (way[::2], 2 * STEP, 0.0),
    "all of it": lambda way: (0.5 + way[101::2].round(2), 2 * STEP, 101 * STEP),
}


@pytest.mark.parametrize("change", EXPORTS)
def test_a_copy_counts_once_and_is_named(change):
    one = record()
    first, again = without_copies([one, exported(one, EXPORTS[change])])
    assert not first.reason
    assert again.reason == "2.csv holds the same samples as 1.csv: they count once"


def test_operations_of_one_drive_are_no_copies():
    """Of 60 pairs, none: each differs by the noise of both, 2.5 times as much as a copy may."""
    assert not any(each.reason for each in without_copies([record(n) for n in range(12)]))


def test_three_phases_of_the_same_samples_are_one():
    poles = [record(1, seed=7, phase=phase) for phase in "RYB"]
    reasons = [each.reason for each in without_copies(poles)]
    assert reasons[0] == ""
    assert all("they count once" in each for each in reasons[1:])


@pytest.mark.parametrize("other", [{"stroke": 15.7}, {"stroke": 14.4}, {"slow": 1.06}])
def test_records_of_two_drives_are_said(other):
    some = [record(n, **(other if n % 2 else {})) for n in range(6)]
    (said,) = mixed(some).values()
    assert "They are not averaged" in said
    assert said in doubts_about(some)


def test_operations_of_one_drive_are_not_mixed():
    """Scatter of 0.4 %, 300 visits: neighbours that are 1.8 % and five times as far apart as others
    are 4.5 sds apart, 7e-6 a pair."""
    rng = np.random.default_rng(3)
    for number in range(300):
        scatter = 1.0 + 0.004 * rng.standard_normal((4, 2))
        some = [
            record(10 * number + n, stroke=14.0 * a, slow=b) for n, (a, b) in enumerate(scatter)
        ]
        assert mixed(some) == {}


def test_dates_that_fall_while_numbers_rise():
    some = [record(1, date="2024-05-01"), record(2, date="2023-05-01T10:00:00")]
    (said,) = doubts_about(some)
    assert "the date of 2.csv, operation 2, 2023-05-01T10:00:00, is earlier than that" in said
    assert doubts_about([record(1, date="2024-05-01T12:00:00"), record(2, date="2024-05-01")]) == []


def test_breakers_that_files_state():
    assert (
        "serial numbers: 'A' in 1.csv and 'B' in 2.csv"
        in doubts_about([record(1, serial="A"), record(2, serial="B")])[0]
    )
    poles = [record(n, serial=f"A{n}", phase=phase) for n, phase in enumerate("RYB")]
    assert doubts_about(poles) == []  # poles may have numbers of their own
    assert len(doubts_about([record(1, bay="E01"), record(2, bay="e02")])) == 1
    assert doubts_about([record(1, bay="E 01"), record(2, bay="e  01")]) == []


def test_a_visit_before_that_is_later():
    before, today = [record(1, date="2024-05-01")], [record(2, date="2019-03-02")]
    (said,) = visits_in_order({"before": before, "today": today})
    assert "earlier than those of the visit before" in said
    assert visits_in_order({"before": today, "today": before}) == []
    assert visits_in_order({"before": [record(1)], "today": today}) == []


def test_swapped_phases_are_said_where_they_explain_what_differs():
    slow = {"R": 1.0, "Y": 1.065, "B": 1.03}
    before = [record(n, slow=slow[p], phase=p) for n, p in enumerate(slow)]
    crossed = {"R": "Y", "Y": "R", "B": "B"}
    today = [record(10 + n, slow=slow[crossed[p]], phase=p) for n, p in enumerate(slow)]
    said = swapped(before, today)
    assert "R of today looks like Y of before" in said
    assert "Y of today looks like R of before" in said
    assert (
        swapped(before, [record(20 + n, slow=slow[p], phase=p) for n, p in enumerate(slow)]) == ""
    )
    worn = [record(30 + n, slow=1.04 * slow[p], phase=p) for n, p in enumerate(slow)]
    assert swapped(before, worn) == ""


def test_files_that_are_numbered_by_their_place_alone_have_no_order():
    first, second = (record(n, date="") for n in (1, 2))
    named = [
        replace(each, operation=replace(each.operation, file=file), stated=Preamble(dates=(date,)))
        for each, file, date in (
            (first, "b.csv", "2024-05-01"),
            (second, "a.csv", "2019-05-01"),
        )
    ]
    assert doubts_about(named) == []
    numbered = [
        replace(each, operation=replace(each.operation, file=f"op_{each.operation.number:04}.csv"))
        for each in named
    ]
    assert len(doubts_about(numbered)) == 1


def test_a_type_in_two_spellings_is_one():
    types = [
        replace(record(n), stated=Preamble(type=name))
        for n, name in enumerate(("GL314", "GL 314", "gl-314"))
    ]
    assert doubts_about(types) == []
