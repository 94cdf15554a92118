"""Quantities, trust and limits of records."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.stats import kstest

from breaker.answers.judgement import (
    PHASES,
    VERDICTS,
    _errors,
    with_limits,
    with_quantities,
    with_trust,
)
from breaker.mechanism.limits import Limit
from breaker.mechanism.quantities import SOURCES, evaluate, quantities_of
from breaker.model.randomness import generator
from tests.answers.conftest import simulated


def test_quantities_are_those_of_the_draws(answers):
    one = answers["closing"].isel(operation=0)
    draws = one.draws.values.astype(np.float64)[:, :7]
    (values,) = evaluate(["touch_time"], draws, "closing").T
    touch = one.sel(quantity="touch_time")
    assert touch.quantity_median == pytest.approx(np.median(values))
    assert touch.quantity_interval.values == pytest.approx(np.quantile(values, [0.025, 0.975]))
    assert touch.quantity_undefined == 0.0
    assert answers["closing"].quantity_median[2].isnull().all()  # no record


def ranks(model, *, known=None):
    """Ranks of what the model leaves out at one sample in its draws, of simulated records."""
    rng = generator(3, "test ranks", model.motion)
    values, records, left_out = simulated(model, 150, rng)
    known = known or model
    found = []
    for value, record, truth in zip(values, records, left_out, strict=True):
        record[100:130] = np.nan
        same = np.repeat(value[None], 200, axis=0)
        curves = np.repeat(known.curves(value[None]), 200, axis=0)
        draws, _ = _errors(known, record, same, curves, rng)
        found.append((draws[:, 60] < truth[60]).mean())
    return np.array(found)


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_what_the_model_leaves_out_is_drawn_from_its_posterior(models, motion):
    """Ranks of the truth are uniform: false alarm 1e-3, by the Kolmogorov-Smirnov test."""
    assert kstest(ranks(models[motion]), "uniform").pvalue > 1e-3
    model = models[motion]
    sure = replace(model, sensor=replace(model.sensor, zero_sd=0.01))  # a planted fault
    assert kstest(ranks(model, known=sure), "uniform").pvalue < 1e-3


def test_the_residual_is_what_is_left_out_and_noise(answers):
    answer = answers["opening"].isel(operation=0)
    noise = (answer.residual - answer.left_out).values
    assert np.std(noise) == pytest.approx(0.1, rel=0.25)
    assert answer["part"].values.tolist() == list(PHASES)
    assert (answer.explained > 0.5).all()
    low, middle, high, _ = answer.model_error.values.T
    assert (low < middle).all()
    assert (middle < high).all()


def test_where_the_model_is_right_nothing_is_left_out(answers, models):
    right = models["closing"].leaving_out(None)
    answer = with_trust(answers["closing"][["draws", "travel"]], right, seed=1)
    assert (answer.model_error[:2] == 0.0).all()
    assert (answer.explained[:2] == 0.0).all()
    assert answer.model_error[2].isnull().all()


def test_verdicts_follow_from_probabilities():
    draws = np.ones((4, 100, 7))
    for i, above in enumerate((1, 50, 100)):  # of a hundred draws
        draws[i, :above, 6] = 11.0
    draws[3] = np.nan
    answer = xr.Dataset(
        {"draws": (("operation", "draw", "output"), draws)}
        | {name: ("operation", [True] * 4) for name in ("accepted", "resolved")},
        {"operation": [1, 2, 3, 4]},
        {"motion": "closing"},
    )
    wide = Limit("wide", "closing", (("L", 10.0, True),))
    other = Limit("other", "opening", (("L", 0.0, True),))
    found = with_limits(answer, [wide, other], {"raise": 0.95})
    assert found.limit.values.tolist() == ["wide"]
    assert found.limit_verdict.values[:, 0].tolist() == [*VERDICTS[1:], "unknown"]
    unresolved = answer.assign(resolved=("operation", [False] * 4))
    assert (with_limits(unresolved, [wide], {"raise": 0.95}).limit_verdict == "unknown").all()


def test_what_records_alone_show_stands_beside():
    """Where one does: not inferred, but measured, and a limit on it is judged."""
    draws = np.tile([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], (2, 4, 1))
    names = list(quantities_of("closing", of=SOURCES))
    seen = np.full((2, len(names)), np.nan)
    answer = xr.Dataset(
        {"draws": (("operation", "draw", "output"), draws)}
        | dict.fromkeys(("accepted", "resolved"), ("operation", [True, True])),
        {"operation": [1, 2], "quantity": names},
        {"motion": "closing"},
    )
    by = ("operation", "quantity")
    none = with_quantities(answer.assign(measured=(by, seen), measured_sd=(by, seen)))
    assert none["quantity"].values.tolist() == list(quantities_of("closing"))
    seen[0, names.index("latch_time")] = 8.0
    shown = with_quantities(answer.assign(measured=(by, seen), measured_sd=(by, 0.0 * seen + 0.2)))
    assert shown["quantity"].values.tolist() == names
    latch = shown.sel(quantity="latch_time")
    assert latch.measured.values[0] == 8.0
    for name in ("quantity_median", "quantity_undefined"):
        assert np.isnan(latch[name]).all()
    late = Limit("late", "closing", (("latch_time", 7.0, True),), of="record")
    verdicts = with_limits(shown, [late], {"raise": 0.95}).limit_verdict.values[:, 0]
    assert verdicts.tolist() == ["not healthy", "unknown"]
