"""Write a simulated record as a text file that the default format reads."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np


def write_curve(
    file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
) -> None:
    """Write a record of the simulated endurance test, which the default format reads.

    Args:
        time: Times, ``(t,)``, ms; written in s.
        travel: Travel, ``(t,)``, mm, zero at the open position.
        motion, operation: Motion and number in the header.
    """
    above = ["travel record", f"motion: {motion}", f"operation: {operation}", "zero: open position"]
    columns = {"time": ["s", *texts(time / 1e3, 7)], "travel": ["mm", *texts(travel, 3)]}
    text = "\n".join([*above, *rows(columns, ","), ""])
    Path(file).write_text(text, encoding="utf-8")


def texts(values: np.ndarray, digits: int) -> list[str]:
    """Return numbers as text; missing numbers are blank."""
    return [f"{x:.{digits}f}" if x == x else "" for x in values.tolist()]


def rows(columns: Mapping[str, Sequence[str]], delimiter: str) -> list[str]:
    """Return the line of names and the lines of cells."""
    cells = zip(*columns.values(), strict=True)
    return [delimiter.join(columns), *(delimiter.join(row) for row in cells)]
