"""Chunks of operations: by number, the same whatever else is there."""

import pytest

from breaker.workflow.jobs import chunks_of


@pytest.mark.parametrize("size", [1, 7, 20])
def test_appended_operations_change_their_own_chunks_alone(size):
    before = chunks_of([*range(1, 31), 40], size)
    after = chunks_of([*range(1, 31), 40, 41, 42], size)
    last = list(before)[-1]
    assert {name: after[name] for name in before if name != last} == {
        name: before[name] for name in before if name != last
    }
    assert [number for each in after.values() for number in each] == [*range(1, 31), 40, 41, 42]


def test_gaps_give_no_empty_chunks_and_order_does_not_matter():
    """Nor do other numbers, so that an operation is in the same chunk in both motions."""
    assert chunks_of([70, 1, 0, 20, 21, 1], 20) == {"000": [0, 1, 20], "001": [21], "003": [70]}
