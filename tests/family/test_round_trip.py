"""Curves of the model through files: what comes back is a record of the truth that is told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.common.randomness import generator
from breaker.family.dialects import DIALECTS
from breaker.family.round_trip import through_files
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from breaker.records.settings import FORMAT

CURVES = 60
# Each record's chi-square has t degrees of freedom at the truth. Two-sided, over all records of a
# motion together: a false alarm of 1e-3.
FALSE_ALARM = 1e-3


@pytest.fixture(scope="module", params=MOTIONS)
def through(request, prior, sensor):
    rng = generator(4, "test through files", request.param)
    through = through_files(prior, sensor, request.param, CURVES, rng)
    return request.param, through.measured, through.truth


def tail(sensor, motion, measured, truth):
    """Smaller tail probability of each record's chi-square at a truth, ``(n,)``."""
    p = len(NAMES)
    exact = travel(truth[:, :p], sensor.times, motion, onset=truth[:, p]).travel
    square = sensor.chi_square(measured, exact)
    df = sensor.samples
    return np.minimum(chi2.cdf(square, df), chi2.sf(square, df))


def test_the_format_is_the_default_of_the_configuration(defaults):
    assert defaults["endurance"]["format"] == FORMAT


def test_records_are_those_of_the_truth(through, sensor):
    motion, measured, truth = through
    assert measured.shape == (CURVES, sensor.samples)
    assert truth.shape == (CURVES, len(NAMES) + 1)
    assert tail(sensor, motion, measured, truth).min() > FALSE_ALARM / (2 * CURVES)


@pytest.mark.parametrize("fault", ["onset", "sign of the onset", "another curve", "averaged"])
def test_a_wrong_truth_would_be_noticed(through, sensor, fault):
    motion, measured, truth = through
    if fault == "onset":
        truth = truth + np.eye(len(NAMES) + 1)[-1] * 0.4  # one sample of the grid off
    elif fault == "sign of the onset":
        truth = truth * np.array([1.0] * len(NAMES) + [-1.0])
    elif fault == "another curve":
        truth = np.roll(truth, 1, axis=0)
    else:  # what averaging the four samples of a step would do to the noise
        exact = travel(truth[:, :-1], sensor.times, motion, onset=truth[:, -1]).travel
        measured = exact + 0.5 * (measured - exact)
    assert tail(sensor, motion, measured, truth).min() < FALSE_ALARM / (2 * CURVES)


def test_the_onset_is_small_against_its_prior(through, sensor):
    _, _, truth = through
    # The reader's first motion is off by 0.06 ms, sd 0.12 ms (tests of first_motion), and its
    # rounding to a sample of 0.1 ms by up to 0.05 ms.
    assert abs(truth[:, -1].mean()) < 0.12  # 4 standard errors away: below 1e-4
    assert 0.05 < truth[:, -1].std() < 0.5 * sensor.onset_sd


def test_dialects_take_turns_and_the_same_generator_gives_the_same_bytes(prior, sensor):
    some = [DIALECTS["tab"], DIALECTS["degrees"]]
    first, again, one = (
        through_files(prior, sensor, "opening", 5, generator(8, "test turns"), each)
        for each in (some, some, some[:1])
    )
    assert first.dialect.tolist() == [0, 1, 0, 1, 0]
    assert [each.tobytes() for each in again[:3]] == [each.tobytes() for each in first[:3]]
    assert one.truth[:, :7].tobytes() == first.truth[:, :7].tobytes()


# Rates of which the grid's 2.5 kHz is a whole fraction. At others samples are moved, which takes a
# part of their noise; slower ones leave times of the grid without a sample.
@pytest.mark.parametrize("rate", [2.5, 5.0, 25.0, 100.0])
def test_other_rates(prior, sensor, rate):
    rng = generator(8, "test rates", int(10 * rate))
    wide = DIALECTS["wide"]
    other = replace(wide, rate=rate, settings={**wide.settings, "rate": rate})
    measured, truth, *_ = through_files(prior, sensor, "opening", 20, rng, [other])
    assert tail(sensor, "opening", measured, truth).min() > FALSE_ALARM / (2 * 20)


def test_rejected_records_are_counted_by_reason(prior, sensor):
    far = replace(sensor, zero_sd=3.0)  # a zero beyond what the reader takes for an open breaker
    found = through_files(prior, far, "closing", 24, generator(8, "test far"))
    assert 0 < len(found.measured) == len(found.truth) == found.dialect.size < 24
    assert sum(found.rejected.values()) == 24 - found.dialect.size
    (first, *_), counts = zip(*found.rejected.items(), strict=True)
    assert first.startswith("the open breaker rests at # mm, not near #")
    assert max(counts) > 1
    assert tail(far, "closing", found.measured, found.truth).min() > FALSE_ALARM / (2 * 24)
    farther = replace(sensor, zero_sd=1e4)
    with pytest.raises(RuntimeError, match=r"all 4 curves of the model are rejected: .*near #"):
        through_files(prior, farther, "closing", 4, generator(8, "test farther"))
