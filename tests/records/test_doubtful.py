"""Samples that no sensor can give are named; those of impacts, bounces and dampers never are."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.family.drive_family import Family
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.axes import seen_quantum
from breaker.records.checks import doubtful_samples, doubts_in_words
from breaker.shipped import HELD_BACK

RATES = [1.0, 2.5, 10.0, 20.0]
STROKES = [4.0, 14.0, 150.0, 1000.0]


def measured(x, stroke, rng, *, noise=0.1, quantum=0.0):
    """A curve scaled to a stroke, with noise and quantum of one of 14 mm scaled along."""
    x = x + noise * rng.standard_normal(x.size)
    if quantum:
        x = quantum * np.round(x / quantum)
    return x * stroke / 14.0


def doubts(x, rate):
    return doubtful_samples(x, 1.0 / rate, seen_quantum(x))


def none_is_masked(exact, rate, rng):
    masked = 0
    for i, x in enumerate(exact):
        kind = ({}, {"noise": 0.0}, {"quantum": 0.3}, {"noise": 0.02, "quantum": 0.1})[i % 4]
        record = measured(x, STROKES[i % 3], rng, **kind)
        masked += (doubts(record, rate) != "").any()
    # Three checks at a rate of 1.25e-4: of 250 records more than 2 have a remark at 1.3e-4.
    assert masked <= 2


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_no_sample_of_the_model_is_masked(prior, motion, rate):
    """2,000 curves in all, of strokes from 4 to 150 mm, white noise or none, coarse or fine."""
    rng = generator(1, "doubtful", motion, str(rate))
    time = np.arange(0.0, 76.0, 1.0 / rate)
    onset = 10.0 + rng.random(250)
    none_is_masked(travel(prior.sample(250, rng), time, motion, onset=onset).travel, rate, rng)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_no_sample_of_a_rig_is_masked(prior, defaults, motion, rate):
    """200 rigs with bounces, dampers, bumpers, and what the family lacks: an elastic linkage."""
    foreign = {"force_fall": [0.0, 0.15], "drag": [0.005, 0.05], "linkage": [0.5, 2.0]}
    rigs = family_of(HELD_BACK)
    family = Family(prior, rigs | {"effects": rigs["effects"] | foreign})
    rng = generator(2, "doubtful", motion, str(rate))
    time = np.arange(0.0, 76.0, 1.0 / rate)
    exact = [family.new(rng).travel(motion, time - 10.0 - rng.random()) for _ in range(25)]
    none_is_masked(exact, rate, rng)


@pytest.mark.parametrize("between", [2, 4])
@pytest.mark.parametrize("motion", MOTIONS)
def test_no_sample_is_masked_between_which_others_were_interpolated(prior, motion, between):
    rng = generator(4, "doubtful", motion, str(between))
    time = np.arange(0.0, 76.0, 0.2)
    fine = np.linspace(time[0], time[-1], between * (time.size - 1) + 1)
    for exact in travel(prior.sample(40, rng), time, motion, onset=np.full(40, 10.0)).travel:
        x = np.interp(fine, time, measured(exact, 14.0, rng))
        assert not (doubts(x, 5.0 * between) != "").any()


# ---- planted damage -----------------------------------------------------------------------------


# How many samples in a row, and what they read instead of x, mm.
DAMAGE = {
    "spike": (1, lambda x, stroke: x + 0.5 * stroke),
    "dip": (1, lambda x, stroke: x - 0.5 * stroke),
    "pair": (2, lambda x, stroke: x + 0.4 * stroke),
    "burst of 0.8 ms": (8, lambda x, stroke: x + 0.57 * stroke),
    "broken wire for 3 ms": (30, lambda x, stroke: 1.7 * stroke),
    "absurd": (3, lambda x, stroke: [1e246, -1e300, np.inf]),
    "far": (1, lambda x, stroke: -0.8 * stroke),
}


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("stroke", STROKES)
def test_damage_is_masked_and_nothing_else(prior, damage, motion, stroke):
    """At rest before the motion, in it, and after it."""
    rng, (samples, reading) = generator(3, "damage", motion, str(stroke)), DAMAGE[damage]
    time = np.arange(0.0, 76.0, 0.1)
    exact = travel(prior.sample(20, rng), time, motion, onset=10.0).travel
    for x, at in zip(exact, rng.integers(40, 700, 20), strict=True):
        record = measured(x, stroke, rng)
        wrong = range(at, at + samples)
        record[wrong] = reading(record[wrong], stroke)
        found = np.flatnonzero(doubts(record, 10.0))
        # A sample at the edge of a block may happen to be where the travel is.
        assert set(found) <= set(wrong)
        assert len(found) >= len(wrong) - 1


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_what_is_no_record_is_no_error(share):
    """Noise of any size on any share of samples, all missing, all equal, or hardly any."""
    rng = generator(8, "no record", str(share))
    for size in (2, 5, 6, 30, 760):
        for scale in (1e-300, 1.0, 1e3, 1e300):
            x = np.where(rng.random(size) < share, scale * rng.standard_normal(size), 0.0)
            assert doubtful_samples(x, 0.1, seen_quantum(x)).shape == (size,)
        assert not (doubtful_samples(np.full(size, np.nan), 0.1, 0.0) != "").any()
        assert not (doubtful_samples(np.full(size, 3.0), 0.1, 0.0) != "").any()


def test_doubts_are_listed_with_their_times():
    kinds = np.full(100, "", dtype="U12")
    kinds[[7, 30, 31, 32, 50, 60, 70]] = "spike", *3 * ["jump"], *3 * ["spike"]
    remark = doubts_in_words(0.1 * np.arange(100), kinds)
    assert remark.values["count"] == 7
    assert "jump at 3 ms (sample 31)" in remark.values["places"]
    assert doubts_in_words(np.arange(3.0), np.full(3, "")) == ""


def swinging(time, rate):
    """A closing of 170 mm that goes 18 mm too far, of noise below the step of its reading."""
    share = np.clip((time - 60.0) / 25.0, 0.0, 1.0)
    beyond = np.clip(time - 80.0, 0.0, None)
    record = 170.0 * share**2 * (3.0 - 2.0 * share)
    record += 32.0 * np.sin(0.15 * beyond) * np.exp(-beyond / 20.0) * (time > 80.0)
    return record + 0.04 * np.random.default_rng(round(rate)).standard_normal(time.size)


@pytest.mark.parametrize("rate", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("quantum", [0.01, 0.1])
def test_a_top_that_is_cut_off_is_masked(rate, quantum):
    """Also where both rests are seen; a top that is whole, or a rest without noise, is kept."""
    time = np.arange(0.0, 300.0, 1.0 / rate)
    record = swinging(time, rate)
    cut = quantum * np.rint(np.minimum(record, 175.0) / quantum)
    assert set(doubts(cut, rate)[cut == cut.max()]) == {"clipped"}
    assert not (doubts(quantum * np.rint(record / quantum), rate) != "").any()
    hard = 170.0 * np.clip((time - 60.0) / 25.0, 0.0, 1.0) ** 2
    assert not (doubts(quantum * np.rint(hard / quantum), rate) != "").any()


@pytest.mark.parametrize("period", [3.2, 4.9, 7.0])
def test_a_ripple_makes_no_jump(period):
    """As on an elastic linkage, by 1 % of the stroke, in little noise; so large a slip is one."""
    time = 0.1 * np.arange(1500)
    rise = np.clip((time - 40.0) / 35.0, 0.0, 1.0)
    fall = np.clip((time - 100.0) / 20.0, 0.0, 1.0)
    way = 140.0 * (rise**2 * (3.0 - 2.0 * rise) - fall**2 * (3.0 - 2.0 * fall))
    speed = np.abs(np.gradient(way))
    for seed in range(10):
        rng = np.random.default_rng(seed)
        swing = 1.6 * speed / speed.max() * np.sin(2.0 * np.pi * time / period + seed)
        travel = way + swing + 0.02 * rng.standard_normal(time.size)
        assert (doubtful_samples(travel, 0.1, 0.0) == "").all()
    slipped = travel + 1.6 * (time > 85.0)
    assert (doubtful_samples(slipped, 0.1, 0.0) != "").any()
