"""Figures of the training and of predictive checks: curves, bands, residuals, shares."""

import numpy as np
import pytest
import xarray as xr

from breaker.common.randomness import generator
from breaker.figures import predictive, training
from breaker.paper.validation import prior_check
from tests.figures.drawn import assert_drawn

TIME = np.linspace(-2.0, 58.0, 31)
NOISE_SD = 0.1


def curves(count, dim):
    rng = generator(5, "test", "curves")
    rise = 14.0 / (1.0 + np.exp(-(TIME - 8.0) / 2.0))
    travel = rise * rng.uniform(0.9, 1.1, (count, 1))
    noisy = travel + NOISE_SD * rng.standard_normal(travel.shape)
    both = {"median": travel, "lower": travel - 0.2, "upper": travel + 0.3, "travel": noisy}
    return xr.Dataset({name: ((dim, "time"), v) for name, v in both.items()}, {"time": TIME})


def test_prior_predictive_states_what_is_outside():
    prior, measured = curves(50, "curve"), curves(3, "operation")
    measured = measured.assign_coords(operation=[1, 50, 100])
    measured["travel"][2] += 5.0
    check = prior_check(prior.travel.values, measured.travel.values)
    figure = predictive.prior_predictive(prior, check, measured, motion="opening")
    assert_drawn(figure)


def stages(count):
    data = curves(count, "stage").assign_attrs(noise_sd=NOISE_SD)
    data = data.assign_coords(operation=("stage", np.arange(count) * 100 + 1))
    return data.assign(
        share_inside=("stage", np.linspace(0.9, 1.0, count)),
        main_motion_end=("stage", 10.0 + np.arange(count)),
        p_value=("stage", np.geomspace(0.4, 1e-5, count)),
        misfit=("stage", np.arange(count) == 3),
    )


@pytest.mark.parametrize("count", [3, 4])
def test_residuals_are_in_units_of_the_noise(count):
    data = stages(count)
    figure = predictive.endurance_predictive(data, motion="closing")
    assert_drawn(figure)
    only_stages = ["operation", "main_motion_end", "p_value", "misfit"]
    data = data.rename(stage="curve", travel="measured").drop_vars(only_stages)
    figure = predictive.posterior_predictive(data, motion="closing")
    assert_drawn(figure)


@pytest.mark.parametrize("solves", [True, False])
def test_loss_has_a_panel_for_each_scale(solves):
    steps, at = np.arange(1, 401), np.arange(100, 401, 100)
    history = xr.Dataset(
        {
            "training_loss": ("step", 0.3 + np.exp(-steps / 50)),
            "learning_rate": ("step", 1e-3 * np.cos(steps / 400)),
            "validation_loss": ("evaluation", 0.31 + np.exp(-at / 50)),
            "evaluation_step": ("evaluation", at),
        },
        {"step": steps},
        {"best_step": 200, "held_out_log_density": 3.42, "held_out_log_density_se": 0.05},
    )
    differences = {"mean": [0.1, 0.03, 0.01], "max": [1.0, 0.4, 0.1], "density": [0.3, 0.1, 0.02]}
    solver = xr.Dataset(
        {f"{name}_difference": ("solver_steps", each) for name, each in differences.items()},
        {"solver_steps": [2, 4, 8]},
        {"chosen_steps": 4, "chosen_density_steps": 8, "reference_steps": 64, "solves": 1},
    )
    solver = solver if solves else xr.Dataset(attrs={"solves": 0})
    figure = training.loss(history, solver, motion="closing")
    assert_drawn(figure)
    (shown,) = (e for axis in figure.axes for e in axis.lines if e.get_label().startswith("valid"))
    np.testing.assert_array_equal(shown.get_data(), [at, history.validation_loss])
