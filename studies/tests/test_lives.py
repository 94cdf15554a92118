"""Simulated lives, and the cost of their services relative to the best fixed interval."""

import numpy as np
import pytest
import xarray as xr

from breaker.configuration.loading import load
from breaker.model.limits import Limit
from breaker.model.prior import Prior
from breaker.prognosis.limit_states import STATES
from studies.lives import against_fixed, alarms_of, serviced
from studies.other_lives import LAWS, RECORDS, OtherLife


@pytest.mark.parametrize("name", LAWS)
def test_a_law_wears_from_new_to_worn_and_never_back(name):
    wear = LAWS[name](np.linspace(0.0, 1.0, 1001))
    assert wear[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-9)
    assert (np.diff(wear) >= 0.0).all()


def test_a_share_of_the_wear_is_reached_when_the_law_says():
    life = OtherLife.drawn(Prior.from_settings(load()["prior"]), np.random.default_rng(1))
    operation = life.reached(0.8)
    assert life.wear(operation - 1.0) < 0.8 <= life.wear(operation)


@pytest.mark.parametrize("length", [700.0, 1083.0, 4000.0])
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


@pytest.mark.parametrize(
    ("states", "by", "service"),
    [
        (["ok"] * 4, [np.inf] * 4, np.inf),
        (["ok", "planned", "planned", "due"], [np.inf, 250, 250, 400], 250),
        (["ok", "planned", "planned", "due"], [np.inf, 450, 450, 400], 400),
        (["planned", "ok", "ok", "ok"], [150, np.inf, np.inf, np.inf], 150),
        (["planned", "ok", "ok", "ok"], [250, np.inf, np.inf, np.inf], np.inf),
    ],
)
def test_a_planned_service_is_done_if_it_comes_before_the_next_look(states, by, service):
    state = np.array([[STATES.index(name)] for name in states])
    columns = {"state": state, "service_by": np.array(by, dtype=float)[:, None]}
    stands = xr.Dataset(
        {name: (("operation", "limit"), values) for name, values in columns.items()},
        {"operation": [100, 200, 300, 400], "limit": ["a"]},
    )
    limit = Limit("a", "", (("f", -7.0, False),), of="change")
    assert serviced(limit, 390.0, "monitoring", stands)["service"] == service


def test_a_false_alarm_counts_with_the_time_before_it():
    """A service that is due from operation 300 on; nothing else, and nothing before 100."""
    operations = np.arange(0, 500, 10)
    state = np.where(operations >= 300, STATES.index("due"), STATES.index("ok"))[:, None]
    about = {"operation": operations, "limit": ["measured stroke"]}
    stands = xr.Dataset({"state": (("operation", "limit"), state)}, about)
    data = xr.Dataset(
        {"unchanged": (("asked", "parameter"), np.ones((50, 7))), "noticed": ("change", [])},
        {"operation": operations, "asked": operations},
        {"reported_from": 100},
    )
    rows = {row["kind"]: (row["operations"], row["false"]) for row in alarms_of(data, stands)}
    assert rows == {"planned": (200, 1), "due": (200, 1), "worn": (390, 0), "change": (390, 0)}
