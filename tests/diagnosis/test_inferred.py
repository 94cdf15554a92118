"""What is inferred of each operation: by which records, which family, and with which weights."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.common.terminal import text_of
from breaker.diagnosis import inference as inferred
from breaker.diagnosis.answer_words import words_of
from breaker.diagnosis.draw_weights import contradicted, possible, weights_of
from breaker.diagnosis.drive_records import _Reader, read_operations
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.result import document
from breaker.family.export import write_curve
from breaker.family.membership import Match
from breaker.family.networks import StateDraws
from breaker.model.curves import travel
from breaker.model.parameters import NAMES, Size, powers
from breaker.model.prior import Prior
from breaker.records.header import Header
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from tests.cli.conftest import written
from tests.diagnosis.conftest import SETTINGS, TOUCH, spread
from tests.raws import smooth


def test_both_motions_of_an_operation_share_their_draws(answers):
    both, alone, gone, opening = answers
    assert [each.record.motion for each in answers] == ["closing"] * 3 + ["opening"]
    assert both.draws.theta is opening.draws.theta
    assert both.motions == opening.motions == ("closing", "opening")
    assert alone.motions == ("closing",)
    assert gone.draws is None
    assert spread(opening.inferred("k_a")) < spread(alone.inferred("k_a"))


def test_means_of_records_say_more_than_one_of_them(tmp_path, infer, answers, prior):
    (two,) = inferred.infer_means(answers, Given(), SETTINGS)
    assert {each.record.motion: each.records for each in two} == {"closing": 2, "opening": 1}
    assert two[0].draws is two[1].draws
    assert inferred.infer_means(answers[:1], Given(), SETTINGS) == []
    for k in range(10):
        written(tmp_path / f"{k}.csv", prior, "closing", "opening")
    listed = [Operation(k, tmp_path / f"{k}.csv") for k in range(10)]
    several = infer(some=read_operations({"closing": listed, "opening": listed}, {}, loose=True))
    (many,) = inferred.infer_means(several, Given(), SETTINGS)
    assert [each.records for each in many] == [10, 10]
    for name in ("k_a", "f", "L"):
        one = np.median([spread(np.log(each.inferred(name))) for each in several])
        assert spread(np.log(many[0].inferred(name))) < 0.9 * one
        off = np.median(many[0].inferred(name)) / prior.medians[NAMES.index(name)] - 1.0
        assert abs(off) < 3.0 * one


@pytest.mark.parametrize("rate", [20, 40])
def test_long_rests_move_no_answer(tmp_path, infer, prior, rate):
    """Records of real analysers last 20 to 100 durations, those of trainings ten."""
    listed, sizes = [], ((15.0, 65.0), (25.0, 120.0), (60.0, 360.0))
    for number, (lead, length) in enumerate(sizes):
        time = np.arange(-60.0, 360.0, 1.0 / rate)
        curve = travel(prior.medians[None], time, "closing").travel[0]
        noise = 0.1 * generator(1, "long rests", rate).standard_normal(time.size)
        part = (time >= -lead) & (time < length - lead)
        file = tmp_path / f"{length:.0f}.csv"
        write_curve(file, time[part] + lead, (curve + noise)[part], motion="closing", operation=1)
        listed.append(Operation(number, file))
    known = Given(size=Size())
    # Each by itself: they hold the same samples, and would count once.
    each = (read_operations({"closing": [one]}, {"rate": rate}) for one in listed)
    short, *long = infer(known, [record for records in each for record in records])
    for name in NAMES:
        usual = np.log(short.inferred(name))
        for each in long:
            moved = np.median(np.log(each.inferred(name))) - np.median(usual)
            assert abs(moved) < 0.3 * usual.std()  # noise is seen better in long ones


def test_the_mean_of_timed_records_has_the_mean_time(infer, timed):
    timed_twice = infer(some=[timed(TOUCH), timed(TOUCH + 0.2)])
    ((mean,),) = inferred.infer_means(timed_twice, Given(), SETTINGS)
    assert mean.record.raw.contact.time == pytest.approx(TOUCH + 0.1)
    assert mean.record.raw.contact.sd == pytest.approx(np.hypot(0.1, 0.1) / np.sqrt(2.0))


def test_a_share_of_an_interval_is_the_prior(infer, answers, records, defaults):
    (sized,) = infer(Given(size=Size()), records[1:2])
    for each in (answers[0], answers[1], sized):
        assert (each.prior_share > 0.0).all()
        assert (each.prior_share < 1.5).all()
    for name, share in zip(NAMES, sized.prior_share, strict=True):
        told = spread(np.log(sized.inferred(name))) / (1.96 * defaults["prior"][name]["log_sd"])
        assert np.sqrt(share) == pytest.approx(told, rel=0.25)


def test_what_needs_the_touch_is_measured_at_the_inferred_one(answers, infer, timed):
    inferred = answers[0].measured
    (measured,) = infer(some=[timed(TOUCH, 0.02)])
    assert measured.alone("closing_wipe")
    assert not answers[0].alone("closing_wipe")
    assert answers[0].alone("stroke")
    for name in ("closing_wipe", "closing_speed"):
        assert measured.measured[name].sd < 0.9 * inferred[name].sd
        off = measured.measured[name].value - inferred[name].value
        assert abs(off) < 4.0 * inferred[name].sd


def test_a_timed_contact_weighs_the_draws_and_one_of_another_record_is_told(infer, timed, answers):
    (right,) = infer(some=[timed(TOUCH)])
    assert abs(right.surprise) < 4.0
    assert right.effective_size > 100
    touch = right.record.tenth + right.draws.switching["closing"]
    assert np.median(touch) == pytest.approx(TOUCH, abs=0.1)
    assert spread(touch) < 0.25 < spread(answers[1].draws.switching["closing"])
    (wrong,) = infer(some=[timed(TOUCH + 20.0)])
    assert wrong.surprise > 4.0
    assert len(wrong.remarks) > len(right.remarks)
    assert spread(wrong.draws.switching["closing"]) > 0.25
    (rough,) = infer(some=[timed(TOUCH + 5.0, sd=5.0)])
    assert 0.5 < rough.surprise < 1.5


@pytest.mark.parametrize(("name", "value", "sd"), [("mu", 2.1, 0.05), ("touch_time", 10.1, 0.05)])
def test_a_fact_narrows_what_it_is_about(infer, records, name, value, sd):
    (known,) = infer(Given(known={name: [value, sd]}), records[1:2])
    assert np.median(known.inferred(name)) == pytest.approx(value, abs=sd)
    assert spread(known.inferred(name)) == pytest.approx(1.96 * sd, rel=0.3)
    (far,) = infer(Given(known={name: [5.0 * value, sd]}), records[1:2])
    assert far.draws is None


def test_the_wipe_is_one_of_both_motions_and_the_stroke_less_the_gap(infer, records, answers):
    """The drive's way from touch or to separation is another one, and another in either motion."""
    closing, opening = answers[0], answers[3]
    for each in (closing, opening):
        rest = each.record.shape.stroke - each.inferred("L")
        np.testing.assert_allclose(each.inferred("spring_compression"), rest)
    one, other = (np.median(each.inferred("spring_compression")) for each in (closing, opening))
    assert one == pytest.approx(other, abs=0.1)
    ways = [
        closing.measured["closing_wipe"].value,
        opening.measured["opening_wipe"].value,
    ]
    assert ways[1] < 0.7 * ways[0] < 0.7 * one  # friction holds the contact back in an opening
    for each, way in zip((closing, opening), ways, strict=True):
        assert np.median(each.way_to_rest) == pytest.approx(way, abs=0.3)
    found, *_, later = infer(Given(known={"spring_compression": [one + 0.2, 0.05]}), records)
    assert np.median(found.inferred("spring_compression")) == pytest.approx(one + 0.2, abs=0.15)
    assert not any("contradicts" in each for each in later.remarks)


