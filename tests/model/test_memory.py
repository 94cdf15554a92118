"""Memory besides the output: the same for any number of operations.

numpy reports its arrays to ``tracemalloc``. What compiled code allocates for itself it does not
report: buffers of some 10 kB a thread, whatever the number of operations.
"""

import tracemalloc

import numpy as np

from breaker.common.randomness import generator
from breaker.model.curves import _ROWS, travel
from breaker.paper.bank import simulate
from breaker.paper.joint_model import Model

FEW, MANY = 2**13, 2**15  # operations
SLACK = 2**16  # bytes of Python's own objects


def besides(make, size):
    """Most bytes in use besides the output while it was made."""
    tracemalloc.start()
    try:
        output = make()
        return tracemalloc.get_traced_memory()[1] - sum(size(part) for part in output)
    finally:
        tracemalloc.stop()


def test_curves_and_banks_are_made_in_blocks(prior, sensor):
    """What has to be converted is converted block by block as well."""
    theta = prior.sample(MANY, generator(1, "test", "memory")).astype(np.float32)
    model, times = Model(prior, sensor, "closing"), np.linspace(-2, 58, 31)

    def curves(n):
        return besides(lambda: travel(theta[:n], times, "closing"), lambda part: part.nbytes)

    def bank(n):
        rng = generator(1, "test", "memory", "bank")
        made = besides(lambda: simulate(model, n, rng).variables.values(), lambda part: part.nbytes)
        assert made > _ROWS * sensor.samples * 8 or n < FEW  # a block of float64
        return made

    for needed in (curves, bank):
        needed(8)  # compiled from here on
        assert needed(MANY) < needed(FEW) + SLACK
    assert curves(FEW) < _ROWS * 200
