"""The picture of the first page: rows, intervals, arrows, and what is not known."""

import numpy as np
import pytest
import xarray as xr

from breaker.figures.verdict import verdict as drawn
from tests.figures.drawn import assert_drawn, written
from tests.lives import life_data, standing_data

SAID = ("Service now: slow_one is due.", "Since new: drive friction +6 %.", "Trust: all of it.")


def verdict(life, standing):
    return drawn(life, standing, SAID)


def test_each_row_has_its_way_its_state_and_the_operations_left():
    life = life_data()
    assert_drawn(verdict(life, standing_data(life)))


@pytest.mark.parametrize(
    ("value", "new", "said"),
    [
        ([0.2, 0.4, 1.3], 0.0, "not known well enough"),  # wider than the way
        ([1.2, 2.0, 3.5], 0.0, None),  # so is this, and past the limit
        ([0.7, 1.3, 1.9], 0.0, None),  # probably
        ([np.nan] * 3, 0.0, "not known well enough"),
        ([2.0, 2.1, 2.2], 1.5, "beyond the limit when new"),
    ],
)
def test_a_bar_is_drawn_where_the_way_is_known(value, new, said):
    life = life_data()
    life.value[:, 0], life.new[0] = value, new
    left = verdict(life, standing_data(life)).axes[0]
    rows = [part.get_segments()[0][0, 1] for part in left.collections]
    assert (0 in rows) == (said is None)
    assert (said in written(left)) or said is None


def test_of_several_parts_the_one_farthest_from_its_bound_counts():
    life = life_data()
    second = life.isel(part=[0]).assign(value=life.value.isel(part=[0]) * 0.5)
    standing = standing_data(life)
    life = xr.concat([life, second], "part", data_vars="minimal", coords="minimal")
    assert_drawn(verdict(life, standing))