def test_each_time_of_a_contact_has_one_zero_whether_it_was_recorded_or_not(infer, timed, answers):
    """From the first motion by a recorded touch and by an inferred one, which are a release apart
    from the time that networks infer.
    """
    (seen,) = infer(some=[timed(TOUCH)])
    said = document([seen, answers[0]], [[], []], {"words": []}, {}).records
    recorded, inferred = (each.quantities["touch_time"] for each in said)
    words = text_of(words_of(document([seen], [[]], {"words": []}, {})))
    assert re.search(r"recorded touch \S+ ms after the first motion, .* sd .* they agree", words)
    assert (recorded.source, inferred.source) == ("measured", "measured, touch inferred")
    assert abs(recorded.median - inferred.median) < recorded.half + inferred.half
    for each, entry in zip((seen, answers[0]), said, strict=True):
        moves = each.record.tenth - each.record.raw.moves
        later = entry.quantities["touch_from10"].median - entry.quantities["release_from10"].median
        after = entry.quantities["touch_after_release"]
        assert after.median == pytest.approx(later, abs=0.2)
        np.testing.assert_allclose(
            each.inferred("touch_time"), moves + each.draws.switching["closing"]
        )


def test_a_fact_that_is_contradicted_is_told_with_its_side():
    answer = SimpleNamespace(draws=True, inferred=lambda name: np.full(9, 2.0))
    assert contradicted([answer], Given(known={"mu": [2.29, 0.1]})) == []
    (remark,) = contradicted([answer], Given(known={"mu": [2.4, 0.1]}))
    assert "known.mu, 2.4 with an sd of 0.1: the posterior is -4.0 sd off" in remark


# ---- weights, where the posterior is known ------------------------------------------------------


def prior_means(levels, own, draws, size, told):
    """Means and sds of log parameters by the weights of a prior of one's own, in its units."""
    record = SimpleNamespace(timed=False, motion="closing")
    given = Given(told, own)
    answer = Estimate(record, levels, draws=StateDraws(draws, {}, {}))
    weights = weights_of([answer], given, size)
    z = own.standardise(draws)
    mean = weights @ z
    return mean, np.sqrt(weights @ np.square(z - mean)), 1.0 / np.square(weights).sum()


