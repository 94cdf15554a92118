"""In which job a breaker is. Light to import: the plan of the workflow is made from it."""

from collections.abc import Sequence


def breaker_chunks(breakers: Sequence[str], size: int) -> dict[str, list[str]]:
    """Sort breakers into chunks, each a job of its own, in their order.

    Breakers whose first rows are appended to a table leave all chunks but the last as they are.

    >>> breaker_chunks(["Q7", "Q1", "Q3"], size=2)
    {'000': ['Q7', 'Q1'], '001': ['Q3']}
    """
    begins = range(0, len(breakers), size)
    return {f"{k:03d}": list(breakers[begin : begin + size]) for k, begin in enumerate(begins)}
