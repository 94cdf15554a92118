"""Which limits are exceeded: how probably, by one record."""

from collections.abc import Sequence

import numpy as np

from breaker.answers.answer import NOTHING, Answer
from breaker.mechanism import Limit
from breaker.model import generator

__all__ = ["VERDICTS", "judged"]

VERDICTS = ("unknown", "healthy", "in doubt", "not healthy")
"""Verdicts on a record, the worst last."""

_LEVELS = 0.05, 0.95  # probabilities, from which a limit is in doubt, and exceeded


def judged(answer: Answer, limits: Sequence[Limit], *, seed: int) -> list[dict]:
    """Return how probably a record exceeds each limit of its motion, and the verdict.

    Parameters and the time of touch or parting are judged by their draws; all else as measured,
    with normal errors. A limit ``of: record`` takes only what the record shows by itself; one
    ``of: change`` is of no single record. From 95 % on a limit is exceeded, from 5 % on in doubt.
    """
    motion = answer.record.motion
    limits = [each for each in limits if each.motion == motion and each.of != "change"]
    if answer.record.reason or not limits:
        return []
    rows = []
    for limit in limits:
        probability = _probability(answer, limit, seed)
        verdict = VERDICTS[0]
        if np.isfinite(probability):
            verdict = VERDICTS[1 + sum(probability >= level for level in _LEVELS)]
        row = {"name": limit.name, "words": limit.words}
        rows.append(row | {"probability": probability, "verdict": verdict})
    return rows


def _probability(answer: Answer, limit: Limit, seed: int) -> float:
    """Probability that a limit is exceeded; nan where the record does not tell."""
    names, alone = limit.quantities, limit.of == "record"
    measured = [answer.measured.get(name, NOTHING) for name in names]
    values, sds = np.array([(each.value, each.sd) for each in measured]).T
    if (alone or answer.unresolved) and not all(map(answer.alone, names)):
        return np.nan
    if alone or not any(map(answer.is_inferred, names)):
        return float(limit.measured_exceedance(values, sds))
    if answer.draws is None or answer.unresolved:
        return np.nan
    rng = generator(seed, "limit", limit.name, answer.record.operation.number)
    draws = values + sds * rng.standard_normal((len(answer.draws.theta), len(names)))
    for k, name in enumerate(names):
        if answer.is_inferred(name):
            draws[:, k] = answer.inferred(name)
    return float(limit.exceeded(draws).mean()) if np.isfinite(draws).all() else np.nan
