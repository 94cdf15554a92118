"""Steady answers: which limit a decision is about, and by when to service.

One rule for both: what is more urgent is told at once, what is less urgent only after it has been
so for a number of operations, or with a reason: a change or step noticed, an event such as
maintenance, or a limit that is no longer exceeded.

Shapes: ``o`` operations, ``l`` limits.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

__all__ = ["RANKS", "Subject", "service_by", "subject"]

RANKS = ("none", "watch", "doubtful", "plan", "check", "service")
"""How urgent a limit is, the most urgent last."""

_RECORDS = 10  # at least, in which a less urgent answer has to hold
_TOLERANCE = 0.1  # of the operations left, within which two estimates are the same
_SERVICE = RANKS.index("service")


class Subject(NamedTuple):
    """What decisions are about.

    Attributes:
        limit: Index of the limit after each operation, ``(o,)``.
        rank: How urgent it is, index in ``RANKS``, ``(o,)``.
    """

    limit: np.ndarray
    rank: np.ndarray


def subject(
    rank: np.ndarray,
    due: np.ndarray,
    probability: np.ndarray,
    operations: np.ndarray,
    reasons: Sequence[str],
    *,
    hold: int,
) -> Subject:
    """Choose the limit that each decision is about: the most urgent one, steadily.

    One as urgent that is due clearly before it takes its place once it has been so for ``hold``
    operations, or at once if it is due within as many.

    Args:
        rank: How urgent each limit is, ``(o, l)``.
        due: Operation by which to service for each, inf if not known, ``(o, l)``.
        probability: That each is exceeded, which decides between equals, ``(o, l)``.
        operations: Numbers of the operations, ``(o,)``.
        reasons: Why less urgent answers may be told after an operation, empty without, ``(o,)``.
        hold: Operations after which they are told without a reason, if all of them agree.

    Example:
        >>> rank = np.array([[3, 3], [3, 4], [3, 3], [3, 3]])
        >>> due = np.array([[80.0, 90.0], [80, 2], [80, 90], [80, 90]])
        >>> reasons = ["", "", "", "repair"]
        >>> subject(rank, due, 0 * due, np.arange(1, 5), reasons, hold=100).limit.tolist()
        [0, 1, 1, 0]
    """
    limits, ranks = [], []
    told, level, calm, sooner = -1, 0, [], []
    for i, operation in enumerate(operations.tolist()):
        best = int(np.lexsort((-probability[i], due[i], -rank[i]))[0])
        over = level == _SERVICE and rank[i, told] < _SERVICE  # it has a hysteresis of its own
        calm = [*calm, operation] if told >= 0 and rank[i, told] < level else []
        free = told < 0 or bool(reasons[i]) or over or _held(calm, hold)
        free = free or rank[i, best] > level or (rank[i, best] == level > rank[i, told])
        is_sooner = due[i, best] < due[i, told] - _same(due[i, told], operation)
        sooner = [*sooner, operation] if rank[i, best] == level and is_sooner else []
        if free or (sooner and due[i, best] <= operation + hold) or _held(sooner, hold):
            told, level, calm, sooner = best, int(rank[i, best]), [], []
        limits.append(told)
        ranks.append(level)
    return Subject(np.array(limits, dtype=int), np.array(ranks, dtype=int))


def _held(operations: Sequence[int], hold: int) -> bool:
    """Whether an answer held for so many operations, and in records enough."""
    return len(operations) >= _RECORDS and operations[-1] - operations[0] >= hold


def _same(due: float, operation: float) -> float:
    """Operations within which an estimate is the same as ``due``."""
    left = due - operation
    return max(1.0, _TOLERANCE * left) if np.isfinite(left) else 0.0


def service_by(
    estimate: np.ndarray, operations: np.ndarray, reasons: Sequence[str], *, hold: int
) -> tuple[np.ndarray, list[str]]:
    """Return by which operation to service, and why it is later than before where it is.

    It moves earlier at once, beyond a small tolerance. It moves later with a reason, or once all
    estimates of ``hold`` operations were later, to the earliest of the last ten; an estimate that
    is due already never counts as later.

    Args:
        estimate: Operation by which to service as it is estimated, inf without one, ``(o,)``.
        operations: Numbers of the operations, ``(o,)``.
        reasons: As of ``subject``.
        hold: As of ``subject``.

    Returns:
        Operations, inf without one, ``(o,)``, and reasons, empty where it is not later, ``(o,)``.

    Example:
        >>> estimate = np.array([50.0, 70, 30, 90])
        >>> found, why = service_by(estimate, np.arange(1, 5), ["", "", "", "repair"], hold=100)
        >>> found.tolist(), why
        ([50.0, 50.0, 30.0, 90.0], ['', '', '', 'repair'])
    """
    told, later, found, why = np.inf, [], [], []
    for i, (new, operation) in enumerate(zip(estimate.tolist(), operations.tolist(), strict=True)):
        same, reason = _same(told, operation), ""
        is_later = new > max(told, operation) + same
        later = [*later, operation] if is_later else []
        if new < told - same:
            told = new
        elif is_later and (reasons[i] or _held(later, hold)):
            what = "no trend leads to a limit" if math.isinf(new) else "later"
            reason = reasons[i] or f"{what} for {hold} operations"
            told = new if reasons[i] else min(estimate[i - _RECORDS + 1 : i + 1].tolist())
            later = []
        found.append(told)
        why.append(reason)
    return np.array(found), why
