"""What is inferred of each operation: by which records, which family, and with which weights."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.diagnosis import inference
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.limits import judged
from breaker.diagnosis.reading import _record, read_operations
from breaker.family.membership import Match
from breaker.family.networks import StateDraws
from breaker.model.equations import spring_compression
from breaker.model.limits import Limit
from breaker.model.parameters import MOTIONS, NAMES, Size, powers
from breaker.model.prior import Prior
from breaker.records.header import Header
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from tests.cli.conftest import written
from tests.diagnosis.conftest import TOUCH, result_of, spread
from tests.raws import smooth


def test_both_motions_of_an_operation_share_their_draws(answers):
    both, alone, gone, opening = answers
    assert [answer.record.motion for answer in answers] == ["closing"] * 3 + ["opening"]
    assert both.draws.theta is opening.draws.theta
    assert both.motions == opening.motions == ("closing", "opening")
    assert alone.motions == ("closing",)
    assert gone.draws is None
    assert spread(opening.inferred("k_a")) < spread(alone.inferred("k_a"))


def test_a_share_of_an_interval_is_the_prior(infer, records, defaults):
    (sized,) = infer(Given(size=Size()), records[1:2])
    for name, share in zip(NAMES, sized.prior_share, strict=True):
        expected = spread(np.log(sized.inferred(name))) / (1.96 * defaults["prior"][name]["log_sd"])
        assert np.sqrt(share) == pytest.approx(expected, rel=0.25)


def codes(estimate):
    """Codes of the remarks of an estimate."""
    return [getattr(remark, "code", "") for remark in estimate.remarks]


def test_a_recorded_contact_weights_the_draws(infer, timed, answers):
    (right,) = infer(some=[timed(TOUCH)])
    assert right.contact_used
    assert abs(right.surprise) < 4.0
    touch = right.record.tenth + right.draws.switching["closing"]
    assert np.median(touch) == pytest.approx(TOUCH, abs=0.1)
    assert spread(touch) < 0.25 < spread(answers[1].draws.switching["closing"])
    (rough,) = infer(some=[timed(TOUCH + 5.0, sd=5.0)])
    assert 0.5 < rough.surprise < 1.5


@pytest.mark.parametrize("shift", [-4.0, 20.0])
def test_a_recorded_contact_never_costs_the_estimate(infer, timed, records, shift):
    """One that disagrees is left out: the estimate is that of the record without a contact."""
    (wrong,) = infer(some=[timed(TOUCH + shift, 0.02)])
    (without,) = infer(some=records[:1])
    assert not wrong.unresolved
    assert np.array_equal(wrong.draws.theta, without.draws.theta)
    assert "contact-disagrees" in codes(wrong)
    assert np.sign(wrong.surprise) == np.sign(shift)
    measured = TOUCH + shift - wrong.record.raw.moves
    assert wrong.measured["touch_time"].value == pytest.approx(measured, abs=0.1)


@pytest.mark.parametrize(("name", "value", "sd"), [("mu", 2.1, 0.05), ("touch_time", 10.1, 0.05)])
def test_a_known_value_narrows_its_quantity(infer, records, name, value, sd):
    (known,) = infer(Given(known={name: [value, sd]}), records[1:2])
    assert np.median(known.inferred(name)) == pytest.approx(value, abs=sd)
    assert spread(known.inferred(name)) == pytest.approx(1.96 * sd, rel=0.3)
    (far,) = infer(Given(known={name: [5.0 * value, sd]}), records[1:2])
    assert far.draws is None
    assert far.unresolved.code == "few-draws"
    assert codes(far)[-1] == "known-value-disagrees"
    assert far.remarks[-1].values["sds"] > 4.0


def test_the_spring_compression_is_the_stroke_at_rest_less_the_gap(tmp_path, prior, infer, records):
    """Of an opening that swings still at the end of what networks see, too."""
    closing, *_, opening = infer()
    for item in (closing, opening):
        assert np.median(item.inferred("spring_compression")) == pytest.approx(
            closing.measured["stroke"].value - np.median(item.inferred("L")), abs=0.05
        )
    swinging = Prior(prior.medians * [1, 1, 1, 0.7, 1, 1, 1], prior.log_sds)
    file = tmp_path / "opening.csv"
    written(file, swinging, "opening", noise_sd=0.02)
    (record,) = read_operations({"opening": [Operation(1, file)]}, {})
    compression, gap = spring_compression(swinging.medians), swinging.medians[NAMES.index("L")]
    assert abs(record.shape.stroke - compression - gap) > 0.2
    (known,) = infer(Given(known={"spring_compression": [compression, 0.05]}), [record])
    assert np.median(known.inferred("L")) == pytest.approx(gap, abs=0.1)


def test_a_recorded_touch_and_an_inferred_one_count_from_the_first_motion(infer, timed, answers):
    (seen,) = infer(some=[timed(TOUCH)])
    entries = result_of([seen, answers[0]])["records"]
    recorded, inferred = (item["quantities"]["touch_time"] for item in entries)
    assert abs(entries[0]["fit"]["contact_deviation"]) < inference.SURPRISING
    assert (recorded["source"], inferred["source"]) == ("measured", "mixed")
    halves = [np.ptp(item["interval_95"]) / 2.0 for item in (recorded, inferred)]
    assert abs(recorded["median"] - inferred["median"]) < sum(halves)
    for entry in entries:
        names = ("touch_from10", "release_from10", "touch_after_release")
        touch, release, after = (entry["quantities"][name]["median"] for name in names)
        assert after == pytest.approx(touch - release, abs=0.2)


# ---- weights, where the posterior is known ------------------------------------------------------


def prior_means(levels, own, draws, size):
    """Means and sds of log parameters by the weights of a prior of one's own, in its units."""
    seen = SimpleNamespace(stroke=[2.0 * np.exp(levels.usual[0, 0])])
    seen.duration = [1.5 * np.exp(levels.usual[1, 0])]
    record = SimpleNamespace(timed=False, motion="closing", seen=seen)
    answer = Estimate(record, levels, draws=StateDraws(draws, {}, {}))
    asked = inference.Inference(lambda: [levels], Given(size, own), 0, 0.0, 0)
    weights = asked._weights([answer], ())
    weights /= weights.sum()
    z = own.standardise(draws)
    mean = weights @ z
    return mean, np.sqrt(weights @ np.square(z - mean)), 1.0 / np.square(weights).sum()


