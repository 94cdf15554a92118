"""Limits on the state of the drive: in words, exceeded or not, how probably, and the alarm.

A limit has parts, each a quantity above or below a value; it is exceeded where all of them hold.
The probability that it is comes from draws of the full posterior. Beside it stands the product
over its quantities of the probability of each, which is what marginals alone would say.

Shapes: ``o`` operations, ``d`` draws, ``l`` limits.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from breaker.mechanism.quantities import QUANTITIES, check_quantity

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "Exceedance",
    "Hysteresis",
    "Limit",
    "alarms",
    "first",
    "from_list",
    "table",
]

_SIDES = {"upper": "above", "lower": "below"}


class Exceedance(NamedTuple):
    """Probabilities that a limit is exceeded, ``(...)``.

    Attributes:
        joint: Share of the draws in which all parts hold.
        marginal: Product over the quantities of the share of draws in which the parts of each hold.
        undefined: Share of the draws in which a quantity of the limit does not exist; they
            count as beyond it.
    """

    joint: np.ndarray
    marginal: np.ndarray
    undefined: np.ndarray


@dataclass(frozen=True)
class Limit:
    """A named condition on the state of the drive.

    Attributes:
        name: Its name in the configuration.
        motion: Motion whose quantities it is about.
        parts: (quantity, value, whether it holds above the value rather than below), at least one.

    >>> entry = {"name": "slow", "motion": "closing", "upper": {"touch_time": 10}}
    >>> limit = Limit.from_settings(entry)
    >>> limit.words
    'touch_time above 10 ms'
    >>> limit.exceeded([[9.9], [10.1]])
    array([False,  True])
    """

    name: str
    motion: str
    parts: tuple[tuple[str, float, bool], ...]

    def __post_init__(self) -> None:
        wrong = [check_quantity(quantity, self.motion) for quantity, _, _ in self.parts]
        above, below = (
            {quantity: value for quantity, value, is_upper in self.parts if is_upper == side}
            for side in (True, False)
        )
        wrong += [
            f"{name} cannot be above {value:g} and below {below[name]:g} at once. Make two limits, "
            "or swap the values."
            for name, value in above.items()
            if name in below and value >= below[name]
        ]
        if not self.parts:
            wrong.append("it has no quantity. Name one under upper or lower, with a value.")
        if any(wrong):
            texts = " ".join(dict.fromkeys(filter(None, wrong)))
            raise ValueError(f"{self.name}: {texts}")

    @classmethod
    def from_settings(cls, entry: Mapping[str, Any]) -> "Limit":
        """Build a limit from an entry of the list ``limits`` of the configuration.

        Raises:
            ValueError: If it has no quantity, one that its motion does not have, or one that would
                have to be above and below what excludes each other.
        """
        parts = (
            (quantity, float(value), side == "upper")
            for side in _SIDES
            for quantity, value in entry.get(side, {}).items()
        )
        return cls(entry["name"], entry["motion"], tuple(parts))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the parts, in their order."""
        return tuple(quantity for quantity, _, _ in self.parts)

    @property
    def words(self) -> str:
        """The condition in words, such as "touch_time above 10 ms"."""
        return " and ".join(
            f"{quantity} {_SIDES['upper' if is_upper else 'lower']} {_with_unit(quantity, value)}"
            for quantity, value, is_upper in self.parts
        )

    def excess(self, values: ArrayLike) -> np.ndarray:
        """Return how far values are beyond the limit, ``(..., parts) -> (..., parts)``.

        In the units of the quantities: positive where a part holds, nan where a value is nan.
        """
        values = np.asarray(values, dtype=np.float64)
        if values.shape[-1:] != (len(self.parts),):
            raise ValueError(f"{self.name} needs values (..., {len(self.parts)}): {self.words}")
        bounds = np.array([value for _, value, _ in self.parts])
        signs = np.array([1.0 if is_upper else -1.0 for _, _, is_upper in self.parts])
        return signs * (values - bounds)

    def exceeded(self, values: ArrayLike) -> np.ndarray:
        """Say where all parts hold, ``(..., parts) -> (...)``.

        A quantity that does not exist, nan, is beyond any limit: the contact does not touch.
        """
        return np.all(~(self.excess(values) <= 0), axis=-1)

    def exceedance(self, values: ArrayLike) -> Exceedance:
        """Return how probably the limit is exceeded, ``(..., d, parts) -> (...)``.

        Args:
            values: The quantities of the limit in draws of a posterior, nan where they do not
                exist, which is beyond any limit.

        Raises:
            ValueError: If there is no draw, or a shape does not fit.
        """
        excess = self.excess(values)
        if excess.ndim < 2 or excess.shape[-2] == 0:
            raise ValueError(f"{self.name}: a probability needs draws")
        holds = ~(excess <= 0)
        undefined = np.isnan(excess).any(axis=-1).mean(axis=-1)
        names = np.array(self.quantities)
        shares = [
            holds[..., names == name].all(axis=-1).mean(axis=-1)
            for name in dict.fromkeys(self.quantities)
        ]
        return Exceedance(holds.all(axis=-1).mean(axis=-1), np.prod(shares, axis=0), undefined)


