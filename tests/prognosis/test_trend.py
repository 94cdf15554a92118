"""The path of coordinates: what it knows, which changes it notices, and what it does not."""

import numpy as np
import pytest

from breaker.prognosis import trend
from breaker.prognosis.series import Series
from breaker.prognosis.trend import Block, PathFit, evidence

N, NEW = 300, 50
TIME = np.arange(N)


def blocks(seed=1, *, add=0.0, aside=0.0, k=6):
    """Two blocks of scatter, with something added to the first coordinate, and to the third."""
    rng = np.random.default_rng(seed)
    values = [rng.standard_normal((N, k)) for _ in range(2)]
    values[0][:, 0] += add
    values[0][:, 2] += aside
    return [Block(value, np.geomspace(1e4, 1.0, k), np.ones(k)) for value in values]


def follow(some, events=None, conditions=()):
    series = Series(TIME, {}, np.arange(NEW), events or {}, conditions)
    return trend.Follower(series, some, threshold=10.0).path()


@pytest.mark.parametrize("start", [10, 38])
@pytest.mark.parametrize("step", [True, False])
def test_coefficients_and_evidence_are_those_of_regressions_of_all_records(start, step):
    """Log evidence with the column less that without it, both from normal densities of all data."""
    n, k, rng = 40, 3, np.random.default_rng(1)
    design = np.stack([np.ones(n), np.linspace(0.0, 1.0, n)], axis=1)
    values = rng.standard_normal((n, k)) + np.outer(design[:, 1], [3.0, -1.0, 0.0])
    values[5] = np.nan
    fit = PathFit([Block(values, np.ones(k), np.ones(k))])
    fit.noise = np.array([1.0, 2.0, 0.5])
    fit.design(design, 10)
    for i in range(10, n):
        fit.add(i, i + 1)
    fit.solve(n - 1, np.full((k, 2), 0.01))
    row = np.array([1.0, 0.0]) if step else np.array([-design[start, 1], 1.0])
    explained = fit.explained(np.array([start]), n - 1, row[None])
    there = np.isfinite(values[:, 0])
    some, column = design[there], ((np.arange(n) >= start) * (design @ row))[there, None]
    expected = 0.0
    for y, noise, mean, cov in zip(values[there].T, fit.noise, fit.mean, fit.cov, strict=True):
        square = some.T @ some / noise + 0.01 * np.eye(2)
        np.testing.assert_allclose(mean, np.linalg.solve(square, some.T @ y / noise))
        np.testing.assert_allclose(cov, np.linalg.inv(square))
        wide = 100.0 * some @ some.T + noise * np.eye(len(y))
        for sign, cov_y in ((-0.5, wide + 4.0 * column @ column.T), (0.5, wide)):
            expected += sign * (y @ np.linalg.solve(cov_y, y) + np.linalg.slogdet(cov_y)[1])
    (result,) = evidence(*explained, np.full((1, k), 4.0))
    assert result == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("bend", "rate"), [(0.0, 0.05), (0.001, 0.05 + 0.002 * TIME[-1])])
def test_a_path_and_its_rate_are_known_also_where_it_bends(bend, rate):
    path = follow(blocks(add=0.05 * TIME + bend * TIME**2.0))
    assert np.isnan(path.change[: NEW - 1]).all()
    last, sd = path.rate[-1], np.sqrt(path.rate_variance[-1])
    assert abs(last[0] - rate) < 4.0 * sd[0]
    assert abs(last[2]) < 4.0 * sd[2]


def test_nothing_is_noticed_where_nothing_changes_and_neighbours_share_errors():
    """6 lives of 200 records, false with a probability of 1e-3 each at most."""
    assert not any(follow(blocks(seed)).changes for seed in range(6))
    rng, some = np.random.default_rng(1), blocks()
    for values in (block.values for block in some):
        for i in range(1, N):
            values[i] = 0.6 * values[i - 1] + 0.8 * rng.standard_normal(6)
    assert not follow(some).changes


@pytest.mark.parametrize(
    ("what", "aside", "kind", "late"),
    [
        (4.0 * (TIME >= 200), 0.0, "step", 5),
        (0.02 * TIME + 0.3 * np.maximum(TIME - 199, 0), 0.0, "rate", 30),
        (0.05 * TIME, 0.3 * np.maximum(TIME - 199, 0), "rate", 40),
    ],
)
def test_a_planted_change_is_noticed_placed_and_named(what, aside, kind, late):
    path = follow(blocks(add=what, aside=aside))
    assert len(path.changes) == 1
    result = path.changes[0]
    assert result.kind == kind
    assert 200 < result.noticed <= 200 + late
    assert abs(result.start - 200) <= 8
    assert result.earliest <= result.start <= result.latest
    true = what - what[:NEW].mean()
    off = (path.change[-1, 0] - true[-1]) / np.sqrt(path.variance[-1, 0])
    assert abs(off) < 4.0


def test_one_odd_record_is_no_change_and_hardly_counts():
    odd = blocks()
    odd[0].values[200] += 30.0
    path, usual = follow(odd), follow(blocks())
    assert not path.changes
    assert path.weight[200] < 0.05 < 0.5 < np.median(path.weight[100:])
    off = np.abs(path.change[201:, 0] - usual.change[201:, 0])
    assert (off < np.sqrt(path.variance[201:, 0])).all()


def test_a_bent_path_is_no_change_unless_its_bend_is_denied(monkeypatch):
    """A curvature of a tenth of the change; the planted fault is a trend that knows of none."""
    share = TIME / N
    bent = 60.0 * (share + 0.1 * share**2)
    assert not follow(blocks(add=bent)).changes
    monkeypatch.setattr(trend, "_BEND", 1e-6)
    assert follow(blocks(add=bent)).changes


def test_work_starts_a_line_without_an_alarm_and_what_a_transducer_moved_is_no_change():
    moved = blocks(add=5.0 * (TIME >= 150))
    path, remounted = (follow(moved, events={150: maintained}) for maintained in (True, False))
    assert [(e.kind, e.maintenance) for e in path.changes] == [("event", True)]
    assert [(e.kind, e.maintenance) for e in remounted.changes] == [("event", False)]
    assert path.change[-1, 0] == pytest.approx(5.0, abs=1.0)
    assert remounted.change[-1, 0] == pytest.approx(0.0, abs=1.0)
    assert follow(moved).change[-1, 0] > 3.0  # the planted fault: nobody said so


def test_seasons_and_low_batteries_are_not_taken_for_wear():
    """The voltage falls by 15 % for good, in a winter that comes and goes; true wear stays told."""
    low = -1.5 * (TIME >= 150) + 0.2 * np.sin(TIME)
    warm = np.sin(2.0 * np.pi * TIME / 150.0)
    for add, known in ((6.0 * warm, [warm]), (4.0 * low + 2.0 * warm, [warm, low])):
        path = follow(blocks(add=add), conditions=known)
        assert not path.changes
        assert path.change[-1, 0] == pytest.approx(0.0, abs=1.0)
        assert follow(blocks(add=add)).changes  # the planted fault: no temperatures, no voltages
    worn = follow(blocks(add=4.0 * low + 0.05 * TIME), conditions=[warm, low])
    assert worn.change[-1, 0] == pytest.approx(0.05 * (N - NEW / 2.0), abs=2.5)
