"""States of limits: each transition of the table, and by when to service."""

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.prognosis.states import STATES, TRANSITIONS, Facts, next_state, states_of
from tests.lives import OPERATIONS, a_life

PLANNING = defaults()["planning"] | {"operations": 150, "years": 2.0}
NO_DATES = np.full(OPERATIONS.size, np.nan)
USUAL = Facts("ok", False, 0.0, 0.5, soon=False, far=True)


def stood(fails=(450.0, np.inf), dates=NO_DATES, **about):
    return states_of(a_life(fails, **about), PLANNING, dates)


def states(found, limit):
    return np.array(STATES)[found.state.sel(limit=limit).values]


@pytest.mark.parametrize(
    ("row", "facts"),
    [
        (0, {"p_exceeded": 0.95}),
        (1, {"before": "due"}),
        (2, {"p_exceeded": np.nan}),
        (2, {"before": "due", "maintained": True, "p_nearer": np.nan}),
        (3, {"p_nearer": 0.95, "soon": True, "far": False}),
        (4, {"before": "planned", "p_nearer": 0.6, "far": False}),
        (5, {"p_exceeded": 0.3}),
        (6, {}),
        (6, {"p_exceeded": 0.3, "p_nearer": 0.99}),
        (6, {"before": "planned", "p_nearer": 0.4, "far": False}),
        (6, {"before": "due", "maintained": True}),
    ],
)
def test_each_transition(row, facts):
    facts = USUAL._replace(**facts)
    assert next(k for k, (*_, holds) in enumerate(TRANSITIONS) if holds(facts)) == row
    assert next_state(facts) == TRANSITIONS[row][0]


def test_a_drive_is_ok_then_planned_then_due():
    found = stood()
    seen = states(found, "slow")
    assert (seen[:99] == "unknown").all()
    assert seen[150] == "ok"
    assert seen[400] == "planned"
    assert seen[-1] == "due"
    assert (np.diff(found.state.sel(limit="slow").values[99:]) >= 0).all()
    assert found.certain.sel(limit="slow") == 450.0
    assert np.isnan(found.certain.sel(limit="stiff"))
    assert (found.remaining.sel(limit="slow", operation=slice(450, None)) == 0.0).all()
    assert found.recommended_since.sel(limit="slow")[-1] == found.drive_since[-1]


def test_no_service_is_behind_the_quantile_printed_with_it():
    found, asked = stood(), a_life().asked.values
    at = np.searchsorted(OPERATIONS, asked)
    planned = found.state.values[at] == STATES.index("planned")
    last = asked[:, None] + found.remaining.values[at, :, 0]
    assert planned.any()
    assert (found.service_by.values[at] <= last)[planned].all()


def test_nothing_is_known_without_limits_or_records():
    unknown = a_life()
    for name in ("p_exceeded", "p_nearer", "remaining", "lives", "value"):
        unknown[name][:] = np.nan
    for life in (unknown, a_life().isel(limit=slice(0, 0), part=slice(0, 0))):
        found = states_of(life, PLANNING, NO_DATES)
        assert (found.state == 0).all()
        assert (found.drive_state == 0).all()
        assert (found.subject == -1).all()
        assert np.isinf(found.drive_service_by).all()


@pytest.mark.parametrize("maintained", [False, True])
def test_due_ends_with_maintenance_alone(maintained):
    life = a_life((1500.0, np.inf), told=60)
    life.p_exceeded[:, 0] = (life.asked > 300) & (life.asked < 350)
    if maintained:
        life["start"][:], life["maintenance"][:] = 351, True
    found = states(states_of(life, PLANNING, NO_DATES), "slow")
    assert found[320] == found[349] == "due"
    assert found[-1] == ("ok" if maintained else "due")
