"""A record written as the stand-in's instrument does."""

from pathlib import Path

import numpy as np

_PREAMBLE = ("travel record", "motion: {motion}", "operation: {operation}", "zero: open position")


def write_curve(
    file: str | Path, time: np.ndarray, travel: np.ndarray, *, motion: str, operation: int
) -> None:
    """Write a record: preamble, names, units, rows.

    Args:
        time: Times, ``(t,)``, ms; written in s.
        travel: Travel, ``(t,)``, mm, zero at the open position.
        motion: Motion named in the preamble.
        operation: Operation named in the preamble.
    """
    preamble = [line.format(motion=motion, operation=operation) for line in _PREAMBLE]
    rows = [f"{t:.7f},{x:.3f}" for t, x in zip((time / 1e3).tolist(), travel.tolist(), strict=True)]
    Path(file).write_text(
        "\n".join([*preamble, "time,travel", "s,mm", *rows, ""]), encoding="utf-8"
    )
