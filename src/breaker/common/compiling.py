"""Loops compiled by numba if it is installed, or else run in Python, and the number of threads.

Divide numbers of numpy: a division by zero then gives inf or nan in both.
"""

import os
import sys
from collections.abc import Callable
from typing import Any


def set_threads(count: int) -> None:
    """Set the number of threads of torch, numba and the linear algebra.

    Call this before numpy is loaded, because its linear algebra reads the number only then.
    (Snakemake sets the same variables for its jobs.)
    """
    for name in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{name}_NUM_THREADS"] = str(count)
    if "numba" in sys.modules:
        numba = sys.modules["numba"]
        numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    else:
        os.environ["NUMBA_NUM_THREADS"] = str(count)
    # Last, because numba starts its threads here, which sets the threads of OpenMP and of torch.
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(count)


def compiled(**options: Any) -> Callable[[Callable], Callable]:
    """Return a decorator that compiles a function, and caches the machine code for later processes
    if its folder can be written. ``options`` are options of ``numba.njit``.
    """

    def decorate(function: Callable) -> Callable:
        njit, _ = numba_or_plain()
        try:
            return njit(cache=True, error_model="numpy", **options)(function)
        except RuntimeError:  # the cache cannot be written
            return njit(error_model="numpy", **options)(function)

    return decorate


def numba_or_plain() -> tuple[Callable, Callable]:
    """Return ``njit`` and ``prange`` of numba, or replacements in Python without numba."""
    try:
        from numba import njit, prange
    except ModuleNotFoundError:
        import numpy as np

        plain = np.errstate(all="ignore")
        return lambda function=None, **_: plain(function) if function else plain, range
    return njit, prange
