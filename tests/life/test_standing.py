"""How limits stand: states, the operation by which to service, and what is too vague to be told."""

import numpy as np
import pytest

from breaker.drive.life.limit_states import STATES, planned, standing
from tests.lives import OPERATIONS, a_life

PLANNING = {"operations": 150, "years": 2.0}
NO_DATES = np.full(OPERATIONS.size, np.nan)


def stood(fails=(450.0, np.inf), dates=NO_DATES, **about):
    return standing(a_life(fails, **about), PLANNING, dates)


def states(stands, limit):
    return np.array(STATES)[stands.state.sel(limit=limit).values]


def test_a_drive_is_healthy_then_planned_then_due():
    stands = stood()
    found = states(stands, "slow")
    assert (found[:99] == "unknown").all()
    assert found[150] == "healthy"
    assert found[380] == "plan"
    assert found[-1] == "now"
    assert (np.diff(stands.state.sel(limit="slow").values[99:]) >= 0).all()
    # Due before the failure, and not far before.
    assert 430 <= OPERATIONS[np.argmax(found == "now")] <= 450
    by = stands.service_by.sel(limit="slow").values
    assert (np.diff(by[np.isfinite(by)]) != 0).sum() <= 5


def test_a_limit_that_is_exceeded_is_now_since_when_it_is_sure():
    stands = stood((400.0, np.inf))
    assert stands.certain.sel(limit="slow") == 400.0
    assert 390.0 <= stands.crossed.sel(limit="slow") <= 400.0
    assert np.isnan(stands.certain.sel(limit="stiff"))
    assert (stands.left.sel(limit="slow", operation=slice(400, None)) == 0.0).all()


def test_a_vague_limit_hides_no_other_and_plans_nothing():
    """The second fails first, but its quantity is known to a third of the way: not told."""
    stands = stood((450.0, 400.0))
    assert states(stands, "stiff")[350] == "unknown"
    assert states(stands, "slow")[350] == "plan"
    assert stands.subject[350] == 0
    assert stands.drive_service_by[350] == stands.service_by.sel(limit="slow")[350]
    sharp = stood((450.0, 400.0), half=(0.01, 0.1))
    assert states(sharp, "stiff")[350] == "plan"
    assert sharp.subject[350] == 1


def test_nothing_is_told_without_limits_or_of_those_of_which_nothing_is_known():
    unknown = a_life()
    for name in ("beyond", "remaining", "steady", "value"):
        unknown[name][:] = np.nan
    for life in (unknown, a_life().isel(limit=slice(0, 0), part=slice(0, 0))):
        stands = standing(life, PLANNING, NO_DATES)
        assert (stands.state == 0).all()
        assert (stands.drive_state == 0).all()
        assert (stands.subject == -1).all()
        assert np.isinf(stands.drive_service_by).all()


def test_what_is_measured_and_exceeded_is_told_at_once():
    assert states(stood((40.0, np.inf)), "slow")[60] == "now"


@pytest.mark.parametrize(
    ("fails", "days", "state"),
    [(1500.0, 5.0, "healthy"), (1500.0, 0.1, "plan"), (700.0, 3.0, "plan")],
)
def test_a_plan_looks_ahead_in_years_where_operations_are_dated(fails, days, state):
    stands = stood((fails, np.inf), np.full(OPERATIONS.size, days))
    assert states(stands, "slow")[-1] == state


@pytest.mark.parametrize(
    ("estimate", "told"),
    [
        ([700.0, 520.0, 480.0], [np.inf, 520.0, 520.0]),  # told from the horizon on
        ([500.0, 520.0, 480.0], [500.0, 500.0, 500.0]),  # within what is left
        ([500.0, 300.0, 320.0], [500.0, 300.0, 300.0]),
        ([300.0, 700.0], [300.0, 700.0]),
        ([300.0, 910.0, 620.0], [300.0, np.inf, 620.0]),  # no plan any more
        ([np.inf, 400.0, np.inf], [np.inf, 400.0, np.inf]),
        ([400.0, np.nan], [400.0, 400.0]),
        ([210.0, 215.0, 225.0], [210.0, 210.0, 210.0]),  # too little is gained
        ([210.0, 215.0, 250.0], [210.0, 210.0, 250.0]),
        ([100.0, 150.0, 200.0], [100.0, 100.0, 100.0]),  # one that has come stays
    ],
)
def test_a_date_moves_by_evidence_alone(estimate, told):
    operations, horizon = np.array([100, 150, 200])[: len(estimate)], np.full(len(estimate), 500.0)
    found = planned(np.array(estimate)[:, None], operations, horizon)
    np.testing.assert_array_equal(found[:, 0], told)
