"""Figures over the operations: health, remaining life, changes, evolution."""

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults
from breaker.figures import style
from breaker.figures.endurance import evolution
from breaker.figures.life import (
    changepoint,
    changes,
    coverage,
    health,
    remaining_life,
    service_cost,
)
from breaker.model.parameters import NAMES
from breaker.paper.run_numbers import blocks_of, held
from breaker.prognosis.states import states_of as stands
from tests.figures.drawn import assert_drawn, line_of, words
from tests.lives import LIMITS, a_life, life_data, standing_data


@pytest.fixture
def life():
    return life_data()


@pytest.fixture
def standing(life):
    return standing_data(life)


def test_health_shows_probability_state_and_since_when(life, standing):
    figure = health(life, standing)
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        shown = line_of(axis, style.MODEL).get_ydata()
        assert np.isin(shown, standing.p_exceeded.isel(limit=k)).all()
    standing["state"][:], standing["p_exceeded"][:] = 1, np.nan
    standing["certain"][:], standing["crossed"][:] = np.nan, np.nan
    assert_drawn(health(life, standing))


def test_operations_left_services_and_truths_are_drawn(life, standing):
    true = {"failure": ("limit", [180.0, 300, np.nan, 1])}
    true |= {"held": ("limit", [0.9, 0.72, np.nan, np.nan])}
    truth = xr.Dataset(true, {"limit": list(LIMITS)})
    assert_drawn(remaining_life(life, standing, truth))
    assert "72 % to 90 %" in words(remaining_life(life, standing, truth))
    assert "truth" not in words(remaining_life(life, standing))
    standing["state"][:] = 0
    assert_drawn(remaining_life(life, standing))


def test_operations_hold_the_truth_between_what_is_told_and_the_failure(life):
    """Of the first limit the band is 0.8 to 1.2 times what is left to 180; the others go on."""
    assert coverage(life, [180.0, 180.0, np.nan, 5.0]) == pytest.approx(
        [1.0, 0.0, np.nan, np.nan], nan_ok=True
    )
    asked = life.asked.values
    asked = asked[(asked >= life.attrs["reported_from"]) & (asked < 150)]
    inside = (0.8 * (180 - asked) <= 150 - asked) & (150 - asked <= 1.2 * (180 - asked))
    assert 0.0 < inside.mean() < 1.0
    assert coverage(life, [150.0] * 4)[0] == pytest.approx(inside.mean())


def test_the_cost_of_a_service_its_least_and_what_is_told_are_drawn():
    planning = defaults()["planning"]

    def drawn(*fails, surely=True):
        life = a_life(fails, half=(0.01, 0.01))
        life.remaining[-1, :, 0] *= surely
        return service_cost(stands(life, planning))

    assert_drawn(drawn(700.0, np.inf))
    assert_drawn(drawn(450.0, 900.0))
    # What may be exceeded already is due, however far away the cheapest operation is.
    assert_drawn(drawn(700.0, np.inf, surely=False))


def test_changes_evidence_and_weights_are_drawn_and_told():
    life = life_data(changes=("rate", "step", "event", "rate"))
    life["evidence"][150] = 5000.0
    assert_drawn(changepoint(life))
    assert_drawn(changepoint(life_data(400, ("step",) * 12)))
    assert_drawn(changepoint(life_data(60, ())))


def test_changes_since_new_are_drawn(life):
    truth = life.changed.sel(quantile=0.5).rename(asked="operation") * 1.5
    assert_drawn(changes(life, truth))
    assert "truth" not in words(changes(life))


def inferred(count, shift, width):
    """Draws of operations that drift by their width, the third block without any."""
    rng = generator(1, "test evolution", str(shift))
    theta = np.array([2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0])
    logs = shift + width * rng.standard_normal((count, 50, 7))
    logs += width * np.linspace(0.0, 1.0, count)[:, None, None]
    logs[2 * count // 40 : 3 * count // 40] = np.nan
    coords = {"operation": np.arange(1, count + 1), "output": list(NAMES)}
    return xr.Dataset({"draws": (("operation", "draw", "output"), theta * np.exp(logs))}, coords)


def test_evolution_shows_values_of_both_and_cuts_nothing_off():
    blocks = {
        "paper": blocks_of(inferred(200, 0.3, 0.05)),
        "family": blocks_of(inferred(200, 0.0, 0.1)),
    }
    theta = np.array([2.0, 0.045, 0.04, 0.3, 0.12, 0.75, 10.0]) * np.ones((200, 1))
    coords = {"operation": np.arange(1, 201), "parameter": list(NAMES)}
    truth = xr.DataArray(theta, coords, ("operation", "parameter"))
    shares = {by: held(one, truth) for by, one in blocks.items()}
    figure = evolution(blocks, truth, shares, motion="closing")
    assert_drawn(figure)
    for k, axis in enumerate(figure.axes):
        low, high = axis.get_ylim()
        drawn = [one["value"][:, k] for one in blocks.values()] + [truth[:, k]]
        assert low < min(np.nanmin(each) for each in drawn)
        assert high > max(np.nanmax(each) for each in drawn)
    assert "truth" not in words(evolution(blocks, motion="opening"))
