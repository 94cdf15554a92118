"""Statements of files: copies, breakers, dates, phases, and poles of one operation."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.identity import (
    check_phases,
    days_of,
    doubts_about,
    order_doubts,
    stated_differences,
)
from breaker.diagnosis.reading import without_copies
from breaker.records.header import Header, header_of
from breaker.records.operations import Operation
from tests.raws import raw_of

STEP = 0.05


def record(number=1, *, seed=None, phase="", date="", **stated):
    """A closing with noise, as it is read from a file of its own."""
    rng = np.random.default_rng([40, number if seed is None else seed])
    share = np.clip((STEP * np.arange(2400) - 30.0) / 12.0, 0.0, 1.0)
    way = 14.0 * share**2 * (3.0 - 2.0 * share) + 0.05 * rng.standard_normal(share.size)
    operation = Operation(number, f"{number}{phase}.csv", phase=phase, date=date)
    raw = replace(raw_of(way, STEP, 29.0), operation=operation)
    return DriveRecord(operation, "closing", Header(**stated), "", raw)


def test_a_copy_counts_once_and_is_named():
    """Also as another phase; operations of one drive are no copies."""
    first, again, *others = without_copies(
        [record(1), record(2, seed=1), *map(record, range(3, 9))]
    )
    assert not any(item.reason for item in (first, *others))
    assert again.reason.code == "copy"
    assert again.reason.values == {"name": "2.csv", "other": "1.csv"}
    poles = without_copies([record(1, seed=7, phase=phase) for phase in "RYB"])
    assert [getattr(pole.reason, "code", "") for pole in poles] == ["", "copy", "copy"]


def test_breakers_that_files_state():
    assert len(doubts_about([record(1, serial="A"), record(2, serial="B")])) == 1
    poles = [record(n, serial=f"A{n}", phase=phase) for n, phase in enumerate("RYB")]
    assert doubts_about(poles) == []  # poles may have numbers of their own
    assert len(doubts_about([record(1, bay="E01"), record(2, bay="e02")])) == 1
    assert doubts_about([record(1, bay="E 01"), record(2, bay="e  01")]) == []
    assert doubts_about([record(1, type="GL314"), record(2, type="gl-314")]) == []


@pytest.mark.parametrize(
    ("text", "ambiguous"),
    [("02/03/2026", True), ("2026-02-30", False), ("13/03/2026", None), ("unknown", None)],
)
def test_a_date_that_is_not_clear(text, ambiguous):
    header = header_of([[f"Test Date: {text}"]])
    read = {"dates": header.dates, "date_text": header.date_text}
    undated = record(1, **read, date="".join(header.dates) if ambiguous is None else "")
    codes = [(doubt.code, "2026-03-02" in doubt.values["why"]) for doubt in doubts_about([undated])]
    assert codes == ([] if ambiguous is None else [("date-unclear", ambiguous)])
    assert doubts_about([record(1, **read, date="2026-03-02")]) == []


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        ({"serial": "B", "bay": "e01"}, ["serial number"]),
        ({"ratio": "1.0", "type": "LTB 145"}, ["linkage ratio", "type"]),
    ],
)
def test_what_files_of_two_inspections_state_otherwise(stated, expected):
    before = [record(1, serial="A", bay="E 01", ratio="1.64", type="GL 314")]
    differences = stated_differences({"before": before, "today": [record(2, **stated)]})
    assert [difference.values["what"] for difference in differences] == expected


def test_an_earlier_inspection_that_is_later_and_no_day_is_left_out():
    before, today = [record(1, date="2024-05-01")], [record(2, date="2019-03-02")]
    assert len(order_doubts({"before": before, "today": today})) == 1
    assert order_doubts({"before": today, "today": before}) == []
    assert order_doubts({"before": [record(1)], "today": today}) == []
    dates = ["2021-04-14T10:00:00", "", "2021-03-04"]
    assert days_of([record(1, date=date) for date in dates]) == "2021-03-04 to 2021-04-14"
    assert days_of([record(1)]) == ""


@pytest.mark.parametrize(
    ("before", "today", "code"),
    [
        (["R"], ["R", "R"], None),
        ([""], [""], "phase-not-stated"),
        ([""], ["R"], "phase-not-stated"),
        (["R"], ["Y"], "different-phases"),
        ([""], ["R", "Y"], "several-phases"),
        (["R", "Y"], ["Y", "R"], "several-phases"),
        (["R"], ["R", "Y"], "several-phases"),
    ],
)
def test_records_are_compared_by_the_phase_that_is_stated(before, today, code):
    inspections = {
        name: [record(k, phase=phase) for k, phase in enumerate(phases)]
        for name, phases in (("before", before), ("today", today))
    }
    try:
        codes = [remark.code for remark in check_phases(inspections)]
        assert code in (None, "phase-not-stated")
    except ValueError as error:
        codes = [error.args[0].code]
    assert codes == [code] * (code is not None)
