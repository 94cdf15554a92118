"""Numpy and numba, loaded at first use, and the number of threads.

Numba compiles inner loops if it is installed; otherwise they run in Python. A division by zero
gives inf or nan in both, as in numpy.
"""

import os
import sys
from collections.abc import Callable
from functools import cached_property, update_wrapper, wraps
from typing import TYPE_CHECKING, Any

_PLAIN = 300_000  # elements that plain Python processes in the time that numba takes to load


class _Numpy:
    def __getattr__(self, name: str) -> Any:
        import numpy

        vars(self)[name] = attribute = getattr(numpy, name)  # found directly from now on
        return attribute


if TYPE_CHECKING:
    import numpy as np
else:
    np = _Numpy()


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


def compiled(*, late: bool = False, **options: Any) -> Callable[[Callable], Callable]:
    """Return a decorator that compiles a function, and caches the machine code for later processes
    if its folder can be written. ``options`` are options of ``numba.njit``.

    With ``late``, the function runs in Python until the process has handled many elements, because
    a command on one record takes less time than numba needs to load.
    """

    def decorate(function: Callable) -> Callable:
        njit, _ = numba_or_plain()
        try:
            return njit(cache=True, error_model="numpy", **options)(function)
        except RuntimeError:  # the cache cannot be written
            return njit(error_model="numpy", **options)(function)

    return (lambda function: _Late(function, decorate)) if late else decorate


def compile_now() -> None:
    """Compile every ``late`` function at its next call, for servers that run for hours."""
    _Late.left = 0


def numba_or_plain() -> tuple[Callable, Callable]:
    """Return ``njit`` and ``prange`` of numba, or replacements in Python without numba."""
    try:
        from numba import njit, prange
    except ModuleNotFoundError:
        return lambda function=None, **_: _plain(function) if function else _plain, range
    return njit, prange


def _plain(function: Callable) -> Callable:
    @wraps(function)
    def plain(*args: Any) -> Any:
        with np.errstate(all="ignore"):
            try:
                return function(*args)
            except ZeroDivisionError:  # raised by Python's numbers, but not by numpy's
                return function(*(np.float64(e) if isinstance(e, float) else e for e in args))

    return plain


class _Late:
    """A function that is compiled once all such functions have handled many elements."""

    left = _PLAIN  # elements until compilation, of all such functions of this process

    def __init__(self, function: Callable, decorate: Callable[[Callable], Callable]) -> None:
        update_wrapper(self, function)
        self.plain, self.decorate = _plain(function), decorate

    @cached_property
    def fast(self) -> Callable:
        return self.decorate(self.__wrapped__)

    @property
    def _numba_type_(self) -> Any:  # for compiled code that calls it
        return self.fast._numba_type_

    def __call__(self, *args: Any) -> Any:
        _Late.left -= sum(getattr(arg, "size", 0) for arg in args)
        return (self.plain if _Late.left > 0 else self.fast)(*args)
