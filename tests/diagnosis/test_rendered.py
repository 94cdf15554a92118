"""Limits, and answers as a document, in words, as a table and as a tree."""

import csv
import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from breaker.common.plain_values import to_json
from breaker.common.terminal import text_of
from breaker.diagnosis.answer_words import words_of
from breaker.diagnosis.arviz import tree
from breaker.diagnosis.curves import shown
from breaker.diagnosis.estimate import Given
from breaker.diagnosis.limits import VERDICTS, judged
from breaker.diagnosis.result import document, table_of
from breaker.family.membership import PARTS
from breaker.family.networks import StateDraws
from breaker.family.shape import SHAPE_TIMES
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, NAMES
from breaker.model.quantities import AFTER_RELEASE, QUANTITIES
from breaker.records.measurements import Measured


def limit(name, value, of="model", *more):
    return Limit("wide", "closing", ((name, value, True), *more), of=of)


@pytest.fixture
def verdict(answers):
    """The verdict of a limit on the first closing, or on one like it."""

    def verdict(limit, answer=answers[0]):
        (row,) = judged(answer, [limit], seed=1)
        return row.verdict

    return verdict


def test_verdicts_follow_from_the_draws(answers, verdict):
    found = []
    for above in (0.025, 0.975, 0.98):
        theta = np.ones((200, len(NAMES)))
        theta[: int(200 * above), -1] = 11.0
        answer = replace(answers[0], draws=StateDraws(theta, {}, {}))
        found.append(verdict(limit("L", 10.0), answer))
    assert found == list(VERDICTS)
    few = replace(answers[0], unresolved="few", draws=None)
    assert verdict(limit("L", 10.0), few) == "inconclusive"
    assert judged(answers[3], [limit("L", 10.0)], seed=1) == []  # of the other motion


def test_measured_quantities_are_judged_as_measured(answers, infer, timed, verdict):
    assert verdict(limit("stroke", 13.0, "record")) == VERDICTS[-1]
    assert verdict(limit("stroke", 13.0)) == VERDICTS[-1]
    out = replace(answers[0], draws=None, misfit=True)
    assert verdict(limit("stroke", 14.5), out) == "pass"
    assert verdict(limit("touch_time", 5.0, "record")) == "inconclusive"  # no contact was timed
    assert verdict(limit("touch_time", 5.0, "record", ("stroke", 13.0, True))) == "inconclusive"
    assert verdict(limit("touch_time", 5.0)) == VERDICTS[-1]
    (measured,) = infer(some=[timed(20.09)])
    assert verdict(limit("touch_time", 5.0, "record"), measured) == VERDICTS[-1]
    assert verdict(limit("reaction_time", 5.0, "record")) == "inconclusive"
    fit = document([measured], [[]], {}, {}).records[0].fit
    assert fit.contact_time == pytest.approx(10.09, abs=0.5)  # after the first motion


@pytest.fixture
def found(answers):
    limits = [judged(each, [limit("L", 5.0)], seed=1) for each in answers]
    return document(answers, limits, {"words": ["size given"]}, {"seed": 1})


def test_a_document_has_every_record_and_no_number_that_json_lacks(found, answers):
    written = json.loads(to_json(found), parse_constant=pytest.fail)
    assert json.loads(to_json(written)) == written
    first, _, rejected, _ = written["records"]
    assert [each["accepted"] for each in written["records"]] == [True, True, False, True]
    assert first["phase"] == "L1"
    assert "is not there" in rejected["reason"]
    assert "parameters" not in rejected
    low, median, high = np.quantile(answers[0].draws.theta[:, -1], [0.025, 0.5, 0.975])
    assert first["parameters"]["L"]["median"] == pytest.approx(median, rel=1e-5)
    assert first["parameters"]["L"]["interval_95"] == pytest.approx([low, high], rel=1e-5)
    assert first["verdict"] == "fail"
    assert first["quantities"]["closing_wipe"]["source"] == "measured, touch inferred"
    together = written["together"]
    assert set(together) == {"closing"}
    each = [written["records"][k]["parameters"]["mu"] for k in (0, 1)]
    mu = together["closing"]["parameters"]["mu"]
    assert mu["sd"] == pytest.approx(np.std([e["median"] for e in each], ddof=1), rel=1e-3)
    half = np.median([np.ptp(e["interval_95"]) for e in each]) / 2.0
    assert mu["half_interval_95"] == pytest.approx(half, rel=1e-3)
    assert together["closing"]["limits"]["wide"]["fail"] == 2


def test_a_table_has_a_row_for_each_parameter_and_quantity(found):
    rows = list(csv.DictReader(table_of(found).splitlines()))
    counts = Counter((row["motion"], row["operation"]) for row in rows)
    assert [*counts.values()] == [31, 31, 1, 30]
    touch = next(row for row in rows if row["output"] == "touch_time")
    assert (touch["kind"], touch["unit"], touch["source"]) == (
        "quantity",
        "ms",
        "measured, touch inferred",
    )
    assert touch["verdict"] == "fail"
    assert float(touch["exceeded_wide"]) == 1.0
    assert {row["phase"] for row in rows} == {"L1"}
    fit = {"p_value", "misfit", "resolved", "part_main_motion"}
    assert {"file", "median", "interval_50_upper", "reason", "remarks", *fit} <= rows[0].keys()


