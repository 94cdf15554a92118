"""First motions of slow starts: the interval contains the truth, or the quantity is withheld."""

from dataclasses import replace

import numpy as np

from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve
from tests.raws import smooth

RECORDS = 80


def closing(number, *, slow, strokes=(100.0, 220.0)):
    """Times, travel and first motion of a closing, ms and mm.

    Slow: the travel rises with a power of 1.5 to 4, of every second record after a creep of 0.5 to
    2 % of the stroke in 5 to 20 ms, of several shapes; with hum of 0.05 to 0.3 mm and a ripple.
    """
    rng = np.random.default_rng([71, number])
    stroke = float(np.exp(rng.uniform(*np.log(strokes))))
    lasts, rate = (9.0 + 0.22 * stroke) * rng.uniform(0.7, 1.3), rng.choice([2.0, 5.0, 10.0, 20.0])
    start, tail = rng.uniform(30.0, 80.0), rng.uniform(3.0, 6.0) * lasts
    power, share, creeps = rng.uniform([1.5, 0.005, 5.0], [4.0, 0.02, 20.0])
    if not slow:
        power = rng.uniform(1.7, 2.1)
    if not (slow and number % 2):
        share, creeps = 0.0, 1e-9
    time = np.arange(0.0, start + creeps + lasts + tail, 1.0 / rate)
    fine = np.linspace(0.0, 1.0, 2001)
    speed = fine ** (power - 1.0) * (1.0 - fine**3)
    done = np.cumsum(speed) / speed.sum()
    after, before = (time - start - creeps) / lasts, np.clip((time - start) / creeps, 0.0, 1.0)
    shape = (before, before**1.5, before**2 * (3.0 - 2.0 * before))[number // 2 % 3]
    travel = stroke * ((1.0 - share) * np.interp(after, fine, done) + share * shape)
    noise = rng.choice([0.02, 0.05, 0.1]) * rng.standard_normal(time.size)
    if slow:
        phases = rng.uniform(0.0, 2.0 * np.pi, 2)
        travel += rng.uniform(0.05, 0.3) * np.sin(0.1 * np.pi * time + phases[0])
        fast = np.interp(after, fine, speed / speed.max()) * (after > 0.0)
        ripple = rng.choice([0.0, 0.003, 0.01]) * stroke * fast
        travel += ripple * np.sin(2.0 * np.pi * time / rng.uniform(3.0, 7.0) + phases[1])
    quantum = rng.choice([0.0, 0.08])
    read = travel + noise
    return time, quantum * np.round(read / quantum) if quantum else read, start


def latches(**more):
    """Start, value and sd of first motions from a trigger at 0 ms, ``(n, 3)``; nan if withheld."""
    found = []
    for number in range(RECORDS):
        time, travel, start = closing(number, **more)
        contact = ContactTimes(trigger=0.0)
        value, sd, _ = measure_curve(time, travel, "closing", contact=contact)["reaction_time"]
        found.append((start, value, sd))
    return np.array(found)


def test_slow_starts():
    """Of 80, 67 have a value. That of a threshold or of a power alone was up to 16 ms off."""
    start, value, sd = latches(slow=True).T
    shown = np.isfinite(value)
    inside = np.abs(value - start) < 1.96 * sd
    assert inside[shown].mean() >= 0.95
    assert shown.mean() >= 0.7


def test_plain_starts_are_as_accurate_as_ever():
    """Mean errors are 0.14 and 0.11 ms; noise of 0.1 mm in 12 mm hides a few of them."""
    for strokes in ((100.0, 220.0), (12.0, 25.0)):
        start, value, sd = latches(slow=False, strokes=strokes).T
        assert np.isfinite(value).mean() >= 0.9
        assert np.nanmean(np.abs(value - start)) < 0.2
        shown = np.isfinite(value)
        assert (np.abs(value - start) < 1.96 * sd)[shown].mean() >= 0.95


def test_a_start_that_noise_hides_is_withheld_and_times_to_shares_are_not():
    """Noise of 0.6 mm in 13: a creep or a gradual start is not seen, and the middle is."""
    time, travel, _ = closing(4, slow=False, strokes=(13.0, 13.01))
    read = travel + 0.6 * np.random.default_rng(1).standard_normal(time.size)
    contact = ContactTimes(time=70.0, sd=0.1, trigger=0.0)
    found = measure_curve(time, read, "closing", contact=contact)
    assert found["reaction_time"].reason
    assert found["touch_time"].reason == found["reaction_time"].reason
    assert np.isfinite(found["time_to_50"].value)


def test_the_time_that_aligns_records_is_as_uncertain_as_the_start():
    raw = smooth(np.random.default_rng(1))
    assert raw.reading.start_hidden == ""
    assert raw.reading.start_sd >= raw.first_motion_sd
    noise = 0.05 * raw.segment.stroke * np.random.default_rng(2).standard_normal(raw.time.size)
    assert replace(raw, whole=raw.whole + noise).reading.start_hidden


def test_the_end_of_a_motion_before_does_not_hide_a_start():
    """An opening that swings about its rest, 80 ms before a closing."""
    time = np.arange(0.0, 400.0, 0.2)
    share = np.clip((time - 220.0) / 60.0, 0.0, 1.0)
    late = np.maximum(time - 87.0, 0.0)
    swing = 8.0 * np.exp(-late / 12.0) * np.cos(late / 5.0) * (time > 87.0)
    back = 120.0 * (1.0 - np.clip((time - 60.0) / 40.0, 0.0, 1.0) ** 2)
    travel = back + swing + 120.0 * share**2 * (3.0 - 2.0 * share)
    travel += 0.1 * np.random.default_rng(3).standard_normal(time.size)
    contact = ContactTimes(trigger=180.0)
    found = measure_curve(time, travel, "closing", contact=contact)["reaction_time"]
    assert abs(found.value - 40.0) < 1.96 * found.sd < 10.0
