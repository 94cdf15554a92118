"""What a file of labelled columns, or of tables, shows of itself before anything is known of it."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.reading.files.guards import RejectedCurveError

MOST_COLUMNS = 300
"""Columns of the widest table; exports have a tenth of it."""

_MOST_SAMPLES = 1_200_000  # a record of 10 s at 100 kHz has a million
_MOST_LINES = 2_000_000
_MOST_CELLS = 8_000_000


class Labelled(NamedTuple):
    """Columns of which a file says names and units.

    Attributes:
        settings: What it tells of ``endurance.format``, by key.
        preamble: Cells of what it states beside, line by line.
        names: Of the columns.
        units: As the settings call them; None where none is known.
        columns: Numbers of each, ``(t,)``.
    """

    settings: dict
    preamble: list[list[str]]
    names: list[str]
    units: list[str | None]
    columns: list[np.ndarray]


class Tables(NamedTuple):
    """Tables of cells, of which it is to be guessed where names and samples are.

    Attributes:
        lines: Of each table, cells with tabs between.
        reason: Why the file is refused where none of them has columns of numbers.
    """

    lines: Iterable[Sequence[str]]
    reason: str


def check_lines(file: str | Path, content: bytes) -> None:
    """Reject a text with more lines than a record, before they are split."""
    if max(content.count(b"\n"), content.count(b"\r")) > _MOST_LINES:
        reason = f"has more than {_MOST_LINES:,} lines; export a shorter part of the record"
        raise RejectedCurveError(file, reason)


def check_size(file: str | Path, samples: int, columns: int, *, line: int | None = None) -> None:
    """Reject a table with more columns, samples or cells than a record, before they are built."""
    if columns > MOST_COLUMNS:
        reason = f"has {columns:,} columns, but records have at most {MOST_COLUMNS}"
        raise RejectedCurveError(file, f"{reason}; export fewer channels", line=line)
    most = min(_MOST_SAMPLES, _MOST_CELLS // max(1, columns))
    if samples > most:
        reason = f"has {samples:,} samples, but of {columns} columns at most {most:,} are read"
        raise RejectedCurveError(file, f"{reason}; export fewer channels, or a shorter part")