@dataclass(frozen=True)
class Hysteresis:
    """An alarm after some operation: with the next probability it steps to the next.

    It goes on after ``after`` usable operations in a row with a probability of at least
    ``raise_at``, and off after as many with one of at most ``clear_at``. An operation without a
    probability (nan) neither counts nor breaks the row.

    Attributes:
        raise_at, clear_at: Probabilities, the first not below the second.
        after: Number of operations in a row.
        active: Whether the alarm is on.
        count: Length of the row so far that would change it.
    """

    raise_at: float
    clear_at: float
    after: int
    active: bool = False
    count: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.clear_at <= self.raise_at <= 1:
            raise ValueError("an alarm needs 0 <= clear <= raise <= 1")
        if not (self.after >= 1 and 0 <= self.count < self.after):
            raise ValueError("an alarm needs after >= 1, and a count from 0 to below it")

    def step(self, probability: float) -> "Hysteresis":
        """Return the alarm after one more operation.

        Raises:
            ValueError: If the probability is neither nan nor from 0 to 1.
        """
        if np.isnan(probability):
            return self
        if not 0 <= probability <= 1:
            raise ValueError(f"a probability must be from 0 to 1, not {probability}")
        toward = probability <= self.clear_at if self.active else probability >= self.raise_at
        count = self.count + 1 if toward else 0
        if count == self.after:
            return replace(self, active=not self.active, count=0)
        return replace(self, count=count)

    def follow(self, probability: ArrayLike) -> tuple[np.ndarray, "Hysteresis"]:
        """Step through probabilities ``(o,)``; return where it is on, ``(o,)``, and the last."""
        state, active = self, []
        for each in np.asarray(probability, dtype=np.float64).tolist():
            state = state.step(each)
            active.append(state.active)
        return np.array(active, dtype=bool), state


def alarms(probability: ArrayLike, *, raise_at: float, clear_at: float, after: int) -> np.ndarray:
    """Return where the alarm of a new series is on, ``(o,) -> (o,)`` of bool: see `Hysteresis`."""
    return Hysteresis(raise_at, clear_at, after).follow(probability)[0]


def first(active: ArrayLike, operations: ArrayLike) -> float:
    """Return the number of the first operation with the alarm on, ``(o,), (o,)``; nan if none."""
    on = np.flatnonzero(active)
    return float(np.asarray(operations)[on[0]]) if on.size else math.nan


def table(
    limits: Sequence[Limit], operations: ArrayLike, active: ArrayLike, probability: ArrayLike
) -> "pd.DataFrame":
    """Return the alarms as a table, one row for each time one was raised.

    Args:
        limits: The limits, ``l`` of them.
        operations: Numbers of the operations, ``(o,)``.
        active: Whether an alarm is on, ``(o, l)``.
        probability: Probability of each limit, ``(o, l)``.

    Returns:
        Columns ``limit``, ``words``, ``motion``, ``from_operation`` and ``to_operation``, the
        first and last operation with the alarm on, the latter empty if it is still on, and
        ``highest_probability`` in between (nan if no operation there is usable).
    """
    import pandas as pd  # here: limits are checked by all that never makes a table

    operations, active = np.asarray(operations), np.asarray(active, dtype=bool)
    probability = np.asarray(probability, dtype=np.float64)
    shape = (len(operations), len(limits))
    if active.shape != shape or probability.shape != shape:
        raise ValueError(f"active and probability must have the shape (o, l) = {shape}")
    rows = []
    for limit, on, p in zip(limits, active.T, probability.T, strict=True):
        changes = np.flatnonzero(np.diff(on, prepend=False, append=False))
        for begin, end in changes.reshape(-1, 2).tolist():
            last = operations[end - 1] if end < len(on) else pd.NA
            highest = np.fmax.reduce(p[begin:end])
            rows.append((limit.name, limit.words, limit.motion, operations[begin], last, highest))
    columns = {"limit": str, "words": str, "motion": str}
    columns |= {"from_operation": "Int64", "to_operation": "Int64", "highest_probability": float}
    return pd.DataFrame(rows, columns=list(columns)).astype(columns)


def from_list(entries: Sequence[Mapping[str, Any]], motions: Sequence[str]) -> list[Limit]:
    """Return the limits of the section ``limits`` that are of these motions, in its order."""
    return [Limit.from_settings(entry) for entry in entries if entry["motion"] in motions]


def _with_unit(quantity: str, value: float) -> str:
    unit = QUANTITIES[quantity].unit
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"
