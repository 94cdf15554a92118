"""The table of decisions: after each operation, what is known, what changed, what to do when.

Combines what is known of every limit (``states``) into one steady answer (``steadiness``): one
action about one limit, and by when.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.actions import code_of, due_of, in_words, rank_of, recent
from breaker.decisions.alarms import latest
from breaker.decisions.changes import changes
from breaker.decisions.columns import ALARMS, DECISIONS, table_of
from breaker.decisions.dates import days_left, days_per_operation, on_date
from breaker.decisions.steadiness import service_by, subject
from breaker.decisions.trust import trust_in_limits
from breaker.decisions.wearing import drifts, wearing, with_measured
from breaker.files import ABOUT, known_about

__all__ = ["dated", "decide"]


def decide(
    judged: xr.Dataset,
    left: xr.Dataset,
    trends: Mapping[str, xr.Dataset],
    curves: Mapping[str, xr.Dataset],
    trust: pd.DataFrame,
    *,
    alarm: Mapping,
    notice: int,
    measured: xr.Dataset | None = None,
) -> pd.DataFrame:
    """Return one row per operation, with the columns ``DECISIONS``.

    Args:
        judged, left: What ``judge`` and ``remaining`` return, for the same operations.
        trends: Whole trends by source, those that limits are read from.
        curves: Results of each motion, with ``accepted`` and ``resolved``.
        trust: What ``trust_table`` returns.
        alarm: The section ``alarm`` of the configuration.
        notice: Operations for which a change or step is worth a look.
        measured: Trends of measured quantities, if limits are on any.
    """
    operations = judged.operation.values
    known = _about(curves, operations)
    followed, noted = with_measured(trends, measured), changes(trends, operations, measured)
    reasons = _reasons(noted, known["event"], judged.exceeded.values)
    due, probability = due_of(judged, alarm["after"]), judged.level_probability.values
    urgent = rank_of(judged, alarm["clear"]), due, probability
    chosen = subject(*urgent, operations, reasons, hold=alarm["hold"])
    by, why = service_by(due.min(axis=1), operations, reasons, hold=alarm["hold"])
    looked, silent = recent(noted, operations, within=notice), _silent(curves, operations, notice)
    worn = wearing(followed, drifts(followed, operations))
    look = [bool(wears or lately) for wears, lately in zip(worn, looked, strict=True)]
    blind = np.isnan(probability).all(axis=1) | (np.array(silent, dtype=str) != "")
    codes, about = zip(chosen.rank, blind, look, strict=True), chosen.rank > 0
    rows, pace = np.arange(len(operations)), days_per_operation(operations, known["date"])
    named = np.where(about, judged.limit.values[chosen.limit], "")
    told = np.where(about[:, None], judged.told.values[rows, chosen.limit], np.nan)
    data = {
        **known,
        "operation": operations,
        "state": judged.drive_state.values,
        "action": [code_of(each, blind=unseen, look=looks) for each, unseen, looks in codes],
        "limit": named,
        "service_by": [pd.NA if np.isinf(each) else int(each) for each in by],
        "service_by_date": on_date(by, operations, known["date"], pace),
        "why": why,
        "exceeded": _exceeded(judged),
        "wearing": worn,
        "change": noted,
        "trust": trust_in_limits(judged, left, named, trust),
        "not_used": _not_used(curves, operations),
    }
    table = table_of(data | _left(told, pace), DECISIONS)
    return table.assign(to_do=in_words(table, probability[rows, chosen.limit], looked, silent))


def dated(alarms: pd.DataFrame, decisions: pd.DataFrame) -> pd.DataFrame:
    """Return alarms and steps with the columns ``ALARMS``: with breaker and dates, where known."""
    known = decisions.set_index("operation")
    about = {"breaker": alarms.from_operation.map(known.breaker)}
    for end in ("from", "to"):
        about[f"{end}_date"] = alarms[f"{end}_operation"].map(known.date)
    return table_of(alarms.assign(**about), ALARMS)


def _left(told: np.ndarray, pace: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of what is left, operations and days, from the quantiles ``(o, 3)``."""
    data = {}
    for suffix, quantile in zip(("_5", "", "_95"), told.T, strict=True):
        data[f"operations_left{suffix}"] = quantile.round()
        data[f"days_left{suffix}"] = days_left(quantile, pace).round(1)
    return data


def _exceeded(judged: xr.Dataset) -> list[str]:
    """Name each exceeded limit with the operation since when, the first one first, ``(o,)``."""
    names = judged.limit.values
    rows = ([j for j in np.argsort(row) if np.isfinite(row[j])] for row in judged.since.values)
    since = judged.since.values.tolist()
    return [
        "; ".join(f"{names[j]} since {row[j]:.0f}" for j in order)
        for row, order in zip(since, rows, strict=True)
    ]


def _reasons(noted: Sequence[str], events: Sequence[str], exceeded: np.ndarray) -> list[str]:
    """Why an answer may become less urgent after an operation, ``(o,)``; empty without a reason."""
    over = np.diff(exceeded.astype(int), axis=0, prepend=exceeded[:1]).min(axis=1) < 0
    cleared = np.where(over, "a limit is no longer exceeded", "")
    every = zip(noted, events, cleared, strict=True)
    # What is noted of an event names it.
    return ["; ".join(filter(None, [told or event, str(over)])) for told, event, over in every]


def _about(curves: Mapping[str, xr.Dataset], operations: np.ndarray) -> dict[str, list]:
    """What is known of each operation, by its name, ``(o,)``.

    Events of all motions and their mean temperature, as trends have them; of anything else, what
    the first motion knows.
    """
    found = {}
    for name in ABOUT:
        known: dict[int, list] = {int(number): [] for number in operations}
        for data in curves.values():
            if name in known_about(data):
                for number, value in zip(data.operation.values, data[name].values, strict=True):
                    if value == value and value != "":
                        known.setdefault(int(number), []).append(value)
        found[name] = [_joined(name, known[int(number)]) for number in operations]
    return found


def _joined(name: str, values: Sequence) -> object:
    """One value of ``ABOUT`` from those of the motions of an operation; empty without any."""
    if name == "temperature":
        return float(np.mean(values)) if values else np.nan
    words = list(dict.fromkeys(map(str, values)))
    return ", ".join(words if name == "event" else words[:1])


def _silent(curves: Mapping[str, xr.Dataset], operations: np.ndarray, notice: int) -> list[str]:
    """Name motions without a usable record for more than ``notice`` operations, ``(o,)``."""
    told = [[] for _ in operations]
    for motion, data in curves.items():
        used = data.operation.values[data.accepted.values & data.resolved.values]
        last = latest(np.isin(operations, used))
        for words, i, operation in zip(told, last, operations, strict=True):
            if operation - operations[max(i, 0)] > notice:
                since = f"since operation {operations[i]:,}" if i >= 0 else "at all"
                words.append(f"no record of {motion} could be used {since}")
    return [", ".join(words) for words in told]


def _not_used(curves: Mapping[str, xr.Dataset], operations: np.ndarray) -> list[str]:
    """Why a record of an operation could not be used, ``(o,)``; empty where all were."""
    told = [[] for _ in operations]
    for motion, data in curves.items():
        known = data[["accepted", "resolved"]].reindex(operation=operations, fill_value=False)
        reasons = np.select(
            [
                ~np.isin(operations, data.operation.values),
                ~known.accepted.values,
                ~known.resolved.values,
            ],
            ["no record", "rejected", "not resolved"],
            default="",
        )
        for words, reason in zip(told, reasons, strict=True):
            words += [f"{motion}: {reason}"] if reason else []
    return ["; ".join(words) for words in told]
