"""Quantities read from records, against the exact ones of the curves that were recorded."""

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.model.evaluation import evaluate
from breaker.model.quantities import quantities_of, speeds_of
from breaker.records.contacts import ContactTimes
from breaker.records.measurements import measure_curve
from tests.exports import record
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
UNKNOWN, TIMING = ContactTimes(), ContactTimes(18.0, 0.1)


def scores(motion, prior, n=40):
    """Errors of what is measured in n records, in their stated sds, by name, ``(n,)``; the first
    motion is some 8 ms late.
    """
    rng = generator(3, "test", "measured", motion)
    theta, time = prior.sample(n, rng), np.arange(0.0, 72.0, 0.1)
    names = list(quantities_of(motion, SPEEDS))
    truth = evaluate(names, theta, motion, SPEEDS)
    spring, rows = names.index("spring_compression"), []
    names[spring] = f"{motion}_wipe"
    for row, known in zip(theta, truth, strict=True):
        # The contact is behind or before the drive by what its spring gives way, so at the touch
        # the drive is not just the gap from where it began.
        switches, begins = known[names.index(TIMED[motion])], 8.0 + rng.uniform(0.0, 0.1)
        at_switch = travel(row[None], np.array([0.0, switches]), motion).travel[0, 1]
        known[spring] = known[names.index("stroke")] - at_switch
        curve = travel(row[None], time, motion, onset=begins).travel[0]
        read = curve + 0.1 * rng.standard_normal(time.size) + 0.05 * rng.standard_normal()
        contact = ContactTimes(begins + switches + 0.1 * rng.standard_normal(), 0.1)
        measured = measure_curve(time, read, motion, contact=contact, speeds=SPEEDS)
        rows.append([measured[name][:2] for name in names])
    values, sds = np.moveaxis(np.array(rows), 2, 0)
    return dict(zip(names, ((values - truth) / sds).T, strict=True))


@pytest.mark.parametrize("motion", TIMED)
def test_measured_agrees_with_the_model_within_its_uncertainty(prior, motion):
    """Of normal errors of the stated sds, a quantity's sum of squares is beyond either bound with
    probability 2e-5, before the factors for what is not normal; 14 quantities: below 1e-3.
    """
    for name, all_scores in scores(motion, prior).items():
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
def closing(prior):
    """Times and travel of a closing that moves from 8.0 ms on, and touches at 18 ms."""
    time = np.arange(0.0, 90.0, 0.1)
    curve = travel(prior.medians[None], time, "closing", onset=8.0).travel[0]
    return time, curve + 0.02 * np.random.default_rng(2).standard_normal(time.size)


TIMES = "reaction_time", "closing_time", "time_to_50", "bounce_time"
SWITCHED = "touch_time", "closing_wipe", "closing_speed", "closing_speed_late"


@pytest.mark.parametrize(
    ("contact", "gap", "hidden"),
    [
        (TIMING, 0.0, TIMES),
        (UNKNOWN, 0.0, (*TIMES, *SWITCHED)),
        (TIMING, 1.5, (*TIMES, "closing_speed")),
    ],
    ids=["without a trigger", "without any contact", "without samples about the touch"],
)
def test_what_a_record_does_not_show_has_a_reason(closing, contact, gap, hidden):
    time, read = closing
    missing = np.abs(time - time[int(np.argmax(read > 6.0))]) < gap
    about = {"contact": contact, "speeds": SPEEDS}
    values = measure_curve(time, np.where(missing, np.nan, read), "closing", **about)
    for name in {*hidden, "touch_time", "stroke", "travel_time", "over_travel"}:
        assert bool(values[name].reason) == (name in hidden)
        assert np.isnan(values[name][:2]).tolist() == [name in hidden] * 2


# ---- records as breakers give them -------------------------------------------------------------


