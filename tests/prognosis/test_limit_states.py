"""States of limits: each transition, and by when to service."""

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.prognosis.limit_states import STATES, _ahead, _subject, next_state, states_of
from tests.lives import OPERATIONS, a_life

PLANNING = defaults()["planning"] | {"operations": 150, "years": 2.0}
USUAL = {"before": "ok", "p_exceeded": 0.0, "p_nearer": 0.5, "ahead": 2.0}


def states(result, limit):
    return np.array(STATES)[result.state.sel(limit=limit).values]


@pytest.mark.parametrize(
    ("state", "facts"),
    [
        ("due", {"p_exceeded": 0.95}),
        ("due", {"before": "due"}),
        ("unknown", {"p_exceeded": np.nan}),
        ("unknown", {"before": "planned", "p_nearer": np.nan}),
        ("planned", {"p_nearer": 0.95, "ahead": 1.0}),
        ("planned", {"before": "planned", "p_nearer": 0.6, "ahead": 1.0}),
        ("planned", {"before": "planned", "p_nearer": 0.6, "ahead": 2.0}),
        ("ok", {"before": "planned", "p_nearer": 0.6, "ahead": 2.1}),
        ("unknown", {"p_exceeded": 0.3}),
        ("ok", {}),
        ("ok", {"p_nearer": 0.94, "ahead": 1.0}),
        ("ok", {"p_exceeded": 0.3, "p_nearer": 0.99}),
        ("ok", {"before": "planned", "p_nearer": 0.4, "ahead": 1.0}),
    ],
)
def test_each_transition(state, facts):
    assert next_state(**USUAL | facts) == state


def test_a_drive_is_ok_then_planned_then_due():
    life = a_life()
    life.p_exceeded[:, 0] = np.where(life.asked >= 450, 1.0, 0.6 * (life.asked >= 430))
    result = states_of(life, PLANNING)
    seen, slow, stiff = states(result, "slow"), result.sel(limit="slow"), result.sel(limit="stiff")
    assert (seen[:99] == "unknown").all()
    assert [seen[150], seen[400], seen[-1]] == ["ok", "planned", "due"]
    assert (np.diff(slow.state.values[99:]) >= 0).all()
    assert (slow.certain, slow.crossed) == (450.0, 430.0)
    assert np.isnan([stiff.certain, stiff.crossed]).all()
    assert (slow.remaining.sel(operation=slice(450, None)) == 0.0).all()
    assert slow.recommended_since[-1] == result.drive_since[-1] > 300.0
    at = np.searchsorted(
        OPERATIONS, life.asked
    )  # no service is behind the quantile printed with it
    planned = result.state.values[at] == STATES.index("planned")
    last = life.asked.values[:, None] + result.remaining.values[at, :, 0]
    assert (result.service_by.values[at] <= last)[planned].all()


@pytest.mark.parametrize("maintained", [False, True])
def test_maintenance_alone_ends_due_and_makes_a_drive_young(maintained):
    life = a_life((1500.0, np.inf), reported_from=60)
    life.p_exceeded[:, 0] = (life.asked > 300) & (life.asked < 350)
    if maintained:
        life["start"][:], life["maintenance"][:] = 351, True
    result = states_of(life, PLANNING)
    seen = states(result, "slow")
    assert seen[320] == seen[349] == "due"
    assert seen[-1] == ("ok" if maintained else "due")
    assert (result.remaining.sel(limit="slow", operation=349) == 0.0).all()


@pytest.mark.parametrize(
    ("days", "age", "left", "ahead"),
    [
        (np.nan, 10000.0, 1e6, 400.0 / 150.0),  # in 150 operations, while the rate is not known
        (7.305, 10000.0, 1e6, 400.0 / 150.0),  # two years are 100 operations
        (3.6525, 10000.0, 1e6, 400.0 / 200.0),  # two years are 200 operations
        (np.nan, 250.0, 1e6, 400.0 / 50.0),  # a fifth of the age
        (np.nan, 10000.0, 30.0, 30.0 / 15.0),  # one and a half intervals of 10 operations
    ],
)
def test_planning_looks_ahead_by_operations_years_age_or_inspections(days, age, left, ahead):
    """Of lives of 0 to 1,000 operations, 40 % end within 400."""
    life = a_life()
    life.lives[:], life.remaining[:] = np.linspace(0.0, 1000.0, 41), left * np.array([1, 2, 3])
    result = _ahead(life, PLANNING, np.full(life.asked.shape, days), np.full(life.asked.shape, age))
    assert result[-1, 0] == pytest.approx(ahead)


def test_the_drive_is_about_its_most_urgent_limit():
    state, inf, nan = np.array([[1, 1], [0, 0], [2, 1], [2, 2], [3, 3], [1, 1]]), np.inf, np.nan
    by = np.array([[inf, inf], [inf, inf], [500, inf], [500, 400], [300, 400], [inf, inf]])
    left = np.array([[300, 200], [9, 9], [300, 10], [1, 2], [0, 0], [nan, nan]])
    assert _subject(state, by, left).tolist() == [1, -1, 0, 1, 0, -1]
