"""The bank: curves simulated with parameters from the prior, from which networks learn.

Paper, Sec. 3 and 5, and the training phase of Fig. 2. Curves have no noise and no zero. A training
draws new ones for every batch, so one bank serves all sensors with the same grid and onset. A shard
is one store and one job; its content depends only on the seed, the motion and the shard number. The
principal components and the envelope of a bank detect records that are unlike its curves.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.common.zarr_store import open_store
from breaker.model.curves import blocks
from breaker.model.sensor import Sensor
from breaker.paper.joint_model import Model

_TRAVEL_DTYPE = np.float32  # rounds to 1e-6 mm, a hundred-thousandth of the noise
_SHARED = ("motion", "settings")  # attributes that all shards of a bank have in common


def simulate(model: Model, n: int, rng: np.random.Generator) -> xr.Dataset:
    """Simulate operations drawn from the prior; raise a FloatingPointError if one is not finite.

    Returns:
        Dataset with dims ``curve`` (n), ``time`` (t), ``parameter`` (p): noise-free ``travel``
        (mm), ``parameters`` and ``onset`` (ms).
    """
    motion, times = model.motion, model.sensor.times
    theta, onset = model.sample(n, rng)
    travel = np.empty((n, len(times)), _TRAVEL_DTYPE)
    bad = 0
    for rows in blocks(n):  # only one block at a time is in double precision
        travel[rows] = model.simulate(theta[rows], onset[rows], rng)
        bad += np.count_nonzero(~np.isfinite(travel[rows]).all(axis=1))
    if bad:
        raise FloatingPointError(f"{bad} of {n} simulated {motion} curves are not finite")
    parameters = model.outputs[: theta.shape[1]]
    return xr.Dataset(
        {
            "travel": (("curve", "time"), travel, {"unit": "mm"}),
            "parameters": (("curve", "parameter"), theta),
            "onset": ("curve", onset, {"unit": "ms"}),
        },
        coords={
            "time": ("time", times, {"unit": "ms"}),
            "parameter": ("parameter", [parameter.name for parameter in parameters]),
            "parameter_unit": ("parameter", [parameter.unit for parameter in parameters]),
        },
        attrs={"motion": motion},
    )


def truth(bank: xr.Dataset, model: Model) -> np.ndarray:
    """Return the outputs of a bank's rows, ``(n, q)``, physical units."""
    values = np.column_stack([bank.parameters.values, bank.onset.values])
    return values[:, : len(model.names)]


def open_bank(shards: Sequence[str | Path]) -> xr.Dataset:
    """Read the shards of a bank, in this order, into one dataset in memory; raise a ValueError if
    they differ in motion, grid or settings.
    """
    parts = [open_store(shard) for shard in shards]
    if any(part.attrs[key] != parts[0].attrs[key] for key in _SHARED for part in parts):
        raise ValueError(
            f"{shards[0]} and other shards are of different banks. Delete them and simulate again"
        )
    return xr.concat(parts, dim="curve", join="exact", combine_attrs="override").load()


# ---- which records are unlike a bank ------------------------------------------------------------


def principal_components(
    travel: np.ndarray, sensor: Sensor, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean ``(t,)`` of noise-free curves ``(n, t)``, mm, and the weights ``(t, c)``,
    1/mm, of the ``count`` components with the largest ratio of signal to noise:
    ``(record - mean) @ weights`` has unit variance over records of the bank.
    """
    mean = travel.mean(axis=0, dtype=np.float64)
    whitened = sensor.whiten(travel - mean)
    variances, vectors = np.linalg.eigh(whitened.T @ whitened / len(travel))
    variances, vectors = variances[::-1][:count], vectors[:, ::-1][:, :count]
    # The sign of eigh's vectors depends on the library, so fix it here.
    vectors = vectors * np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(count)])
    return mean, sensor.whiten(vectors.T).T / np.sqrt(1.0 + variances)


def distance(measured: np.ndarray, mean: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the distance of records from the bank's centre, ``(n, t) -> (n,)``.

    It is the largest score, in standard deviations of the bank; a mean over all scores hides a
    single large one.
    """
    return np.abs((measured - mean) @ weights).max(axis=-1)


def excess(measured: np.ndarray, lowest: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Return how far records leave the bank's envelope, ``(n, t) -> (n,)``, mm.

    It is the largest excess over the samples, negative for a record entirely inside. It detects
    records that the components miss: half the stroke lies near the bank's mean in all components.
    The envelope is the lowest and highest noise-free travel at each sample, ``(t,)``, mm.
    """
    return np.maximum(measured - highest, lowest - measured).max(axis=-1)