@pytest.mark.parametrize("k", [0, 3])
def test_a_picture_has_the_record_beside_the_nearest_shape_and_what_is_usual(answers, k):
    curve = shown(answers, Given(), seed=1).curves[answers[k].record.motion]
    assert curve.good
    record = np.interp(curve.grid, curve.time, curve.travel)
    there = np.isfinite(curve.left)
    np.testing.assert_allclose(record[there], curve.nearest[there], atol=0.5)
    begin, end = PARTS["main motion"]
    part = (begin <= SHAPE_TIMES) & (end > SHAPE_TIMES)
    ratio = np.sqrt(np.nanmean(np.square(curve.left[part]))) / curve.usual[part]
    np.testing.assert_allclose(ratio, answers[k].match.parts["main motion"])


def test_a_tree_has_the_records_with_a_posterior(answers):
    found = tree(answers, Given(), seed=1)
    posterior = found["posterior"]
    assert posterior.motion.values.tolist() == ["closing", "closing", "opening"]
    assert posterior.operation.values.tolist() == [1, 2, 1]
    draws = answers[1].draws.theta[:, -1]
    assert np.array_equal(posterior["L"].sel(chain=0, record=1), draws)
    assert posterior["L"].attrs["unit"] == "mm"
    nothing = [
        posterior[name].isnull().all("draw").values.tolist() for name in AFTER_RELEASE.values()
    ]
    assert nothing == [[[False, False, True]], [[True, True, False]]]
    assert (posterior.mu.sel(record=0) == posterior.mu.sel(record=2)).all()  # of both motions
    assert found["observed_data"].way.sel(record=0).max() == pytest.approx(1.05, abs=0.1)
    assert (found["sample_stats"].p_value > 0.001).all()
    ratio = posterior.to_dataset().median("draw") / found["prior"].to_dataset().median("draw")
    for name in NAMES:
        assert (abs(np.log(ratio[name])) < 0.5).all(), name
    with pytest.raises(ValueError, match="no record has a posterior"):
        tree(answers[2:3], Given(), seed=1)


def test_every_limit_has_a_row_whatever_is_known_of_its_quantity(answers, timed, infer):
    """Every quantity that a limit can be about, of each source, with and without a trigger."""
    entries = [
        {"name": f"{name} {of} {motion} {side}", "motion": motion, "of": of, side: {name: 3.0}}
        for motion in MOTIONS
        for of in ("model", "record")
        for name, each in QUANTITIES.items()
        if motion in each.motions and of in each.of
        for side in ("upper", "lower")
    ]
    limits = from_list(entries, MOTIONS, answers[0].speeds)
    (touched,) = infer(some=[timed(20.09)])
    latched = replace(
        touched, measured=touched.measured | {"reaction_time": Measured(9.0, 0.1, "")}
    )
    out = replace(answers[0], misfit=True, draws=None)
    for answer in (*answers, latched, out, replace(answers[3], unresolved="few", draws=None)):
        rows = judged(answer, limits, seed=1)
        text_of(words_of(document([answer], [rows], {"words": []}, {})))
        for row in [] if answer.record.reason else rows:
            assert (row.verdict == "inconclusive") == bool(row.reason)
    verdicts = {row.name: row.verdict for row in judged(latched, limits, seed=1)}
    assert verdicts["reaction_time record closing upper"] == "fail"
    assert verdicts["touch_time record closing lower"] == "pass"


def test_a_pair_is_one_row_with_both_bounds(answers):
    entry = {"quantity": "stroke", "motion": "closing", "reference": 13.5, "tolerance": "5 %"}
    (row,) = judged(answers[0], from_list([entry], MOTIONS), seed=1)
    (part,) = row.parts
    assert (row.name, row.verdict, row.p_exceeded) == ("stroke", "pass", 0.0)
    assert part.bounds == pytest.approx([12.825, 14.175])
    assert part.interval_95[0] < part.value < part.interval_95[1]
    (row,) = judged(answers[0], from_list([entry | {"reference": 15}], MOTIONS), seed=1)
    assert (row.verdict, row.p_exceeded) == ("fail", 1.0)


def test_of_measured_values_it_is_told_how_many_there_are_and_why_others_lack(answers):
    """One record of three has a stroke and no touch, as it is out of the family."""
    gone = Measured(np.nan, np.nan, "the record ends before the drive rests")
    ended = replace(answers[0], measured=answers[0].measured | {"stroke": gone})
    out = replace(answers[1], misfit=True, draws=None)
    found = document([ended, answers[1], out], [[]] * 3, {"words": []}, {})
    stroke = found.together["closing"].quantities["stroke"]
    assert (stroke.told, stroke.of, stroke.reasons) == (2, 3, {gone.reason: 1})
    assert text_of(words_of(found)).count(gone.reason) == 2  # of the record, and of all together
