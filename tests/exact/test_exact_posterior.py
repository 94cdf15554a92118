"""One operation as particles see it: drives laid onto its records, and what is told of them."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.answers.drive_records import read_operations
from breaker.drive.answers.evidence import Answer, AnswerSettings, Given
from breaker.drive.answers.inference import infer_drive
from breaker.drive.exact import exact_posterior
from breaker.drive.exact.exact_posterior import _evidence, _Operation, divergence, exactly
from breaker.drive.exact.family_scores import FamilyScores
from breaker.drive.exact.record_samples import RecordSamples
from breaker.drive.family.mechanisms import MECHANISMS
from breaker.quantities.parameters import MOTIONS, NAMES
from breaker.quantities.size import Size
from breaker.reading.files.operations_table import Operation
from breaker.reading.instruments.export import write_curve
from breaker.reading.records.contact_edges import Contact

SETTINGS = AnswerSettings(draws=100, misfit_p_value=1e-3, seed=1)
NOISE = 0.01  # mm
SIZE = Size(4.0, 1.5)


def read(folder, number=1):
    """Records of a file, with the number of its operation."""
    found = [Operation(number, folder)]
    return read_operations({motion: found for motion in MOTIONS}, {}, loose=True)


# ---- drives laid onto records --------------------------------------------------------------------


@pytest.fixture(scope="module")
def drive(drawn):
    return next(each for each in drawn if each.elements.contact == "held")


@pytest.fixture(scope="module")
def operation(drive, scores, tmp_path_factory):
    """A closing and an opening of a drive of another size, with little noise."""
    time, rng, answers = 0.1 * np.arange(1200), generator(1, "laid"), []
    for motion in MOTIONS:
        file = tmp_path_factory.mktemp("laid") / f"{motion}.csv"
        way = drive.scaled(SIZE).travel(motion, time - 20.0) + NOISE * rng.standard_normal(1200)
        write_curve(file, time, way, motion=motion, operation=1)
        (record,) = (each for each in read(file) if not each.reason)
        answers.append(Answer(record))
    samples = [
        RecordSamples.of(
            e.record.raw, e.record.tenth, e.record.shape.stroke, e.record.shape.duration
        )
        for e in answers
    ]
    return _Operation(answers, Given(), scores, samples)


def laid(drive, *scores):
    """Numbers of a drive, with scores of its size and its releases."""
    return np.hstack([drive.numbers, scores])[None]


def test_a_drive_is_laid_onto_its_record_by_stroke_and_duration(operation, drive):
    found, travels = operation.simulate(laid(drive, 0.0, 0.0, 0.0, 0.0))
    assert np.allclose(found.theta, drive.scaled(SIZE).theta, rtol=0.02)
    true = drive.scaled(SIZE)
    for answer, samples, travel in zip(operation.answers, operation.samples, travels, strict=True):
        motion, record = answer.record.motion, answer.record
        begin = 20.0 - record.tenth
        assert found.release[motion][0] == pytest.approx(begin, abs=0.1)
        own, switching = true.operate(motion, samples.times - begin)
        assert found.switching[motion][0] == pytest.approx(begin + switching, abs=0.2)
        assert np.abs(travel - own).max() < 0.01 * record.shape.stroke
        assert np.allclose(samples.travel - samples.travel[0], own - own[0], atol=8 * NOISE)


def test_scores_change_the_size_and_the_releases_each_by_itself(operation, drive):
    plain, _ = operation.simulate(laid(drive, 0.0, 0.0, 0.0, 0.0))
    larger, _ = operation.simulate(laid(drive, 1.0, 0.0, 0.0, 0.0))
    slower, _ = operation.simulate(laid(drive, 0.0, 1.0, 0.0, 0.0))
    later, _ = operation.simulate(laid(drive, 0.0, 0.0, 0.0, 1.0))
    size = Size(np.exp(0.1), 1.0), Size(1.0, np.exp(0.1))
    for found, by in zip((larger, slower), size, strict=True):
        assert np.allclose(found.theta, plain.theta * by.factors)
    assert np.allclose(later.theta, plain.theta)
    closing, opening = (later.release[m] - plain.release[m] for m in MOTIONS)
    assert closing == 0.0
    assert opening == pytest.approx(0.1 * operation.answers[1].record.shape.duration)
    assert later.switching["opening"] - plain.switching["opening"] == pytest.approx(opening)


def test_a_given_size_is_taken_as_it_is(operation, drive):
    given = replace(operation, given=Given(size=SIZE))
    found, _ = given.simulate(laid(drive, 2.0, -1.0, 0.0, 0.0))
    assert np.allclose(found.theta, drive.scaled(SIZE).theta)


def test_what_is_no_drive_is_told_by_nan(operation, drive):
    both = np.vstack([laid(drive, *np.zeros(4)), laid(drive.changed(f=1e-3), *np.zeros(4))])
    residuals = operation.residuals(both)
    assert residuals.shape == (2, sum(each.times.size for each in operation.samples))
    assert np.isfinite(residuals).all(axis=1).tolist() == [True, False]


def test_a_contact_that_counts_is_a_residual(operation, drive):
    first = operation.answers[0]
    plain = operation.residuals(laid(drive, *np.zeros(4)))
    found, _ = operation.simulate(laid(drive, *np.zeros(4)))
    at = first.record.tenth + found.switching["closing"][0]
    raw = replace(first.record.raw, contact=Contact(at - 0.6, 0.2))
    for surprise, more in ((0.5, [3.0]), (50.0, [])):
        timed = replace(first, record=replace(first.record, raw=raw), surprise=surprise)
        other = replace(operation, answers=[timed, operation.answers[1]])
        residuals = other.residuals(laid(drive, *np.zeros(4)))
        assert np.allclose(residuals, [[*plain[0], *more]])


# ---- evidence, and how far networks are off ------------------------------------------------------


def test_evidence_of_drives_of_the_family_itself_is_none(operation, scores, drawn):
    rng = generator(2, "evidence")
    numbers = np.vstack([laid(each, *np.zeros(4)) for each in drawn])
    found = _evidence(operation, numbers, len(numbers), rng)
    assert found.keys() == {*MECHANISMS, *scores.kinds}
    # Log odds of shares of at least 0.1 of 600 drives, and of some 2,000: 4 standard errors.
    assert max(map(abs, found.values())) < 4.0 * np.sqrt((1.0 / 600 + 1.0 / 2000) / (0.1 * 0.9))


def test_evidence_is_beside_the_shares_that_the_family_has(operation, scores, drawn):
    """Not those of its draws, of which fewer work of some kinds; and as sure as draws can be."""
    numbers = np.vstack([laid(e, *np.zeros(4)) for e in drawn if e.elements.contact == "elastic"])
    found = _evidence(operation, numbers, 200.0, generator(3, "evidence"))
    bound = np.log((1.0 - 0.5 / 200.0) / (0.5 / 200.0))
    for kind, sign in (("elastic", 1.0), ("held", -1.0)):
        share = scores.family.settings["contacts"][kind]
        expected = sign * bound - np.log(share / (1.0 - share))
        assert found[kind] == pytest.approx(expected, abs=0.18)  # 4 standard errors


def test_there_is_no_evidence_of_what_all_drives_of_a_family_have(operation, family):
    settings = family.settings | {"strength": 1.0, "contacts": {"elastic": 1, "held": 0}}
    settings["contacts"]["sliding"] = 0
    alike = FamilyScores.of(replace(family, settings=settings), generator(3, "evidence"))
    other, rng = replace(operation, scores=alike), generator(4, "evidence")
    numbers = other.numbers(rng.standard_normal((300, other.target.unknowns)))
    assert _evidence(other, numbers, 300.0, rng).keys().isdisjoint({"elastic", "drag", "build_up"})


def test_the_divergence_is_that_of_two_normals():
    rng = generator(1, "divergence")
    one, two = rng.standard_normal((2, 200_000, 2))
    assert divergence(one, two) == pytest.approx(0.0, abs=1e-3)
    expected = 0.5 * (2 / 9 - 2 + 1 / 9 + 2 * np.log(9) / 2 * 2)
    assert divergence(one, 3.0 * two + [1.0, 0.0]) == pytest.approx(expected, rel=0.02)


# ---- answers -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def infer(small, levels, folder):
    """Infer a closing, whose contact was timed if a time is given, exactly and not."""

    def infer(*contact, given=None):
        given = given or Given()
        (record,) = (each for each in read(folder / "a.csv") if not each.reason)
        if contact:
            raw = replace(record.raw, contact=Contact(*contact))
            record = replace(record, raw=raw)
        answers = infer_drive([record], (levels,), given, (), SETTINGS)
        return answers[0], exactly(answers, given, SETTINGS)[0]

    return infer


def test_drives_touch_when_the_contact_was_timed(infer):
    _, plain = infer()
    _, timed = infer(20.09, 0.1)
    before, after = (each.draws.switching["closing"] for each in (plain, timed))
    assert after.std() < 0.5 * before.std()
    assert after.mean() == pytest.approx(timed.record.switched, abs=0.3)
    assert timed.contact.time == pytest.approx(20.09)


def test_a_fact_weighs_draws_and_both_answers_know_it(infer):
    network, exact = infer(given=Given(Size(), known={"mu": [2.0, 0.1]}))
    assert exact.effective_size < exact.exact.effective_size
    both = [np.log(each.draws.theta) for each in (exact, network)]
    assert exact.exact.gap == pytest.approx(divergence(*both))
    assert exact.draws.theta[:, NAMES.index("mu")].std() < 0.15


def test_few_independent_draws_are_remarked_on(infer, monkeypatch):
    """Between what is needed and what was aimed at."""

    def remarked(least, enough):
        monkeypatch.setattr(exact_posterior, "LEAST", least)
        monkeypatch.setattr(exact_posterior, "ENOUGH", enough)
        return any("few independent draws" in each for each in infer()[1].remarks)

    assert remarked(1.0, 1e9)
    assert not remarked(0.1, 1.0)
    assert not remarked(1e9, 2e9)  # not told at all


def test_a_contact_that_surprises_is_not_used_and_remarked_on_once(infer):
    network, exact = infer(45.0, 0.1)
    assert abs(network.surprise) > 4.0
    assert any("it is not used" in each for each in exact.remarks)
    assert len(set(exact.remarks)) == len(exact.remarks)
    assert exact.draws.switching["closing"].mean() < exact.record.switched - 10.0


def test_the_way_tells_which_operation_of_how_many(folder, levels, monkeypatch):
    lines = []

    def at_once(answers, given, settings, rng, progress):
        progress("on the way")
        return answers

    monkeypatch.setattr(exact_posterior, "_exact", at_once)
    records = [*read(folder / "both.csv", 3), *read(folder / "a.csv", 5), *read(folder / "bad.csv")]
    answers = infer_drive(records, (levels,), Given(), (), SETTINGS)
    assert exactly(answers, Given(), SETTINGS, lines.append) == answers
    assert lines == ["operation 3 (1 of 2): on the way", "operation 5 (2 of 2): on the way"]
    lines.clear()
    exactly(answers[:2], Given(), SETTINGS, lines.append)
    assert lines == ["on the way"]
