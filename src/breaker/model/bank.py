"""Banks of simulated operations, in Zarr shards.

A bank holds noise-free curves: the zero and the noise are drawn afresh for every batch of a
training, so that one bank serves every sensor of the same grid and onset. A shard is one store
and one job; its content depends on the seed, the motion and its number alone.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, PARAMETERS, Motion, blocks, travel
from breaker.model.prior import Prior

__all__ = ["open_bank", "simulate"]

_TRAVEL_DTYPE = np.float32  # 1e-6 mm, a hundred-thousandth of the noise


def simulate(
    prior: Prior,
    times: np.ndarray,
    motion: str,
    n: int,
    rng: np.random.Generator,
    *,
    onset_sd: float,
) -> xr.Dataset:
    """Simulate operations drawn from the prior.

    Args:
        prior: Prior of the parameters.
        times: Times of the samples, ``(t,)``, ms.
        motion: "closing" or "opening".
        n: Number of operations.
        rng: Generator of parameters and onsets.
        onset_sd: Standard deviation of the onset, ms; 0 if motions start at time 0.

    Returns:
        Dataset with dims ``curve`` (n), ``time`` (t), ``parameter`` (p): noise-free ``travel``
        (mm), ``parameters``, ``onset`` (ms), ``switching_time`` (ms after the onset, inf if not
        within the record) and ``reopening`` (contact force zero again after the touch).

    Raises:
        FloatingPointError: If a curve is not finite.
    """
    theta = prior.sample(n, rng)
    onset = onset_sd * rng.standard_normal(n)
    curves = Motion(np.empty((n, len(times)), _TRAVEL_DTYPE), np.empty(n), np.empty(n, np.bool_))
    bad = sum(_fill(curves, rows, theta, times, motion, onset) for rows in blocks(n))
    if bad:
        raise FloatingPointError(f"{bad} of {n} simulated {motion} curves are not finite")
    return xr.Dataset(
        {
            "travel": (("curve", "time"), curves.travel, {"unit": "mm"}),
            "parameters": (("curve", "parameter"), theta),
            "onset": ("curve", onset, {"unit": "ms"}),
            "switching_time": ("curve", curves.switching, {"unit": "ms"}),
            "reopening": ("curve", curves.reopening),
        },
        coords={
            "time": ("time", times, {"unit": "ms"}),
            "parameter": ("parameter", list(NAMES)),
            "parameter_unit": ("parameter", [parameter.unit for parameter in PARAMETERS]),
        },
        attrs={"motion": motion},
    )


def _fill(
    curves: Motion,
    rows: slice,
    theta: np.ndarray,
    times: np.ndarray,
    motion: str,
    onset: np.ndarray,
) -> int:
    """Fill a block of a bank, and return how many of its curves are not finite.

    The curves in double precision are those of one block, and gone when it is filled.
    """
    block = travel(theta[rows], times, motion, onset=onset[rows])
    for whole, part in zip(curves, block, strict=True):
        whole[rows] = part
    return np.count_nonzero(~np.isfinite(block.travel).all(axis=1))


def open_bank(shards: Sequence[str | Path]) -> xr.Dataset:
    """Read the shards of a bank, in the order given, as one dataset in memory.

    Raises:
        ValueError: If there is no shard, or if two shards differ in motion, grid or settings.
    """
    if not shards:
        raise ValueError("a bank needs at least one shard")
    parts = [xr.open_zarr(shard, chunks=None) for shard in shards]
    for shard, part in zip(shards, parts, strict=True):
        for key in ("motion", "settings"):
            if part.attrs[key] != parts[0].attrs[key]:
                raise ValueError(
                    f"{shard} does not fit {shards[0]}: its {key} is {part.attrs[key]}, not "
                    f"{parts[0].attrs[key]}; simulate the bank anew"
                )
    return xr.concat(parts, dim="curve", join="exact", combine_attrs="override").load()
