"""A reading that jumps: the sd of the stroke holds it, or the record is refused."""

import numpy as np
import pytest

from breaker.records.checks import check_slips, doubtful_samples, ends_of_range
from breaker.records.measurements import measure_curve
from breaker.records.motion import find_segment
from breaker.records.rejections import UnusableError

KINDS = {
    "behind": lambda time, at, size: size * (time > 135.0 + at),
    "before": lambda time, at, size: size * (time < 30.0 - 0.2 * at),
    "returns": lambda time, at, size: size * ((time > 140.0 + at) & (time < 155.0 + at)),
    "within": lambda time, at, size: size * (time > 75.0 + 0.5 * at),
}


def record(rate, stroke=178.0, over=0.06):
    """A motion from 55 ms on of 60 ms, that swings at its end."""
    time = np.arange(0.0, 400.0, 1.0 / rate)
    share = np.clip((time - 55.0) / 60.0, 0.0, 1.0)
    late = np.clip((time - 110.0) / 60.0, 0.0, None)
    swing = over * np.sin(7.0 * late) * np.exp(-late / 0.3)
    noise = 0.1 * np.random.default_rng(3).standard_normal(time.size)
    return time, stroke * (share**2 * (3.0 - 2.0 * share) + swing) + noise


@pytest.mark.parametrize("rate", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [-2.2, 2.2])
def test_a_slip_is_named_and_in_the_uncertainty(rate, kind, size):
    for at in (0.0, 40.0):
        time, travel = record(rate)
        slipped = travel + KINDS[kind](time, at, size)
        kinds = doubtful_samples(slipped, 1.0 / rate, 0.0)
        assert kinds[kinds != ""].tolist() == ["slip"] * (2 if kind == "returns" else 1)
        if kind == "before":
            with pytest.raises(UnusableError):  # it looks like the first motion
                check_slips(time, slipped, kinds, find_segment(time, slipped, "closing"))
        found = measure_curve(time, slipped, "closing")["stroke"]
        assert abs(found.value - 178.0) < 3.0 * found.sd < 4.0 * abs(size)


@pytest.mark.parametrize("kind", ["behind", "within"])
@pytest.mark.parametrize("lasts", [0.05, 4.0, np.inf])
def test_what_returns_soon_is_left_out_and_a_large_slip_is_refused(kind, lasts):
    """By 17 % of the stroke."""
    time, travel = record(10.0)
    at = time[(KINDS[kind](time, 0.0, 1.0) > 0.0).argmax()]
    off = 30.0 * ((time >= at) & (time < at + lasts))
    kinds = doubtful_samples(travel + off, 0.1, 0.0)
    sure = np.where(kinds == "", travel + off, np.nan)
    segment = find_segment(time, sure, "closing")
    if np.isinf(lasts):
        with pytest.raises(UnusableError):
            check_slips(time, sure, kinds, segment)
    else:
        check_slips(time, sure, kinds, segment)
        assert (kinds[off > 0.0] != "").all()
        found = measure_curve(time, travel + off, "closing")["stroke"]
        assert abs(found.value - 178.0) < max(3.0 * found.sd, 0.1)
        assert found.sd < 0.6


@pytest.mark.parametrize("rate", [2.5, 10.0, 40.0])
@pytest.mark.parametrize("quantum", [0.0, 0.05, 0.5])
def test_an_end_of_the_range_within_the_stroke_is_named(rate, quantum):
    """None of 18,000 simulated motions is; where a quantum hides the noise, no end can be."""
    time, travel = record(rate)
    for end in (np.inf, 120.0):
        read = np.minimum(travel, end)
        read = quantum * np.round(read / quantum) if quantum else read
        ended = np.isfinite(ends_of_range(time, read, 55.0)).any()
        assert ended == (end == 120.0 and quantum < 0.5)
