"""Memory besides the output: the same for any number of operations.

numpy reports its arrays to ``tracemalloc``; compiled code allocates some 10 kB a thread.
"""

import tracemalloc

import numpy as np

from breaker.common.randomness import generator
from breaker.model.curves import travel

FEW, MANY = 2**13, 2**15  # operations
SLACK = 2**16  # bytes of Python's own objects


def test_curves_are_made_in_blocks(prior):
    """What has to be converted is converted block by block as well."""
    theta = prior.sample(MANY, generator(1, "test", "memory")).astype(np.float32)

    def besides(n):
        """Most bytes in use besides the output while it was made."""
        tracemalloc.start()
        output = travel(theta[:n], np.linspace(-2, 58, 31), "closing")
        most = tracemalloc.get_traced_memory()[1] - sum(part.nbytes for part in output)
        tracemalloc.stop()
        return most

    besides(8)  # compiled from here on
    assert besides(MANY) < besides(FEW) + SLACK
    assert besides(FEW) < FEW * 200
