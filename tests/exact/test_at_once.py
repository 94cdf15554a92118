"""Two calls at once: both are made, and an error of either is raised."""

import threading

import pytest

from breaker.drive.exact.at_once import at_once


def test_both_run_at_the_same_time():
    meet = threading.Barrier(2, timeout=10.0)
    first, second = at_once(lambda: (meet.wait(), 1)[1], lambda: (meet.wait(), 2)[1])
    assert (first, second) == (1, 2)


@pytest.mark.parametrize("place", [0, 1])
def test_an_error_of_either_is_raised_when_both_are_done(place):
    done = []

    def fails():
        raise ValueError("here")

    calls = [lambda: done.append(1)]
    calls.insert(place, fails)
    with pytest.raises(ValueError, match="here"):
        at_once(*calls)
    assert done == [1]
