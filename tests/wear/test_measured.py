"""Trends of measured quantities: levels, changes, remaining lives, and how honest they are."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binom

from breaker.mechanism.limits import Limit
from breaker.model.randomness import generator
from breaker.wear.events import Event
from breaker.wear.measured import _left, _nothing, follow_measured

SLOW = Limit("slow", "closing", (("travel_time", 9.6, True),), of="record")


@pytest.fixture(scope="module")
def wear(defaults):
    return defaults["wear_model"] | {"baseline": 20, "settle": 30}


def records(values, sd, operations=None, quantity="travel_time"):
    """Records that show one quantity, none where its value is nan."""
    o = np.arange(1, len(values) + 1) if operations is None else operations
    both = {"measured": values, "measured_sd": np.where(np.isnan(values), np.nan, sd)}
    return xr.Dataset(
        {name: (("operation", "quantity"), each[:, None]) for name, each in both.items()}
        | {"accepted": ("operation", np.ones(len(values), dtype=bool))},
        {"operation": o, "quantity": [quantity]},
    )


def worn(n, slope, change=np.inf, faster=1.0, sd=0.04, seed=1):
    """Travel times of a drive that wears, ms, and their level."""
    o = np.arange(n)
    level = 9.0 + slope * (np.minimum(o, change) + faster * np.maximum(o - change, 0.0))
    return level + sd * generator(seed, "test", "measured").standard_normal(n), level


@pytest.fixture(scope="module")
def bent(wear):
    """200 operations of little wear, then four times as much."""
    values, level = worn(300, 0.0005, change=200, faster=8.0)
    values[40:45] = np.nan
    return follow_measured({"closing": records(values, 0.03)}, [SLOW], wear, 1), level


def test_level_and_change(bent):
    """A level is within 4 sds with a probability of 6e-5; a half interval is 1.64 of them."""
    found, level = bent
    half = np.diff(found.level_interval.values[:, 0], axis=-1)[:, 0] / 2.0
    off = (found.level.values[:, 0] - level) / half
    settled = np.r_[30:195, 270:300]
    assert np.abs(off[settled]).max() < 4.0 / 1.64
    alarms = found.operation.values[found.alarm.values[:, 0]]
    assert len(alarms) == 1
    assert 200 < alarms[0] < 260
    assert np.isnan(found.start_interval.sel(operation=alarms[0] - 1)).all()
    low, middle, high = found.start_interval.values[-1, 0]  # one of ten holds it not
    assert 190 < low <= middle <= high <= alarms[0]
    assert low <= 201 <= high
    assert found.followed.values.tolist() == ["closing travel_time"]
    assert found.followed_unit.values.tolist() == ["ms"]
    # An sd of 0.04 is 0.03 of the records and 0.026 of the drive.
    assert found.scatter.values[-1, 0] == pytest.approx(0.026, abs=0.012)


def test_remaining_life(bent):
    """At 280, the level is at 9.42 and the limit is 45 operations away."""
    found, level = bent
    lower, median, upper = found.remaining.sel(limit="slow", operation=280).values
    truth = np.ceil((9.6 - level[279]) / 0.004)
    assert lower <= truth <= upper
    assert upper - lower < truth
    assert lower < median < upper
    assert found.toward.sel(limit="slow", operation=280) > 0.95
    assert found.beyond.sel(limit="slow", operation=280) == 0.0
    assert found.words.values.tolist() == ["measured travel_time above 9.6 ms"]
    assert found.part_limit.values.tolist() == ["slow"]


@pytest.mark.parametrize("factor", [0.01, 40.0])
def test_any_size_is_followed_alike(wear, factor):
    values, _ = worn(60, 0.002)
    limit = replace(SLOW, parts=(("travel_time", 9.6 * factor, True),))
    here = follow_measured({"closing": records(values, 0.03)}, [SLOW], wear, 1)
    there = follow_measured({"closing": records(factor * values, factor * 0.03)}, [limit], wear, 1)
    for name in ("remaining", "toward", "beyond"):
        np.testing.assert_allclose(there[name], here[name], rtol=1e-6)
    for name in ("level", "slope", "scatter"):
        np.testing.assert_allclose(there[name], factor * here[name], rtol=1e-6)


def test_what_no_record_shows_is_unknown(wear):
    values = np.full(20, np.nan)
    values[12:] = 9.0
    late = follow_measured({"closing": records(values, 0.03)}, [SLOW], wear, 1)
    for name in ("remaining", "toward", "beyond", "value", "level"):
        known = np.isfinite(late[name].values).reshape(20, -1)
        assert not known[:12].any()
        assert name == "remaining" or known[12:].all()
    rejected = records(np.full(20, 9.0), 0.03).assign(accepted=("operation", np.zeros(20, bool)))
    assert np.isnan(follow_measured({"closing": rejected}, [SLOW], wear, 1).remaining).all()


def test_a_limit_of_several_quantities():
    """All parts at once: from the last that begins to hold, unless one ends to hold before."""
    slow = Limit("a", "closing", (("travel_time", 9.5, True), ("stroke", 13.0, False)), of="record")
    time, stroke = _nothing(4), _nothing(4)
    time.lines[:] = [9.0, 0.1]  # beyond 9.5 from 5 operations on
    stroke.lines[0] = [14.0, -0.05]  # below 13 from 20 on
    stroke.lines[1] = [12.9, 0.01]  # below it for 10
    stroke.lines[2] = [12.9, 0.05]  # below it for 2
    trends = {("closing", "travel_time"): time, ("closing", "stroke"): stroke}
    left = _left(slow, trends, 1000)
    np.testing.assert_allclose(left.lives[:3, 0], [21.0, 6.0, np.inf], atol=1.0)
    assert left.toward.tolist()[:3] == [1.0, 1.0, 1.0]
    assert np.isnan(left.lives[3]).all()
    assert np.isnan(left.toward[3])
    assert np.isinf(_left(slow, trends, 15).lives[0]).all()  # beyond the horizon


def test_intervals_are_honest(wear):
    """Of 40 lines, the 90 % intervals of level and life hold as many as chance: bounds of 5e-4.

    With half their width they hold too few.
    """
    held, half = np.zeros((2, 2), dtype=int)
    for seed in range(40):
        rng = generator(seed, "test", "measured lines")
        slope, sd = rng.uniform(0.001, 0.004), rng.uniform(0.02, 0.06)
        values, level = worn(50, slope, sd=sd, seed=seed)
        values = values + 0.5 * sd * rng.standard_normal()  # what all records share
        limit = replace(SLOW, parts=(("travel_time", level[-1] + 60 * slope, True),))
        still = wear | {"bend": 0.0, "operations_between_changes": np.inf}
        last = follow_measured({"closing": records(values, 0.5 * sd)}, [limit], still, seed)
        last = last.isel(operation=-1)
        levels = np.append(last.level_interval.values[0], last.level.values[0])
        lives = last.remaining.values[0][[0, 2, 1]]
        for k, (ends, truth) in enumerate(((levels, level[-1]), (lives, 60.0))):
            low, high, middle = ends
            held[k] += low <= truth <= high
            half[k] += (low + middle) / 2 <= truth <= (middle + high) / 2
    least, most = binom.ppf([5e-4, 1 - 5e-4], 40, 0.9)
    assert np.all((held >= least) & (held <= most)), held
    assert np.all(half < least), half


@pytest.mark.parametrize("text", ["greased", "remounted"])
def test_a_known_event_starts_a_quantity_anew(wear, text):
    """A jump by 0.5 ms is known at once, and alarms nobody; only work on the drive takes the slope.

    Beyond 4 sds with a probability of 6e-5.
    """
    values, level = worn(120, 0.002)
    values[90:] += 0.5
    data = {"closing": records(values, 0.03)}
    unknown = follow_measured(data, [SLOW], wear, 1)
    found = follow_measured(data, [SLOW], wear, 1, {91: Event.from_text(text)})
    assert unknown.alarm.any()
    assert not found.alarm.any()
    assert np.isnan(found.start_interval).all()
    told = found.event.values[90]
    assert told == Event.from_text(text).told(91)
    assert (found.event.values == told).sum() == 1
    half = np.diff(found.level_interval.values[90:, 0], axis=-1)[:, 0] / 2.0
    assert np.abs((found.level.values[90:, 0] - level[90:] - 0.5) / half).max() < 4.0 / 1.64
    before, after = np.ptp(found.slope_interval.values[[89, 90], 0], axis=-1)
    assert (after > 4 * before) == (text == "greased")
    xr.testing.assert_identical(
        found.level.isel(operation=slice(0, 90)), unknown.level.isel(operation=slice(0, 90))
    )
