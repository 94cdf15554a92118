"""Exports of a rig of another kind of breaker: long strokes, close and open in one record.

The default drive at 150 mm of stroke and 3.5 m/s, recorded as analysers of high-voltage breakers
do: six currents and six travels side by side, no times, a preamble of 4 to 45 lines, steps of 0.08
mm, blank cells where a channel ends and behind each line.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from breaker.mechanism import Size
from breaker.model import generator
from breaker.synthetic.dialects import DIALECTS
from breaker.synthetic.rigs import Rig

__all__ = ["CHANNELS", "LENGTHS", "TIMES", "write_exports"]

LENGTHS, TIMES = 10.35, 4.46
"""Factors on lengths and times of the default drive: 150 mm, and 3.5 m/s where it is fastest."""

_DIALECT = replace(DIALECTS["wide"], ending=".txt")
CHANNELS = _DIALECT.channels
"""Names of the columns of travel."""

_APART = 200.0  # ms from closing to opening
_LENGTH = 600.0  # ms of a record
_TRIGGER = (50.0, 5.0)  # ms before the closing, and their sd
_PHASES_SD = 1.0  # ms, between the first motions of channels
_FORCE_SD = 0.01  # share of the forces, between channels and operations
_NOISE_SD = 0.05  # mm


def write_exports(
    settings: Mapping, seed: int, folder: str | Path, operations: int
) -> dict[tuple[str, str, int], float]:
    """Write the files of some operations, ``rack_0001.txt`` and on.

    Args:
        settings: The section ``rig`` of the configuration: the drive that is made larger.
        seed: Seed of the scatter and the noise.
        folder: Where to write.
        operations: How many.

    Returns:
        Time of the first motion, ms of the record, by channel, motion and operation.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    drive = Rig.from_settings(settings, seed).new.scaled(Size(LENGTHS, TIMES))
    time = np.arange(0.0, _LENGTH, 1.0 / _DIALECT.rate)
    truth: dict[tuple[str, str, int], float] = {}
    for operation in range(1, operations + 1):
        rng = generator(seed, "high voltage", operation)
        trigger = _TRIGGER[0] + _TRIGGER[1] * rng.standard_normal()
        records = []
        for channel in CHANNELS:
            one = drive.changed(f=drive.value("f") * (1.0 + _FORCE_SD * rng.standard_normal()))
            closes, opens = trigger + _PHASES_SD * rng.standard_normal(2) + (0.0, _APART)
            closing, opening = (
                one.travel(motion, time - moves)
                for motion, moves in (("closing", closes), ("opening", opens))
            )
            record = np.where(time < opens, closing, opening)
            record += _NOISE_SD * rng.standard_normal(time.size)
            truth[channel, "closing", operation], truth[channel, "opening", operation] = (
                closes,
                opens,
            )
            records.append(record)
        records[-1][round(0.95 * time.size) :] = np.nan  # a channel that ends early
        file = Path(folder, f"rack_{operation:04d}.txt")
        _DIALECT.write(file, time, np.array(records), motion="close-open", operation=operation)
    return truth