@pytest.mark.parametrize("told", [True, False])
def test_draws_that_know_nothing_become_the_prior_of_ones_own(levels, told):
    """Draws of the family's prior, at the size or at all sizes alike, weighed: those of one's own.

    Standard errors of means are below 1 over the root of the effective size. In the second case a
    wrong family prior is a planted fault: as if it said something of the size.
    """
    size, rng = Size(2.0, 1.5), np.random.default_rng(1)
    family = Prior.from_settings(levels.settings["prior"]).sized(size)
    draws = family.sample(60_000, rng)
    if not told:
        draws = draws * np.exp(rng.uniform(-0.6, 0.6, (len(draws), 2)) @ powers())
    own = Prior(family.medians * np.exp(0.3 * family.log_sds), 0.9 * family.log_sds)
    mean, sds, left = prior_means(levels, own, draws, size if told else None, size)
    assert left > 200
    assert np.abs(mean).max() < 5.0 / np.sqrt(left)
    assert np.abs(sds - 1.0).max() < 5.0 / np.sqrt(left)
    wrong, *_ = prior_means(levels, own, draws, None if told else size, size)
    assert np.abs(wrong).max() > 8.0 / np.sqrt(left)


def test_the_try_of_which_weights_leave_most_counts(infer, records, prior, monkeypatch):
    left = iter([50, 300, 2])

    def weights(answers, *_):
        count = next(left)
        return np.where(np.arange(len(answers[0].draws.theta)) < count, 1.0 / count, 0.0)

    monkeypatch.setattr(inferred, "weights_of", weights)
    (found,) = infer(Given(Size(), prior), records[1:2])
    assert found.effective_size == pytest.approx(300.0)
    assert not found.unresolved


# ---- families -----------------------------------------------------------------------------------


def test_nothing_is_inferred_out_of_the_family(infer, levels):
    found = infer(families=[replace(levels, members={m: Never() for m in ("closing", "opening")})])
    out = found[0]
    assert out.misfit
    assert out.draws is None
    assert np.isfinite(out.measured["stroke"].value)
    assert np.isnan(out.measured["closing_speed"].value)


class Never:
    """Members of a family that no record is of."""

    def match(self, seen, basis):
        return Match(0.0, {"start": 1.0, "main motion": 9.0, "end": 1.0}, seen.way[0])


def test_motions_that_contradict_each_other_are_inferred_apart(tmp_path, prior, infer):
    other = Prior(prior.medians * [1, 2.2, 1, 2.0, 1, 1, 1], prior.log_sds)
    files = {"closing": tmp_path / "closing.csv", "opening": tmp_path / "opening.csv"}
    for (motion, file), drive in zip(files.items(), (prior, other), strict=True):
        written(file, drive, motion)
    found = {motion: [Operation(1, file)] for motion, file in files.items()}
    closing, opening = infer(some=read_operations(found, {}))
    assert (closing.motions, opening.motions) == (("closing",), ("opening",))
    for each in (closing, opening):
        assert any("closing and opening contradict each other" in said for said in each.remarks)


def test_no_draw_has_a_gap_beyond_the_stroke_or_a_contact_beyond_the_rest(answers):
    theta = np.tile(answers[1].draws.theta[:1], (3, 1))
    stroke = answers[1].record.shape.stroke
    theta[:, NAMES.index("L")] = 0.7 * stroke, 1.1 * stroke, 0.7 * stroke
    late = answers[1].record.shape.duration * np.array([0.8, 0.8, 4.0])
    draws = StateDraws(theta, {"closing": 0.0 * late}, {"closing": late})
    assert possible([replace(answers[1], draws=draws)]).tolist() == [True, False, False]


def test_what_is_missing_is_of_the_motion():
    """A gap within it, but not that the record ends early."""
    raw = replace(smooth(np.random.default_rng(1), until=45.0), settings={"missing": 0.05})
    files = Reader({})
    files.header = lambda operation: Header()
    reader = _Reader("closing", files, 0)
    assert reader.records(raw.operation, raw)[0].reason == ""
    gap = replace(raw, whole=np.where(np.abs(raw.time - 30.0) < 4.0, np.nan, raw.whole))
    (found,) = reader.records(raw.operation, gap)
    assert "a share of 0.29 of the motion" in found.reason


def test_the_medians_of_a_slip_in_units_are_far_from_the_prior(infer, records, prior):
    assert NAMES[5] == "f"
    slip = Prior(prior.medians * [1, 1, 1, 1, 1, 10, 1], prior.log_sds)
    (far,) = infer(Given(Size(), slip), records[1:2])
    assert far.far_from_prior
    assert far.unresolved
    (near,) = infer(Given(Size(), prior), records[1:2])
    assert not near.far_from_prior
    assert not near.unresolved
