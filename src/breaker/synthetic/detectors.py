"""What else could notice a change of wear: detectors beside the model, and how they compare.

Every detector watches simulated lives online, each at a range of levels. The first records, as many
as the model takes to settle, raise no alarm, and after an alarm each starts anew. Their levels are
fitted to the very lives on which they are scored, in their favour: the least at which there are no
more false alarms than a given rate. The settings of the multivariate ones were chosen on lives of
another seed.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd
import xarray as xr

from breaker.mechanism import NAMES
from breaker.synthetic.control_charts import KINDS, chart, mewma, slope_test
from breaker.synthetic.lives import WINDOW
from breaker.synthetic.prognostics import detections, share
from breaker.synthetic.watching import Detector, Watch, level_for

__all__ = [
    "RATES",
    "Watches",
    "compare_detectors",
    "of_records",
    "raw_time_charts",
    "score_alarms",
    "watched",
]

RATES = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""False alarms in 10,000 operations, to which levels are fitted."""

_CLASSES = {"from_5": (5.0, np.inf), "3_to_5": (3.0, 5.0), "1.5_to_3": (0.0, 3.0)}  # of the ratio
_WORDS = {"threshold": "threshold", "cusum": "CUSUM", "ewma": "EWMA"}
_WEIGHT = 0.1  # of the newest residual in the multivariate EWMA; with 0.05 or 0.2 it does no better
_AGES = (3, 4, 5, 6, 8, 10, 13, 17, 22, 30)  # records since a bend; up to 60 or 120 is no better
_PER = 10_000.0


def compare_detectors(lives: xr.Dataset, *, settle: int) -> pd.DataFrame:
    """Score the model and other detectors at many levels on what ``follow_lives`` returns.

    Args:
        lives: Lives with their truth, ``raw_time``, ``output``, and ``alarm_at`` of the model.
        settle: Records in which nothing raises an alarm.

    Returns:
        A row for each detector and level: ``detector``, ``level`` and what ``score_alarms`` says.
    """
    table = []
    for level in lives.level.values:
        each = zip(of_records(lives, "operation"), of_records(lives, "alarm_at"), strict=True)
        alarms = [x[on[:, lives.level.values == level][:, 0] == 1] for x, on in each]
        table.append({"detector": "model", "level": level} | score_alarms(lives, alarms, settle))
    opponents = raw_time_charts(lives, settle) | _of_outputs(lives, settle)
    for name, (series, detector) in opponents.items():
        watches = Watches(lives, series, detector)
        for rate in RATES:
            level, alarms = watches.alarms(rate, settle)
            table.append({"detector": name, "level": level} | score_alarms(lives, alarms, settle))
    return pd.DataFrame(table)


class Watches:
    """All lives under one detector.

    Args:
        series: What is watched of each, ``(n,)`` or ``(n, q)``.
    """

    def __init__(self, lives: xr.Dataset, series: Sequence[np.ndarray], detector: Detector) -> None:
        self.lives = lives
        self.operations = of_records(lives, "operation")
        self.watches = [Watch(each, detector) for each in series]
        pairs = zip(self.operations, lives.change.values, strict=True)
        self.quiet = [int(np.searchsorted(x, change)) for x, change in pairs]

    def alarms(self, rate: float, settle: int) -> tuple[float, list[np.ndarray]]:
        """Return the level for a rate of false alarms in 10,000 operations, and its alarms.

        The rate is one of operations that are watched, those after the first ``settle`` records.
        """
        allowed = rate / _PER * watched(self.lives, settle) / sum(self.quiet)
        level = level_for(self.watches, allowed, self.quiet)
        found = zip(self.operations, self.watches, strict=True)
        return level, [x[each.at(level).alarm] for x, each in found]


def watched(lives: xr.Dataset, settle: int) -> float:
    """Return how many operations without a change are watched, in all lives together."""
    every = float(np.nanmedian(np.diff(lives.operation.values[0])))
    return float(np.maximum(lives.change.values - settle * every, 0).sum())


def of_records(lives: xr.Dataset, name: str) -> list[np.ndarray]:
    """Return values of each life at its own records, ``(n, ...)``."""
    there = np.isfinite(lives.operation.values)
    values = lives[name].transpose("life", "record", ...).values
    return [row[own] for row, own in zip(values, there, strict=True)]


def raw_time_charts(lives: xr.Dataset, settle: int) -> dict[str, tuple[list[np.ndarray], Detector]]:
    """Return raw times and their control chart, by the name of the detector: each motion alone."""
    times, charts = of_records(lives, "raw_time"), {}
    for kind in KINDS:
        for i, motion in enumerate(lives.motion.values):
            own = [each[:, i] for each in times]
            charts[f"{_WORDS[kind]}, {motion}"] = own, partial(chart, kind=kind, warm_up=settle)
    return charts


def _of_outputs(lives: xr.Dataset, settle: int) -> dict[str, tuple[list[np.ndarray], Detector]]:
    """Return what watches the means of the posteriors of single records, all motions together."""
    series = [each.reshape(len(each), -1) for each in of_records(lives, "output")]
    names = [str(name) for _ in lives.motion.values for name in lives.parameter.values]
    groups = [[i for i, each in enumerate(names) if each == name] for name in NAMES]
    bend = partial(slope_test, groups=groups, ages=_AGES, warm_up=settle)
    return {
        "multivariate EWMA": (series, partial(mewma, weight=_WEIGHT, warm_up=settle)),
        "slope test": (series, bend),
    }


def score_alarms(lives: xr.Dataset, alarms: Sequence[np.ndarray], settle: int) -> dict[str, float]:
    """Score the alarms of a detector in all lives.

    Returns:
        ``false_alarms`` in 10,000 operations; and for each class of the ratio, such as ``from_5``,
        the share of changes ``found_…`` within 3 % of the life and the median ``delay_…`` in
        operations, inf where fewer than half are noticed before the failure.
    """
    found = detections(alarms, lives.change.values, lives.failure.values)
    early = found.delay <= WINDOW * lives.failure.values
    late = np.where(np.isnan(found.delay), np.inf, found.delay)
    scores = {"false_alarms": found.false_alarms * _PER / watched(lives, settle)}
    for name, (low, high) in _CLASSES.items():
        mine = (lives.ratio.values >= low) & (lives.ratio.values < high)
        scores[f"found_{name}"] = share(early[mine])[0]
        median = np.quantile(late[mine], 0.5, method="higher") if mine.any() else np.nan
        scores[f"delay_{name}"] = float(median)
    return scores
