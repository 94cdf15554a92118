"""Change points and remaining life judged on simulated lives, whose truth is known.

Every life goes the whole way that a measured one goes: records, the network's posteriors, the
trend of both motions, alarms and predictions, operation by operation.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.model import Model, generator
from breaker.posterior import Posterior
from breaker.records import raw_time
from breaker.synthetic.lives import Life, simulate_life
from breaker.wear import Follower, Series

__all__ = ["FRACTIONS", "follow_lives"]

FRACTIONS = (0.1, 0.25, 0.5, 0.75, 0.9)
"""Shares of the way from the change to the failure at which predictions are scored."""

_SHARES = {"closing": 0.7, "opening": 0.7}  # of the way, where raw times are taken
_BLOCK = 50  # records that are inferred together


def follow_lives(
    posteriors: Mapping[str, Posterior],
    numbers: Sequence[int],
    lives: Mapping,
    wear_model: Mapping,
    *,
    seed: int,
) -> xr.Dataset:
    """Simulate lives, infer their records and follow them.

    Args:
        posteriors: The trained posterior of each motion.
        numbers: Numbers of the lives.
        lives, wear_model: Sections of the configuration.
        seed: Seed of the lives.

    Returns:
        Dataset over ``life``, ``record`` (filled up with missing values), ``fraction``, ``future``
        and ``quantile``: ``operation``, ``change_probability``, ``alarm``, ``remaining`` and
        ``toward`` of each record, ``raw_time`` in each ``motion``; ``change``, ``failure``,
        ``ratio``, ``changed`` and ``words`` of each life; and at each fraction of the way from
        change to failure the ``record_at`` and the ``cdf`` of the remaining life.
    """
    models = {motion: posterior.model for motion, posterior in posteriors.items()}
    rows = []
    for number in tqdm(numbers, desc="following lives", mininterval=5, unit="life"):
        life = simulate_life(models, lives, seed, number)
        series = _observe(posteriors, life, lives, seed, number)
        follower = Follower.from_settings(models, [life.limit], wear_model, seed)
        rows.append(_follow(follower, life, series, models))
    length = -(-2 * lives["operations"] // lives["every"])  # the longest that a life can be
    return _together(rows, numbers, length, follower.horizon.grid)


def _observe(
    posteriors: Mapping[str, Posterior], life: Life, lives: Mapping, seed: int, number: int
) -> Series:
    """Record and infer a life, both motions."""
    records, outputs = {}, {}
    for motion, posterior in posteriors.items():
        rng = generator(seed, "records of a life", number, motion)
        operations, records[motion] = life.records(posterior.model, lives["every"], rng)
        blocks = np.array_split(records[motion], -(-len(operations) // _BLOCK))
        means = [
            posterior.model.standardise(
                posterior.sample(
                    block, rng.standard_normal((len(block), lives["draws"], len(posterior.outputs)))
                )
            ).mean(axis=1)
            for block in blocks
        ]
        outputs[motion] = np.concatenate(means)
    return Series(operations, records, outputs)


def _follow(
    follower: Follower, life: Life, series: Series, models: Mapping[str, Model]
) -> dict[str, object]:
    usable = {motion: series.usable(motion) for motion in models}
    state, found, cdfs = follower.begin(series), [], []
    for i in range(len(series.operations)):
        state, row, left = follower.step(state, series, i, usable)
        found.append(row)
        cdfs.append(left.cdf[0])
    way = life.change + np.array(FRACTIONS) * (life.failure - life.change)
    at = np.abs(series.operations[:, None] - way).argmin(axis=0)
    at = np.minimum(at, np.searchsorted(series.operations, life.failure) - 1)
    raw = {
        motion: raw_time(model.sensor.times, series.records[motion], share=_SHARES[motion])
        for motion, model in models.items()
    }
    return {
        "operation": series.operations,
        "change_probability": np.array([row["change_probability"] for row in found]),
        "alarm": np.array([row["alarm"] for row in found]),
        "remaining": np.array([row["remaining"][0] for row in found]),
        "toward": np.array([row["toward"][0] for row in found]),
        "raw_time": np.stack(list(raw.values()), axis=-1),
        "cdf": np.array(cdfs)[at],
        "record_at": at,
        "change": life.change,
        "failure": life.failure,
        "ratio": life.ratio,
        "changed": life.changed,
        "words": life.limit.words,
    }


_DIMS = {
    "remaining": ("record", "quantile"),
    "raw_time": ("record", "motion"),
    "cdf": ("fraction", "future"),
    "record_at": ("fraction",),
    **dict.fromkeys(("operation", "change_probability", "alarm", "toward"), ("record",)),
}


def _together(
    rows: list[dict], numbers: Sequence[int], length: int, grid: np.ndarray
) -> xr.Dataset:
    """Put lives of different lengths into one dataset."""

    def filled(value: np.ndarray, name: str) -> np.ndarray:
        if "record" not in _DIMS.get(name, ()):
            return np.asarray(value)
        missing = length - len(value)
        shape = ((0, missing), *(((0, 0),) * (value.ndim - 1)))
        return np.pad(value.astype(float), shape, constant_values=np.nan)

    data = {
        name: (("life", *_DIMS.get(name, ())), np.stack([filled(r[name], name) for r in rows]))
        for name in rows[0]
    }
    coords = {
        "life": list(numbers),
        "fraction": list(FRACTIONS),
        "future": grid,
        "motion": list(_SHARES),
    }
    return xr.Dataset(data, coords=coords)
