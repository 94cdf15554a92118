"""Chunks and sources joined: of trends made up for it."""

import numpy as np
import pytest

from breaker.decisions.series import join, remaining
from breaker.mechanism.limits import Limit
from breaker.mechanism.parameters import MOTIONS
from tests.decisions.made_up import LIMITS, NUMBERS, PARTS, trend_of


def test_chunks_are_joined():
    first = trend_of(MOTIONS, NUMBERS[:2], toward={"slow": 0.3})
    second = trend_of(MOTIONS, NUMBERS[2:], toward={"slow": 0.7}).assign_attrs(horizon=1)
    whole = join([first, second])
    assert whole.operation.values.tolist() == [1, 2, 3, 4]
    assert whole.toward.sel(limit="slow").values.tolist() == [0.3, 0.3, 0.7, 0.7]
    assert whole.part_bound.dims == ("part",)
    assert whole.attrs["horizon"] == 10000
    with pytest.raises(ValueError, match="limit"):
        join([first, second.isel(limit=[0, 1])])


def test_remaining_is_read_from_the_source_of_each_limit():
    closing = trend_of(["closing"], NUMBERS, remaining={"slow": [1, 2, 3], "tired": [4, 5, 6]})
    opening = trend_of(["opening"], NUMBERS[1:], remaining={"wide": [7, 8, 9]})
    left = remaining({"closing": closing, "opening": opening}, LIMITS, NUMBERS)
    assert left.limit.values.tolist() == ["slow", "tired", "wide"]
    assert left.source.values.tolist() == ["closing", "closing", "opening"]
    assert left.attrs["source"] == "separate"
    assert left.operation.values.tolist() == [1, 2, 3, 4]
    assert left.remaining.sel(operation=2, quantile=0.5).values.tolist() == [2, 5, 8]
    assert np.isnan(left.remaining.sel(operation=1, limit="wide")).all()
    assert np.isnan(left.beyond.sel(operation=1, limit="wide"))
    assert left.part_limit.values.tolist() == PARTS
    assert left.value.sel(operation=4, quantile=0.5).values.tolist() == [9.5, 9.5, 0.8, 10.0]
    both = trend_of(MOTIONS, NUMBERS, remaining={"wide": [1, 1, 1]})
    left = remaining({"both": both}, LIMITS, NUMBERS)
    assert set(left.source.values.tolist()) == {"both"}
    assert left.attrs["source"] == "both"
    assert left.remaining.sel(operation=4, limit="wide").values.tolist() == [1, 1, 1]


def test_a_limit_on_what_records_show_is_read_from_their_own_trend():
    """Of other operations, and without parameters; beside limits of the model."""
    late = Limit("late", "closing", (("travel_time", 9.6, True),), of="record")
    shown = ["remaining", "toward", "beyond", "value"]
    record = trend_of(["closing"], NUMBERS[1:], remaining={"slow": [1, 2, 3]})[shown]
    record = record.sel(limit=["slow"]).isel(part=[0]).assign_coords(limit=["late"])
    record["part_limit"][:], record["part_quantity"] = "late", ("part", ["travel_time"])
    left = remaining(
        {"both": trend_of(MOTIONS, NUMBERS), "record": record}, [*LIMITS, late], NUMBERS
    )
    assert left.of.values.tolist() == ["model"] * 3 + ["record"]
    assert left.source.values.tolist() == ["both"] * 3 + ["record"]
    assert left.attrs["source"] == "both"
    assert left.part_unit.values.tolist() == ["ms", "ms", "mm/ms²", "mm", "ms"]
    assert left.remaining.sel(limit="late", operation=2).values.tolist() == [1, 2, 3]
    assert np.isnan(left.beyond.sel(limit="late", operation=1))
