"""Steady answers: constant input changes nothing, noise little, and what is real passes at once."""

import numpy as np
import pytest

from breaker.decisions.steadiness import RANKS, service_by, subject
from breaker.model.randomness import generator

INF = np.inf
HOLD = 20
NUMBERS = np.arange(1, 401)
QUIET = [""] * 400
PLAN, CHECK, SERVICE = (RANKS.index(name) for name in ("plan", "check", "service"))


def chosen(rank, due, reasons=QUIET, hold=HOLD, numbers=NUMBERS):
    """Limit and rank of 400 operations, from what is broadcast to (400, l)."""
    rank, due = (np.broadcast_to(each, (400, np.shape(each)[-1])) for each in (rank, due))
    return subject(rank, due, np.zeros(due.shape), numbers, reasons, hold=hold)


def changes(values):
    """How often a series takes another value."""
    return int((np.diff(values) != 0).sum())


# ---- the limit -------------------------------------------------------------------------------


def test_constant_input_changes_nothing():
    found = chosen([PLAN, CHECK, 0], [900.0, 950.0, INF])
    assert set(found.limit) == {1}
    assert set(found.rank) == {CHECK}
    by, why = service_by(np.full(400, 500.0), NUMBERS, QUIET, hold=HOLD)
    assert set(by) == {500.0}
    assert set(why) == {""}


def test_equals_are_decided_by_probability():
    due, probability = np.full((1, 2), 7.0), np.array([[0.1, 0.3]])
    found = subject(np.full((1, 2), CHECK), due, probability, NUMBERS[:1], [""], hold=HOLD)
    assert found.limit.tolist() == [1]


@pytest.mark.parametrize(("dates", "scatter"), [([300.0, 302.0], 0.03), ([900.0, 905.0], 0.2)])
def test_two_limits_that_are_due_about_the_same_do_not_alternate(dates, scatter):
    """Soon, or far ahead where estimates scatter more: hardly ever is one sooner by a tenth."""
    rng = generator(1, "test", "alternate", str(scatter))
    left = np.array(dates) * np.exp(scatter * rng.standard_normal((400, 2)))
    assert changes(left.argmin(axis=1)) > 100
    assert changes(chosen(PLAN * np.ones(2, int), NUMBERS[:, None] + left).limit) <= 5


def test_noise_about_a_threshold_changes_the_action_rarely():
    """At most twice in the operations after which a milder one is told."""
    rng = generator(1, "test", "threshold")
    rank = np.where(rng.random((400, 1)) < 0.5, PLAN, CHECK)
    assert changes(rank[:, 0]) > 100
    found = chosen(rank, NUMBERS[:, None] + 50.0)
    assert changes(found.rank) <= 2 * 400 // HOLD
    assert found.rank.mean() > CHECK - 0.2  # the more urgent one


@pytest.mark.parametrize("urgent", [CHECK, SERVICE])
def test_what_is_more_urgent_is_told_at_once_and_what_is_less_after_it_held(urgent):
    rank = np.full((400, 2), PLAN)
    rank[100:200, 1] = urgent
    found = chosen(rank, np.tile([500.0, 900.0], (400, 1)))
    ends = 200 if urgent == SERVICE else 200 + HOLD  # exceeded has a hysteresis of its own
    assert np.flatnonzero(found.limit).tolist() == list(range(100, ends))
    reasons = ["repaired" if i == 210 else "" for i in range(400)]
    ends = min(ends, 210)
    again = chosen(rank, np.tile([500.0, 900.0], (400, 1)), reasons)
    assert np.flatnonzero(again.limit).tolist() == list(range(100, ends))


def test_a_limit_that_is_due_earlier_is_told_at_once_if_soon_else_once_it_held():
    due = np.tile([500.0, 900.0], (400, 1))
    due[100:, 1] = 450.0  # a tenth of 399 before is 460
    assert np.flatnonzero(chosen(PLAN * np.ones(2, int), due).limit)[0] == 100 + HOLD
    due[100:, 1] = 101.0 + HOLD
    assert np.flatnonzero(chosen(PLAN * np.ones(2, int), due).limit)[0] == 100
    due[100:, 1] = 465.0
    assert chosen(PLAN * np.ones(2, int), due).limit[100:150].max() == 0


# ---- the date --------------------------------------------------------------------------------


def service(estimate, reasons=QUIET, hold=HOLD):
    estimate = np.asarray(estimate, dtype=float)
    return service_by(estimate, NUMBERS[: len(estimate)], reasons[: len(estimate)], hold=hold)


def test_a_date_follows_noise_rarely_and_never_back_without_a_reason():
    rng = generator(1, "test", "date")
    estimate = NUMBERS + 600.0 * np.exp(0.05 * rng.standard_normal(400)) - NUMBERS
    by, why = service(estimate)
    assert changes(by) <= 400 // HOLD
    later = np.flatnonzero(np.diff(by) > 0) + 1
    assert all(why[i] for i in later)
    assert all(not why[i] for i in set(range(400)) - set(later))


def test_a_date_moves_earlier_at_once():
    estimate = np.where(NUMBERS > 100, 300.0, 600.0)
    by, _ = service(estimate)
    assert by[99:101].tolist() == [600, 300]
    assert service(np.where(NUMBERS > 100, 560.0, 600.0))[0][-1] == 560  # beyond a tenth, in time
    near = service(np.where(NUMBERS > 100, 560.0, 600.0)[:150])[0]
    assert set(near) == {600.0}  # within a tenth of 450 to 500 operations


def test_a_date_moves_later_to_the_earliest_of_what_held():
    estimate = np.where(NUMBERS > 100, 700.0, 300.0)
    estimate[[110, 118]] = 600.0, 650.0  # before the last ten, and among them
    by, why = service(estimate)
    assert by[119:122].tolist() == [300, 650, 650]
    assert why[120] == f"later for {HOLD} operations"
    estimate[110] = 300.0  # it was not later all the time
    assert service(estimate)[0][120] == 300
    rare = service_by(np.array([3000.0] + [7000.0] * 15), 5 * np.arange(16), QUIET, hold=HOLD)[0]
    assert rare[9:11].tolist() == [3000, 7000]  # ten records, though twenty operations are four


def test_a_date_moves_later_with_a_reason_at_once():
    estimate = np.where(NUMBERS > 100, 700.0, 300.0)
    by, why = service(estimate, ["" if i != 101 else "new spring" for i in range(400)])
    assert by[100:103].tolist() == [300, 700, 700]
    assert why[101] == "new spring"


def test_what_is_due_stays_due():
    """An estimate that goes along with the operations is no later one; no estimate is."""
    by, why = service(np.where(NUMBERS > 50, NUMBERS, 200))
    assert by[-1] == 51
    assert set(why) == {""}
    by, why = service(np.where(NUMBERS > 100, INF, 300))
    assert by[119:121].tolist() == [300, INF]
    assert why[120].startswith("no trend leads to a limit")


def test_planted_alternation_is_noticed():
    """Without a tolerance and without waiting, both properties above fail."""
    rng = generator(1, "test", "alternate")
    left = np.array([300.0, 302.0]) * np.exp(0.03 * rng.standard_normal((400, 2)))
    unsteady = ["reason"] * 400
    assert changes(chosen(PLAN * np.ones(2, int), NUMBERS[:, None] + left, unsteady).limit) > 100
    assert changes(service(600.0 + 60 * rng.standard_normal(400), unsteady)[0]) > 100
