"""Quantities read from records, against the exact ones of the curves that were recorded."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from breaker.files import Operation
from breaker.mechanism.curves import travel
from breaker.mechanism.quantities import SOURCES, evaluate, quantities_of
from breaker.mechanism.size import Size
from breaker.mechanism.speeds import speeds_of
from breaker.model.randomness import generator
from breaker.records.export import write_curve
from breaker.records.grid import Grid
from breaker.records.landmarks import first_motion
from breaker.records.measured import Contact, Reading, measure_curve, variables
from breaker.records.noise import noise_at_rest
from breaker.records.reader import read_curves
from breaker.records.segments import find_segment
from tests.raws import smooth

SPEEDS = speeds_of(
    {
        "closing_speed_mean": ["10 % of stroke", "90 % of stroke"],
        "closing_speed_late": ["4 ms before touch", "touch"],
        "opening_speed_mean": ["10 % of stroke", "90 % of stroke"],
        "opening_speed_early": ["1 mm after parting", "6 ms after parting"],
    }
)
TIMED = {"closing": "touch_time", "opening": "part_time"}
NOISE, CONTACT_SD = 0.1, 0.1
AS_IT_IS, UNKNOWN, TIMING = Size(1.0, 1.0), Contact(), Contact(18.0, 0.1)


def record_of(theta, motion, rng, *, size=AS_IT_IS, speeds=SPEEDS):
    """Read one record of a drive, its first motion some 8 ms late; of a size, all is scaled."""
    time = np.arange(0.0, 72.0, 0.1)
    begins = 8.0 + rng.uniform(0.0, 0.1)
    curve = travel(theta[None], time, motion, onset=begins).travel[0]
    read = curve + NOISE * rng.standard_normal(time.size) + 0.05 * rng.standard_normal()
    timing = evaluate([TIMED[motion]], theta[None], motion)[0, 0]
    touch = begins + timing + CONTACT_SD * rng.standard_normal()
    reading = reading_of(time, read, motion, Contact(touch, CONTACT_SD), speeds)
    lengths, times = size.lengths, size.times
    rests = {name: lengths * getattr(reading.segment, name) for name in ("before", "after")}
    return replace(
        reading,
        time=times * reading.time,
        travel=lengths * reading.travel,
        segment=replace(reading.segment, **rests),
        moves=times * reading.moves,
        noise=reading.noise._replace(sd=lengths * reading.noise.sd),
        contact=Contact(*(times * each for each in reading.contact)),
    ).quantities()


def reading_of(time, read, motion, contact=UNKNOWN, speeds=SPEEDS):
    """What the reader finds in a record."""
    segment = find_segment(time, read, motion)
    inside = slice(segment.begin, segment.end)
    moves = first_motion(time[inside], read[inside], motion)
    noise = noise_at_rest(read[time < moves - 1.0], time[1] - time[0], 0.4, 0.0)
    found = motion, segment, moves, noise, 0.0, contact, speeds
    return Reading(time[inside], read[inside], *found)


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
        known[names.index("wipe")] = known[names.index("stroke")] - there
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
        assert chi2.isf(1 - 1e-5, z.size) / 1.5 < square < 1.5 * chi2.isf(1e-5, z.size), name
        assert abs(z.mean()) < (1.2 if name in TIMED.values() else 4.3 / np.sqrt(z.size)), name


@pytest.mark.parametrize("size", [Size(0.4, 0.5), Size(11.0, 4.0)])
def test_any_size_is_read_alike(prior, size):
    theta = prior.sample(1, generator(4, "test", "sizes"))[0]
    here = record_of(theta, "closing", np.random.default_rng(1))
    sized = tuple(each.sized(size) for each in SPEEDS)
    there = record_of(theta, "closing", np.random.default_rng(1), size=size, speeds=sized)
    for name, quantity in quantities_of("closing", SPEEDS, SOURCES).items():
        factor = size.factor(quantity.unit)
        assert there[name].value == pytest.approx(factor * here[name].value, rel=1e-6, nan_ok=True)
        assert there[name].sd == pytest.approx(factor * here[name].sd, rel=1e-6, nan_ok=True)


# ---- what a record does not show -------------------------------------------------------------


@pytest.fixture
def reading(prior):
    time = np.arange(0.0, 90.0, 0.1)
    curve = travel(prior.medians[None], time, "closing", onset=8.0).travel[0]
    read = curve + 0.02 * np.random.default_rng(2).standard_normal(time.size)
    return reading_of(time, read, "closing")


def test_without_contact_timing(reading):
    found = reading.quantities()
    for name in ("touch_time", "wipe", "closing_speed", "closing_speed_late"):
        assert "no contact timing" in found[name].reason
        assert np.isnan([found[name].value, found[name].sd]).all()
    for name in ("stroke", "travel_time", "closing_speed_mean", "over_travel"):
        assert found[name].reason == ""
        assert np.isfinite([found[name].value, found[name].sd]).all()


def test_latch_time(reading):
    """From the trigger to the first motion, which is uncertain by itself."""
    found = replace(reading, contact=Contact(trigger=2.0)).quantities()["latch_time"]
    assert abs(found.value - 6.0) < 5.0 * found.sd
    assert 0.05 < found.sd < 0.5
    assert "no trigger" in replace(reading, contact=TIMING).quantities()["latch_time"].reason


def test_a_record_that_ends_early(reading):
    segment = replace(reading.segment, speed=1.0)
    found = replace(reading, segment=segment, contact=TIMING).quantities()
    for name in ("stroke", "travel_time", "over_travel", "closing_speed_mean"):
        assert "ends before the drive rests" in found[name].reason
    assert found["closing_speed"].reason == ""


def test_missing_samples(reading):
    """Only what needs them is missing."""
    begin = reading.time[int(np.argmax(reading.travel > 0.1 * 13.5))]
    travel = np.where(np.abs(reading.time - begin) < 1.5, np.nan, reading.travel)
    found = replace(reading, travel=travel, contact=TIMING).quantities()
    assert found["travel_time"].reason == "samples are missing at the point"
    assert found["stroke"].reason == found["closing_speed"].reason == ""


def test_points_that_are_not_passed(reading):
    speeds = speeds_of(
        {
            "closing_speed": ["30 mm before touch", "touch"],
            "closing_speed_long": ["touch", "30 mm after touch"],
            "closing_speed_back": ["90 % of stroke", "touch"],
        }
    )
    found = replace(reading, contact=TIMING, speeds=speeds).quantities()
    assert "does not travel as far" in found["closing_speed"].reason
    assert "does not pass the point" in found["closing_speed_long"].reason
    assert "touch is not after 90 % of stroke" in found["closing_speed_back"].reason


def test_over_travel_below_the_noise():
    time = np.arange(0.0, 100.0, 0.1)
    rises = np.clip((time - 20.0) / 10.0, 0.0, 1.0)
    curve = 13.0 * (10 * rises**3 - 15 * rises**4 + 6 * rises**5)
    read = curve + 0.1 * np.random.default_rng(5).standard_normal(time.size)
    found = reading_of(time, read, "closing").quantities()
    assert "no more than its noise" in found["over_travel"].reason
    assert found["stroke"].value == pytest.approx(13.0, abs=5 * found["stroke"].sd)


# ---- dataset ---------------------------------------------------------------------------------


def test_dataset_of_files(prior, tmp_path):
    time = np.arange(0.0, 90.0, 0.1)
    files = []
    for number in (1, 2):
        curve = travel(prior.medians[None], time, "opening", onset=10.0).travel[0]
        curve += 0.05 * np.random.default_rng(number).standard_normal(time.size)
        files.append(Operation(number, tmp_path / f"operation_{number}.csv"))
        write_curve(files[-1].file, time, curve, motion="opening", operation=number)
    files[1].file.write_text("nothing")
    curves = read_curves(files, {}, Grid(np.linspace(-2.0, 58.0, 151)), "opening", speeds=SPEEDS)
    names = list(quantities_of("opening", SPEEDS, SOURCES))
    assert curves["quantity"].values.tolist() == names
    assert curves.quantity_unit.sel(quantity="opening_speed_mean").item() == "mm/ms"
    one, other = (curves.sel(operation=number) for number in (1, 2))
    exact = evaluate(["stroke"], prior.medians[None], "opening")[0, 0]
    error = (one.measured - exact) / one.measured_sd
    assert abs(error.sel(quantity="stroke").item()) < 5.0
    assert np.isnan(other.measured).all()
    assert set(other.measured_reason.values) == {"the record was rejected"}
    nothing, where = variables([], "closing")
    assert nothing["measured"][1].shape == (0, len(where["quantity"]))


def test_an_outlier_before_the_motion_stops_nothing():
    raw = smooth(np.random.default_rng(1))
    raw.whole[20] = 500.0
    assert "travel_time" in measure_curve(raw.time, raw.whole, "closing")
