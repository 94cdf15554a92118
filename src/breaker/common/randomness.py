"""Random numbers from one seed of the configuration and a purpose.

Purposes separate the generators, so results do not depend on the order of jobs or on cores.
"""

import hashlib

import numpy as np


def generator(seed: int, *purpose: str | int) -> np.random.Generator:
    """Return the generator of a seed (at least 0) and a purpose, such as ``"bank", "closing"``."""
    words = np.frombuffer(hashlib.sha256(repr(purpose).encode()).digest(), dtype="<u4")
    return np.random.default_rng([seed, *words.tolist()])


def systematic(weights: np.ndarray, n: int, start: float, rng: np.random.Generator) -> np.ndarray:
    """Return the indices of ``n`` draws, ``(n,)``, by systematic resampling in random order.

    The number of times that a draw is taken is its expectation, rounded up or down.

    Args:
        weights: Weights of the draws, ``(d,)``, not negative, with any sum above 0.
        start: Uniform number from 0 to 1, the position of the first draw.
        rng: Generator of the order.

    >>> np.sort(systematic(np.array([0.0, 3.0, 1.0]), 4, 0.5, np.random.default_rng(1)))
    array([1, 1, 1, 2])
    """
    edges = np.cumsum(weights)
    positions = (start + np.arange(n)) / n * edges[-1]
    return rng.permutation(np.searchsorted(edges, positions))


def seed_integer(seed: int, *purpose: str | int) -> int:
    """Return a 63-bit seed for a generator of another library, from a seed and a purpose."""
    return int(generator(seed, *purpose).integers(2**63))
