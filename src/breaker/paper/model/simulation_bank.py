"""Banks of simulated operations, in Zarr shards.

A bank contains noise-free curves. The zero and the noise are drawn anew for every batch of a
training, so one bank serves every sensor with the same grid and onset. A shard is one store and one
job; its content depends on the seed, the motion and its number alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from breaker.common.zarr_store import open_store
from breaker.mechanism.curves import Motion, blocks, travel
from breaker.paper.model.joint_model import Model
from breaker.quantities.parameters import NAMES, PARAMETERS

_TRAVEL_DTYPE = np.float32  # 1e-6 mm, a hundred-thousandth of the noise


def simulate(model: Model, n: int, rng: np.random.Generator) -> xr.Dataset:
    """Simulate operations drawn from the prior.

    Args:
        model: Joint model of the motion; the sensor's noise and zero are not used.

    Returns:
        Dataset with dims ``curve`` (n), ``time`` (t), ``parameter`` (p): noise-free ``travel``
        (mm), ``parameters``, ``onset`` (ms), ``switching_time`` (ms after the onset, inf if not
        within the record) and ``reopening`` (contact force zero again after the touch).

    Raises:
        FloatingPointError: If a curve is not finite.
    """
    motion, times = model.motion, model.sensor.times
    theta = model.prior.sample(n, rng)
    onset = model.sensor.onset_sd * rng.standard_normal(n)
    curves = Motion(np.empty((n, len(times)), _TRAVEL_DTYPE), np.empty(n), np.empty(n, np.bool_))
    bad = 0
    for rows in blocks(n):  # curves in double precision are those of one block
        block = travel(theta[rows], times, motion, onset=onset[rows])
        for whole, part in zip(curves, block, strict=True):
            whole[rows] = part
        bad += np.count_nonzero(~np.isfinite(block.travel).all(axis=1))
        del block
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


@dataclass(frozen=True)
class Bank:
    """Shards of a bank in their order, whose rows are read when they are asked for.

    Args:
        shards: What is in them, ``(curve, time)``, not in memory.
    """

    shards: Sequence[xr.Dataset]

    def __len__(self) -> int:
        return sum(shard.sizes["curve"] for shard in self.shards)

    def __getitem__(self, rows: slice) -> xr.Dataset:
        """Read neighbouring rows, as one dataset in memory."""
        first, last, _ = rows.indices(len(self))
        parts = []
        for shard in self.shards:
            n = shard.sizes["curve"]
            part = slice(max(0, first), max(0, min(n, last)))
            first, last = first - n, last - n
            if part.start < part.stop:
                parts.append(shard.isel(curve=part).load())
        return xr.concat(parts, dim="curve", join="exact", combine_attrs="override")


def open_bank(shards: Sequence[str | Path]) -> Bank:
    """Open the shards of a bank, in the order given.

    Raises:
        ValueError: If there is no shard, or if two shards differ in motion, grid or settings.
    """
    if not shards:
        raise ValueError("a bank needs at least one shard")
    parts = [open_store(shard) for shard in shards]
    for shard, part in zip(shards, parts, strict=True):
        for key in ("motion", "settings"):
            if part.attrs[key] != parts[0].attrs[key]:
                raise ValueError(
                    f"{shard} does not fit {shards[0]}: its {key} is {part.attrs[key]}, not "
                    f"{parts[0].attrs[key]}; simulate the bank anew"
                )
        if not part.time.equals(parts[0].time):
            raise ValueError(
                f"{shard} does not fit {shards[0]}: its time is another; simulate the bank anew"
            )
    return Bank(parts)
