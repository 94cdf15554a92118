"""Two calls at once, each in a thread.

There are always two, so that results do not depend on the number of cores.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

_Found = TypeVar("_Found")
_BESIDE = ThreadPoolExecutor(1, "breaker exact")


def at_once(first: Callable[[], _Found], second: Callable[[], _Found]) -> tuple[_Found, _Found]:
    """What both return. Neither may call this function.

    Example:
        >>> at_once(lambda: 1, lambda: 2)
        (1, 2)
    """
    beside = _BESIDE.submit(second)
    try:
        own = first()
    finally:
        other = beside.exception()
    if other is not None:
        raise other
    return own, beside.result()
