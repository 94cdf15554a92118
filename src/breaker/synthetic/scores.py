"""Scores of change points and remaining life on simulated lives, beside raw times."""

import numpy as np
import pandas as pd
import xarray as xr

from breaker.synthetic.control_charts import level_for, monitor
from breaker.synthetic.lives import WINDOW
from breaker.synthetic.prognostics import (
    alpha_lambda_median,
    coverage_interval,
    covered,
    crps,
    detection,
    false_alarms_per,
    prognostic_horizon,
)

__all__ = ["score"]

_CHARTS = {"threshold": "threshold", "CUSUM": "cusum", "EWMA": "ewma"}
_ALPHA = 0.2  # of the cone of accuracy, share of the true remaining life
_HARD = 5.0  # ratio from which a change should be found
_RARE = 1e-4  # false alarms an operation that the baselines have at least
_RATIOS = np.array([1.5, 3.0, 5.0, 8.0, 13.0, 30.0])  # bins


def score(lives: xr.Dataset, *, toward: float, settle: int) -> tuple[xr.Dataset, pd.DataFrame]:
    """Score what ``follow_lives`` returns; below ``toward`` a trend counts as none.

    The baselines watch the raw time of closing, and the raw time of opening by themselves, each at
    the least level at which it has no more false alarms on the same stretches before the change
    than the model, or than one in 10,000 operations if the model has fewer.

    Returns:
        Dataset of all scores (see ``figures.prognostics``), and one table of the main ones.
    """
    delays, false, watched = _detections(lives, settle)
    found = {method: delays[method] <= WINDOW * lives.failure.values for method in delays}
    prognosis = _prognoses(lives, toward)
    rows = [
        ("lives", lives.sizes["life"], np.nan, np.nan),
        *_rows_of_detection(delays, found, false, watched, lives.ratio.values),
        *_rows_of_prognosis(prognosis, lives.fraction.values),
    ]
    table = pd.DataFrame(rows, columns=["score", "value", "lower_95", "upper_95"])
    return _dataset(lives, delays, found, prognosis), table


def _rows_of_detection(
    delays: dict, found: dict, false: dict, watched: float, ratio: np.ndarray
) -> list[tuple]:
    hard = ratio >= _HARD
    late = {method: np.nan_to_num(each, nan=np.inf) for method, each in delays.items()}
    others = np.min([each for method, each in late.items() if method != "model"], axis=0)
    earlier = late["model"] < others
    return [
        *(
            (f"false alarms in 10,000 operations, {m}", *false_alarms_per(false[m], watched))
            for m in delays
        ),
        *(
            (f"found within 3 % of life, ratio of 5 or more, {m}", *_share(found[m][hard]))
            for m in delays
        ),
        ("earlier than the best raw time", *_share(earlier)),
        ("earlier than the best raw time, ratio of 5 or more", *_share(earlier[hard])),
    ]


def _rows_of_prognosis(prognosis: dict, fractions: np.ndarray) -> list[tuple]:
    rows, nothing = [], (np.nan, np.nan)
    for k, fraction in enumerate(fractions):
        at = f"at {fraction:g} of the way to failure"
        one = {name: each[:, k] for name, each in prognosis.items() if each.ndim == 2}
        rows += [
            (f"coverage of the 90 % interval {at}", *_share(one["covered"])),
            (f"the same, change noticed by then, {at}", *_share(one["covered"][one["noticed"]])),
            (f"alpha-lambda accuracy {at}", *_share(one["accurate"])),
            (f"CRPS over remaining life, median, {at}", np.median(one["crps"]), *nothing),
            (f"no trend {at}", *_share(one["no_trend"])),
        ]
    far = np.median(prognosis["horizon"])
    rows.append(("prognostic horizon, share of the life after the change, median", far, *nothing))
    return rows


def _dataset(lives: xr.Dataset, delays: dict, found: dict, prognosis: dict) -> xr.Dataset:
    """What ``figures.prognostics`` draws."""
    ratio, failure = lives.ratio.values, lives.failure.values
    bins = np.clip(np.digitize(ratio, _RATIOS) - 1, 0, len(_RATIOS) - 2)
    by_bin = [
        [each[bins == b].mean() if (bins == b).any() else np.nan for each in found.values()]
        for b in range(len(_RATIOS) - 1)
    ]
    ends = coverage_interval(prognosis["covered"].sum(0), len(ratio))
    return xr.Dataset(
        {
            "ratio": ("life", ratio),
            "delay": (("life", "method"), np.stack([d / failure for d in delays.values()], -1)),
            "found": (("bin", "method"), np.array(by_bin)),
            "bin_lower": ("bin", _RATIOS[:-1]),
            "bin_upper": ("bin", _RATIOS[1:]),
            "coverage": ("fraction", prognosis["covered"].mean(0)),
            "coverage_interval": (("fraction", "bound"), np.stack(ends, -1)),
            "alpha_lambda": ("fraction", prognosis["accurate"].mean(0)),
            "crps": ("fraction", np.median(prognosis["crps"], 0)),
        },
        coords={
            "method": list(delays),
            "fraction": lives.fraction.values,
            "bound": ["lower", "upper"],
        },
    )


