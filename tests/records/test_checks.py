"""Checks of samples and records: good ones pass at the stated rate, planted faults do not."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.family.drive_family import Family
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.records.checks import (
    check_slips,
    doubtful_samples,
    ends_of_range,
    of_no_drive,
    unsteady_remark,
)
from breaker.records.conversion import seen_quantum
from breaker.records.measurements import measure_curve
from breaker.records.motion import find_segment
from breaker.records.rejections import UnusableError
from tests.raws import swinging

STROKES = [4.0, 14.0, 150.0, 1000.0]
TIME = np.arange(0.0, 76.0, 0.1)
MOVES = 10.0


def measured(x, stroke, rng, *, noise=0.1, quantum=0.0):
    """A curve scaled to a stroke, with noise and quantum of one of 14 mm scaled along."""
    x = x + noise * rng.standard_normal(x.size)
    if quantum:
        x = quantum * np.round(x / quantum)
    return x * stroke / 14.0


def doubts(x, rate=10.0):
    return doubtful_samples(x, 1.0 / rate, seen_quantum(x))


# ---- good samples are kept ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rate", "motion"), [(1.0, "closing"), (2.5, "opening"), (10.0, "closing"), (20.0, "opening")]
)
def test_no_sample_of_a_good_record_is_masked(prior, defaults, rate, motion):
    """Of 250 records of the model and 25 of drives with bounces, dampers and an elastic linkage,
    of strokes from 4 to 150 mm, white noise or none, coarse or fine.
    """
    family = Family(prior, family_of("medium_voltage"))
    rng, masked = generator(1, "doubtful", motion, str(rate)), 0
    time = np.arange(0.0, 76.0, 1.0 / rate)
    onset = 10.0 + rng.random(250)
    exact = [*travel(prior.sample(250, rng), time, motion, onset=onset).travel]
    exact += [family.new(rng).travel(motion, time - 10.0 - rng.random()) for _ in range(25)]
    for i, x in enumerate(exact):
        kind = ({}, {"noise": 0.0}, {"quantum": 0.3}, {"noise": 0.02, "quantum": 0.1})[i % 4]
        masked += (doubts(measured(x, STROKES[i % 3], rng, **kind), rate) != "").any()
    # Three checks at a rate of 1.25e-4: of 275 records more than 2 have a remark at 2e-4.
    assert masked <= 2


@pytest.mark.parametrize("values", [[np.nan] * 760, [3.0] * 760, [0.0, 1e300], [1e300, 0.0] * 15])
def test_what_is_no_record_is_no_error(values):
    assert doubts(np.array(values)).shape == (len(values),)


# ---- planted damage ----------------------------------------------------------------------------

# How many samples in a row, and what they read instead of x, mm.
DAMAGE = {
    "spike": (1, lambda x, stroke: x + 0.5 * stroke),
    "dip": (1, lambda x, stroke: x - 0.5 * stroke),
    "pair": (2, lambda x, stroke: x + 0.4 * stroke),
    "burst of 0.8 ms": (8, lambda x, stroke: x + 0.57 * stroke),
    "broken wire for 3 ms": (30, lambda x, stroke: 1.7 * stroke),
    "absurd": (3, lambda x, stroke: [1e246, -1e300, np.inf]),
}


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("motion", MOTIONS)
def test_damage_is_masked_and_nothing_else(prior, damage, motion):
    """At rest before the motion, in it, and after it, of any stroke."""
    rng, (samples, reading) = generator(3, "damage", motion), DAMAGE[damage]
    exact = travel(prior.sample(40, rng), TIME, motion, onset=10.0).travel
    for k, (x, at) in enumerate(zip(exact, rng.integers(40, 700, 40), strict=True)):
        record = measured(x, STROKES[k % 4], rng)
        wrong = range(at, at + samples)
        record[wrong] = reading(record[wrong], STROKES[k % 4])
        masked = np.flatnonzero(doubts(record))
        # A sample at the edge of a block may happen to be where the travel is.
        assert set(masked) <= set(wrong)
        assert len(masked) >= len(wrong) - 1


@pytest.mark.parametrize(("rate", "quantum"), [(5.0, 0.1), (20.0, 0.01)])
def test_a_top_that_is_cut_off_is_masked(rate, quantum):
    """Also where both rests are seen; a top that is whole, or a rest without noise, is kept."""
    time = np.arange(0.0, 300.0, 1.0 / rate)
    share = np.clip((time - 60.0) / 25.0, 0.0, 1.0)
    beyond = np.clip(time - 80.0, 0.0, None)
    record = 170.0 * share**2 * (3.0 - 2.0 * share)
    record += 32.0 * np.sin(0.15 * beyond) * np.exp(-beyond / 20.0) * (time > 80.0)
    record += 0.04 * np.random.default_rng(5).standard_normal(time.size)
    cut = quantum * np.rint(np.minimum(record, 175.0) / quantum)
    assert set(doubts(cut, rate)[cut == cut.max()]) == {"clipped"}
    for whole in (record, 170.0 * share**2):
        assert not (doubts(quantum * np.rint(whole / quantum), rate) != "").any()


@pytest.mark.parametrize("period", [3.2, 7.0])
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
        reading = way + swing + 0.02 * rng.standard_normal(time.size)
        assert (doubtful_samples(reading, 0.1, 0.0) == "").all()
    assert (doubtful_samples(reading + 1.6 * (time > 85.0), 0.1, 0.0) != "").any()


# ---- a reading that jumps ----------------------------------------------------------------------

SLIPS = {
    "behind": lambda time, at, size: size * (time > 135.0 + at),
    "before": lambda time, at, size: size * (time < 30.0 - 0.2 * at),
    "returns": lambda time, at, size: size * ((time > 140.0 + at) & (time < 155.0 + at)),
    "within": lambda time, at, size: size * (time > 75.0 + 0.5 * at),
}


def swings(rate):
    """A motion of 178 mm from 55 ms on of 60 ms, that swings at its end."""
    time = np.arange(0.0, 400.0, 1.0 / rate)
    noise = 0.1 * np.random.default_rng(3).standard_normal(time.size)
    return time, swinging(time - 55.0, 178.0, 60.0, 0.06, 0.3) + noise


@pytest.mark.parametrize("kind", SLIPS)
@pytest.mark.parametrize(("rate", "size"), [(5.0, -2.2), (20.0, 2.2)])
def test_a_slip_is_named_and_in_the_uncertainty(rate, kind, size):
    for at in (0.0, 40.0):
        time, reading = swings(rate)
        slipped = reading + SLIPS[kind](time, at, size)
        kinds = doubtful_samples(slipped, 1.0 / rate, 0.0)
        assert kinds[kinds != ""].tolist() == ["slip"] * (2 if kind == "returns" else 1)
        if kind == "before":
            with pytest.raises(UnusableError):  # it looks like the first motion
                check_slips(time, slipped, kinds, find_segment(time, slipped, "closing"))
        stroke = measure_curve(time, slipped, "closing")["stroke"]
        assert abs(stroke.value - 178.0) < 3.0 * stroke.sd < 4.0 * abs(size)


@pytest.mark.parametrize("kind", ["behind", "within"])
@pytest.mark.parametrize("lasts", [0.05, 4.0, np.inf])
def test_what_returns_soon_is_left_out_and_a_large_slip_is_refused(kind, lasts):
    """By 17 % of the stroke."""
    time, reading = swings(10.0)
    at = time[(SLIPS[kind](time, 0.0, 1.0) > 0.0).argmax()]
    off = 30.0 * ((time >= at) & (time < at + lasts))
    kinds = doubtful_samples(reading + off, 0.1, 0.0)
    sure = np.where(kinds == "", reading + off, np.nan)
    segment = find_segment(time, sure, "closing")
    if np.isinf(lasts):
        with pytest.raises(UnusableError):
            check_slips(time, sure, kinds, segment)
    else:
        check_slips(time, sure, kinds, segment)
        assert (kinds[off > 0.0] != "").all()
        stroke = measure_curve(time, reading + off, "closing")["stroke"]
        assert abs(stroke.value - 178.0) < max(3.0 * stroke.sd, 0.1)
        assert stroke.sd < 0.6


# ---- whole records -----------------------------------------------------------------------------


@pytest.mark.parametrize(("rate", "quantum"), [(2.5, 0.0), (10.0, 0.05), (40.0, 0.5)])
def test_an_end_of_the_range_within_the_stroke_is_named(rate, quantum):
    """In the motion or at rest before it. Where a quantum hides the noise, no end can be."""
    time, reading = swings(rate)
    for ends in ((-np.inf, np.inf), (-np.inf, 120.0), (0.5, np.inf)):
        read = np.clip(reading, *ends)
        read = quantum * np.round(read / quantum) if quantum else read
        ended = np.isfinite(ends_of_range(time, read, 55.0)).any()
        assert ended == (np.isfinite(ends).any() and quantum < 0.5)


@pytest.mark.parametrize(("stroke", "lasts"), [(13.0, 5.2), (6.0, 5.0), (150.0, 45.0)])
def test_a_motion_of_no_drive_is_named(stroke, lasts):
    """Where its time or its unit is wrong by a factor of 10 or 20."""
    for factor, wrong in ((1.0, False), (0.1, True), (20.0, True)):
        time = np.linspace(0.0, 2.0 * factor * lasts, 400)
        done = np.clip((time - 0.5 * factor * lasts) / (1.25 * factor * lasts), 0.0, 1.0)
        assert bool(of_no_drive("closing", time, done, stroke)) == wrong


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_rest_that_moves_is_seen_and_none_in_good_records(prior, motion):
    """By hum or a bump, before the motion or after it; of 100 good records 2 have
    a remark at 7e-4.
    """
    rng = generator(3, "records", motion)
    exact = travel(prior.sample(100, rng), TIME, motion, onset=MOVES).travel
    good = np.round(exact + 0.05 * rng.standard_normal(exact.shape), 2)

    def is_unsteady(reading):
        segment = find_segment(TIME, reading, motion)
        return bool(unsteady_remark(TIME, reading, MOVES, segment))

    assert sum(map(is_unsteady, good)) <= 1
    moved = [0.5 * np.sin(0.1 * np.pi * TIME + 1.0), 0.5 * np.cos(0.12 * np.pi * TIME)]
    moved += [s * np.exp(-(((TIME - at) / 2.0) ** 2)) for s, at in ((0.4, 4.0), (1.5, 66.0))]
    for off in moved:
        assert all(is_unsteady(reading + off) for reading in good[:5])
