"""Limits, and a result as data, CSV and a document."""

import csv
import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from breaker.common.document import text_of
from breaker.common.numerals import in_digits
from breaker.common.plain_values import to_json
from breaker.diagnosis.limits import VERDICTS, judged
from breaker.diagnosis.result import csv_of
from breaker.diagnosis.tables import RESULTS, document_of
from breaker.family.networks import StateDraws
from breaker.model.limits import Limit
from breaker.model.parameters import NAMES
from breaker.records.measurements import Measured
from tests.diagnosis.conftest import result_of


def limit(name, value, of="model", *more):
    return Limit("wide", "closing", ((name, value, True), *more), of=of)


def verdict(answer, *about):
    (row,) = judged(answer, [limit(*about)], seed=1)
    return row["verdict"]


def test_verdicts_follow_from_the_draws(answers):
    result = []
    for above in (0.025, 0.975, 0.98):
        theta = np.ones((200, len(NAMES)))
        theta[: int(200 * above), -1] = 11.0
        result.append(verdict(replace(answers[0], draws=StateDraws(theta, {}, {})), "L", 10.0))
    assert result == list(VERDICTS) == list(RESULTS)[::-1]
    few = replace(answers[0], unresolved="few", draws=None)
    assert verdict(few, "L", 10.0) == "inconclusive"
    assert judged(answers[3], [limit("L", 10.0)], seed=1) == []  # of the other motion


def test_measured_quantities_are_judged_as_measured(answers, infer, timed):
    assert verdict(answers[0], "stroke", 13.0, "record") == verdict(answers[0], "stroke", 13.0)
    assert verdict(replace(answers[0], draws=None, misfit=True), "stroke", 14.5) == "pass"
    assert verdict(answers[0], "touch_time", 5.0, "record") == "inconclusive"  # no contact
    assert verdict(answers[0], "touch_time", 5.0) == "fail"
    (measured,) = infer(some=[timed(20.09)])
    assert verdict(measured, "touch_time", 5.0, "record") == "fail"
    assert verdict(measured, "reaction_time", 5.0, "record") == "inconclusive"
    (other_unit,) = judged(answers[0], [limit("stroke", 0.014, "record")], seed=1)
    assert other_unit["reason"].code == "limit-in-other-unit"


def test_no_limit_is_judged_on_a_motion_of_no_drive(answers):
    """The same record as if its travel were ten times as long: a unit of cm."""
    record = answers[0].record
    segment = replace(record.raw.segment, before=0.0, after=135.0)
    long = replace(record.raw, whole=10.0 * record.raw.whole, segment=segment)
    wrong = replace(answers[0], record=replace(record, raw=long))
    limits = [limit("stroke", 200.0, "record"), limit("stroke", 5.0), limit("L", 5.0)]
    for answer, verdicts, code in (
        (answers[0], ["pass", "fail", "fail"], None),
        (wrong, ["inconclusive"] * 3, "no-drive"),
    ):
        rows = judged(answer, limits, seed=1)
        assert [row["verdict"] for row in rows] == verdicts
        assert {row["reason"] and row["reason"].code for row in rows} == {code}
        result = result_of([answer], [rows])
        assert [warning.code for warning in result["warnings"]] == [code] * bool(code)
        summary = document_of(result).summary
        assert len([text for text in summary if f"[{code}]" in text]) == bool(code)


@pytest.fixture
def result(answers):
    limits = [judged(answer, [limit("L", 5.0)], seed=1) for answer in answers]
    return result_of(answers, limits)


def test_data_have_every_record_and_no_number_that_json_lacks(result, answers):
    written = json.loads(to_json(result), parse_constant=pytest.fail)
    first, _, rejected, _ = written["records"]
    assert [item["accepted"] for item in written["records"]] == [True, True, False, True]
    assert (first["phase"], first["verdict"], written["verdict"]) == ("L1", "fail", "fail")
    assert {*rejected["reason"]} == {"code", "text"}
    assert "parameters" not in rejected
    ends = np.quantile(answers[0].draws.theta[:, -1], [0.025, 0.975])
    assert first["parameters"]["L"]["interval_95"] == pytest.approx(ends, rel=1e-5)
    sources = {name: item.get("source") for name, item in first["quantities"].items()}
    assert sources["closing_wipe"] == "mixed"
    assert sources["stroke"] == "measured"
    assert sources["touch_after_release"] == "estimated"
    rows = list(csv.DictReader(csv_of(result).splitlines()))
    counts = Counter((row["motion"], row["operation"]) for row in rows)
    assert [*counts.values()] == [29, 29, 1, 28]
    assert {row["phase"] for row in rows} == {"L1"}


def test_a_document_has_determined_parameters_alone_and_each_remark_once(result, answers):
    answer = document_of(result)
    assert [part.title.split(":")[0] for part in answer.parts][:2] == ["closing"] * 2
    state = answer.after[-1]
    known = [item["parameters"] for item in result["records"][:2]]
    determined = [n for n in NAMES if any(item[n]["prior_share"] < 0.8 for item in known)]
    assert [row[0].split()[-1] for row in state.rows] == determined
    assert text_of(answer).count("gone.csv") == 1
    outside = [replace(answer, misfit=True, draws=None) for answer in answers if answer.draws]
    notes = document_of(result_of(outside)).after[-1].notes
    assert len(notes) == 1


def test_limits_have_all_of_many_operations_and_tables_the_first(answers):
    gone = Measured(np.nan, np.nan, "the record ends before the drive rests")
    ended = replace(answers[0], measured=answers[0].measured | {"stroke": gone})
    again = [replace(answers[1].record.operation, number=k) for k in (2, 3, 4, 5)]
    records = [replace(answers[1].record, operation=item) for item in again]
    several = [ended, *(replace(answers[1], record=item) for item in records)]
    verdicts = [judged(item, [limit("stroke", 5.0, "record")], seed=1) for item in several]
    tables = document_of(result_of(several, verdicts)).parts
    assert [table.title.split(":")[0] for table in tables[:4]] == ["closing"] * 3 + ["Limits"]
    (row,) = tables[3].rows
    assert row[1].split()[1:] == ["4", "of", "5"]
    assert row[2] == in_digits(answers[1].measured["stroke"].value, 4)
    assert sum(gone.reason in note for note in tables[3].notes) == 1


def long(answer, **more):
    """The same answer, of a drive of 150 mm."""
    shape = answer.record.shape._replace(stroke=150.0)
    return replace(answer, record=replace(answer.record, shape=shape), **more)


def test_a_long_stroke_withholds_touch_and_gap_everywhere(answers):
    """The contact may slide; a known value or a used contact brings them back."""
    answer = long(answers[0])
    verdicts = judged(answer, [limit("touch_time", 50.0), limit("L", 500.0)], seed=1)
    assert [verdict["verdict"] for verdict in verdicts] == ["inconclusive"] * 2
    assert {verdict["reason"].code for verdict in verdicts} == {"contact-may-slide"}
    (entry,) = result_of([answer])["records"]
    for name in ("touch_time", "spring_compression", "closing_wipe"):
        assert entry["quantities"][name]["median"] is None
        assert entry["quantities"][name]["reason"].code == "contact-may-slide"
    assert "touch_from10" not in entry["quantities"]
    assert entry["parameters"]["L"]["reason"].code == "contact-may-slide"
    assert entry["parameters"]["f"]["median"] > 0.0
    assert answer.contact_unknown
    assert np.isnan(answer.contact.time)
    assert not long(answers[0], contact_given=True).contact_unknown
    assert not long(answers[0], contact_used=True).contact_unknown
