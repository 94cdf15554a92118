"""How limits stand: states, the operation by which to service, and what is too vague to be told."""

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.prognosis.limit_states import STATES, planned, standing
from tests.lives import OPERATIONS, a_life

PLANNING = defaults()["planning"] | {"operations": 150, "years": 2.0}
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
    # The 5 % quantile is half of what is left: so the date is moved with each half that is gone.
    assert (np.diff(by[np.isfinite(by)]) != 0).sum() <= 8


def test_a_limit_that_is_exceeded_is_now_since_when_it_is_sure():
    stands = stood((400.0, np.inf))
    assert stands.certain.sel(limit="slow") == 400.0
    assert 390.0 <= stands.crossed.sel(limit="slow") <= 400.0
    assert np.isnan(stands.certain.sel(limit="stiff"))
    assert (stands.left.sel(limit="slow", operation=slice(400, None)) == 0.0).all()


def test_a_vague_limit_hides_no_other_and_plans_nothing():
    """The second fails first, but may as well be as new: not told."""
    stands = stood((450.0, 400.0))
    assert states(stands, "stiff")[370] == "unknown"
    assert states(stands, "slow")[370] == "plan"
    assert stands.subject[370] == 0
    assert stands.drive_service_by[370] == stands.service_by.sel(limit="slow")[370]
    sharp = stood((450.0, 400.0), half=(0.01, 0.1))
    assert states(sharp, "stiff")[350] == "plan"
    assert sharp.subject[350] == 1


def test_what_all_readings_are_off_alike_is_none_of_the_change_since_new():
    """A value of half the way to its limit, at 80 % of it, may be beyond: its readings' sd."""
    life = a_life((450.0, np.inf), half=(0.9, 0.1))
    assert states(standing(life, PLANNING, NO_DATES), "slow")[370] == "unknown"
    alike = life.assign(common=life.common + np.array([0.9 / 1.645, 0.0]))
    assert states(standing(alike, PLANNING, NO_DATES), "slow")[370] == "plan"


def test_nothing_is_told_without_limits_or_of_those_of_which_nothing_is_known():
    unknown = a_life()
    for name in ("beyond", "remaining", "lives", "value"):
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


def told_of(estimate, last=None, work=None, horizon=500.0):
    """What is told of estimates at the operations 100, 150, 200 ..."""
    estimate = np.array(estimate)[:, None]
    asked = 100.0 + 50.0 * np.arange(len(estimate))
    last = np.full(estimate.shape, np.inf) if last is None else np.array(last)[:, None]
    spell = np.zeros(len(asked)) if work is None else np.array(work)
    about = np.full(len(asked), horizon), spell, np.full(len(asked), 300.0)
    return planned(estimate, last, asked, *about)[:, 0].tolist()


@pytest.mark.parametrize(
    ("estimate", "told"),
    [
        ([700.0, 520.0, 480.0], [np.inf, 520.0, 520.0]),  # told from the horizon on
        ([500.0, 520.0, 480.0], [500.0, 500.0, 500.0]),  # within what is left
        ([500.0, 300.0, 320.0], [500.0, 300.0, 300.0]),
        ([300.0, 700.0], [300.0, 700.0]),
        ([300.0, 910.0, 620.0], [300.0, 300.0, 620.0]),
        ([np.inf, 400.0, np.inf, 380.0], [np.inf, 400.0, 400.0, 400.0]),  # one estimate
        ([np.inf, 400.0, np.inf, np.inf], [np.inf, 400.0, 400.0, np.inf]),  # no plan any more
        ([400.0, np.nan], [400.0, 400.0]),
        ([300.0, 301.0, 302.0], [300.0, 300.0, 300.0]),  # too little is gained
        ([210.0, 215.0, 250.0], [210.0, 215.0, 250.0]),  # all counts of what is about to come
        ([100.0, 150.0, 900.0], [100.0, 100.0, 100.0]),  # one that has come stays
    ],
)
def test_a_date_moves_by_evidence_alone(estimate, told):
    assert told_of(estimate) == told


@pytest.mark.parametrize("seed", range(5))
def test_a_plan_does_not_flicker_where_soon_and_never_cost_alike(seed):
    """A third of the estimates are beyond the horizon, and four in a row now and then: the plan
    stays. It is revoked once they last for a tenth of the operations since new.
    """
    asked = np.arange(500.0, 1500.0, 4.0)
    never = np.random.default_rng(seed).random(asked.size) < 0.33
    never[200:] = True
    estimate = np.where(never, np.inf, asked + 380.0)[:, None]
    about = np.full(asked.size, 500.0), np.zeros(asked.size), asked
    told = planned(estimate, asked[:, None] + 220.0, asked, *about)[:, 0]
    first = np.argmin(never)
    on = np.isfinite(told)
    assert on[first:200].all()
    assert np.flatnonzero(np.diff(on[first:].astype(int))).size == 1
    assert 1300.0 + 130.0 <= asked[np.flatnonzero(on)[-1] + 1] <= 1300.0 + 165.0


def test_a_date_is_never_behind_the_last_that_may_be_told():
    assert told_of([500.0, 520.0], last=[300.0, 310.0]) == [300.0, 300.0]
    assert told_of([500.0, 520.0], last=[450.0, 430.0]) == [450.0, 430.0]
    # Perhaps exceeded already: now, however far away the cheapest operation is.
    assert told_of([np.inf, np.inf], last=[np.inf, 150.0]) == [np.inf, 150.0]


def test_what_is_due_stays_so_until_work_on_the_drive():
    due = [100.0, 400.0, 900.0, 900.0]
    assert told_of(due) == [100.0] * 4
    assert told_of(due, work=[0, 0, 1, 1]) == [100.0, 100.0, np.inf, np.inf]


@pytest.mark.parametrize("works", [False, True])
def test_now_is_revoked_by_work_alone(works):
    """Exceeded at 300 by a record that was wrong, or by a drive that was greased at 351."""
    life = a_life((1500.0, np.inf), told=60)
    life.beyond[:, 0] = (life.asked > 300) & (life.asked < 350)
    if works:
        life["start"][:], life["work"][:] = 351, True
    stands = standing(life, PLANNING, NO_DATES)
    found = states(stands, "slow")
    assert found[320] == found[349] == "now"
    assert found[-1] == ("healthy" if works else "now")
    since = stands.since.sel(limit="slow").values
    assert np.isnan(since[200])
    assert since[349] == 310.0
    assert (stands.drive_since.values[-1] == 310.0) != works


def test_a_service_is_told_since_when_it_was_first_planned():
    stands = stood()
    planned_at = OPERATIONS[np.argmax(states(stands, "slow") == "plan")]
    assert stands.since.sel(limit="slow")[-1] == planned_at == stands.drive_since[-1]
