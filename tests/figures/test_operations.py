"""Figures over the operations: health, remaining life, changes, evolution."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures import style
from breaker.figures.changepoint import changepoint
from breaker.figures.evolution import evolution
from breaker.figures.health import health
from breaker.figures.marks import COLOURS
from breaker.figures.remaining_life import remaining_life
from tests.figures.drawn import assert_nothing_overlaps, bands, boxes, line_of, words, written
from tests.lives import LIMITS, life_data, standing_data


@pytest.fixture
def life():
    return life_data()


def test_health_shows_probability_state_and_since_when(life):
    standing = standing_data(life)
    figure = health(life, standing)
    assert_nothing_overlaps(figure)
    said = ["exceeded: certain at 151, crossed about 141"]
    said += ["plan: 10 % beyond it", "healthy: < 1 % beyond it", "unknown: 30 % beyond it"]
    for j, axis in enumerate(figure.axes):
        line = line_of(axis, style.MODEL)
        shown = standing.isel(limit=j).sel(operation=slice(126, None))  # half as many before 151
        np.testing.assert_array_equal(line.get_xdata(), shown.operation)
        np.testing.assert_array_equal(line.get_ydata(), shown.beyond)
        assert written(axis) == [said[j]]
    for axis, name in zip(figure.axes, ("now", "plan"), strict=False):
        assert boxes(axis, COLOURS["healthy"].upper()) == [(125.5, 150.5)]
        assert boxes(axis, COLOURS[name].upper()) == [(150.5, 200.5)]
    since = [line.get_xdata()[0] for line in figure.axes[0].lines if len(line.get_xdata()) == 2]
    assert since == [141, 151]
    assert figure.get_suptitle().endswith(
        "limits exceeded: 1 of 4; shown from operation 126, nothing happened before"
    )


def test_health_shows_all_operations_where_nothing_happens(life):
    standing = standing_data(life)
    standing["state"][:], standing["beyond"][:] = 1, np.nan
    standing["certain"][:], standing["crossed"][:] = np.nan, np.nan
    figure = health(life, standing)
    assert figure.get_suptitle().endswith("no limit is exceeded")
    assert boxes(figure.axes[3], COLOURS["healthy"].upper()) == [(0.5, 200.5)]
    assert "certain" not in words(figure)


def test_operations_left_services_and_truths_are_drawn(life):
    true = {"failure": ("limit", [180.0, 300, np.nan, 1]), "changed": ((), 80.0)}
    true |= {"failure_without": ("limit", [220.0, np.nan, np.nan, np.nan])}
    truth = xr.Dataset(true, {"limit": list(LIMITS)})
    figure = remaining_life(life, standing_data(life), truth)
    assert_nothing_overlaps(figure)
    assert len(figure.axes) == 3
    assert figure.legends[0].get_title().get_text() == "Too little is known to draw: wide."
    told = life.remaining.sel(asked=slice(20, None))
    for j, axis in enumerate(figure.axes):
        median = line_of(axis, style.CORRECTED)
        np.testing.assert_array_equal(median.get_xdata(), told.asked)
        np.testing.assert_array_equal(median.get_ydata(), told[:, j, 1])
    assert bands(figure.axes[0])[0].tolist() == [0.0, told[:, 0].max()]
    assert bands(figure.axes[1])[0][1] > figure.axes[1].get_ylim()[1]  # goes on past the panel
    dashed, dotted = (
        next(line for line in figure.axes[0].lines if line.get_linestyle() == look)
        for look in ("--", ":")
    )
    np.testing.assert_array_equal(dashed.get_ydata(), 180 - np.arange(1, 181))
    np.testing.assert_array_equal(dotted.get_ydata(), 220 - np.arange(1, 80))
    service = line_of(figure.axes[1], "#8A4B00").get_ydata()
    np.testing.assert_array_equal(service, [*[np.nan] * 150, *range(89, 39, -1)])
    assert np.isnan(line_of(figure.axes[0], "#8A4B00").get_ydata()).all()  # exceeded: too late
    assert "not reached" in figure.axes[2].get_title("left")


def test_real_measurements_have_no_truth_and_nothing_known_is_a_sentence(life):
    standing = standing_data(life)
    assert "truth" not in words(remaining_life(life, standing))
    standing["state"][:] = 0
    figure = remaining_life(life, standing)
    assert figure.axes == []
    assert figure.texts[-1].get_text() == "Too little is known to draw: slow, dry, tired, wide."


def test_changes_evidence_and_weights_are_drawn_and_told():
    life = life_data(changes=("rate", "step", "event", "rate"))
    life["certainty"][3], life["evidence"][150] = -1.0, 5000.0
    life["change_names"][1] = ""
    figure = changepoint(life)
    assert_nothing_overlaps(figure)
    top, evidence, weight, told = figure.axes
    moved = [line.get_color() for line in top.lines[:2]]
    assert moved == [style.COLOURS["gamma_a"], style.COLOURS["f"]]
    np.testing.assert_array_equal(top.lines[0].get_ydata(), life.changed[:, 3, 1])
    np.testing.assert_array_equal(evidence.lines[0].get_ydata(), life.evidence)
    assert evidence.get_yscale() == "symlog"
    assert evidence.get_ylim()[1] > 5000
    assert line_of(evidence, style.WARNING).get_xdata().tolist() == [84, 117, 184]
    np.testing.assert_array_equal(weight.lines[0].get_ydata(), life.weight)
    for axis in (top, evidence, weight):
        starts = [(line.get_xdata()[0], line.get_linestyle()) for line in axis.lines[-4:]]
        assert starts == [(80, "-"), (113, "-"), (146, "--"), (180, ":")]
        assert boxes(axis, "#7A35D0") == [(77, 82), (110, 115)]
    said = [line.strip() for line in written(told)]
    assert said[:5] == [
        "1  operation 80",
        r"the wear changed its rate: $\gamma_a$ or $f$",
        "90 %: 77 to 82",
        "noticed at 84",
        "2  operation 113",
    ]
    assert said[5] == "a sudden fault"
    assert "taken back by later records" in said
    assert "change taken back" in words(figure)


def test_many_changes_and_none():
    figure = changepoint(life_data(400, ("step",) * 12))
    assert written(figure.axes[3])[-1] == "and 4 more"
    assert_nothing_overlaps(figure)
    figure = changepoint(life_data(60, ()))
    assert written(figure.axes[3]) == ["No change is found."]
    assert "noticed" not in [text.get_text() for text in figure.legends[0].get_texts()]


def test_evolution_shows_changes_since_new(life):
    truth = life.changed.sel(quantile=0.5).rename(asked="operation") * 1.5
    singles = {"opening": truth * 40.0}
    figure = evolution(life, truth, singles)
    assert_nothing_overlaps(figure)
    for axis, name in zip(figure.axes, life.parameter.values, strict=True):
        one = life.changed.sel(parameter=name)
        np.testing.assert_array_equal(line_of(axis, style.COLOURS[name]).get_ydata(), one[:, 1])
        np.testing.assert_array_equal(bands(axis)[0], [one.min(), one.max()])
        np.testing.assert_array_equal(
            line_of(axis, style.MEASURED).get_ydata(), truth.sel(parameter=name)
        )
        low, high = axis.get_ylim()
        reached = [one.min(), one.max(), *truth.sel(parameter=name).values]
        assert low < min(reached)
        assert max(reached) < high < max(reached) + 5.0  # dots are cut off
        unchanged = "< 1 %" if name in ("gamma_a", "f") else "40 %"
        assert axis.get_title("right") == f"no change: {unchanged} probable"
        assert boxes(axis, "#7A35D0") == [(77, 82)]
    assert "single operation by the model, opening" in words(figure)
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
