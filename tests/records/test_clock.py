"""Times of a file: even steps in ms, or a reason with the line."""

import tracemalloc

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.records.axes import even_times
from breaker.records.rejections import UnusableError

MS = {"time_unit": "ms", "rate": None}
TIME = 0.1 * np.arange(760)
LINES = np.arange(760) + 7


def test_times_are_kept_to_the_last_digit():
    time, place, remark = even_times(TIME, LINES, MS)
    np.testing.assert_array_equal(time, TIME)
    np.testing.assert_array_equal(place, np.arange(760))
    assert remark == ""
    seconds, _, _ = even_times(TIME / 1e3, LINES, {"time_unit": "s", "rate": 10.0})
    np.testing.assert_allclose(seconds, TIME, rtol=1e-15)
    time, _, _ = even_times(None, LINES, {"time_unit": "s", "rate": 4.0})
    np.testing.assert_array_equal(time, 0.25 * np.arange(760))
    even_times(TIME, LINES, {"time_unit": "ms", "rate": 10.05})
    with pytest.raises(UnusableError):
        even_times(TIME, LINES, {"time_unit": "ms", "rate": 9.6})


@pytest.mark.parametrize("step", [0.01, 0.03, 1 / 9.6, 0.1, 1 / 2.2, 0.4, 1.0])
def test_samples_that_are_missing_leave_their_places(step):
    keep = generator(1, "clock").random(760) > 0.3
    keep[[0, -1]] = True
    time, place, _ = even_times((step * np.arange(760))[keep], LINES[keep], MS)
    np.testing.assert_array_equal(place, np.flatnonzero(keep))
    np.testing.assert_allclose(time, step * np.arange(760), atol=1e-9)


@pytest.mark.parametrize("digits", [2, 3, 4])
def test_times_of_few_digits_are_even_times(digits):
    """30 kHz: steps of 0.03 and 0.04 ms where two digits are printed."""
    printed = np.round(np.arange(2000) / 30.0, digits)
    time, place, remark = even_times(printed, np.arange(2000), MS)
    np.testing.assert_array_equal(place, np.arange(2000))
    assert (time[-1] - time[0]) / 1999 == pytest.approx(1 / 30, rel=1e-3)
    assert bool(remark) == (digits == 2)


def changed(place, value):
    time = TIME.copy()
    time[place] = value
    return time


ODD = {
    "repeated": (changed(300, TIME[299]), 307),
    "clock reset": (np.append(TIME, TIME), 767),
    "reversed": (TIME[::-1], 8),
    "twice": (np.repeat(TIME, 2), 8),
    "jitter": (changed(300, 30.03), 307),
    "half a step lost": (TIME + 0.05 * (TIME > 40), 408),
    "another rate half-way": (np.where(TIME < 40, TIME, 40 + 1.09 * (TIME - 40)), None),
    "an overflow": (changed(759, 1e300), 766),
    "a gap of 1e9 steps": (TIME + 1e8 * (TIME > 40), 408),
    "5 ms": (5.0 * np.arange(100), None),
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
