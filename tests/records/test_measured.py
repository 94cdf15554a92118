"""Quantities read from records, against the exact ones of the curves that were recorded."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.evaluation import evaluate
from breaker.model.quantities import quantities_of, speeds_of
from breaker.records.contacts import ContactTimes
from breaker.records.first_motion import first_motion
from breaker.records.measurements import Reading, measure_curve
from breaker.records.motion import LocatedMotion, find_segment
from tests.raws import swinging

SPEEDS = speeds_of(
    {
        "closing_speed_mean": ["10 % of stroke", "90 % of stroke"],
        "closing_speed_late": ["4 ms before touch", "touch"],
        "opening_speed_mean": ["10 % of stroke", "90 % of stroke"],
        "opening_speed_early": ["1 mm after separation", "6 ms after separation"],
    }
)
TIMED = {"closing": "touch_time", "opening": "separation_time"}
NOISE, CONTACT_SD = 0.1, 0.1
UNKNOWN, TIMING = ContactTimes(), ContactTimes(18.0, 0.1)


def record_of(theta, motion, rng):
    """Read one record of a drive, its first motion some 8 ms late."""
    time = np.arange(0.0, 72.0, 0.1)
    begins = 8.0 + rng.uniform(0.0, 0.1)
    curve = travel(theta[None], time, motion, onset=begins).travel[0]
    read = curve + NOISE * rng.standard_normal(time.size) + 0.05 * rng.standard_normal()
    timing = evaluate([TIMED[motion]], theta[None], motion)[0, 0]
    touch = begins + timing + CONTACT_SD * rng.standard_normal()
    return reading_of(time, read, motion, ContactTimes(touch, CONTACT_SD)).quantities()


def reading_of(time, read, motion, contact=UNKNOWN):
    """What the reader finds in a record."""
    segment = find_segment(time, read, motion)
    inside = slice(segment.begin, segment.end)
    moves = first_motion(time[inside], read[inside], motion)
    about = motion, time, read, np.full(time.size, ""), 0.0, segment, *moves
    return Reading(LocatedMotion(*about), contact, SPEEDS)


def scores(motion, prior, n=40):
    """Errors of what is measured in n records, in their stated sds, by name, ``(n,)``."""
    rng = generator(3, "test", "measured", motion)
    theta = prior.sample(n, rng)
    names = list(quantities_of(motion, SPEEDS))
    truth = evaluate(names, theta, motion, SPEEDS)
    # The contact is behind or before the drive by what its spring gives way, so at the touch the
    # drive is not just the gap from where it began.
    for row, known in zip(theta, truth, strict=True):
        at = np.array([0.0, known[names.index(TIMED[motion])]])
        there = travel(row[None], at, motion).travel[0, 1]
        known[names.index("spring_compression")] = known[names.index("stroke")] - there
    names[names.index("spring_compression")] = f"{motion}_wipe"
    found = [record_of(row, motion, rng) for row in theta]
    values, sds = (
        np.array([[getattr(each[name], part) for name in names] for each in found])
        for part in ("value", "sd")
    )
    return dict(zip(names, ((values - truth) / sds).T, strict=True))


@pytest.fixture(scope="module")
def both(prior):
    return {motion: scores(motion, prior) for motion in TIMED}


@pytest.mark.parametrize("motion", TIMED)
def test_measured_agrees_with_the_model_within_its_uncertainty(both, motion):
    """Of normal errors of the stated sds, a quantity's sum of squares is beyond either bound with
    probability 2e-5, before the factors for what is not normal; 14 quantities: below 1e-3.
    """
    for name, all_scores in both[motion].items():
        z = all_scores[np.isfinite(all_scores)]
        assert z.size >= 0.75 * all_scores.size, name
        square = np.sum(z**2)
        assert square < 1.5 * chi2.isf(1e-5, z.size), name
        assert abs(z.mean()) < 4.3 / np.sqrt(z.size), name
        if name in TIMED.values():  # their sds allow for slow starts, which these drives have not
            assert square > 0.015 * z.size
        else:
            assert square > chi2.isf(1 - 1e-5, z.size) / 1.5, name


# ---- what a record does not show -------------------------------------------------------------


@pytest.fixture
def reading(prior):
    time = np.arange(0.0, 90.0, 0.1)
    curve = travel(prior.medians[None], time, "closing", onset=8.0).travel[0]
    read = curve + 0.02 * np.random.default_rng(2).standard_normal(time.size)
    return reading_of(time, read, "closing")


def test_without_contact_timing(reading):
    found = reading.quantities()
    for name in ("touch_time", "closing_wipe", "closing_speed", "closing_speed_late"):
        assert found[name].reason
        assert np.isnan([found[name].value, found[name].sd]).all()
    for name in ("stroke", "travel_time", "closing_speed_mean", "over_travel"):
        assert found[name].reason == ""
        assert np.isfinite([found[name].value, found[name].sd]).all()


def test_times_from_the_trigger_and_of_bounces(reading):
    timed = ContactTimes(18.0, 0.1, trigger=2.0, bounce_time=3.5)
    found = replace(reading, contact=timed).quantities()
    assert found["closing_time"][:2] == pytest.approx((16.0, 0.1))
    assert found["bounce_time"].value == pytest.approx(3.5)
    assert 0.0 < found["bounce_time"].sd < 0.1
    travels = found["time_to_90"].value - found["time_to_10"].value
    assert travels == pytest.approx(found["travel_time"].value)
    assert found["reaction_time"].value < found["time_to_10"].value < found["time_to_50"].value
    assert abs(found["reaction_time"].value - 6.0) < 5.0 * found["reaction_time"].sd < 2.5
    found = replace(reading, contact=TIMING).quantities()
    for name in ("reaction_time", "closing_time", "time_to_50", "bounce_time"):
        assert found[name].reason


def test_missing_samples(reading):
    """Only what needs them is missing."""
    time, whole = reading.located.time, reading.located.whole
    begin = time[int(np.argmax(whole > 0.1 * 13.5))]
    missing = replace(reading.located, whole=np.where(np.abs(time - begin) < 1.5, np.nan, whole))
    found = Reading(missing, TIMING).quantities()
    assert found["travel_time"].reason
    assert found["stroke"].reason == found["closing_speed"].reason == ""


# ---- records as breakers give them -------------------------------------------------------------


def made_up(number):
    """A record of 10 to 250 mm with what tests bring, its motion, stroke, over-travel and speed."""
    rng = np.random.default_rng([24, number])
    stroke = float(np.exp(rng.uniform(np.log(10.0), np.log(250.0))))
    duration, rate = (9.0 + 0.22 * stroke) * rng.uniform(0.7, 1.3), rng.choice([2.0, 5.0, 20.0])
    lead, tail, over, fades = 0.6 * duration, rng.uniform(2.5, 8.0), rng.choice([0.0, 0.1]), 0.3
    kind = ("plain", "spike", "ends", "early", "rings")[number % 5]
    if kind in ("early", "rings"):
        tail, fades = (0.3, 0.3) if kind == "early" else (2.0, 1.0)

    time = np.arange(0.0, lead + duration * (1.0 + tail), 1.0 / rate)
    noise = min(float(np.exp(rng.uniform(np.log(0.05), np.log(1.2)))), 0.02 * stroke)
    about = stroke, duration, over, fades
    travel = swinging(time - lead, *about) + noise * rng.standard_normal(time.size)
    if kind in ("spike", "ends"):
        where = rng.integers(0, time.size, 3) if kind == "spike" else rng.choice([0, -1])
        travel[where] += rng.choice([-1.0, 1.0]) * rng.uniform(10.0, 60.0)
    fine = np.linspace(0.0, 20.0 * duration, 100_000)
    exact = swinging(fine, *about)
    begin, end = (fine[int((exact >= share * stroke).argmax())] for share in (0.1, 0.9))
    truth = {"stroke": stroke, "travel_time": end - begin, "over_travel": exact.max() - stroke}
    return time, travel, truth | {"closing_speed_mean": 0.8 * stroke / (end - begin)}


def test_a_value_with_a_wide_uncertainty_rather_than_none():
    """Of records that show the rest all values, of others none of its stroke.

    95 % intervals hold the truth in at least 90 % of them.
    """
    held = []
    for number in range(100):
        time, travel, truth = made_up(number)
        found = measure_curve(time, travel, "closing", speeds=SPEEDS)
        early = number % 5 == 3
        assert {bool(found[name].reason) for name in truth} == {early}, number
        if early:
            continue
        held.append(
            [abs(found[name].value - truth[name]) < 1.96 * found[name].sd for name in truth]
        )
    assert (np.mean(held, axis=0) >= 0.9).all()


def test_speeds_between_points_that_makers_name():
    """From and to a rest, and about a point: as way over time of the exact curve."""
    time = np.arange(0.0, 100.0, 0.1)
    share = np.clip((time - 20.0) / 40.0, 0.0, 1.0)
    read = 120.0 * share**2 * (3.0 - 2.0 * share)
    read += 0.02 * np.random.default_rng(5).standard_normal(time.size)
    exact = {
        ("0 % of stroke", "50 % of stroke"): 60.0 / 20.0,
        ("60 mm from open", "18.75 mm from closed"): 41.25 / 10.0,
        ("50 % from closed", "10 ms after 50 % of stroke"): 41.25 / 10.0,
        ("10 ms before 60 mm from closed", "60 mm from open"): 41.25 / 10.0,
    }
    for points, expected in exact.items():
        speeds = speeds_of({"closing_speed": list(points)})
        found = measure_curve(time, read, "closing", speeds=speeds)["closing_speed"]
        assert abs(found.value - expected) < max(4.0 * found.sd, 2e-3), points
