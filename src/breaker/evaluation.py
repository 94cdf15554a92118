"""Change points and remaining life judged on simulated lives, whose truth is known.

Every life goes the whole way that a measured one goes: records, the network's posteriors, the
trend of both motions, alarms and predictions, operation by operation.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from tqdm import tqdm

from breaker import baselines, prognostics
from breaker.lives import WINDOW, Life, simulate_life
from breaker.model import Model
from breaker.posterior import Posterior
from breaker.randomness import generator
from breaker.raw_time import raw_time
from breaker.trend import Follower, Series

__all__ = ["FRACTIONS", "METHODS", "follow_lives", "score"]

FRACTIONS = (0.1, 0.25, 0.5, 0.75, 0.9)
"""Shares of the way from the change to the failure at which predictions are scored."""

METHODS = ("model", "threshold", "CUSUM", "EWMA")
_KINDS = {"threshold": "threshold", "CUSUM": "cusum", "EWMA": "ewma"}
_ALPHA = 0.2  # of the cone of accuracy, share of the true remaining life
_WARM_UP = 30  # records from which the baselines know their line
_SHARES = {"closing": 0.7, "opening": 0.7}  # of the way, where raw times are taken
_BLOCK = 50  # records that are inferred together
_RATIOS = np.array([1.5, 3.0, 5.0, 8.0, 13.0, 30.0])  # bins


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
    kinds = [row["kind_probability"] for row in found]
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
        "kind_at_end": kinds[-1],
    }


_DIMS = {
    "remaining": ("record", "quantile"),
    "raw_time": ("record", "motion"),
    "cdf": ("fraction", "future"),
    "record_at": ("fraction",),
    "kind_at_end": ("kind",),
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
    coords = {"life": list(numbers), "fraction": list(FRACTIONS), "future": grid}
    return xr.Dataset(data, coords=coords)


# ---- scores ----------------------------------------------------------------------------------


def score(lives: xr.Dataset, *, toward: float) -> tuple[xr.Dataset, pd.DataFrame]:
    """Score what ``follow_lives`` returns; below ``toward`` a trend counts as none.

    The baselines watch the raw time of closing, and the raw time of opening by themselves, each at
    the least level at which it has no more false alarms on the same stretches before the change
    than the model, or than one in 10,000 operations if the model has fewer.

    Returns:
        Dataset of all scores (see ``figures.prognostics``), and one table of the main ones.
    """
    delays, false, watched, rate = _detections(lives)
    ratio, failure = lives.ratio.values, lives.failure.values
    nominal = WINDOW * failure
    found = {method: delays[method] <= nominal for method in delays}
    best = np.fmin.reduce([delays[m] for m in delays if m != "model"])
    bins = np.digitize(ratio, _RATIOS) - 1
    bins = np.clip(bins, 0, len(_RATIOS) - 2)
    by_bin = np.array(
        [
            [found[m][bins == b].mean() if (bins == b).any() else np.nan for m in delays]
            for b in range(len(_RATIOS) - 1)
        ]
    )
    hard = ratio >= 5
    model, other = np.nan_to_num(delays["model"], nan=np.inf), np.nan_to_num(best, nan=np.inf)
    prognosis = _prognoses(lives, toward)
    rates = {m: prognostics.false_alarms_per(false[m], watched) for m in delays}
    rows = [
        ("lives", len(ratio), np.nan, np.nan),
        *((f"false alarms in 10,000 operations, {m}", *rates[m]) for m in delays),
        *(
            (f"found within 3 % of life, ratio of 5 or more, {m}", *_share(found[m][hard]))
            for m in delays
        ),
        ("earlier than the best raw time", *_share(model < other)),
        ("earlier than the best raw time, ratio of 5 or more", *_share((model < other)[hard])),
    ]
    for k, fraction in enumerate(FRACTIONS):
        name = f"at {fraction:g} of the way to failure"
        rows += [
            (f"coverage of the 90 % interval {name}", *_share(prognosis["covered"][:, k])),
            (
                f"the same, change noticed by then, {name}",
                *_share(prognosis["covered"][:, k][prognosis["noticed"][:, k] == 1]),
            ),
            (f"alpha-lambda accuracy {name}", *_share(prognosis["accurate"][:, k])),
            (
                f"CRPS over remaining life, median, {name}",
                np.median(prognosis["crps"][:, k]),
                *[np.nan] * 2,
            ),
            (f"no trend {name}", *_share(prognosis["no_trend"][:, k])),
        ]
    rows.append(
        (
            "prognostic horizon, share of the life after the change, median",
            np.median(prognosis["horizon"]),
            *[np.nan] * 2,
        )
    )
    table = pd.DataFrame(rows, columns=["score", "value", "lower_95", "upper_95"])
    low, high = prognostics.coverage_interval(prognosis["covered"].sum(0), len(ratio))
    data = xr.Dataset(
        {
            "ratio": ("life", ratio),
            "delay": (("life", "method"), np.stack([delays[m] / failure for m in delays], -1)),
            "found": (("bin", "method"), by_bin),
            "bin_lower": ("bin", _RATIOS[:-1]),
            "bin_upper": ("bin", _RATIOS[1:]),
            "coverage": ("fraction", prognosis["covered"].mean(0)),
            "coverage_interval": (("fraction", "bound"), np.stack([low, high], -1)),
            "alpha_lambda": ("fraction", prognosis["accurate"].mean(0)),
            "crps": ("fraction", np.median(prognosis["crps"], 0)),
        },
        coords={"method": list(delays), "fraction": list(FRACTIONS), "bound": ["lower", "upper"]},
        attrs={"false_alarms": rate},
    )
    return data, table


def _share(hits: np.ndarray) -> tuple[float, float, float]:
    """Share of hits and its 95 % interval."""
    if hits.size == 0:
        return np.nan, np.nan, np.nan
    low, high = prognostics.coverage_interval(int(hits.sum()), hits.size)
    return float(hits.mean()), float(low), float(high)


def _detections(lives: xr.Dataset) -> tuple[dict, dict, int, float]:
    """Delays (life,) and false alarms by method, operations watched, rate of the baselines."""
    change, failure = lives.change.values, lives.failure.values
    numbers = [row[np.isfinite(row)] for row in lives.operation.values]
    watched, n = int(change.sum()), len(change)
    delays, false = {"model": np.full(n, np.nan)}, {"model": 0}
    for i in range(n):
        alarms = numbers[i][lives.alarm.values[i][: len(numbers[i])] == 1]
        found = prognostics.detection(alarms, change[i], failure[i])
        delays["model"][i] = found.delay
        false["model"] += found.false_alarms
    every = float(np.median(np.diff(numbers[0])))
    rate = max(false["model"] / watched, 1e-4)
    for method, kind in _KINDS.items():
        for k, motion in enumerate(_SHARES):
            series = [lives.raw_time.values[i, : len(numbers[i]), k] for i in range(n)]
            quiet = [s[x <= c] for s, x, c in zip(series, numbers, change, strict=True)]
            level = baselines.level_for(quiet, kind, rate * every, warm_up=_WARM_UP)
            name = f"{method}, {motion}"
            delays[name], false[name] = np.full(n, np.nan), 0
            for i in range(n):
                alarms = numbers[i][baselines.monitor(series[i], kind, level, warm_up=_WARM_UP)]
                found = prognostics.detection(alarms, change[i], failure[i])
                delays[name][i] = found.delay
                false[name] += found.false_alarms
    return delays, false, watched, rate


def _prognoses(lives: xr.Dataset, level: float) -> dict[str, np.ndarray]:
    """Scores of the remaining life, ``(life, fraction)``, and prognostic horizon ``(life,)``."""
    grid, n = lives.future.values.astype(float), lives.sizes["life"]
    shape = (n, len(FRACTIONS))
    result = {
        name: np.zeros(shape) for name in ("covered", "accurate", "crps", "no_trend", "noticed")
    }
    horizon = np.zeros(n)
    for i in range(n):
        numbers = lives.operation.values[i]
        failure, change = float(lives.failure[i]), float(lives.change[i])
        remaining, toward = lives.remaining.values[i], lives.toward.values[i]
        none = ~(toward >= level)
        # Up to the last scored fraction: the cone closes at the failure, and nothing stays inside.
        last = change + FRACTIONS[-1] * (failure - change)
        after = np.isfinite(numbers) & (numbers > change) & (numbers <= last)
        truth = failure - numbers
        inside = np.zeros(numbers.shape, dtype=bool)
        inside[after] = ~none[after] & prognostics.alpha_lambda_median(
            remaining[after, 1], truth[after], _ALPHA
        )
        far = prognostics.prognostic_horizon(numbers[after], inside[after], failure)
        horizon[i] = far / (failure - change)
        for k, at in enumerate(lives.record_at.values[i]):
            cdf = lives.cdf.values[i, k]
            result["covered"][i, k] = prognostics.covered(
                remaining[at, 0], remaining[at, 2], truth[at]
            )
            median = remaining[at, 1]
            near = prognostics.alpha_lambda_median(median, truth[at], _ALPHA)
            result["accurate"][i, k] = near and not none[at]
            result["crps"][i, k] = prognostics.crps(grid, cdf, truth[at]) / truth[at]
            result["no_trend"][i, k] = none[at]
            since = (numbers > change) & (np.arange(numbers.size) <= at)
            result["noticed"][i, k] = np.any(lives.alarm.values[i][since] == 1)
    return result | {"horizon": horizon}