def test_speeds_between_points_that_makers_name():
    """From and to a rest, and about a point: as way over time of the exact curve."""
    time = np.arange(0.0, 100.0, 0.1)
    read = swinging(time - 20.0, 120.0, 40.0)
    read += 0.02 * np.random.default_rng(5).standard_normal(time.size)
    exact = {
        ("0 % of stroke", "50 % of stroke"): 60.0 / 20.0,
        ("60 mm from open", "18.75 mm from closed"): 41.25 / 10.0,
        ("50 % from closed", "10 ms after 50 % of stroke"): 41.25 / 10.0,
        ("10 ms before 60 mm from closed", "60 mm from open"): 41.25 / 10.0,
    }
    for points, expected in exact.items():
        speeds = speeds_of({"closing_speed": list(points)})
        result = measure_curve(time, read, "closing", speeds=speeds)["closing_speed"]
        assert abs(result.value - expected) < max(4.0 * result.sd, 2e-3), points


@pytest.mark.parametrize(("stroke", "rate"), [(13.5, 40.0), (150.0, 5.0)])
def test_a_record_that_is_cut_has_no_wrong_stroke(stroke, rate):
    """Cut from half of the way to a duration after it: 40 cuts, of which none may be off by more
    than five sds and 2 %.
    """
    rng = np.random.default_rng([5, int(stroke), int(rate)])
    duration, reported = 12.0 * (stroke / 13.5) ** 0.7, 0
    for until in np.linspace(0.5, 2.0, 40):
        time = np.arange(0.0, duration * (1.0 + until), 1.0 / rate)
        noise = stroke * 10.0 ** rng.uniform(-3.2, -2.0)
        way = swinging(time - duration, stroke, duration, rng.choice([0.0, 0.12]))
        try:
            result = measure_curve(time, way + noise * rng.standard_normal(time.size), "closing")
        except ValueError:
            continue
        if not result["stroke"].reason:
            reported += 1
            off = abs(result["stroke"].value - stroke)
            assert off < max(5.0 * result["stroke"].sd, 0.02 * stroke), until
    assert reported >= 5


@pytest.mark.parametrize("creeps", [True, False])
def test_a_creep_that_noise_hides_is_in_the_stated_error(creeps):
    """Of 150 strokes 90 % should be within the interval that says so, of drives at rest, too, whose
    intervals are to stay narrow; without that error, 75 % are of drives that creep.
    """
    rng, held, sds = np.random.default_rng(6), [], []
    for _ in range(150):
        time = np.arange(0.0, rng.uniform(50.0, 75.0), rng.choice([0.1, 0.2, 0.5]))
        way = swinging(time - 20.0, 13.5, 12.0, rng.choice([0.0, 0.08]))
        if creeps:
            lasts, size = rng.uniform(10.0, 20.0), 0.015 * 13.5 * rng.standard_normal()
            way -= size * np.exp(-np.maximum(time - 30.0, 0.0) / lasts) * (way / 13.5)
        noise = rng.choice([0.05, 0.1, 0.2]) * rng.standard_normal(time.size)
        result = measure_curve(time, way + noise, "closing")["stroke"]
        held.append(abs(result.value - 13.5) < 1.645 * result.sd)
        sds.append(result.sd)
    assert np.mean(held) >= 0.85
    assert creeps or np.median(sds) < 0.003 * 13.5


@pytest.mark.parametrize("drift", [0.0, 0.01, -0.02])
def test_a_drift_is_in_the_stated_error(drift):
    """Of the reading, mm/ms, over 260 ms around a motion of 170 mm."""
    time = np.arange(0.0, 320.0, 0.1)
    way = swinging(time - 60.0, 170.0, 50.0) + drift * time
    way += 0.1 * np.random.default_rng(1).standard_normal(time.size)
    stroke = measure_curve(time, way, "closing")["stroke"]
    assert abs(stroke.value - 170.0) < 2.0 * stroke.sd
    assert stroke.sd < 0.1 + 320.0 * abs(drift)  # all of the record


def test_a_swing_that_an_opening_cuts_off_is_not_a_drift():
    """Taken for a drift, it made strokes uncertain by 7 mm."""
    for seed in range(5):
        columns = record(rate=5.0, seed=seed, motions=("closing", "opening"))
        time = np.arange(columns["Travel 1 (mm)"].size) / 5.0
        stroke = measure_curve(time, columns["Travel 1 (mm)"], "closing")["stroke"]
        assert abs(stroke.value - 178.0) < 2.0 * stroke.sd < 2.0, seed
