"""Figures of the training and of predictive checks: curves, bands, residuals, shares."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures import loss, predictive, style
from breaker.model.randomness import generator
from breaker.validation import prior_check
from tests.figures.drawn import assert_nothing_overlaps, bands, line_of, words

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
    (axis,) = figure.axes
    drawn = [line for line in axis.lines if line.get_color() == style.MEASURED]
    np.testing.assert_array_equal([line.get_ydata() for line in drawn], measured.travel)
    assert len([line for line in axis.lines if line.get_color() == style.PRIOR]) == 50
    np.testing.assert_array_equal(line_of(axis, style.MODEL).get_ydata(), check.median)
    np.testing.assert_allclose(bands(axis)[0], (check.lower.min(), check.upper.max()))
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("time (ms)", "travel (mm)")
    share = f"{100 * check.inside.mean():.0f} % of all samples of the endurance test in the 95 %"
    assert share in figure.get_suptitle()
    assert "\n1 of 3 operations below the" in figure.get_suptitle()
    assert "endurance test, operation 50" in words(figure)
    assert_nothing_overlaps(figure)


def stages(count):
    data = curves(count, "stage").assign_attrs(noise_sd=NOISE_SD)
    data = data.assign_coords(operation=("stage", np.arange(count) * 100 + 1))
    return data.assign(
        share_inside=("stage", np.linspace(0.9, 1.0, count)),
        main_motion_end=("stage", 10.0 + np.arange(count)),
        p_value=("stage", np.geomspace(0.4, 1e-5, count)),
        misfit=("stage", np.arange(count) == 3),
    )


@pytest.mark.parametrize("kind", ["simulated", "endurance"])
def test_residuals_are_in_units_of_the_noise(kind):
    data, count = stages(4), 4
    if kind == "endurance":
        figure = predictive.endurance_predictive(data, motion="closing")
        flags = ["fits the model (p = 0.4)\n", *[""] * 2, "does NOT fit the model (p < 0.0001)\n"]
        titles = [f"operation {100 * i + 1}: {flags[i]}" for i in range(4)]
        assert figure.get_suptitle().endswith("\n1 of 4 flagged as not fitting the model")
        assert figure.axes[6].title.get_color() == style.WARNING
        ends = [line_of(axis, style.REFERENCE).get_xdata()[0] for axis in figure.axes[::2]]
        assert ends == [10, 11, 12, 13]
    else:
        only_stages = ["operation", "main_motion_end", "p_value", "misfit"]
        data = data.rename(stage="curve", travel="measured").drop_vars(only_stages)
        figure = predictive.posterior_predictive(data, motion="closing")
        titles = [f"simulated record {i}: " for i in range(1, 5)]
        data = data.rename(measured="travel")
        assert "measured" not in words(figure)
    assert len(figure.axes) == 2 * count
    for i, (above, below) in enumerate(zip(figure.axes[::2], figure.axes[1::2], strict=True)):
        travel, median = data.travel.values[i], data["median"].values[i]
        np.testing.assert_array_equal(line_of(above, style.MEASURED).get_ydata(), travel)
        np.testing.assert_array_equal(line_of(above, style.MODEL).get_ydata(), median)
        residual = line_of(below, style.MEASURED).get_ydata()
        np.testing.assert_allclose(residual, (travel - median) / NOISE_SD)
        np.testing.assert_allclose(bands(below)[0], (-2, 3))
        share = f"{100 * data.share_inside.values[i]:.0f} % "
        assert above.get_title().startswith(titles[i])
        assert share in above.get_title()
    assert_nothing_overlaps(figure)


def test_few_stages():
    assert len(predictive.endurance_predictive(stages(3), motion="opening").axes) == 6


def draw_loss(*, solves):
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
    figure = loss.loss(
        history, solver if solves else xr.Dataset(attrs={"solves": 0}), motion="closing"
    )
    return figure, history, solver


@pytest.mark.parametrize("solves", [True, False])
def test_loss_has_a_panel_for_each_scale(solves):
    figure, history, solver = draw_loss(solves=solves)
    panels = {axis.get_title(): axis for axis in figure.axes}
    validation, rate = panels["negative log density"], panels[""]
    training = panels["training loss"] if solves else validation
    assert training.get_ylabel() == ("loss, a scale of its own" if solves else "nats per curve")
    batches = line_of(training, style.PRIOR).get_ydata()
    np.testing.assert_array_equal(batches, history.training_loss)
    assert validation.get_ylabel() == "nats per curve"
    line = line_of(validation, style.MODEL)
    np.testing.assert_array_equal(line.get_xdata(), history.evaluation_step)
    np.testing.assert_array_equal(line.get_ydata(), history.validation_loss)
    star = line_of(validation, style.WARNING, "*").get_xydata()[0]
    np.testing.assert_allclose(star, (200, history.validation_loss[1]))
    held_out = line_of(validation, style.REFERENCE).get_ydata()[0]
    assert held_out == -3.42
    low, high = validation.get_ylim()
    assert low < held_out - 0.05
    assert high > history.validation_loss.max()
    np.testing.assert_array_equal(rate.lines[0].get_ydata(), history.learning_rate)
    assert "held-out log density 3.420 ± 0.050 nats" in figure.get_suptitle()
    assert_nothing_overlaps(figure)
    assert len(panels) == (5 if solves else 2)
    if solves:
        for title, unit, names, chosen in (
            ("draws", "posterior sd", ("max", "mean"), 4),
            ("log density", "nats", ("density",), 8),
        ):
            axis = panels[f"convergence of the {title}"]
            assert f"({unit})" in axis.get_ylabel()
            for line, name in zip(axis.lines, names, strict=False):
                np.testing.assert_array_equal(line.get_ydata(), solver[f"{name}_difference"])
            assert axis.lines[len(names)].get_xdata()[0] == chosen
