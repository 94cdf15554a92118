"""Shares and errors over all judged rigs, with their Monte-Carlo errors."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from breaker.synthetic.judged_lives import FRACTIONS
from breaker.synthetic.judged_power import FAULTS
from breaker.synthetic.lives import WINDOW
from breaker.synthetic.prognostics import false_alarms_per, share

__all__ = ["score_lives", "score_power"]

_CLEAR = 5.0  # ratio from which a change should be found
_ENDS = ("value", "lower_95", "upper_95", "n")


def score_lives(rows: pd.DataFrame, *, settle: int, every: int, operations: int) -> pd.DataFrame:
    """Score what ``judge_lives`` returns.

    Args:
        settle: Records before which no change is reported.
        every: Operations between two records.

    Returns:
        A row per set, scale and ``score``: coverage of levels, drifts and remaining lives,
        root mean square errors of drifts (percent per thousand operations), the share of sources
        that are followed together, false alarms in 10,000 operations before a change, and shares
        of changes found; with 95 % intervals.
    """
    found, by = [], ["set", "scale"]
    for place, some in rows.groupby(by, sort=False):
        begins = dict(zip(by, place, strict=True))
        followed = some[some.score == "life"]
        each = followed.drop_duplicates("life")
        found.append(begins | _row("followed together", each.source == "both"))
        for score in ("level", "slope"):
            for name, one in some[some.score == score].groupby("name", sort=False):
                found.append(begins | _row(f"coverage, {score}", _inside(one), name))
                if score == "slope":
                    found.append(begins | _rms("error, slope", one, name))
        for fraction in FRACTIONS:
            name = f"{fraction:g}"
            one = some[(some.score == "remaining") & (some.name == name)]
            found.append(begins | _row("coverage, remaining", _inside(one), name))
        found += [begins | each for each in _reports(some, settle * every, WINDOW * operations)]
    return pd.DataFrame(found)


def score_power(rows: pd.DataFrame, *, settle: int, every: int, records: int) -> pd.DataFrame:
    """Score what ``judge_power`` returns: share of each fault reported, its size, reports before.

    Args:
        settle, every: As of ``score_lives``.
        records: Records before a fault.
    """
    found = []
    for fault in FAULTS:
        one = rows[(rows.fault == fault) & (rows.kind != "left out")]
        found.append(_row("reported", one.kind != "none", fault))
        found.append(_row("reported as a step", one.kind == "step", fault))
        size = {"score": "change over noise, median", "quantity": fault, "n": len(one)}
        found.append(size | {"value": one.clear.median()})
    before, watched = rows[rows.fault == "before"], (records - settle) * every
    watched *= rows.rig.nunique()
    for kind in ("alarm", "step"):
        found.append(_rate(f"false {kind}s", (before.kind == kind).sum(), watched))
    return pd.DataFrame(found)


def _reports(rows: pd.DataFrame, silent: int, window: float) -> list[dict]:
    """Rows of false alarms and of changes found within a window, of one set and scale."""
    lives = rows[rows.score == "life"].reset_index(drop=True)
    watched = (lives.change - silent).clip(lower=0).sum()
    reports = rows[rows.score.isin(["alarm", "step"])]
    early = reports[reports.operation <= reports.change]
    found = [
        _rate(f"false {kind}s", (early.score == kind).sum(), watched) for kind in ("alarm", "step")
    ]
    late = reports[reports.operation > reports.change]
    first = late.groupby("life").operation.min()
    changed = lives[lives.faster > 1.0].drop_duplicates("life").set_index("life")
    delay = first.reindex(changed.index) - changed.change
    clear = changed.ratio >= _CLEAR
    for words, which in (("", changed.ratio > 0), (", ratio of 5 or more", clear)):
        found.append(_row(f"found within 3 % of life{words}", delay[which] <= window))
        found.append(_row(f"found{words}", delay[which].notna()))
    return found


def _inside(rows: pd.DataFrame) -> pd.Series:
    """Whether intervals hold the truth; an end that is nan does not."""
    return (rows.lower <= rows.truth) & (rows.truth <= rows.upper)


def _row(score: str, hits: Sequence[bool], quantity: str = "") -> dict:
    """A share with its interval."""
    return _scored(score, quantity, *share(np.asarray(hits)), len(hits))


def _rate(score: str, count: int, watched: float) -> dict:
    """False reports in 10,000 operations; n is the number of operations watched."""
    rate = false_alarms_per(int(count), float(watched)) if watched else (np.nan,) * 3
    return _scored(f"{score} in 10,000 operations", "", *rate, watched)


def _rms(score: str, rows: pd.DataFrame, quantity: str) -> dict:
    """Root mean square error of medians, with two standard errors of the mean square."""
    square = np.square(rows["median"] - rows.truth).to_numpy()
    mean, error = square.mean(), square.std() / np.sqrt(len(square))
    ends = np.sqrt(np.maximum([mean, mean - 1.96 * error, mean + 1.96 * error], 0.0))
    return _scored(score, quantity, *ends.tolist(), len(square))


def _scored(score: str, quantity: str, *values: float) -> dict:
    return {"score": score, "quantity": quantity} | dict(zip(_ENDS, values, strict=True))
