"""In which chunk an operation is."""

from collections.abc import Iterable


def chunks_of(numbers: Iterable[int], size: int) -> dict[str, list[int]]:
    """Sort operations into chunks, each a job of its own: number 1 to ``size``, and so on.

    An operation that is appended leaves all earlier chunks as they are, and the operations of one
    number are in the same chunk in both motions. Chunks without any operation are left out.

    Args:
        numbers: Numbers of operations, from 0 or 1 on; some may be missing or stand twice.
        size: How many numbers there are to a chunk.

    Returns:
        Names of the chunks, ``000`` and on, with the numbers in each; both rising.

    >>> chunks_of([1, 2, 3, 4, 11], size=3)
    {'000': [1, 2, 3], '001': [4], '003': [11]}
    """
    found: dict[str, list[int]] = {}
    for number in sorted(set(numbers)):
        found.setdefault(f"{max(number - 1, 0) // size:03d}", []).append(number)
    return found
