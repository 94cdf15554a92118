"""What to do: how urgent each limit is, the code of an action, and the action in words."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from breaker.decisions.states import MAY_BE
from breaker.decisions.steadiness import RANKS
from breaker.decisions.wording import in_percent, span

__all__ = ["ACTIONS", "code_of", "due_of", "in_words", "rank_of", "recent"]

ACTIONS = {
    "none": "go on",
    "watch": "go on, and look at what wears or has changed",
    "plan": "plan a service, by the operation of `service_by`",
    "check": "measure: the limit may be exceeded already, which the curves cannot tell",
    "service": "service now: the limit is exceeded",
}
"""Codes of actions and their meaning, the most urgent last."""


def rank_of(judged: xr.Dataset, likely: float) -> np.ndarray:
    """Return how urgent each limit is after each operation, index in ``RANKS``, ``(o, l)``.

    Args:
        judged: What ``judge`` returns.
        likely: Probability from which a limit without a trend counts before those with one.
    """
    state, probability = judged.state.values, judged.level_probability.values
    early = judged.told.values[..., 0]
    may_be = probability >= MAY_BE
    conditions = {
        "service": state == "now",
        "check": may_be & ~np.isnan(early) | (probability >= likely),
        "plan": state == "plan",
        "doubtful": may_be,
        "watch": state == "drifting",
    }
    ranks = [RANKS.index(name) for name in conditions]
    return np.select(list(conditions.values()), ranks, default=0)


def due_of(judged: xr.Dataset, after: int) -> np.ndarray:
    """Return by which operation to service for each limit, inf if not known, ``(o, l)``.

    The 5 % quantile of its remaining life, the latest of so many operations in a row: one odd
    record, with which a change seems possible, makes nothing urgent. Where a limit is exceeded,
    since when it is.
    """
    due = judged.operation.values[:, None] + judged.told.values[..., 0]
    due = np.floor(np.where(np.isnan(due), np.inf, due))
    before = np.concatenate([np.full((after - 1, due.shape[1]), -np.inf), due])
    due = np.lib.stride_tricks.sliding_window_view(before, after, axis=0).max(axis=-1)
    return np.where(judged.exceeded.values, judged.since.values, due)


def recent(noted: Sequence[str], operations: np.ndarray, *, within: float) -> list[str]:
    """Return what was last noted, at most so many operations before, ``(o,)``; empty without.

    Changes that later ones took back are left out.

    >>> recent(["", "step", "", ""], np.array([1, 2, 3, 9]), within=5)
    ['', 'step', 'step', '']
    """
    told, when, last = [], -np.inf, ""
    for operation, words in zip(operations, noted, strict=True):
        if valid := [each for each in words.split("; ") if each and "took back" not in each]:
            when, last = operation, "; ".join(valid)
        told.append(last if operation <= when + within else "")
    return told


def code_of(rank: int, *, blind: bool, look: bool) -> str:
    """Return the code of an action, one of ``ACTIONS``.

    Args:
        rank: How urgent its limit is, index in ``RANKS``.
        blind: Whether nothing is known of any limit, or a motion has no usable records any more.
        look: Whether a parameter wears, or something has changed of late.
    """
    name = RANKS[rank]
    if name == "doubtful" or (blind and name == "none"):
        return "check"
    return "watch" if name == "none" and look else name


def in_words(
    table: pd.DataFrame,
    probability: Sequence[float],
    looked: Sequence[str],
    silent: Sequence[str],
) -> list[str]:
    """Return the action of each row in words.

    Args:
        table: Rows with the columns ``DECISIONS``, ``to_do`` still empty.
        probability: That the level is beyond the limit of the row, ``(o,)``.
        looked: What has changed of late, ``(o,)``.
        silent: Motions without usable records of late, ``(o,)``.
    """
    every = zip(table.itertuples(), probability, looked, silent, strict=True)
    return [_words(*each) for each in every]


def _words(row, probability: float, changed: str, silent: str) -> str:
    """Describe one action."""
    lately = "".join(f"; {each}" for each in (changed, silent) if each)
    known = row.operations_left_5 == row.operations_left_5
    left = f"{span(row.operations_left_5, row.operations_left_95)} operations left"
    if row.action == "service":
        every = [each.rsplit(" since ", 1) for each in row.exceeded.split("; ")]
        terms = [" exceeded since operation ", *[" since "] * (len(every) - 1)]
        words = [f"{each}{term}{int(at):,}" for (each, at), term in zip(every, terms, strict=True)]
        return f"service now: {', '.join(words)}{lately}"
    if row.action == "check" and not row.limit:
        why = "; ".join(filter(None, [silent or "no limit can be told from them yet", changed]))
        return f"check the records: {why}"
    by = "" if row.service_by is pd.NA else f"service by operation {row.service_by:,}"
    if row.action == "check":
        also = left if known else by  # before another limit
        words = f"check {row.limit}: it may be exceeded already ({in_percent(probability)})"
        return "; ".join(filter(None, [words, also])) + lately
    if row.action == "plan":
        on = f" ({row.service_by_date})" if row.service_by_date else ""
        within = left if known else "no trend leads there now"
        return f"plan {by or 'service'}{on}, before {row.limit} ({within}){lately}"
    if row.action == "watch":
        limit = f"{row.limit}: a trend leads there beyond the horizon" if row.limit else ""
        return f"watch {'; '.join(filter(None, [limit, row.wearing, changed, silent]))}"
    return "go on"
