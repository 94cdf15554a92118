"""States of limits: each transition, and by when to service."""

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.prognosis.states import STATES, next_state, states_of
from tests.lives import OPERATIONS, a_life

PLANNING = defaults()["planning"] | {"operations": 150, "years": 2.0}
USUAL = {"before": "ok", "p_exceeded": 0.0, "p_nearer": 0.5, "ahead": 2.0}


def stood(fails=(450.0, np.inf), **about):
    return states_of(a_life(fails, **about), PLANNING)


def states(found, limit):
    return np.array(STATES)[found.state.sel(limit=limit).values]


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
    found = stood()
    seen = states(found, "slow")
    assert (seen[:99] == "unknown").all()
    assert [seen[150], seen[400], seen[-1]] == ["ok", "planned", "due"]
    assert (np.diff(found.state.sel(limit="slow").values[99:]) >= 0).all()
    assert found.certain.sel(limit="slow") == 450.0
    assert np.isnan(found.certain.sel(limit="stiff"))
    assert (found.remaining.sel(limit="slow", operation=slice(450, None)) == 0.0).all()
    assert found.recommended_since.sel(limit="slow")[-1] == found.drive_since[-1] > 300.0


def test_no_service_is_behind_the_quantile_printed_with_it():
    found, asked = stood(), a_life().asked.values
    at = np.searchsorted(OPERATIONS, asked)
    planned = found.state.values[at] == STATES.index("planned")
    last = asked[:, None] + found.remaining.values[at, :, 0]
    assert planned.any()
    assert (found.service_by.values[at] <= last)[planned].all()


def test_nothing_is_known_without_records():
    unknown = a_life()
    for name in ("p_exceeded", "p_nearer", "remaining", "lives", "value"):
        unknown[name][:] = np.nan
    found = states_of(unknown, PLANNING)
    assert (found.drive_state == 0).all()
    assert (found.subject == -1).all()
    assert np.isinf(found.service_by).all()


@pytest.mark.parametrize("maintained", [False, True])
def test_due_ends_with_maintenance_alone(maintained):
    life = a_life((1500.0, np.inf), told=60)
    life.p_exceeded[:, 0] = (life.asked > 300) & (life.asked < 350)
    if maintained:
        life["start"][:], life["maintenance"][:] = 351, True
    found = states(states_of(life, PLANNING), "slow")
    assert found[320] == found[349] == "due"
    assert found[-1] == ("ok" if maintained else "due")
