"""In which chunk an operation is, and which files the curves of a chunk come from."""

import json
from collections.abc import Iterable
from pathlib import Path


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


def recorded_source(store: str | Path) -> str | None:
    """Return the ``source`` in the settings of a store; None if there is none, or no store.

    Without xarray, which would take longer than the whole plan.
    """
    try:
        attributes = json.loads(Path(store, ".zattrs").read_text(encoding="utf-8"))
        return json.loads(attributes["settings"])["source"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
