"""How far operations of one drive scatter, and what a mean of few of them is worth."""

from collections.abc import Sequence

import numpy as np

from breaker.drive.family.record_means import beside_usual
from breaker.model.quantities import CURRENTS

# Usual scatter of operations, and how well it is known, as from so many records more than one.
_SCATTER, _KNOWN = 0.004, 4
_PAST = 0.05, 0.002  # of ways past a rest: of themselves, and of the stroke
_BOUNCE = 0.2, 0.3  # of a bounce: of itself, and ms, as it hits another time each time
_CURRENT = 0.02  # of what coils and motors draw, whose voltage varies
PAST_REST = {"over_travel", "rebound"}
"""Ways past a rest, which may be 0."""


def usual_scatter(name: str, value: float, stroke: float) -> float:
    """Return how far a quantity usually scatters from operation to operation, in its unit."""
    if name in PAST_REST:
        return float(np.hypot(*np.multiply(_PAST, (value, stroke))))
    if name == "bounce_time":
        return float(np.hypot(_BOUNCE[0] * value, _BOUNCE[1]))
    return (_CURRENT if name in CURRENTS else _SCATTER) * abs(value)


def visit_error(visits: Sequence[np.ndarray], usual: float) -> float:
    """Return the standard deviation of a mean of readings, or of the difference of two.

    Args:
        visits: Readings of each, and their sds, ``(n, 2)``.
        usual: Scatter of operations that is usual.
    """
    total = 0.0
    for each in visits:
        known = float(np.nan_to_num(np.square(each[:, 1])).mean())
        total += max(known, scattered(visits, usual, known)) / len(each)
    return float(np.sqrt(total))


def scattered(visits: Sequence[np.ndarray], usual: float, known: float) -> float:
    """Return the variance of a reading: as seen in visits, beside what is usual and known of it."""
    seen = sum(len(each) - 1 for each in visits)
    squares = sum(float(np.square(each[:, 0] - each[:, 0].mean()).sum()) for each in visits)
    return beside_usual(squares, seen, known + usual**2, _KNOWN)
