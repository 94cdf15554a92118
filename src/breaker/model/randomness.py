"""Random numbers from one seed of the configuration and a purpose.

Every random number of the project comes from a generator that is made here and passed on. So a
result depends on the seed and the purpose, and not on the order of jobs or the number of cores.
"""

import hashlib

import numpy as np


def generator(seed: int, *purpose: str | int) -> np.random.Generator:
    """Return the generator that belongs to a seed and a purpose.

    Args:
        seed: Seed of the configuration, not negative.
        purpose: What the numbers are for, such as ``("bank", "closing", 3)``. Two purposes give
            two independent streams.

    Raises:
        ValueError: If no purpose is given; two streams without one would be identical.
    """
    if not purpose:
        raise ValueError("a generator needs a purpose, such as generator(seed, 'bank', 'closing')")
    words = np.frombuffer(hashlib.sha256(repr(purpose).encode()).digest(), dtype="<u4")
    return np.random.default_rng([seed, *words.tolist()])


def seed_integer(seed: int, *purpose: str | int) -> int:
    """Return a 63-bit seed for a generator of another library, from a seed and a purpose."""
    return int(generator(seed, *purpose).integers(2**63))
