"""Motions of many drives are those of each drive, at any size; what is no drive has none."""

import numpy as np
import pytest

from breaker.drive.exact.simulated_motions import closed_travels, landmarks, readings
from breaker.quantities.parameters import GAP, MOTIONS
from breaker.quantities.size import Size

_SOME = 40
_ABOUT, _MOST = 5e-3, 0.03  # mm: a mean error, and one behind a contact that bounces
TOUCH = np.array([0.5, 0.95])  # share of the stroke, as of the defaults
TIMES = np.linspace(-5.0, 60.0, 131)


@pytest.fixture(scope="module")
def some(drawn):
    """Drives of all kinds of contact, one of a linkage that swings among them."""
    kinds = {each.elements.contact for each in drawn[:_SOME]}
    assert kinds == {"elastic", "held", "sliding"}
    return [*drawn[: _SOME - 1], drawn[_SOME].changed(linkage=4.0)]


@pytest.fixture(scope="module")
def numbers(some):
    return np.array([each.numbers for each in some])


def closes(motion):
    return motion == "closing"


@pytest.mark.parametrize("motion", MOTIONS)
def test_landmarks_are_where_a_drive_has_made_its_way(some, numbers, motion):
    found = landmarks(numbers, TOUCH, closes(motion))
    assert found.shape == (_SOME, 3)
    fine = np.arange(0.0, 400.0, 0.01)
    for drive, (stroke, tenth, half) in zip(some, found, strict=True):
        rests = [drive.travel(m, np.zeros(1))[0] for m in MOTIONS]
        assert stroke == pytest.approx(rests[1] - rests[0], abs=1e-3)
        way = drive.travel(motion, fine)
        done = (way if closes(motion) else stroke - way) / stroke
        for time, share in ((tenth, 0.1), (half, 0.5)):
            k = int((done >= share).argmax())
            slope = (done[k] - done[k - 1]) / 0.01  # per ms
            off = _ABOUT / stroke / slope + 1e-3
            at = fine[k - 1] + (share - done[k - 1]) / slope
            assert time == pytest.approx(at, abs=off)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("size", [Size(), Size(8.0, 2.5)])
def test_readings_are_those_of_a_drive_of_a_size_released_at_a_time(some, numbers, motion, size):
    begins = np.linspace(-6.0, 2.0, _SOME)
    units = np.tile([size.lengths, size.times], (_SOME, 1))
    travel, switching = readings(numbers, closes(motion), TIMES, begins, units)
    assert travel.shape == (_SOME, TIMES.size)
    assert np.isfinite(travel).all()
    for k, drive in enumerate(some):
        own, switches = drive.scaled(size).operate(motion, TIMES - begins[k])
        off = np.abs(travel[k] - own) / size.lengths
        assert off.mean() < _ABOUT
        assert off.max() < _MOST
        assert switching[k] - begins[k] == pytest.approx(switches, abs=0.01 * size.times)


def test_each_drive_has_its_own_size(some, numbers):
    units = np.array([[1.0, 1.0], [3.0, 2.0]])
    travel, _ = readings(numbers[:2], True, TIMES, np.zeros(2), units)
    for k, (lengths, times) in enumerate(units):
        own = some[k].scaled(Size(lengths, times)).travel("closing", TIMES)
        assert np.allclose(travel[k], own, atol=_MOST * lengths)


def test_a_contact_that_has_not_switched_by_the_last_sample_never_does(numbers):
    begins, units = np.zeros(_SOME), np.ones((_SOME, 2))
    _, switching = readings(numbers, True, np.linspace(-2.0, 0.5, 20), begins, units)
    assert np.isinf(switching).all()


def test_drives_that_do_not_work_have_neither_stroke_nor_landmarks(some, numbers):
    weak = some[0].changed(f=1e-3)
    assert not weak.holds
    both = np.stack([numbers[1], weak.numbers])
    assert np.isfinite(closed_travels(both, TOUCH)).tolist() == [True, False]
    for motion in MOTIONS:
        found = landmarks(both, TOUCH, closes(motion))
        assert np.isfinite(found).all(axis=1).tolist() == [True, False]
        assert np.isnan(found[1]).all()


def test_a_contact_that_slides_touches_where_it_may(drawn):
    drive = next(each for each in drawn if each.elements.contact == "sliding")
    stroke = drive.travel("opening", np.zeros(1))[0]
    for share, works in ((0.49, False), (0.51, True), (0.94, True), (0.96, False)):
        other = drive.changed(**{GAP.name: share * stroke})
        moved = other.travel("opening", np.zeros(1))[0]
        assert moved == pytest.approx(stroke)  # a contact that slides moves no rest
        found = closed_travels(other.numbers[None], TOUCH)
        assert np.isfinite(found).all() == works
        pressed = other.changed(contact="elastic")
        assert np.isfinite(closed_travels(pressed.numbers[None], TOUCH)).all() == pressed.holds


def test_who_is_left_out_has_no_reading(numbers):
    begins = np.zeros(3)
    begins[1] = np.nan
    travel, switching = readings(numbers[:3], True, TIMES, begins, np.ones((3, 2)))
    assert np.isfinite(travel).all(axis=1).tolist() == [True, False, True]
    assert np.isnan(travel[1]).all()
    assert np.isfinite(switching).tolist() == [True, False, True]
