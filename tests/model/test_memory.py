"""Memory besides the output: the same for any number of operations.

numpy reports its arrays to ``tracemalloc``. What compiled code allocates for itself it does not
report: buffers of some 10 kB a thread, whatever the number of operations.
"""

import tracemalloc

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.model import curves
from breaker.model.curves import travel
from breaker.paper.bank import simulate
from breaker.paper.joint_model import Model

FEW, MANY = 2**13, 2**16  # operations
SLACK = 2**16  # bytes of Python's own objects


def besides(make, size):
    """Most bytes in use besides the output while it was made."""
    tracemalloc.start()
    try:
        output = make()
        return tracemalloc.get_traced_memory()[1] - size(output)
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("form", [np.float64, np.float32])
def test_curves(prior, form):
    """What has to be converted is converted block by block as well."""
    theta = prior.sample(MANY, generator(1, "test", "memory")).astype(form)
    times, onset = np.linspace(-2, 58, 31), np.zeros(MANY, np.float32)

    def needed(n):
        def make():
            return travel(theta[:n], times, "closing", onset=onset[:n])

        return besides(make, lambda result: sum(each.nbytes for each in result))

    needed(8)  # compiled from here on
    few, many = needed(FEW), needed(MANY)
    assert many < few + SLACK
    assert few < curves._ROWS * 200


def test_bank(prior, sensor):
    """Parameters and onsets are drawn at once, so that a bank's bytes do not depend on blocks; that
    takes less than the curves, which come after it."""

    def needed(n):
        rng = generator(1, "test", "memory", "bank")
        return besides(
            lambda: simulate(Model(prior, sensor, "closing"), n, rng),
            lambda bank: sum(array.nbytes for array in bank.variables.values()),
        )

    needed(8)
    few, many = needed(FEW), needed(MANY)
    assert many < few + SLACK
    assert few > curves._ROWS * sensor.samples * 8  # a block of float64
