"""Exports of a rig of another kind of breaker: long strokes, close and open in one record.

The default rig at 150 mm of stroke and 3.5 m/s, recorded as analysers of high-voltage breakers do:
six currents and six travels side by side, no times, a preamble, blank cells where a channel ends.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from breaker.common.randomness import generator
from breaker.family.dialects import DIALECTS
from breaker.family.rich_drive import Drive
from breaker.model.parameters import FORCE, Size

HIGH_VOLTAGE = Size(lengths=10.35, times=4.46)
"""Size beside the default drive: 150 mm, and 3.5 m/s where it is fastest."""

_DIALECT = replace(DIALECTS["wide"], ending=".txt")
CHANNELS = _DIALECT.channels
"""Names of the columns of travel."""

_APART = 200.0  # ms from closing to opening
_OPENING = 400.0  # ms of a record from about its opening on
_TRIGGER = (50.0, 5.0)  # ms before the closing, and their sd
_PHASES_SD = 1.0  # ms, between the first motions of channels
_FORCE_SD = 0.01  # share of the forces, between channels and operations
_NOISE_SD = 0.05  # mm


def write_exports(
    drive: Drive,
    seed: int,
    folder: str | Path,
    operations: Sequence[int],
    *,
    force_sd: float = _FORCE_SD,
    apart: float = _APART,
) -> dict[tuple[str, str, int], float]:
    """Write a file for each operation, such as ``rack_0001.txt``: for a seed always the same.

    Args:
        drive: A drive of the default size, which is made larger.
        folder: Where to write; it is made if it is not there.
        force_sd: Standard deviation of the closing force between channels and operations, a share.
        apart: From closing to opening, ms; long enough for the drive to come to rest.

    Returns:
        Time of the first motion, ms of the record, by channel, motion and operation.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    drive = drive.scaled(HIGH_VOLTAGE)
    time = np.arange(0.0, apart + _OPENING, 1.0 / _DIALECT.rate)
    truth: dict[tuple[str, str, int], float] = {}
    for operation in operations:
        rng = generator(seed, "high voltage", operation)
        trigger = _TRIGGER[0] + _TRIGGER[1] * rng.standard_normal()
        records = []
        for channel in CHANNELS:
            force = drive.value(FORCE.name) * (1.0 + force_sd * rng.standard_normal())
            one = drive.changed(**{FORCE.name: force})
            closes, opens = trigger + _PHASES_SD * rng.standard_normal(2) + (0.0, apart)
            closing = one.travel("closing", time - closes)
            record = np.where(time < opens, closing, one.travel("opening", time - opens))
            records.append(record + _NOISE_SD * rng.standard_normal(time.size))
            truth[channel, "closing", operation] = closes
            truth[channel, "opening", operation] = opens
        records[-1][round(0.95 * time.size) :] = np.nan  # a channel that ends early
        file = Path(folder, f"rack_{operation:04d}.txt")
        _DIALECT.write(file, time, np.array(records), motion="close-open", operation=operation)
    return truth
