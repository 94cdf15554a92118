"""What is followed in a life, and what is then known of it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Block(NamedTuple):
    """Coordinates that are seen together, independent, in units of their scatter.

    Attributes:
        values: ``(o, k)``; rows of nan where there is no record.
        variance: Of the changes that drives of the family make, ``(k,)``, the largest first.
        sought: Whether changes are looked for in them, and records weighed by them.
    """

    values: np.ndarray
    variance: np.ndarray
    sought: bool = True


class Change(NamedTuple):
    """A change of the path.

    Attributes:
        noticed: Index of the operation at which it was.
        start: Index of the first operation after it,
        earliest, latest: and within which indices it lies by 90 %.
        kind: ``"rate"`` of the wear, or its direction, ``"step"``, or ``"event"``, known work.
        evidence: How much better it explains the records than none, nats; below 0 it was taken
            back.
        transducer: Whether what it moved is no change of the drive.
    """

    noticed: int
    start: int
    earliest: int
    latest: int
    kind: str
    evidence: float
    transducer: bool = False


@dataclass(frozen=True)
class Path:
    """What is known after each operation, of all blocks' coordinates side by side, ``(o, k)``.

    Attributes:
        change, variance: Change since new, mean and variance; nan before the reference is full.
        since, since_variance: The same since the last known event; nan before one.
        rate, rate_variance: Of the change, per operation.
        covariance: Of change and rate.
        bend, bend_variance: Of the rate, per operation.
        evidence: For a change that is not noticed yet, nats, ``(o,)``; nan where none is sought.
        weight: Of the record beside one that follows the path, ``(o,)``; nan without one.
        changes: Changes that were noticed.
    """

    change: np.ndarray
    variance: np.ndarray
    since: np.ndarray
    since_variance: np.ndarray
    rate: np.ndarray
    rate_variance: np.ndarray
    covariance: np.ndarray
    bend: np.ndarray
    bend_variance: np.ndarray
    evidence: np.ndarray
    weight: np.ndarray
    changes: tuple[Change, ...]
