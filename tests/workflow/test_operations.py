"""Chunks of operations: by number, the same whatever else is there."""

import pytest
import xarray as xr

from breaker.stores import describe, save
from breaker.workflow.operations import chunks_of, recorded_source


def test_the_default_test_has_four_chunks_of_500():
    chunks = chunks_of(range(1, 2001), 500)
    assert list(chunks) == ["000", "001", "002", "003"]
    assert [(each[0], each[-1], len(each)) for each in chunks.values()] == [
        (1, 500, 500),
        (501, 1000, 500),
        (1001, 1500, 500),
        (1501, 2000, 500),
    ]


@pytest.mark.parametrize("size", [1, 7, 20])
def test_appended_operations_change_their_own_chunks_alone(size):
    before = chunks_of([*range(1, 31), 40], size)
    after = chunks_of([*range(1, 31), 40, 41, 42], size)
    last = list(before)[-1]
    assert {name: after[name] for name in before if name != last} == {
        name: before[name] for name in before if name != last
    }
    assert [number for each in after.values() for number in each] == [*range(1, 31), 40, 41, 42]


def test_a_number_is_in_the_same_chunk_in_both_motions():
    closing, opening = chunks_of([1, 2, 45, 46], 20), chunks_of([2, 3, 21, 46], 20)
    for number in (2, 46):
        name = next(name for name, each in closing.items() if number in each)
        assert number in opening[name]


def test_gaps_give_no_empty_chunks_and_order_does_not_matter():
    assert chunks_of([70, 1, 0, 20, 21, 1], 20) == {"000": [0, 1, 20], "001": [21], "003": [70]}


def test_there_may_be_more_than_a_thousand_chunks_in_their_order():
    names = list(chunks_of(range(1, 1203), 1))
    assert names[-1] == "1201"
    assert names == sorted(names, key=int)


def test_the_source_of_a_store_is_read_without_opening_it(tmp_path):
    store = tmp_path / "curves.zarr"
    assert recorded_source(store) is None
    save(describe(xr.Dataset(), "curves", source="stand-in"), store)
    assert recorded_source(store) == "stand-in"
    save(describe(xr.Dataset(), "curves"), store)
    assert recorded_source(store) is None
    (store / ".zattrs").write_text("[")
    assert recorded_source(store) is None
