"""Limits, and a result as data, CSV, a document and a figure."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from breaker.common.document import text_of
from breaker.common.plain_values import to_json
from breaker.diagnosis.estimate import Given
from breaker.diagnosis.limits import VERDICTS, judged
from breaker.diagnosis.result import csv_of
from breaker.diagnosis.tables import RESULTS, document_of
from breaker.family.networks import StateDraws
from breaker.figures import style
from breaker.figures.records import answer
from breaker.model.limits import Limit
from breaker.model.parameters import MOTIONS, NAMES
from tests.diagnosis.conftest import result_of
from tests.figures.drawn import assert_drawn, line_of


def limit(name, value, of="model", *more):
    return Limit("wide", "closing", ((name, value, True), *more), of=of)


def verdict(estimate, *about):
    (row,) = judged(estimate, [limit(*about)], seed=1)
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
    for estimate, verdicts, code in (
        (answers[0], ["pass", "fail", "fail"], None),
        (wrong, ["inconclusive"] * 3, "no-drive"),
    ):
        rows = judged(estimate, limits, seed=1)
        assert [row["verdict"] for row in rows] == verdicts
        assert {row["reason"] and row["reason"].code for row in rows} == {code}
        result = result_of([estimate], [rows])
        assert [warning.code for warning in result["warnings"]] == [code] * bool(code)
        summary = document_of(result).summary
        assert len([text for text in summary if f"[{code}]" in text]) == bool(code)


@pytest.fixture
def result(answers):
    limits = [judged(item, [limit("L", 5.0)], seed=1) for item in answers]
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
    rows = csv.DictReader(csv_of(result).splitlines())
    assert {(row["motion"], row["phase"]) for row in rows} == {(m, "L1") for m in MOTIONS}


def test_a_document_has_determined_parameters_alone_and_each_remark_once(result, answers):
    document = document_of(result)
    assert [part.title.split(":")[0] for part in document.parts][:2] == ["closing"] * 2
    state = document.after[-1]
    known = [item["parameters"] for item in result["records"][:2]]
    determined = [n for n in NAMES if any(item[n]["prior_share"] < 0.8 for item in known)]
    assert [row[0].split()[-1] for row in state.rows] == determined
    assert text_of(document).count("gone.csv") == 1
    outside = [replace(item, misfit=True, draws=None) for item in answers if item.draws]
    notes = document_of(result_of(outside)).after[-1].notes
    assert len(notes) == 1


def long(estimate, **more):
    """The same estimate, of a drive of 150 mm."""
    shape = estimate.record.shape._replace(stroke=150.0)
    return replace(estimate, record=replace(estimate.record, shape=shape), **more)


def test_a_long_stroke_withholds_touch_and_gap_everywhere(answers):
    """The contact may slide; a known value or a used contact brings them back."""
    estimate = long(answers[0])
    verdicts = judged(estimate, [limit("touch_time", 50.0), limit("L", 500.0)], seed=1)
    (entry,) = result_of([estimate])["records"]
    withheld = [entry["quantities"][n] for n in ("touch_time", "spring_compression")]
    for item in (*verdicts, *withheld, entry["parameters"]["L"]):
        assert item["reason"].code == "contact-may-slide"
        assert item.get("median") is None
    assert "touch_from10" not in entry["quantities"]
    assert entry["parameters"]["f"]["median"] > 0.0
    for known in ({"contact_given": True}, {"contact_used": True}):
        assert not long(answers[0], **known).contact_unknown


@pytest.mark.parametrize(
    ("places", "change"), [([0, 1, 2, 3], {}), ([0], {"misfit": True, "draws": None})]
)
def test_a_figure_has_each_motion_next_to_the_nearest_shape(answers, places, change):
    """A record that was rejected has none."""
    some = [replace(answers[k], **change) for k in places]
    figure = answer(some, Given().sample_prior(some[0], 200, np.random.default_rng(1)))
    assert_drawn(figure)
    columns = len({item.record.motion for item in some})
    assert len(figure.axes) == 2 * columns + len(NAMES) + 1
    for above, below in zip(figure.axes[:columns], figure.axes[columns:], strict=False):
        record, nearest = (line_of(above, colour) for colour in (style.MEASURED, style.CHANGED))
        left = line_of(below, style.MEASURED).get_ydata()
        travel = np.interp(nearest.get_xdata(), record.get_xdata(), record.get_ydata())
        there = np.isfinite(left)
        np.testing.assert_allclose(travel[there], nearest.get_ydata()[there], atol=0.5)
        assert np.abs(left[there]).max() < 0.3
