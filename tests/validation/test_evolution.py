"""Posteriors of operations in blocks of a life, with medians and shares known by hand."""

import numpy as np
import pytest
import xarray as xr

from breaker.model.parameters import NAMES
from breaker.paper.run_numbers import blocks_of, held, moved, truth_in_blocks


def operations(count, *, centre=None, without=()):
    """Draws from -1 to 1 about a centre of each operation; the onset is an output, too."""
    centre = np.zeros(count) if centre is None else centre
    draws = centre[:, None, None] + np.linspace(-1.0, 1.0, 201)[:, None] * np.ones(8)
    draws[list(without)] = np.nan
    names = ["onset", *NAMES]
    return xr.Dataset(
        {"draws": (("operation", "draw", "output"), draws)},
        {"operation": np.arange(1, count + 1), "output": names},
    )


def truth(count, value):
    values = np.full((count, 7), value)
    coords = {"operation": np.arange(1, count + 1), "parameter": list(NAMES)}
    return xr.DataArray(values, coords, ("operation", "parameter"))


def test_a_block_has_the_median_operation_and_not_all_draws_together():
    """One operation far off moves neither band nor median; pooled, it would widen the band."""
    centre = np.zeros(400)
    centre[3] = 100.0
    found = blocks_of(operations(400, centre=centre, without=[5, *range(390, 400)]))
    assert found["value"].shape == (40, 7, 3)
    np.testing.assert_allclose(found["value"][0], np.tile([-0.9, 0.0, 0.9], (7, 1)), atol=1e-12)
    assert found["first"].values[[0, -1]].tolist() == [1, 391]
    assert found["last"].values[[0, -1]].tolist() == [10, 400]
    assert found.operation.values[0] == 5.5
    assert found.answered.values[[0, 1, -1]].tolist() == [9, 10, 0]
    assert found["count"].values.tolist() == [10] * 40
    assert np.isnan(found["value"][-1]).all()


@pytest.mark.parametrize("count", [1, 7, 40])
def test_few_operations_are_blocks_of_one(count):
    found = blocks_of(operations(count))
    assert found.sizes["block"] == count
    np.testing.assert_array_equal(found["first"], found["last"])


def test_the_share_is_of_blocks_with_a_posterior():
    """Of 40 blocks one has none, and 10 are off; the truth is a mean over a block."""
    centre = np.where(np.arange(400) < 100, 2.0, 0.0)
    blocks = blocks_of(operations(400, centre=centre, without=range(390, 400)))
    wavy = truth(400, 0.5) + xr.DataArray(np.resize([-5.0, 5.0], 400), dims="operation")
    np.testing.assert_allclose(truth_in_blocks(blocks, wavy), 0.5)
    np.testing.assert_allclose(held(blocks, wavy), 29 / 39)
    np.testing.assert_allclose(held(blocks, truth(400, 0.95)), 0.0)
    none = blocks_of(operations(3, without=range(3)))
    assert np.isnan(held(none, truth(3, 0.0))).all()


def test_a_change_is_that_between_the_first_and_the_last_block_with_an_answer():
    values = np.array([[np.nan, 2.0], [4.0, 9.0], [5.0, 3.0], [np.nan, np.nan]])
    np.testing.assert_allclose(moved(values), [25.0, 50.0])
    assert np.isnan(moved(np.full((3, 1), np.nan))).all()
