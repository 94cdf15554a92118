"""Figures over the operations: health, remaining life, changes, evolution."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures.changepoint import changepoint
from breaker.figures.evolution import evolution
from breaker.figures.health import health
from breaker.figures.remaining_life import remaining_life
from tests.figures.drawn import assert_drawn, words, written
from tests.lives import LIMITS, life_data, standing_data


@pytest.fixture
def life():
    return life_data()


@pytest.fixture
def standing(life):
    return standing_data(life)


def test_health_shows_probability_state_and_since_when(life, standing):
    assert_drawn(health(life, standing), "health")
    standing["state"][:], standing["beyond"][:] = 1, np.nan
    standing["certain"][:], standing["crossed"][:] = np.nan, np.nan
    assert_drawn(health(life, standing), "health, nothing happens")


def test_operations_left_services_and_truths_are_drawn(life, standing):
    true = {"failure": ("limit", [180.0, 300, np.nan, 1]), "changed": ((), 80.0)}
    true |= {"failure_without": ("limit", [220.0, np.nan, np.nan, np.nan])}
    truth = xr.Dataset(true, {"limit": list(LIMITS)})
    assert_drawn(remaining_life(life, standing, truth), "remaining life")
    assert "truth" not in words(remaining_life(life, standing))
    standing["state"][:] = 0
    assert_drawn(remaining_life(life, standing), "remaining life, unknown")


def test_changes_evidence_and_weights_are_drawn_and_told():
    life = life_data(changes=("rate", "step", "event", "rate"))
    life["certainty"][3], life["evidence"][150] = -1.0, 5000.0
    life["change_names"][1] = ""
    assert_drawn(changepoint(life), "changes")
    assert_drawn(changepoint(life_data(400, ("step",) * 12)), "changes, many")
    assert_drawn(changepoint(life_data(60, ())), "changes, none")


def test_evolution_shows_changes_since_new(life):
    truth = life.changed.sel(quantile=0.5).rename(asked="operation") * 1.5
    assert_drawn(evolution(life, truth, {"opening": truth * 40.0}), "evolution")
    assert "stand-in" not in words(evolution(life))


@pytest.mark.parametrize(
    ("family", "agreement", "why"),
    [
        ("", 1.0, "The drive fits no known family"),
        ("", 0.001, "Closing and opening contradict each other"),
        ("medium", 0.5, "The change is larger than any wear"),
    ],
)
def test_parameters_that_are_not_told_are_a_sentence(life, family, agreement, why):
    life["changed"][:] = np.nan
    life.attrs |= {"family": family, "agreement": agreement}
    figure = evolution(life)
    assert figure.axes == []
    assert figure.texts[-1].get_text().startswith(why)
    assert written(changepoint(life).axes[0])[0].startswith(why)
