"""How limits stand: states, the operation by which to service, and what is too vague to be told."""

import numpy as np
import pytest

from breaker.wear import STATES, standing
from breaker.wear.states import planned
from tests.lives import OPERATIONS, a_life

PLANNING = {"operations": 150, "years": 2.0}
NO_DATES = np.full(OPERATIONS.size, np.nan)


def states(stands, limit):
    return np.array(STATES)[stands.state.sel(limit=limit).values]


def test_a_drive_is_healthy_then_planned_then_due():
    stands = standing(a_life(), PLANNING, NO_DATES)
    found = states(stands, "slow")
    assert (found[:99] == "unknown").all()
    assert found[150] == "healthy"
    assert found[380] == "plan"
    assert found[-1] == "now"
    order = [STATES.index(name) for name in found[99:]]
    assert (np.diff(order) >= 0).all()


def test_a_service_is_due_before_the_failure_and_not_far_before():
    stands = standing(a_life(), PLANNING, NO_DATES)
    due = OPERATIONS[np.argmax(states(stands, "slow") == "now")]
    assert 430 <= due <= 450
    by = stands.service_by.sel(limit="slow").values
    assert (np.diff(by[np.isfinite(by)]) != 0).sum() <= 5


def test_a_limit_that_is_exceeded_is_now_since_when_it_is_sure():
    stands = standing(a_life(fails=(400.0, np.inf)), PLANNING, NO_DATES)
    assert stands.certain.sel(limit="slow") == 400.0
    assert 390.0 <= stands.crossed.sel(limit="slow") <= 400.0
    assert np.isnan(stands.certain.sel(limit="stiff"))
    assert (stands.left.sel(limit="slow", operation=slice(400, None)) == 0.0).all()


def test_a_vague_limit_hides_no_other_and_plans_nothing():
    """The second fails first, but its quantity is known to a third of the way: not told."""
    life = a_life(fails=(450.0, 400.0))
    stands = standing(life, PLANNING, NO_DATES)
    assert states(stands, "stiff")[350] == "unknown"
    assert states(stands, "slow")[350] == "plan"
    assert stands.subject[350] == 0
    assert stands.drive_service_by[350] == stands.service_by.sel(limit="slow")[350]
    sharp = standing(a_life(fails=(450.0, 400.0), half=(0.01, 0.1)), PLANNING, NO_DATES)
    assert states(sharp, "stiff")[350] == "plan"
    assert sharp.subject[350] == 1


def test_nothing_is_told_of_a_limit_of_which_nothing_is_known():
    life = a_life()
    for name in ("beyond", "remaining", "steady", "value"):
        life[name][:] = np.nan
    stands = standing(life, PLANNING, NO_DATES)
    assert (stands.state == 0).all()
    assert (stands.subject == -1).all()
    assert np.isinf(stands.drive_service_by).all()


def test_what_is_measured_and_exceeded_is_told_at_once():
    stands = standing(a_life(fails=(40.0, np.inf)), PLANNING, NO_DATES)
    assert states(stands, "slow")[60] == "now"


def test_a_plan_looks_ahead_in_years_where_operations_are_dated():
    rare = standing(a_life(fails=(1500.0, np.inf)), PLANNING, np.full(OPERATIONS.size, 5.0))
    often = standing(a_life(fails=(1500.0, np.inf)), PLANNING, np.full(OPERATIONS.size, 0.1))
    assert states(often, "slow")[-1] == "plan"
    life = a_life(fails=(700.0, np.inf))
    assert states(standing(life, PLANNING, np.full(500, 3.0)), "slow")[-1] == "plan"
    assert states(rare, "slow")[-1] == "healthy"


def test_a_drive_without_limits_stands_nowhere():
    life = a_life().isel(limit=slice(0, 0), part=slice(0, 0))
    stands = standing(life, PLANNING, NO_DATES)
    assert (stands.drive_state == 0).all()
    assert (stands.subject == -1).all()


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
    ],
)
def test_a_date_moves_by_evidence_alone(estimate, told):
    operations, horizon = np.array([100, 150, 200])[: len(estimate)], np.full(len(estimate), 500.0)
    found = planned(np.array(estimate)[:, None], operations, horizon)
    np.testing.assert_array_equal(found[:, 0], told)


def test_a_date_that_has_come_stays():
    asked, estimate = np.array([100, 110, 120]), np.array([[100.0], [110.0], [120.0]])
    assert (planned(estimate, asked, np.full(3, 500.0)) == 100.0).all()
