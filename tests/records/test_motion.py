"""Which part of a record is the motion asked for: found, cut where it goes back, or refused."""

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.family.rich_drive import Drive, Elements, Stop
from breaker.model.parameters import MOTIONS
from breaker.records.motion import find_segment
from breaker.records.rejections import UnusableError

# A damper at the open end, so that the opening has a rebound and a rest.
DRIVE = Drive(
    (2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0),
    Elements(opening_stop=Stop(reach=4.0, damping=0.3, stiffness=0.2)),
)


def record(events, length, *, rate=10.0, size=(1.0, 1.0), noise=0.007, seed=1):
    """A record ``(time, travel)``: motions ``{start in ms: motion}``, noise a share of 14 mm."""
    far, slow = size
    time = np.arange(0.0, length * slow, slow * 10.0 / rate / 10.0)
    travel = np.full(time.size, np.nan)
    for start, motion in sorted(events.items()):
        moved = DRIVE.travel(motion, np.maximum(time / slow - start, 0.0))
        travel = np.where((time >= slow * start) | np.isnan(travel), moved, travel)
    rng = generator(seed, "test segments")
    return time, far * (travel + 14.0 * noise * rng.standard_normal(time.size))


@pytest.mark.parametrize(
    ("size", "rate", "noise"),
    [((1.0, 1.0), 10.0, 0.007), ((11.0, 20.0), 2.0, 0.02), ((40.0, 8.0), 40.0, 0.0)],
)
def test_close_and_open_in_one_record_are_both_found(size, rate, noise):
    """Of any stroke, speed, rate and noise: the rests are not those at the ends of the record."""
    events = {30.0: "closing", 130.0: "opening"}
    time, travel = record(events, 220.0, size=size, rate=rate, noise=noise)
    closing, opening = (find_segment(time, travel, motion) for motion in MOTIONS)
    far, slow = size
    assert (closing.begin, opening.end) == (0, time.size)
    assert 115 * slow <= time[closing.end] <= 131 * slow
    assert 60 * slow <= time[opening.begin] <= 100 * slow
    assert closing.stroke == pytest.approx(opening.stroke, rel=0.03)
    assert [closing.before, opening.after] == pytest.approx([0.0, 0.0], abs=0.02 * far * 14)
    assert np.isnan(opening.back)
    assert closing.back == time[closing.end]


@pytest.mark.parametrize("after", [14.0, 60.0])
def test_a_closing_that_is_tripped_is_cut_before_it_goes_back(after):
    time, travel = record({20.0: "closing", 20.0 + after: "opening"}, 150.0)
    segment = find_segment(time, travel, "closing")
    assert 31.0 <= time[segment.end] <= 20.5 + after
    # What is left is what the record of the closing alone has there.
    alone = record({20.0: "closing"}, 150.0)[1]
    np.testing.assert_array_equal(travel[: segment.end], alone[: segment.end])


def test_of_several_motions_of_a_kind_none_is_chosen():
    time, travel = record({20.0: "opening", 120.0: "closing", 170.0: "opening"}, 260.0)
    assert find_segment(time, travel, "closing").stroke == pytest.approx(13.5, abs=0.3)
    with pytest.raises(UnusableError):
        find_segment(time, travel, "opening")
    second = find_segment(time, travel, "opening", begin=140.0)
    assert 140.0 <= time[second.begin] < 170.0
    assert second.end == time.size
    first = find_segment(time, travel, "opening", end=110.0)
    assert first.begin == 0
    assert time[first.end - 1] == pytest.approx(110.0)


@pytest.mark.parametrize("motion", MOTIONS)
def test_what_does_not_have_the_motion_is_refused(motion):
    """The other motion, the wrong sign, a rest, one value, nothing to look in, hardly a sample."""
    time, travel = record({20.0: motion}, 100.0)
    other = MOTIONS[1 - MOTIONS.index(motion)]
    rest = record({500.0: motion}, 200.0)[1][: time.size]
    few = np.where(np.arange(time.size) < 10, travel, np.nan)
    for reading, of in (
        *((travel, other), (-travel, motion), (rest, motion), (1e-3 * rest, motion)),
        *((np.full(time.size, 3.0), motion), (few, motion)),
    ):
        with pytest.raises(UnusableError):
            find_segment(time, reading, of)
    with pytest.raises(UnusableError):
        find_segment(time, travel, motion, begin=200.0)


def test_overtravel_rebound_and_bounces_are_not_moving_back():
    """A swing of a third of the stroke about the end, as no damper that works leaves."""
    time = np.arange(0.0, 200.0, 0.1)
    tau = np.maximum(time - 20.0, 0.0)
    swing = 1.0 - np.exp(-tau / 12.0) * np.cos(2 * np.pi * tau / 20.0)
    assert swing.max() > 1.3
    for motion, travel in (("closing", 14.0 * swing), ("opening", 14.0 - 14.0 * swing)):
        segment = find_segment(time, travel, motion)
        assert (segment.begin, segment.end) == (0, time.size)
        assert segment.arrived
        assert segment.stroke == pytest.approx(14.0, abs=0.6)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_truncated_record_is_taken_once_the_drive_has_slowed_down(motion):
    time, travel = record({20.0: motion}, 100.0, noise=0.002)
    speed = np.abs(np.gradient(DRIVE.travel(motion, time - 20.0), time))
    fastest = int(speed.argmax())
    slow = time[fastest + int((speed[fastest:] < 0.5 * speed.max()).argmax())]
    # The mean speed over a fifth of the way, which ends half a running median before the record.
    for end in (slow + 2.0, slow + 5.0, slow + 40.0):
        segment = find_segment(time[time < end], travel[time < end], motion)
        assert segment.end == (time < end).sum()
        assert np.isnan(segment.back)
    assert segment.arrived
    for end in np.arange(23.0, time[fastest] + 0.5, 0.5):
        with pytest.raises(UnusableError):
            find_segment(time[time < end], travel[time < end], motion)
