"""Copies count once, and files state one breaker and visits in their order."""

from dataclasses import replace

import numpy as np

from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.identity import doubts_about, visits_in_order, without_copies
from breaker.family.inputs import normalise_record
from breaker.records.header import Header
from breaker.records.operations import Operation
from tests.raws import raw_of

STEP = 0.05


def record(number=1, *, seed=None, phase="", **more):
    """A closing with noise, as it is read from a file of its own."""
    rng = np.random.default_rng([40, number if seed is None else seed])
    time = STEP * np.arange(2400)
    share = np.clip((time - 30.0) / 12.0, 0.0, 1.0)
    way = 14.0 * share**2 * (3.0 - 2.0 * share) + 0.05 * rng.standard_normal(time.size)
    return of(raw_of(way, STEP, 29.0), number, phase, **more)


def of(raw, number=1, phase="", date="", serial="", bay=""):
    """A record of samples."""
    operation = Operation(number, f"{number}{phase}.csv", phase=phase, date=date)
    shape, seen = normalise_record(raw)
    stated = Header(serial=serial, bay=bay)
    return DriveRecord(
        operation, "closing", stated, "", replace(raw, operation=operation), shape, seen
    )


def test_a_copy_counts_once_and_is_named():
    first, again = without_copies([record(1), record(2, seed=1)])
    assert not first.reason
    assert again.reason == "2.csv holds the same samples as 1.csv: they count once"


def test_operations_of_one_drive_are_no_copies():
    assert not any(each.reason for each in without_copies([record(n) for n in range(12)]))


def test_three_phases_of_the_same_samples_are_one():
    poles = [record(1, seed=7, phase=phase) for phase in "RYB"]
    reasons = [each.reason for each in without_copies(poles)]
    assert reasons[0] == ""
    assert all("they count once" in each for each in reasons[1:])


def test_breakers_that_files_state():
    assert len(doubts_about([record(1, serial="A"), record(2, serial="B")])) == 1
    poles = [record(n, serial=f"A{n}", phase=phase) for n, phase in enumerate("RYB")]
    assert doubts_about(poles) == []  # poles may have numbers of their own
    assert len(doubts_about([record(1, bay="E01"), record(2, bay="e02")])) == 1
    assert doubts_about([record(1, bay="E 01"), record(2, bay="e  01")]) == []


def test_a_visit_before_that_is_later():
    before, today = [record(1, date="2024-05-01")], [record(2, date="2019-03-02")]
    assert len(visits_in_order({"before": before, "today": today})) == 1
    assert visits_in_order({"before": today, "today": before}) == []
    assert visits_in_order({"before": [record(1)], "today": today}) == []


def test_a_type_in_two_spellings_is_one():
    types = [
        replace(record(n), stated=Header(type=name))
        for n, name in enumerate(("GL314", "GL 314", "gl-314"))
    ]
    assert doubts_about(types) == []