def _share(hits: np.ndarray) -> tuple[float, float, float]:
    """Share of hits and its 95 % interval."""
    if hits.size == 0:
        return np.nan, np.nan, np.nan
    low, high = coverage_interval(int(hits.sum()), hits.size)
    return float(hits.mean()), float(low), float(high)


def _detections(lives: xr.Dataset, settle: int) -> tuple[dict, dict, float]:
    """Delays ``(life,)`` and false alarms by method, and operations watched before the change.

    Neither the model nor the baselines raise alarms in their first ``settle`` records.
    """
    change, failure = lives.change.values, lives.failure.values
    numbers = [row[np.isfinite(row)] for row in lives.operation.values]
    every = float(np.median(np.diff(numbers[0])))
    watched = float(np.maximum(change - settle * every, 0).sum())
    raised = {
        "model": [
            each[on[: len(each)] == 1] for each, on in zip(numbers, lives.alarm.values, strict=True)
        ]
    }
    delays, false = {}, {}

    def judge(name: str) -> None:
        found = [
            detection(alarms, *truth)
            for alarms, *truth in zip(raised[name], change, failure, strict=True)
        ]
        delays[name] = np.array([each.delay for each in found])
        false[name] = sum(each.false_alarms for each in found)

    judge("model")
    rate = max(false["model"] / watched, _RARE) * every * watched / change.sum()
    for chart, kind in _CHARTS.items():
        for k, motion in enumerate(lives.motion.values):
            series = [
                row[: len(x), k] for row, x in zip(lives.raw_time.values, numbers, strict=True)
            ]
            quiet = [s[x <= c] for s, x, c in zip(series, numbers, change, strict=True)]
            level = level_for(quiet, kind, rate, warm_up=settle)
            raised[f"{chart}, {motion}"] = [
                x[monitor(s, kind, level, warm_up=settle)]
                for s, x in zip(series, numbers, strict=True)
            ]
            judge(f"{chart}, {motion}")
    return delays, false, watched


def _prognoses(lives: xr.Dataset, level: float) -> dict[str, np.ndarray]:
    """Scores of the remaining life, ``(life, fraction)``, and prognostic horizon ``(life,)``."""
    grid, n = lives.future.values.astype(float), lives.sizes["life"]
    fractions = lives.fraction.values
    shape = (n, len(fractions))
    flags = ("covered", "accurate", "no_trend", "noticed")
    result = {name: np.zeros(shape, dtype=bool) for name in flags} | {"crps": np.zeros(shape)}
    horizon = np.zeros(n)
    for i in range(n):
        numbers = lives.operation.values[i]
        failure, change = float(lives.failure[i]), float(lives.change[i])
        remaining, toward = lives.remaining.values[i], lives.toward.values[i]
        none = ~(toward >= level)
        # Up to the last scored fraction: the cone closes at the failure, and nothing stays inside.
        last = change + fractions[-1] * (failure - change)
        after = np.isfinite(numbers) & (numbers > change) & (numbers <= last)
        truth = failure - numbers
        inside = np.zeros(numbers.shape, dtype=bool)
        inside[after] = ~none[after] & alpha_lambda_median(
            remaining[after, 1], truth[after], _ALPHA
        )
        far = prognostic_horizon(numbers[after], inside[after], failure)
        horizon[i] = far / (failure - change)
        for k, at in enumerate(lives.record_at.values[i]):
            cdf = lives.cdf.values[i, k]
            result["covered"][i, k] = covered(remaining[at, 0], remaining[at, 2], truth[at])
            median = remaining[at, 1]
            near = alpha_lambda_median(median, truth[at], _ALPHA)
            result["accurate"][i, k] = near and not none[at]
            result["crps"][i, k] = crps(grid, cdf, truth[at]) / truth[at]
            result["no_trend"][i, k] = none[at]
            since = (numbers > change) & (np.arange(numbers.size) <= at)
            result["noticed"][i, k] = np.any(lives.alarm.values[i][since] == 1)
    return result | {"horizon": horizon}
