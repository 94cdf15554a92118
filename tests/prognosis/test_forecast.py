"""Operations left: of straight paths, of wear that may change, of what is known badly."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.model.limits import Limit
from breaker.prognosis.coordinates import CoordinateReading, Coordinates
from breaker.prognosis.forecast import Future, Onward, _crossings
from breaker.prognosis.readout import Readout

LIMIT = Limit("slow", "closing", (("travel_time", 10.0, True),), of="record")
SURE = Future(changes=0.02)


def forecast(change, rate, future=SURE, *, sd=0.01, rate_sd=1e-6):
    """What is forecast of a measured quantity, 8 and its coordinate, 1,000 operations after new."""
    one, reading = np.ones((1, 1)), CoordinateReading(mean=8.0, scatter=1.0, common=0.0)
    sizes = {"change": change, "variance": sd**2, "rate": rate, "rate_variance": rate_sd**2}
    path = SimpleNamespace(covariance=0.0 * one, **{name: e * one for name, e in sizes.items()})
    coordinates = Coordinates({}, {("closing", "travel_time"): reading})
    drive = Readout(None, coordinates, None, 200, 1, 0.0 * one, 1e-12 * one)
    result = Onward(path, drive, np.array([0]), np.array([1000.0]), future).forecast(LIMIT)
    return SimpleNamespace(**{name: values[0] for name, (_, values) in result.items()})


@pytest.mark.parametrize(
    ("at", "rate", "left"), [(1.0, 0.002, 500.0), (1.0, -0.002, np.inf), (2.5, 0.002, 0.0)]
)
def test_a_path_crosses_where_it_does_or_never(at, rate, left):
    result = forecast(at, rate)
    assert result.p_exceeded[0] == (at > 2.0)
    assert result.p_nearer[0] == 1.0
    assert result.value[0, 1] == pytest.approx(8.0 + at)
    np.testing.assert_allclose(result.remaining[0], left, rtol=0.05)


def test_wear_that_may_become_faster_shortens_the_early_end():
    steady, may = (forecast(1.0, 0.002, SURE._replace(changes=c)) for c in (0.02, 1.0))
    assert may.remaining[0, 0] < 0.6 * steady.remaining[0, 0]
    assert may.remaining[0, 2] == pytest.approx(steady.remaining[0, 2], rel=0.05)
    assert np.ptp(forecast(1.0, 0.002, sd=0.6).remaining) > 5.0 * np.ptp(steady.remaining)


def test_changes_come_as_often_in_any_unit_of_operations():
    turns, faster = Future(changes=1.5).turns(np.array([500.0, 1000.0]), 1000, 1)
    np.testing.assert_allclose(turns[1], 2.0 * turns[0])
    assert (turns[0] > 10000.0).mean() == pytest.approx((10500.0 / 500.0) ** -1.5, abs=1e-3)
    assert np.median(faster) == pytest.approx(6.0, rel=0.01)


def test_crossings_lie_on_the_line_between_nodes():
    nodes = np.array([0.0, 10.0, 100.0])
    excess = np.array([[-1.0, -1.0, 1.0], [-0.5, 1.0, 2.0], [4.0, 2.0, -1.0]])[:, :, None]
    np.testing.assert_allclose(_crossings(excess, nodes), [20.0, 5.0, 0.0])
    assert np.isinf(_crossings(-np.ones((3, 2, 1)), nodes)).all()
