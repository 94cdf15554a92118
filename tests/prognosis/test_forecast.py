"""Operations left: of straight paths, of wear that may change, of what is known badly."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from breaker.model.limits import Limit
from breaker.prognosis.coordinates import CoordinateReading, Coordinates
from breaker.prognosis.forecast import Future, Onward, _continued, _crossings
from breaker.prognosis.readout import Readout

SLOW = Limit("slow", "closing", (("travel_time", 10.0, True),), of="record")
STIFF = Limit("stiff", "", (("gamma_a", 2.0, True),), of="change")
STEADY = Future(changes=0.02, faster=1.0, spread=0.0)


class Skewed(Readout):
    """A drive whose gamma_a changes as its coordinate, with exponential draws of median 0."""

    def of_change(self, _):
        tail = -np.log((np.arange(self.draws) + 0.5) / self.draws) - np.log(2.0)
        tail = np.random.default_rng(self.seed).permutation(tail)
        return (self.change + np.sqrt(self.variance) * tail)[..., None]


def forecast(change, rate, future=STEADY, *, sd=0.01, rate_sd=1e-9, covariance=0.0, limit=SLOW):
    """Forecast of a travel time, 8 and its coordinate, or of gamma_a, at 1,000 operations."""
    change, reading = np.reshape(change, (-1, 1)), CoordinateReading(8.0, scatter=1.0, common=0.0)
    path = {"change": change, "variance": sd**2, "rate": np.reshape(rate, (-1, 1))}
    path |= {"rate_variance": rate_sd**2, "covariance": covariance}
    path = SimpleNamespace(**{name: e + 0.0 * change for name, e in path.items()})
    coordinates, new = Coordinates({}, {("closing", "travel_time"): reading}), np.zeros((1, 1))
    drive, where = Skewed(None, coordinates, None, 200, 1, new, new + 1e-12), np.arange(len(change))
    result = Onward(path, drive, where, np.full(len(where), 1000.0), future).forecast(limit)
    return SimpleNamespace(**{name: values[0] for name, (_, values) in result.items()})


@pytest.mark.parametrize(("limit", "new"), [(SLOW, 8.0), (STIFF, 0.0)])
def test_a_path_crosses_where_it_does_or_never(limit, new):
    """The last two paths cross the limit just within and just beyond the horizon."""
    change = np.array([1.0, 2.5, -1.0, 1.0, 1.0])
    result = forecast(change, [0.002, 0.002, -0.002, 1.01e-4, 0.99e-4], sd=1e-4, limit=limit)
    assert result.p_exceeded.tolist() == [0.0, 1.0, 0.0, 0.0, 0.0]
    assert result.p_nearer.tolist() == [1.0, 1.0, 0.0, 1.0, 1.0]
    assert result.new == pytest.approx(new, abs=1e-5)
    np.testing.assert_allclose(result.value[:, 1], new + change, rtol=1e-4)
    left = [500.0, 0.0, np.inf, 9901.0, np.inf]
    np.testing.assert_allclose(result.remaining.T, [left] * 3, rtol=0.01)


def test_intervals_of_a_quantity_contain_90_percent_of_the_draws():
    result = forecast(0.0, 0.002, sd=0.1)
    np.testing.assert_allclose(result.value[0], [8.0 - 0.1645, 8.0, 8.0 + 0.1645], atol=0.003)
    assert result.p_nearer == 0.5


def test_draws_leave_the_path_by_what_is_not_known():
    """At a node, the path is 0.37 below the limit."""
    ahead = 10.0**2.5
    below = 1.0 - 0.002 * ahead
    sd = np.sqrt(0.2**2 + 2.0 * ahead * 1e-4 + (8e-4 * ahead) ** 2)
    for limit, sizes, share in (
        (SLOW, {"sd": 0.2, "covariance": 1e-4, "rate_sd": 8e-4}, norm.sf(below / sd)),
        (STIFF, {"sd": 1e-6, "rate_sd": 1e-3}, norm.sf(below / (1e-3 * ahead))),
        (STIFF, {"sd": 0.2}, 0.5 * np.exp(-below / 0.2)),  # the tail of exponential draws
    ):
        lives = forecast(1.0, 0.002, limit=limit, **sizes).lives
        assert (lives <= ahead).mean() == pytest.approx(share, abs=0.006)
        assert np.isfinite(forecast(1.0, 0.01, limit=limit, **sizes).lives).all()


def test_a_changed_rate_covers_the_rest_of_the_way_faster():
    turns, faster = (e.ravel() for e in Future().turns(np.array([1000.0]), 200, 1))
    lives = np.where(turns < 500.0, turns + (500.0 - turns) / faster, 500.0)
    np.testing.assert_allclose(forecast(1.0, 0.002, Future(), sd=1e-5).lives[0], lives, rtol=1e-3)


def test_changes_come_as_often_in_any_unit_of_operations():
    """By default half of the drives change their rate before they are twice as old."""
    turns, faster = Future(changes=1.5).turns(np.array([500.0, 1000.0]), 1000, 1)
    np.testing.assert_allclose(turns[1], 2.0 * turns[0])
    assert (turns[0] > 10000.0).mean() == pytest.approx((10500.0 / 500.0) ** -1.5, abs=1e-3)
    assert np.median(faster) == pytest.approx(6.0, rel=0.01)
    assert np.log(faster).std() == pytest.approx(0.4, rel=0.01)
    assert (Future().turns(np.array([500.0]), 1000, 1)[0] < 500.0).mean() == 0.5


def test_a_path_that_no_network_knows_goes_on_straight():
    nodes, nan = np.array([0.0, 1.0, 3.0, 8.0]), np.nan
    paths = np.array([[1.0, 2.0, nan, nan], [0.0, 5.0, 1.0, nan], [0.0, 0.0, nan, 7.0]])
    straight = [[1.0, 2.0, 4.0, 9.0], [0.0, 5.0, 1.0, -9.0], [0.0, 0.0, 0.0, 7.0]]
    np.testing.assert_allclose(_continued(paths.T[:, None, :, None], nodes)[:, 0, :, 0].T, straight)


def test_crossings_lie_on_the_line_between_nodes():
    nodes, inf = np.array([0.0, 10.0, 100.0]), np.inf
    excess = np.array([[-1.0, -1.0, 1.0], [-0.5, 1.0, 2.0], [4.0, 2.0, -1.0]])[:, :, None]
    np.testing.assert_allclose(_crossings(excess, nodes), [20.0, 5.0, 0.0])
    assert np.isinf(_crossings(-np.ones((3, 2, 1)), nodes)).all()
    # Of two parts the later decides; a leap from minus infinity counts from the next node on.
    before, after = [[-1.0, -3.0], [1.0, -1.0], [-inf, 1.0]], [[1.0, 1.0], [1.0, 3.0], [1.0, 1.0]]
    np.testing.assert_allclose(_crossings(np.array([before, after]), nodes[:2]), [7.5, 2.5, 10.0])
