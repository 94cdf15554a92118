"""Change points and remaining life judged on simulated lives, whose truth is known.

Every life passes through the same steps as a measured drive: records, posteriors of the network,
the trend of both motions, alarms and predictions, one operation after another.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from tqdm import tqdm

from breaker.model import generator
from breaker.posterior import Posterior
from breaker.records import raw_time
from breaker.synthetic.ideal import Observer
from breaker.synthetic.lives import Life, simulate_life
from breaker.wear import Follower, Series, State, confirmed, remaining_life

__all__ = ["FRACTIONS", "LEVELS", "follow_lives"]

FRACTIONS = (0.1, 0.25, 0.5, 0.75, 0.9)
"""Shares of the way from the change to the failure at which predictions are scored."""

LEVELS = (0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.99, 0.999, 0.9999)
"""Probabilities of a change from which an alarm might be raised."""

_SHARE = 0.7  # of the way, where raw times are taken
_BLOCK = 50  # records that are inferred together
_SEEDS = 100_000  # lives of one seed, at most


def follow_lives(
    posteriors: Mapping[str, Posterior],
    numbers: Sequence[int],
    lives: Mapping,
    wear_model: Mapping,
    *,
    seed: int,
    widenings: Sequence[float] = (),
) -> xr.Dataset:
    """Simulate lives, infer their records and follow them.

    Args:
        lives, wear_model: Sections of the configuration.
        widenings: Factors on the widths of trends to be tried, besides that of ``wear_model``.

    Returns:
        Dataset over ``life``, ``record`` (filled up with missing values), ``fraction``, ``draw``,
        ``observer``, ``widening`` and ``quantile``: ``operation``, ``change_probability``,
        ``alarm``, ``remaining`` and ``toward`` of each record, ``alarm_at`` other ``level`` s of
        the probability of a change, ``raw_time`` in each ``motion`` and ``output`` of each
        ``parameter``, standardised, the mean of that record's own posterior; ``change``,
        ``failure``, ``ratio``, ``changed`` and ``words`` of each life; and at each fraction of the
        way from change to failure the ``record_at`` and draws of the remaining life, ``lives``,
        which are inf beyond the ``horizon``, beside those of ideal observers, ``ideal``, and
        whether the 90 % interval of each widening holds the truth, ``covered``.
    """
    models = {motion: posterior.model for motion, posterior in posteriors.items()}
    length = -(-2 * lives["operations"] // lives["every"])  # the longest that a life can be
    followed = []
    for number in tqdm(numbers, desc="following lives", mininterval=5, unit="life"):
        life = simulate_life(models, lives, seed, number)
        series = _observe(posteriors, life, lives, seed, number)
        # Draws of its own, as every drive has that is followed with a seed of its own.
        own = seed * _SEEDS + number
        follower = Follower.from_settings(models, [life.limit], wear_model, own)
        one = _follow(follower, life, series, widenings)
        rng = generator(seed, "observer of a life", number)
        observer = Observer.of(models, life, lives, rng)
        one = one.merge(_ideal(observer, one.operation.values[one.record_at.values], follower))
        followed.append(one.pad(record=(0, length - one.sizes["record"])))
    return xr.concat(followed, dim="life").assign_coords(life=list(numbers))


def _observe(
    posteriors: Mapping[str, Posterior], life: Life, lives: Mapping, seed: int, number: int
) -> Series:
    """Record and infer a life, both motions."""
    records, outputs = {}, {}
    for motion, posterior in posteriors.items():
        rng = generator(seed, "records of a life", number, motion)
        operations, records[motion] = life.records(posterior.model, lives["every"], rng)
        blocks = np.array_split(records[motion], -(-len(operations) // _BLOCK))
        means, shape = [], (lives["draws"], len(posterior.outputs))
        for block in blocks:
            draws = posterior.sample(block, rng.standard_normal((len(block), *shape)))
            means.append(posterior.model.standardise(draws).mean(axis=1))
        outputs[motion] = np.concatenate(means)
    return Series(operations, records, outputs)


def _follow(
    follower: Follower, life: Life, series: Series, widenings: Sequence[float]
) -> xr.Dataset:
    """Follow a life from record to record, and gather what its scores are made of."""
    models = follower.models
    usable = {motion: series.usable(motion) for motion in models}
    way = life.change + np.array(FRACTIONS) * (life.failure - life.change)
    at = np.abs(series.operations[:, None] - way).argmin(axis=0)
    at = np.minimum(at, np.searchsorted(series.operations, life.failure) - 1)
    state, found, lives, covered = follower.begin(series), [], {}, {}
    since, alarm_at = np.full(len(LEVELS), state.since), []
    for i in range(len(series.operations)):
        before, (state, row, left) = state, follower.step(state, series, i, usable)
        found.append(row)
        alarm_at.append(_would_raise(follower, before, state, since))
        if i in at:
            lives[i] = left.lives[0]
            covered[i] = [_covers(follower, state, life, each) for each in widenings]
    trend = follower.dataset(series.operations, found)
    raw = [
        raw_time(model.sensor.times, series.records[motion], share=_SHARE)
        for motion, model in models.items()
    ]
    outputs = np.stack([series.outputs[motion] for motion in models], 1, dtype=np.float32)
    per_record = {
        "operation": series.operations,
        "change_probability": trend.change_probability.values,
        "alarm": trend.alarm.values,
        "toward": trend.toward.values[:, 0],
    }
    return xr.Dataset(
        {name: ("record", np.array(values, dtype=float)) for name, values in per_record.items()}
        | {
            "remaining": (("record", "quantile"), trend.remaining.values[:, 0]),
            "raw_time": (("record", "motion"), np.stack(raw, axis=-1)),
            "output": (("record", "motion", "parameter"), outputs),
            "alarm_at": (("record", "level"), np.array(alarm_at, dtype=np.float32)),
            "record_at": ("fraction", at),
            "lives": (("fraction", "draw"), np.array([lives[i] for i in at])),
            "covered": (("fraction", "widening"), np.array([covered[i] for i in at], dtype=bool)),
            "horizon": follower.horizon.operations,
            "words": life.limit.words,
        }
        | {name: getattr(life, name) for name in ("change", "failure", "ratio", "changed")},
        coords={
            "fraction": list(FRACTIONS),
            "motion": list(models),
            "widening": np.array(widenings, dtype=float),
            "parameter": next(iter(models.values())).names,
            "level": list(LEVELS),
        },
    )


def _would_raise(follower: Follower, before: State, state: State, since: np.ndarray) -> np.ndarray:
    """Say at which levels an alarm is raised, and note it in ``since``, the last one of each."""
    changed = np.array([confirmed(before.hypotheses, state.hypotheses, each) for each in since])
    watched = state.seen > before.seen and state.seen >= follower.settings["settle"]
    raised = watched & (changed >= LEVELS)
    since[raised] = state.hypotheses.operation
    return raised


def _covers(follower: Follower, state: State, life: Life, widening: float) -> bool:
    """Say whether the 90 % interval of trends of a given widening holds the truth."""
    horizon = replace(follower.horizon, widening=widening)
    left = remaining_life(state.hypotheses, follower.limits, follower.prior, horizon)
    lower, upper = left.quantiles([0.05, 0.95])[0]
    return bool(lower <= life.failure - state.hypotheses.operation <= upper)


def _ideal(observer: Observer, operations: np.ndarray, follower: Follower) -> xr.Dataset:
    """Remaining lives as ideal observers predict them after some operations."""
    sight, told = (follower.horizon.normals, follower.horizon.operations), (False, True)
    drawn = [[observer.lives(int(o), *sight, told=each) for each in told] for o in operations]
    dims = ("fraction", "observer", "draw")
    return xr.Dataset({"ideal": (dims, np.array(drawn))}, {"observer": ["ideal", "told"]})
