"""Times in even steps of ms, and readings in mm: units, ratios and quanta."""

import tracemalloc

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.records.conversion import even_times, seen_quantum, travel_of
from breaker.records.rejections import UnusableError
from breaker.records.settings import complete

MS = {"time_unit": "ms", "rate": None}
TIME = 0.1 * np.arange(760)
LINES = np.arange(760) + 7


def test_times_are_kept_to_the_last_digit():
    time, place, remark = even_times(TIME, LINES, MS)
    np.testing.assert_array_equal(time, TIME)
    np.testing.assert_array_equal(place, np.arange(760))
    assert remark == ""
    seconds, _, _ = even_times(TIME / 1e3, LINES, {"time_unit": "s", "rate": 10.05})
    np.testing.assert_allclose(seconds, TIME, rtol=1e-15)
    time, _, _ = even_times(None, LINES, {"time_unit": "s", "rate": 4.0})
    np.testing.assert_array_equal(time, 0.25 * np.arange(760))
    with pytest.raises(UnusableError):
        even_times(TIME, LINES, {"time_unit": "ms", "rate": 9.6})


@pytest.mark.parametrize("step", [0.01, 1 / 9.6, 1 / 2.2, 1.0])
def test_samples_that_are_missing_leave_their_places(step):
    keep = generator(1, "clock").random(760) > 0.3
    keep[[0, -1]] = True
    time, place, _ = even_times((step * np.arange(760))[keep], LINES[keep], MS)
    np.testing.assert_array_equal(place, np.flatnonzero(keep))
    np.testing.assert_allclose(time, step * np.arange(760), atol=1e-9)


@pytest.mark.parametrize("digits", [2, 4])
def test_times_of_few_digits_are_even_times(digits):
    """30 kHz: steps of 0.03 and 0.04 ms where two digits are printed."""
    printed = np.round(np.arange(2000) / 30.0, digits)
    time, place, remark = even_times(printed, np.arange(2000), MS)
    np.testing.assert_array_equal(place, np.arange(2000))
    assert (time[-1] - time[0]) / 1999 == pytest.approx(1 / 30, rel=1e-3)
    assert bool(remark) == (digits == 2)


ODD = {
    "repeated": (np.where(np.arange(760) == 300, TIME[299], TIME), 307),
    "clock reset": (np.append(TIME, TIME), 767),
    "jitter": (np.where(np.arange(760) == 300, 30.03, TIME), 307),
    "half a step lost": (TIME + 0.05 * (TIME > 40), 408),
    "another rate half-way": (np.where(TIME < 40, TIME, 40 + 1.09 * (TIME - 40)), None),
    "an overflow": (np.where(np.arange(760) == 759, 1e300, TIME), 766),
    "a gap of 1e9 steps": (TIME + 1e8 * (TIME > 40), 408),
    "too few digits": (np.round(np.arange(2000) / 33.0, 1), 8),
    "seconds": (TIME / 1e3, None),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_times_are_refused_with_their_line(name):
    """None of them allocates for its gap, overflows or warns."""
    time, line = ODD[name]
    tracemalloc.start()
    with pytest.raises(UnusableError) as caught:
        even_times(time, np.arange(len(time)) + 7, MS)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert line is None or caught.value.line == line
    assert most < 1e6  # bytes


# ---- travel --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"travel_unit": "cm"}, [10.0, 20.0]),
        ({"travel_unit": "inch", "zero": 1.0, "sign": -1}, [0.0, -25.4]),
        ({"travel_unit": "deg", "ratio": 1.5, "zero": 0.5}, [0.75, 2.25]),
        ({"travel_unit": "V", "ratio": 30.0, "zero": "rest"}, [30.0, 60.0]),
    ],
)
def test_units_and_ratios(settings, expected):
    travel = travel_of(np.array([1.0, 2.0]), complete(settings))
    np.testing.assert_allclose(travel, expected, rtol=1e-15)


@pytest.mark.parametrize(("stroke", "quantum"), [(4.0, 0.0125), (14.0, 0.08), (1000.0, 1.0)])
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_a_quantum_is_seen(stroke, quantum, noise):
    """Through print with four digits and a few spikes, with noise below the step."""
    rng, time = generator(1, "quantum"), np.arange(0.0, 76.0, 0.1)
    x = stroke / (1.0 + np.exp((22.0 - time) / 1.5))
    fine = np.round(x + 0.02 * rng.standard_normal(x.size), 3)
    x = quantum * np.round((x + noise * quantum * rng.standard_normal(x.size)) / quantum)
    x[[100, 500]] += rng.standard_normal(2)
    assert seen_quantum(np.round(x, 4)) == pytest.approx(quantum, rel=0.01)
    assert seen_quantum(fine) < 0.004