def test_draws_that_know_nothing_become_the_prior_of_ones_own(levels):
    """Draws of the family's prior, of all sizes alike, weighed: those of one's own.

    Standard errors of means are below 1 over the root of the effective size. Draws of one size are
    the planted fault.
    """
    size, rng = Size(2.0, 1.5), np.random.default_rng(1)
    family = Prior.from_settings(levels.settings["prior"]).sized(size)
    draws = family.sample(60_000, rng)
    sizes = np.exp(rng.uniform(-0.6, 0.6, (len(draws), 2)) @ powers())
    own = Prior(family.medians * np.exp(0.3 * family.log_sds), 0.9 * family.log_sds)
    mean, sds, left = prior_means(levels, own, draws * sizes, size)
    assert left > 200
    assert np.abs(mean).max() < 5.0 / np.sqrt(left)
    assert np.abs(sds - 1.0).max() < 5.0 / np.sqrt(left)
    _, wrong, left = prior_means(levels, own, draws, size)
    assert np.abs(wrong - 1.0).max() > 8.0 / np.sqrt(left)


# ---- families -----------------------------------------------------------------------------------


def test_nothing_is_inferred_out_of_the_family(infer, levels):
    parts = {"start": 1.0, "main motion": 9.0, "end": 1.0}
    never = SimpleNamespace(match=lambda seen, basis: Match(0.0, parts, seen.way[0]))
    out, *_ = infer(families=[replace(levels, members=dict.fromkeys(MOTIONS, never))])
    assert out.misfit
    assert out.draws is None
    assert np.isfinite(out.measured["stroke"].value)
    assert np.isnan(out.measured["closing_speed"].value)


def test_motions_that_contradict_each_other_are_inferred_apart(tmp_path, prior, infer):
    other = Prior(prior.medians * [1, 2.2, 1, 2.0, 1, 1, 1], prior.log_sds)
    files = {"closing": tmp_path / "closing.csv", "opening": tmp_path / "opening.csv"}
    for (motion, file), drive in zip(files.items(), (prior, other), strict=True):
        written(file, drive, motion)
    result = {motion: [Operation(1, file)] for motion, file in files.items()}
    closing, opening = infer(some=read_operations(result, {}))
    assert (closing.motions, opening.motions) == (("closing",), ("opening",))
    for item in (closing, opening):
        assert "motions-contradict" in codes(item)


def test_no_draw_has_a_gap_beyond_the_stroke_or_a_contact_beyond_the_rest(answers):
    theta = np.tile(answers[1].draws.theta[:1], (3, 1))
    stroke = answers[1].record.shape.stroke
    theta[:, NAMES.index("L")] = 0.7 * stroke, 1.1 * stroke, 0.7 * stroke
    late = answers[1].record.shape.duration * np.array([0.8, 0.8, 4.0])
    draws = StateDraws(theta, {"closing": 0.0 * late}, {"closing": late})
    assert inference._possible(
        [replace(answers[1], draws=draws, stroke=np.full(3, stroke))]
    ).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("name", "code"),
    [("touch_time", "no-contact-channel-try-model"), ("closing_time", "no-contact-channel")],
)
def test_a_limit_without_a_recorded_contact_says_whether_the_model_helps(answers, name, code):
    limit = Limit("late", "closing", ((name, 9.0, True),), of="record")
    (row,) = judged(answers[0], [limit], seed=1)
    assert (row["verdict"], row["reason"].code) == ("inconclusive", code)


def test_what_is_missing_is_of_the_motion():
    """A gap within it, but not that the record ends early."""
    raw = replace(smooth(np.random.default_rng(1), until=45.0), settings={"missing": 0.05})
    reader = Reader({})
    reader.header = lambda operation: Header()
    assert _record(reader, raw.operation, "closing", raw).reason == ""
    gap = replace(raw, whole=np.where(np.abs(raw.time - 30.0) < 4.0, np.nan, raw.whole))
    reason = _record(reader, raw.operation, "closing", gap).reason
    assert (reason.code, reason.values["missing"]) == ("much-missing", "0.29")


def test_medians_of_a_prior_with_a_slip_in_units_disagree(infer, records, prior):
    assert NAMES[5] == "f"
    slip = Prior(prior.medians * [1, 1, 1, 1, 1, 10, 1], prior.log_sds)
    (far,) = infer(Given(Size(), slip), records[1:2])
    assert far.unresolved.code == "few-draws"
    assert codes(far)[-1] == "prior-disagrees"
    assert far.remarks[-1].values["name"] == "f"
    (near,) = infer(Given(Size(), prior), records[1:2])
    assert "prior-disagrees" not in codes(near)
    assert not near.unresolved
