"""The picture of the first page: rows, intervals, arrows, and what is not known."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures.marks import COLOURS
from breaker.figures.verdict import verdict
from breaker.wear import STATES
from tests.figures.drawn import assert_nothing_overlaps, words, written
from tests.lives import LIMITS, life_data, standing_data


def drawn(axis):
    """Ends of the interval of each row, and the marks of medians and arrows."""
    ends = {
        part.get_segments()[0][0, 1]: part.get_segments()[0][:, 0].tolist()
        for part in axis.collections
    }
    marks = {(line.get_marker(), line.get_ydata()[0]): line.get_xdata()[0] for line in axis.lines}
    return ends, {at: x for at, x in marks.items() if at[0] in "o<>"}


def test_each_row_has_its_way_its_state_and_the_operations_left():
    life = life_data()
    figure = verdict(life, standing_data(life))
    assert_nothing_overlaps(figure)
    assert figure.get_suptitle() == ""  # the page says it
    left, right = figure.axes
    ends, marks = drawn(left)
    assert {row: np.round(each).tolist() for row, each in ends.items()} == {
        0: [110, 130],
        1: [27, 60],
        2: [10, 30],
    }
    assert {key: round(x) for key, x in marks.items()} == {
        ("o", 0): 120,
        ("o", 1): 40,
        ("o", 2): 20,
    }
    states = [STATES[limit[1]] for limit in LIMITS.values()]
    said = written(left)
    assert [each for each in said if each in STATES] == states
    assert [each for each in said if "beyond" in each] == [
        "> 99 % beyond",
        "10 % beyond",
        "< 1 % beyond",
        "30 % beyond",
    ]
    assert said.count("not known well enough") == 1
    colours = {text.get_text(): text.get_color() for text in left.texts}
    assert {name: colours[name] for name in states} == {name: COLOURS[name] for name in states}
    assert drawn(right) == (
        {1: [90, 1000], 2: [1000, 1000]},
        {("o", 1): 210, (">", 1): 1000, (">", 2): 1000},
    )
    assert written(right) == [
        "exceeded: certain at 151, crossed about 141",
        "210  (90 to beyond)\nservice by operation 240",
        "beyond the horizon",
        "cannot be told",
    ]
    assert all(meaning in words(figure) for meaning in ("now: ", "plan: ", "unknown: "))


@pytest.mark.parametrize(
    ("value", "new", "said"),
    [
        ([0.2, 0.4, 1.3], 0.0, "not known well enough"),  # wider than the way
        ([1.2, 2.0, 3.5], 0.0, None),  # so is this, and past the limit
        ([np.nan] * 3, 0.0, "not known well enough"),
        ([2.0, 2.1, 2.2], 1.5, "beyond the limit when new"),
    ],
)
def test_a_bar_is_drawn_where_the_way_is_known(value, new, said):
    life = life_data()
    life.value[:, 0], life.new[0] = value, new
    left = verdict(life, standing_data(life)).axes[0]
    assert (0 in drawn(left)[0]) == (said is None)
    assert (said in written(left)) or said is None


def test_of_several_parts_the_one_farthest_from_its_bound_counts():
    life = life_data()
    second = life.isel(part=[0]).assign(value=life.value.isel(part=[0]) * 0.5)
    standing = standing_data(life)
    life = xr.concat([life, second], "part", data_vars="minimal", coords="minimal")
    assert round(drawn(verdict(life, standing).axes[0])[1]["o", 0]) == 60


def test_names_of_limits_are_no_mathematics():
    life = life_data().assign_coords(limit=["5 $ or {6 $", "b", "c", "d"])
    life["part_limit"] = ("part", life.limit.values)
    figure = verdict(life, standing_data(life))
    figure.canvas.draw()  # mathematics would raise
    assert figure.axes[0].get_yticklabels()[0].get_text().startswith(r"5 \$ or {6 \$")
