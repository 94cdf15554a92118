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
    result, asked = stood(), a_life().asked.values
    seen = states(result, "slow")
    assert (seen[:99] == "unknown").all()
    assert [seen[150], seen[400], seen[-1]] == ["ok", "planned", "due"]
    assert (np.diff(result.state.sel(limit="slow").values[99:]) >= 0).all()
    assert result.certain.sel(limit="slow") == 450.0
    assert np.isnan(result.certain.sel(limit="stiff"))
    assert (result.remaining.sel(limit="slow", operation=slice(450, None)) == 0.0).all()
    assert result.recommended_since.sel(limit="slow")[-1] == result.drive_since[-1] > 300.0
    at = np.searchsorted(OPERATIONS, asked)  # no service is behind the quantile printed with it
    planned = result.state.values[at] == STATES.index("planned")
    last = asked[:, None] + result.remaining.values[at, :, 0]
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
    # What a service now costs more than one in the end, without a failure, tells the age.
    age, horizon = OPERATIONS[-1] - (351 if maintained else 1), life.attrs["horizon"]
    assert result.extra.sel(limit="stiff")[0] == pytest.approx(horizon / (age + horizon))
