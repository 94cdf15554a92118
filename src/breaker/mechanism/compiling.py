"""Compilation of inner loops by numba, whose result is kept where there is a place for it."""

from collections.abc import Callable
from typing import Any

from numba import njit

__all__ = ["compiled"]


def compiled(**options: Any) -> Callable[[Callable], Callable]:
    """Return a decorator that compiles a function, and keeps the machine code for later processes.

    It is kept beside the module, or in the user's cache. Where neither can be written to, as in a
    container that may only read, every process compiles anew: a few seconds each.

    A division by zero gives inf or nan, as it does in numpy.

    Args:
        options: Further ones of ``numba.njit``.

    Example:
        >>> @compiled()
        ... def ratio(a, b):
        ...     return a / b
        >>> ratio(1.0, 0.0)
        inf
    """

    def decorate(function: Callable) -> Callable:
        try:
            return njit(cache=True, error_model="numpy", **options)(function)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            return njit(error_model="numpy", **options)(function)

    return decorate
