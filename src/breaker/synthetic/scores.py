"""Scores of change points and remaining life on simulated lives, beside raw times."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import xarray as xr

from breaker.synthetic.detectors import Watches, of_records, raw_time_charts, watched
from breaker.synthetic.lives import WINDOW
from breaker.synthetic.prognostics import (
    Detections,
    crps,
    detections,
    false_alarms_per,
    prognostic_horizon,
    share,
)
from breaker.wear import quantiles_of

__all__ = ["score"]

OBSERVERS = {"ideal": "an ideal observer", "told": "one that is told of the change"}
"""Observers beside the model, in words."""

_ALPHA = 0.2  # of the cone of accuracy, share of the true remaining life
_HARD = 5.0  # ratio from which a change should be found
_ENDS = (0.05, 0.95)  # of a 90 % interval
_PER = 10_000.0
_RARE = 1.0  # false alarms in so many operations that the baselines have at least
_RATIOS = np.array([1.5, 3.0, 5.0, 8.0, 13.0, 30.0])  # bins


def score(lives: xr.Dataset, *, toward: float, settle: int) -> tuple[xr.Dataset, pd.DataFrame]:
    """Score what ``follow_lives`` returns; below ``toward`` a trend counts as none.

    The baselines watch the raw time of closing, and the raw time of opening by themselves, each at
    the least level at which it has no more false alarms on the same stretches before the change
    than the model, or than one in 10,000 operations if the model has fewer. Neither the model nor
    the baselines raise alarms in their first ``settle`` records.

    Returns:
        Dataset of all scores (see ``figures.prognostics``), and one table of the main ones.
    """
    alarms = _detections(lives, settle)
    found = {name: each.delay <= WINDOW * lives.failure.values for name, each in alarms.items()}
    prognoses = [_prognosis(lives.isel(life=i), toward) for i in range(lives.sizes["life"])]
    prognosis = {name: np.stack([each[name] for each in prognoses]) for name in prognoses[0]}
    rows = [
        ("lives", lives.sizes["life"], np.nan, np.nan),
        *_rows_of_detection(alarms, found, watched(lives, settle), lives.ratio.values),
        *_rows_of_prognosis(prognosis, lives.fraction.values),
    ]
    table = pd.DataFrame(rows, columns=["score", "value", "lower_95", "upper_95"])
    return _dataset(lives, alarms, found, prognosis), table


def _detections(lives: xr.Dataset, settle: int) -> dict[str, Detections]:
    """How the alarms of the model and of each baseline met the changes, by method."""
    truth = lives.change.values, lives.failure.values
    own = zip(of_records(lives, "operation"), of_records(lives, "alarm"), strict=True)
    result = {"model": detections([x[on == 1] for x, on in own], *truth)}
    rate = max(_PER * result["model"].false_alarms / watched(lives, settle), _RARE)
    for name, (series, detector) in raw_time_charts(lives, settle).items():
        _, alarms = Watches(lives, series, detector).alarms(rate, settle)
        result[name] = detections(alarms, *truth)
    return result


def _prognosis(life: xr.Dataset, toward: float) -> dict[str, np.ndarray]:
    """Scores of the remaining life of one life, ``(fraction,)``, and its prognostic horizon."""
    operation, failure, change = life.operation.values, float(life.failure), float(life.change)
    at, truth = life.record_at.values, failure - operation
    lower, median, upper = life.remaining.values.T
    no_trend = ~(life.toward.values >= toward)
    # A median beyond the horizon, inf, is a miss, and so is a bound that is nan.
    accurate = ~no_trend & (median >= (1 - _ALPHA) * truth) & (median <= (1 + _ALPHA) * truth)
    covered = (lower <= truth) & (truth <= upper)
    alarms = np.flatnonzero((operation > change) & (life.alarm.values == 1))
    # Up to the last scored fraction: the cone closes at the failure, and nothing stays inside.
    last = change + float(life.fraction[-1]) * (failure - change)
    after = (operation > change) & (operation <= last)
    horizon = prognostic_horizon(operation[after], accurate[after], failure)
    far, truth = float(life.horizon), truth[at]
    found = {
        "covered": covered[at],
        "accurate": accurate[at],
        "width": np.subtract(*np.minimum((upper[at], lower[at]), far)) / truth,
        "no_trend": no_trend[at],
        "noticed": np.array([np.any(alarms <= record) for record in at]),
        "crps": crps(life.lives.values, truth, far) / truth,
        "horizon": np.array(horizon / (failure - change)),
    }
    for name in OBSERVERS:
        lower, upper = quantiles_of(life.ideal.sel(observer=name).values, _ENDS).T
        found[f"covered, {name}"] = (lower <= truth) & (truth <= upper)
        found[f"width, {name}"] = np.subtract(*np.minimum((upper, lower), far)) / truth
    return found


def _rows_of_detection(
    alarms: dict[str, Detections], found: dict[str, np.ndarray], quiet: float, ratio: np.ndarray
) -> list[tuple]:
    hard = ratio >= _HARD
    late = {name: np.nan_to_num(each.delay, nan=np.inf) for name, each in alarms.items()}
    earlier = late.pop("model") < np.min(list(late.values()), axis=0)
    false, early = "false alarms in 10,000 operations", "found within 3 % of life"
    rates = {name: false_alarms_per(each.false_alarms, quiet) for name, each in alarms.items()}
    clear = ", ratio of 5 or more"
    return [
        *((f"{false}, {name}", *rate) for name, rate in rates.items()),
        *((f"{early}{clear}, {name}", *share(each[hard])) for name, each in found.items()),
        ("earlier than the best raw time", *share(earlier)),
        (f"earlier than the best raw time{clear}", *share(earlier[hard])),
    ]


def _rows_of_prognosis(prognosis: dict[str, np.ndarray], fractions: np.ndarray) -> list[tuple]:
    rows, nothing = [], (np.nan, np.nan)
    for k, fraction in enumerate(fractions):
        at = f"at {fraction:g} of the way to failure"
        one = {name: each[:, k] for name, each in prognosis.items() if each.ndim == 2}
        rows += [
            (f"coverage of the 90 % interval {at}", *share(one["covered"])),
            (f"the same, change noticed by then, {at}", *share(one["covered"][one["noticed"]])),
            (f"its width over remaining life, median, {at}", np.median(one["width"]), *nothing),
        ]
        for name, who in OBSERVERS.items():
            width = np.median(one[f"width, {name}"])
            rows.append((f"coverage of {who} {at}", *share(one[f"covered, {name}"])))
            rows.append((f"width over remaining life of {who}, median, {at}", width, *nothing))
        rows += [
            (f"alpha-lambda accuracy {at}", *share(one["accurate"])),
            (f"CRPS over remaining life, median, {at}", np.median(one["crps"]), *nothing),
            (f"no trend {at}", *share(one["no_trend"])),
        ]
    far = np.median(prognosis["horizon"])
    rows.append(("prognostic horizon, share of the life after the change, median", far, *nothing))
    return rows


def _dataset(
    lives: xr.Dataset,
    alarms: dict[str, Detections],
    found: dict[str, np.ndarray],
    prognosis: dict[str, np.ndarray],
) -> xr.Dataset:
    """What ``figures.prognostics`` draws."""
    ratio, failure = lives.ratio.values, lives.failure.values
    bins = np.clip(np.digitize(ratio, _RATIOS) - 1, 0, len(_RATIOS) - 2)
    places = range(len(_RATIOS) - 1)
    by_bin = [[share(each[bins == b])[0] for each in found.values()] for b in places]
    intervals = [share(hits)[1:] for hits in prognosis["covered"].T]

    def of_ideal(what: str, over: Callable) -> np.ndarray:
        return np.array([over(prognosis[f"{what}, {name}"], axis=0) for name in OBSERVERS])

    delays = np.stack([each.delay / failure for each in alarms.values()], -1)
    return xr.Dataset(
        {
            "ratio": ("life", ratio),
            "delay": (("life", "method"), delays),
            "found": (("bin", "method"), np.array(by_bin)),
            "bin_lower": ("bin", _RATIOS[:-1]),
            "bin_upper": ("bin", _RATIOS[1:]),
            "coverage": ("fraction", prognosis["covered"].mean(0)),
            "coverage_interval": (("fraction", "bound"), np.array(intervals)),
            "width": ("fraction", np.median(prognosis["width"], 0)),
            "ideal_coverage": (("observer", "fraction"), of_ideal("covered", np.mean)),
            "ideal_width": (("observer", "fraction"), of_ideal("width", np.median)),
            "alpha_lambda": ("fraction", prognosis["accurate"].mean(0)),
            "crps": ("fraction", np.median(prognosis["crps"], 0)),
        },
        coords={
            "method": list(alarms),
            "fraction": lives.fraction.values,
            "observer": list(OBSERVERS.values()),
            "bound": ["lower", "upper"],
        },
    )
