"""Simulated lives, and the cost of their services relative to the best fixed interval."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from breaker.configuration.loading import load
from breaker.model.limits import Limit
from breaker.model.prior import Prior
from breaker.prognosis.states import STATES
from studies.lives import against_fixed, alarms_of, planned_of, shown_beyond
from studies.other_lives import LAWS, RECORDS, OtherLife


@pytest.mark.parametrize("name", LAWS)
def test_a_law_wears_from_new_to_worn_and_never_back(name):
    wear = LAWS[name](np.linspace(0.0, 1.0, 1001))
    assert wear[0] == pytest.approx(0.0, abs=1e-9)
    assert wear[-1] == pytest.approx(1.0)
    assert (np.diff(wear) >= 0.0).all()


def test_a_share_of_the_wear_is_reached_when_the_law_says():
    prior = Prior.from_settings(load()["prior"])
    life = OtherLife.drawn(prior, np.random.default_rng(1))
    operation = life.reached(0.8)
    assert life.wear(operation - 1.0) < 0.8 <= life.wear(operation)
    names = [name for name in life.factors if name in life.drive.more]
    worn = life.at(1.0)
    assert all(worn.more[n] == life.drive.more[n] * (1.0 + life.factors[n]) for n in names)


@pytest.mark.parametrize("length", [700.0, 1083.0, 1599.0, 4000.0])
def test_records_last_to_the_end_of_a_life(length):
    """A life whose records end before it fails would count as a failure."""
    operations = OtherLife(None, {}, "straight", length, 0.0).operations
    assert abs(operations[-1] - length) <= 0.5
    assert operations.size == RECORDS
    assert (np.diff(operations) > 0).all()


def test_the_cost_is_relative_to_the_best_interval_of_all_other_lives():
    """Lives of 100, 100 and 200: the others' best is 100 for each; served in time, or never."""
    fails = np.array([100.0, 100.0, 200.0])
    intime, low, high = against_fixed(fails, fails)
    assert intime == pytest.approx((3.0 / 400.0) / (3.0 / 300.0))
    assert low <= intime <= high
    never, *_ = against_fixed(np.full(3, np.inf), fails)
    assert never == pytest.approx(20.0 * intime)


def test_a_life_that_is_never_serviced_fails():
    lives = pd.DataFrame({"fails": [100.0, 100.0, 200.0], "service": [90.0, np.inf, 150.0]})
    lives[["first", "known", "records", "count", "moves"]] = [50.0, True, 10, 0, 1]
    lives["shown"] = [120.0, np.inf, 100.0]
    result = planned_of(lives)
    assert result["serviced in time"] == 2.0 / 3.0
    assert result["serviced before records show it"] == 2.0 / 3.0
    assert result["share of the life given away"] == pytest.approx(0.175)
    assert result["rows with service_by behind the 5 % quantile"] == 0.0


def test_records_show_a_limit_beyond_once_their_median_is():
    """Readings of a line that single ones leave by far more than the limit is away."""
    values = np.linspace(0.0, 10.0, 201)
    values[::10] += 30.0
    measured = SimpleNamespace(measured={"stroke": values})
    series = SimpleNamespace(operations=np.arange(201), motions={"closing": measured})
    limit = Limit("measured", "closing", (("stroke", 7.0, True),), of="record")
    assert shown_beyond(limit, series) == pytest.approx(140.0, abs=4.0)
    never = Limit("measured", "closing", (("stroke", 70.0, True),), of="record")
    assert shown_beyond(never, series) == np.inf
    assert np.isnan(shown_beyond(Limit("changed", "", (("f", 7.0, True),), of="change"), series))


def test_a_false_alarm_counts_with_the_time_before_it():
    """A drive that is told now from operation 300 on; nothing else, and nothing before 100."""
    operations = np.arange(0, 500, 10)
    state = np.where(operations >= 300, STATES.index("due"), STATES.index("ok"))[:, None]
    about = {"operation": operations, "limit": ["measured stroke"]}
    stands = xr.Dataset({"state": (("operation", "limit"), state)}, about)
    data = xr.Dataset(
        {
            "unchanged": (("asked", "parameter"), np.ones((50, 7))),
            "noticed": ("change", np.zeros(0)),
        },
        {"operation": operations, "asked": operations},
        {"reported_from": 100},
    )
    result = pd.DataFrame(alarms_of(data, {"monitoring": stands})).set_index("names")
    assert result.operation.to_dict() == {"planned": 200, "due": 200, "worn": 390, "change": 390}
    assert np.isfinite(result["first"]).to_dict() == {
        "planned": True, "due": True, "worn": False, "change": False
    }  # fmt: skip
