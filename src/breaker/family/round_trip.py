"""Curves of the model itself through files: written as instruments would, and read back.

The true parameters of such a curve are known, so calibration shows whether the reader (its first
motion, decimation, units, zero and steps) introduces an error.
"""

import re
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.family.dialects import DIALECTS, Dialect
from breaker.model.curves import travel
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.records.curves import read_curves
from breaker.records.grid import Grid
from breaker.records.operations import Operation

_MARGIN = 8.0  # ms that a record is longer than the grid, at each end
_SPREAD = 4.0  # ms over which the first motion falls anywhere
_ANY_STROKE = (1e-3, 1e6)  # mm: units are no question here
_NUMBER = re.compile(r"-?\d[\d.]*(?:e[-+]\d+)?")  # in which reasons of one kind differ


class Through(NamedTuple):
    """Records that went through files.

    Attributes:
        measured: Records on the grid, ``(n, t)``, mm.
        truth: Parameters, and where the onset is inferred the time from the reader's first motion
            to the true one, ``(n, q)``.
        dialect: Which of the dialects each was written in, ``(n,)``.
        rejected: How many more the reader rejected, by reason, without what differs in it.
    """

    measured: np.ndarray
    truth: np.ndarray
    dialect: np.ndarray
    rejected: Mapping[str, int]


def through_files(
    prior: Prior,
    sensor: Sensor,
    motion: str,
    n: int,
    rng: np.random.Generator,
    dialects: Sequence[Dialect] = tuple(DIALECTS.values()),
) -> Through:
    """Draw records from the prior, write them as files and read them back.

    The noise is that of a sample; the first motion falls at random; the dialects take turns. What
    is rejected by its record alone leaves the ranks of the others uniform.

    Raises:
        RuntimeError: If the reader rejects all of them.
    """
    theta = prior.sample(n, rng)
    moves = _MARGIN - sensor.start + _SPREAD * (rng.random(n) - 0.5)
    which = np.arange(n) % len(dialects)
    measured, first = np.empty((n, sensor.samples)), np.empty(n)
    reason = np.full(n, "", dtype=object)
    for i in range(min(n, len(dialects))):
        mine = which == i
        through = _through(sensor, motion, theta[mine], moves[mine], rng, dialects[i])
        measured[mine], first[mine], reason[mine] = through
    # Networks of the paper take whole records. The reader masks a sample in one of a thousand.
    reason[(reason == "") & np.isnan(measured).any(axis=1)] = "a sample is missing or masked"
    truth = np.column_stack([theta, moves - first]) if sensor.infers_onset else theta
    read, rejected = reason == "", dict(Counter(reason[reason != ""]).most_common())
    if not read.any():
        raise RuntimeError(f"all {n} curves of the model are rejected: {rejected}")
    return Through(measured[read], truth[read], which[read], rejected)


def _through(
    sensor: Sensor,
    motion: str,
    theta: np.ndarray,
    moves: np.ndarray,
    rng: np.random.Generator,
    dialect: Dialect,
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Records through files of one dialect, ``(m, t)``, first motions, ``(m,)``, and why any are
    rejected.
    """
    length = sensor.stop - sensor.start + 2 * _MARGIN
    time = np.arange(round(length * dialect.rate)) / dialect.rate
    records = sensor.corrupt(travel(theta, time, motion, onset=moves).travel, rng)
    with tempfile.TemporaryDirectory() as folder:
        dialect = dialect.reaching(records.max(), folder)
        names = [dialect.file_name(motion, i) for i in range(len(theta))]
        files = [Operation(i, Path(folder, name)) for i, name in enumerate(names)]
        for each, record in zip(files, records, strict=True):
            dialect.write(each.file, time, record, motion=motion, operation=each.number)
        settings = {"stroke": _ANY_STROKE, **dialect.settings}
        curves = read_curves(files, settings, Grid(sensor.times), motion)
    said = zip(curves.reason.values, curves.file.values, strict=True)
    reasons = [_NUMBER.sub("#", text.removeprefix(file).lstrip(": ")) for text, file in said]
    return curves.travel.values, curves.first_motion.values, reasons
