"""Watching with restarts, and levels for a rate of false alarms."""

from functools import partial

import numpy as np
import pytest

from breaker.model.randomness import generator
from breaker.synthetic.control_charts import KINDS, chart
from breaker.synthetic.watching import Watch, level_for


def charted(series, kind, warm_up):
    return Watch(series, partial(chart, kind=kind, warm_up=warm_up))


def line(n, rng):
    return 10 + 0.02 * np.arange(n) + 0.3 * rng.standard_normal(n)


def rise(position, values):
    """How far a value is above the first, over its distance."""
    return (values - values[0]).max(axis=1) / np.maximum(position - position[0], 1.0)


def test_a_watch_restarts_at_its_alarm():
    """The statistic of an alarm stands; the next is of the values from it on, at their places."""
    found = Watch([0.0, 1.0, np.nan, 9.0, 9.0, 10.0, 12.0], rise).at(2.0)
    assert found.alarm.nonzero()[0].tolist() == [3]
    np.testing.assert_allclose(found.statistic, [0, 1, np.nan, 3, 0, 0.5, 1])


def test_a_statistic_above_the_level_at_once_does_not_stop_the_watch():
    found = Watch(np.zeros(5), lambda _, values: np.full(len(values), 3.0)).at(2.0)
    assert found.alarm.all()


def test_the_order_of_levels_does_not_matter():
    series = np.cumsum(generator(4, "test", "order").standard_normal((60, 2)), axis=0)
    watch = Watch(series, rise)
    for level in (0.1, 2.0, 0.5, 0.1):
        for mine, fresh in zip(watch.at(level), Watch(series, rise).at(level), strict=True):
            np.testing.assert_array_equal(mine, fresh)


def test_an_operation_without_any_value_is_left_out():
    series = np.array([[0.0, 0.0], [np.nan, 50.0], [1.0, 1.0]])
    np.testing.assert_array_equal(Watch(series, rise).at(9.0).statistic, [0, np.nan, 0.5])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("allowed", [0, 3, 12])
def test_level_for_is_the_least(kind, allowed):
    rng = generator(4, "test", "levels")
    watches = [charted(line(int(n), rng), kind, 15) for n in rng.integers(100, 200, 20)]
    rate = allowed / sum(each.values.size for each in watches)
    level = level_for(watches, rate)

    def count(level):
        return sum(each.at(level).alarm.sum() for each in watches)

    assert count(level) <= allowed < count(np.nextafter(level, 0))
    assert max(count(factor * level) for factor in np.linspace(1, 1.5, 40)) <= allowed


def test_what_comes_after_a_change_does_not_count():
    series = [
        np.append(line(100, generator(4, "test", "until", k)), 1e3 * np.arange(20))
        for k in range(3)
    ]
    watches = [charted(each, "ewma", 15) for each in series]
    alone = [charted(each[:100], "ewma", 15) for each in series]
    level = level_for(watches, 0.01, [100] * 3)
    assert level == pytest.approx(level_for(alone, 0.01), rel=1e-9)
    assert sum(each.at(level, 100).alarm.sum() for each in watches) <= 3
    assert all(len(each.at(level, 100).alarm) == 100 for each in watches)


def test_level_for_a_rate_that_nothing_reaches():
    series = line(50, generator(4, "test", "levels"))
    assert level_for([charted(series, "threshold", 5)], 1.0) == 0.0
    assert level_for([charted(np.full(50, np.nan), "cusum", 5)], 0.0) == 0.0


def test_unusable_arguments_are_refused():
    watch = Watch(np.arange(9.0), rise)
    for call, words in (
        (lambda: watch.at(-1.0), "level must not be negative"),
        (lambda: watch.at(np.nan), "level must not be negative"),
        (lambda: Watch(np.zeros((2, 2, 2)), rise), "series must be"),
        (lambda: Watch([1.0, np.inf], rise), "series must be"),
        (lambda: level_for([], 1e-3), "there must be operations"),
        (lambda: level_for([watch], -1e-3), "rate must not be negative"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
