"""Which test to do next: what is known now of a drive, and what each test would leave of it."""

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from breaker.drive.answers.next_test import Plan, Plans
from breaker.drive.answers.next_test_words import first_of_plan
from breaker.figures import style

_WIDTH, _ROW, _HEAD = 13.0, 0.34, 1.7  # inches
_LETTERS = 150  # of a line of a title
_NOW = {"color": style.PRIOR, "alpha": 0.35}


@style.styled
def next_tests(plans: Plans) -> Figure:
    """Draw the tests of each pole.

    A row of panels for each pole and a row of bars for each test, the best for its cost first: the
    sd of the posterior of each quantity that is asked for, now and expected after the test.
    """
    told = [each for each in plans.poles if each.tests]
    heights = [_ROW * len(each.tests) + _HEAD for each in told]
    figure = style.new_figure(_WIDTH, sum(heights, 0.8))
    parts = figure.subfigures(len(told), 1, height_ratios=heights, squeeze=False)[:, 0]
    for plan, part in zip(told, parts, strict=True):
        _pole(part.subplots(1, len(plan.asked) + 1, sharey=True, squeeze=False)[0], plan)
        about = ", ".join(filter(None, (plan.breaker, plan.phase)))
        said = f"{about}: {first_of_plan(plan)}" if about else first_of_plan(plan)
        part.suptitle(fill(style.spoken(said), _LETTERS), fontsize=10.5)
    keys = [
        style.band_key("sd now", _NOW["color"], _NOW["alpha"]),
        style.band_key("expected after the test", style.CORRECTED, 1.0),
    ]
    style.legend_below(figure, keys)
    return figure


def _pole(axes: np.ndarray, plan: Plan) -> None:
    """Bars of a pole: narrowing for the cost, and sds of what is asked for."""
    rows = np.arange(len(plan.tests))
    first, *others = axes
    first.barh(rows, [100.0 * each.per_cost for each in plan.tests], color=style.MODEL)
    first.set(xlabel="variance gone per\ncost, in brackets (%)", ylim=(len(rows) - 0.4, -0.6))
    first.set_yticks(rows, [f"{style.spoken(e.name)} ({e.cost:g})" for e in plan.tests])
    for axis, name in zip(others, plan.asked, strict=True):
        _sds(axis, plan, name)


def _sds(axis: Axes, plan: Plan, name: str) -> None:
    """Sds of a quantity, now and after each test."""
    told = {k: e.narrowing[name] for k, e in enumerate(plan.tests) if name in e.narrowing}
    for row, each in told.items():
        axis.barh(row, each.now, **_NOW)
        look = {"color": style.CORRECTED, "height": 0.5, "ecolor": style.REFERENCE}
        axis.barh(row, each.expected, xerr=each.error, **look)
    units = {"" if each.unit == "1" else f" ({each.unit})" for each in told.values()}
    output = style.OUTPUTS.get(name)
    label = output.symbol if output else style.spoken(name)
    axis.set_xlabel(f"{label}\nsd{''.join(units)}")
