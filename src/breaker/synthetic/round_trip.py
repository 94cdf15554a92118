"""Curves of the model itself through files: written as an instrument would, and read back.

The true parameters of such a curve are known, so calibration shows whether the reader (its first
motion, decimation, units and zero) introduces an error.
"""

import tempfile
from pathlib import Path

import numpy as np

from breaker.mechanism import travel
from breaker.model import Model
from breaker.records import Operation, read_curves, write_curve

__all__ = ["through_files"]

_FASTER = 4  # samples of the instrument for one of the model's grid
_MARGIN = 8.0  # ms that a record is longer than the grid, at each end
_SPREAD = 4.0  # ms over which the first motion falls anywhere


def through_files(model: Model, n: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Draw records from the prior, write them as files and read them back.

    The noise is that of a sample, also at the instrument's rate; the first motion falls at random.

    Returns:
        Records on the grid, ``(n, t)``, mm, and the truth, ``(n, q)``: where the onset is inferred,
        it is the time from the reader's first motion to the true one.

    Raises:
        RuntimeError: If the reader rejects one of them.

    Example:
        >>> from breaker.model import Prior, Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> model = Model(prior, sensor, "closing")
        >>> records, truth = through_files(model, 2, np.random.default_rng(1))
        >>> records.shape, truth.shape
        ((2, 151), (2, 8))
    """
    sensor, motion = model.sensor, model.motion
    step = sensor.step / _FASTER
    time = np.arange(0.0, sensor.stop - sensor.start + 2 * _MARGIN, step)
    theta = model.prior.sample(n, rng)
    moves = _MARGIN - sensor.start + _SPREAD * (rng.random(n) - 0.5)
    records = sensor.corrupt(travel(theta, time, motion, onset=moves).travel, rng)
    with tempfile.TemporaryDirectory() as folder:
        files = [Operation(i, Path(folder, f"{motion}_{i:05d}.csv")) for i in range(n)]
        for each, record in zip(files, records, strict=True):
            write_curve(each.file, time, record, motion=motion, operation=each.number)
        curves = read_curves(files, {}, sensor.times, motion)
    if not curves.accepted.all():
        rejected = curves.reason.values[~curves.accepted.values]
        raise RuntimeError(f"{rejected.size} of {n} curves of the model rejected: {rejected[0]}")
    truth = theta
    if sensor.infers_onset:
        truth = np.column_stack([theta, moves - curves.first_motion.values])
    return curves.travel.values, truth
