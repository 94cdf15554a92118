"""Write curves of the model to files as instruments do, and read them back.

The true parameters of these curves are known, so calibration shows whether the reader (its first
motion, decimation, units, zero and steps) introduces an error.
"""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from breaker.family.exports import LAYOUTS, Layout
from breaker.model.curves import travel
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor
from breaker.records.curves import read_curves
from breaker.records.grid import Grid
from breaker.records.operations import Operation

_MARGIN = 8.0  # ms by which a record is longer than the grid, at each end
_SPREAD = 4.0  # ms, range of the start of motion: any sample of the grid may be the first
_ANY_STROKE = (1e-3, 1e6)  # mm: the prior has strokes that no unit would explain


class RoundTrip(NamedTuple):
    """Records that were written and read.

    Attributes:
        measured: Records on the grid, ``(n, t)``, mm.
        truth: Parameters; where the onset is inferred, also the time from the reader's first motion
            to the true start, ms: ``(n, q)``.
        reasons: Why the reader rejected the other records.
    """

    measured: np.ndarray
    truth: np.ndarray
    reasons: Sequence[str]


def through_files(
    prior: Prior,
    sensor: Sensor,
    motion: str,
    n: int,
    rng: np.random.Generator,
    layouts: Mapping[str, Layout] = LAYOUTS,
) -> RoundTrip:
    """Draw ``n`` records from the prior, write each in one of the layouts, and read them.

    The noise is that of a simulated record; the start of motion is random; the layouts take turns.
    A rejection depends on the record alone, so the ranks of the other truths stay uniform.

    Raises:
        RuntimeError: If the reader rejects all records.
    """
    theta = prior.sample(n, rng)
    starts = _MARGIN - sensor.start + _SPREAD * (rng.random(n) - 0.5)
    measured, first = np.empty((n, sensor.samples)), np.empty(n)
    reasons = np.full(n, "", dtype=object)
    for i, layout in enumerate(layouts.values()):
        own = slice(i, None, len(layouts))
        length = sensor.stop - sensor.start + 2 * _MARGIN
        time = np.arange(round(length * layout.rate)) / layout.rate
        curves = travel(theta[own], time, motion, onset=starts[own]).travel
        read = _read_back(layout, time, sensor.corrupt(curves, rng), motion, sensor)
        measured[own], first[own], reasons[own] = read.travel, read.first_motion, read.reason
    # The networks of the paper take complete records.
    reasons[(reasons == "") & np.isnan(measured).any(axis=1)] = "a sample is missing or masked"
    truth = np.column_stack([theta, starts - first]) if sensor.infers_onset else theta
    accepted = reasons == ""
    if not accepted.any():
        raise RuntimeError(f"the reader rejects all {n} curves of the model: {reasons[0]}")
    return RoundTrip(measured[accepted], truth[accepted], reasons[~accepted].tolist())


def _read_back(
    layout: Layout, time: np.ndarray, records: np.ndarray, motion: str, sensor: Sensor
) -> xr.Dataset:
    """Return what the reader makes of files of records, ``(m, t)``, mm."""
    with tempfile.TemporaryDirectory() as folder:
        operations = []
        for number, record in enumerate(records):
            file = Path(folder, f"{motion}_{number:05d}{layout.ending}")
            layout.write(file, time, record, motion=motion, operation=number)
            operations.append(Operation(number, file))
        settings = {"stroke": _ANY_STROKE, **layout.settings}
        return read_curves(operations, settings, Grid(sensor.times), motion)
