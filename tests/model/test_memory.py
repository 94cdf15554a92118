"""Memory besides the output: the same for any number of operations.

numpy reports its arrays to ``tracemalloc``; compiled code allocates some 10 kB a thread.
"""

import tracemalloc

import numpy as np

from breaker.common.randomness import generator
from breaker.model.curves import travel
from breaker.paper.bank import simulate
from breaker.paper.joint_model import Model

FEW, MANY = 2**13, 2**15  # operations
SLACK = 2**16  # bytes of Python's own objects


def test_curves_and_banks_are_made_in_blocks(prior, sensor):
    """What has to be converted is converted block by block as well."""
    theta = prior.sample(MANY, generator(1, "test", "memory")).astype(np.float32)
    model, times = Model(prior, sensor, "closing"), np.linspace(-2, 58, 31)

    def besides(make, n):
        """Most bytes in use besides the output while it was made."""
        tracemalloc.start()
        try:
            output = make(n)
            return tracemalloc.get_traced_memory()[1] - sum(part.nbytes for part in output)
        finally:
            tracemalloc.stop()

    def curves(n):
        return travel(theta[:n], times, "closing")

    def bank(n):
        return simulate(model, n, generator(1, "test", "bank")).variables.values()

    for make in (curves, bank):
        make(8)  # compiled from here on
        assert besides(make, MANY) < besides(make, FEW) + SLACK
    assert besides(curves, FEW) < FEW * 200
