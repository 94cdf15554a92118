"""Limits on the state of the drive: in words, exceeded or not, and how probably.

A limit has parts, each a quantity above or below a value; it is exceeded where all of them hold.
Its quantities are those of the model at inferred parameters, or those read from the record itself.
Measured quantities have normal errors, which are taken for independent of each other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from breaker.mechanism.quantities import SOURCES, check_quantity, evaluate, quantities
from breaker.mechanism.speeds import SPEEDS, Speed

__all__ = ["Limit", "from_list"]

_LEAST = 1e-12  # least error of a measured value, in its unit


@dataclass(frozen=True)
class Limit:
    """A named condition on the state of the drive.

    Attributes:
        name: Its name in the configuration.
        motion: Motion whose quantities it is about.
        parts: (quantity, value, whether it holds above the value rather than below), at least one.
        speeds: How speeds are defined.
        of: What its quantities are read from, one of ``SOURCES``: "model", inferred parameters,
            "record", the record itself, or "change", changes of parameters in percent.
        since: What changes are from: "new", or the last known "event".

    Example:
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
    speeds: tuple[Speed, ...] = SPEEDS
    of: str = "model"
    since: str = "new"

    def __post_init__(self) -> None:
        names = dict.fromkeys(self.quantities)
        place = self.motion, self.speeds, self.of
        if self.of not in SOURCES:
            wrong = [f"of is {self.of}. Set it to {' or '.join(SOURCES)}."]
        elif not self.motion and self.of != "change":
            wrong = ["it has no motion. Set it to closing or opening."]
        else:
            wrong = [text for name in names if (text := check_quantity(name, *place))]
        bounds = {(name, is_upper): value for name, value, is_upper in self.parts}
        for name in names:
            above, below = bounds.get((name, True), -np.inf), bounds.get((name, False), np.inf)
            if above >= below:
                wrong.append(
                    f"{name} cannot be above {above:g} and below {below:g} at once. "
                    "Make two limits, or swap the values."
                )
        if not names:
            wrong.append("it has no quantity. Name one under upper or lower, with a value.")
        if wrong:
            raise ValueError(f"{self.name}: {' '.join(wrong)}")

    @classmethod
    def from_settings(cls, entry: Mapping[str, Any], speeds: tuple[Speed, ...] = SPEEDS) -> "Limit":
        """Build a limit from an entry of the list ``limits`` of the configuration.

        Raises:
            ValueError: If it has no quantity, one that its motion does not have, or one whose two
                bounds exclude each other.
        """
        parts = (
            (quantity, float(str(value).removesuffix("%")), side == "upper")
            for side in ("upper", "lower")
            for quantity, value in entry.get(side, {}).items()
        )
        about = entry.get("of", "model"), entry.get("since", "new")
        return cls(entry["name"], entry.get("motion", ""), tuple(parts), speeds, *about)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the parts, in their order."""
        return tuple(quantity for quantity, _, _ in self.parts)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of ``quantities``."""
        if self.of == "change":
            return ("%",) * len(self.parts)
        every = quantities(self.speeds)
        return tuple(every[name].unit for name in self.quantities)

    def evaluate(self, theta: np.ndarray) -> np.ndarray:
        """Return the quantities of the parts of parameter sets, ``(n, p) -> (n, parts)``.

        Raises:
            ValueError: If the limit is about measured quantities, which parameters do not give.
        """
        if self.of != "model":
            raise ValueError(f"{self.name} is about what records show, not about parameters")
        return evaluate(self.quantities, theta, self.motion, self.speeds)

    @property
    def words(self) -> str:
        """The condition in words: "touch_time above 10 ms", "measured stroke below 9 mm"."""
        read = {"record": "measured ", "change": "change of "}.get(self.of, "")
        form = "+g" if self.of == "change" else "g"
        words = " and ".join(
            f"{read}{name} {'above' if is_upper else 'below'} {value:{form}}"
            + (f" {unit}" if unit != "1" else "")
            for (name, value, is_upper), unit in zip(self.parts, self.units, strict=True)
        )
        return f"{words} since the last event" if self.since == "event" else words

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

    def measured_exceedance(self, values: ArrayLike, sds: ArrayLike) -> np.ndarray:
        """Return how probably measured values are beyond the limit, ``(..., parts) -> (...)``.

        Args:
            values: Measured quantities of the parts; nan where a record does not show one, and
                then the result is nan, too.
            sds: Standard deviations of their errors, which are normal, and independent of those of
                other quantities.

        Example:
            >>> limit = Limit("slow", "closing", (("travel_time", 10.0, True),), of="record")
            >>> limit.measured_exceedance([[9.9], [10.0]], [[0.1], [0.1]]).round(2)
            array([0.16, 0.5 ])
        """
        from scipy.special import ndtr

        values, sds = (np.asarray(each, dtype=np.float64) for each in (values, sds))
        holds = ndtr(self.excess(values) / np.maximum(sds, _LEAST))
        # Two bounds of one quantity: it is between them, or beyond one of them, never beyond both.
        names = np.array(self.quantities)
        shares = [
            holds[..., names == name].sum(axis=-1) - (np.sum(names == name) - 1)
            for name in dict.fromkeys(self.quantities)
        ]
        return np.prod(shares, axis=0)


def from_list(
    entries: Sequence[Mapping[str, Any]],
    motions: Sequence[str],
    speeds: tuple[Speed, ...] = SPEEDS,
    of: Sequence[str] = SOURCES,
) -> list[Limit]:
    """Return the limits of the section ``limits`` that are of these motions, in its order.

    Args:
        of: What the quantities of these limits are read from, some of ``SOURCES``.
    """
    limits = (
        Limit.from_settings(each, speeds)
        for each in entries
        if each.get("motion") in (*motions, None)
    )
    return [limit for limit in limits if limit.of in of]
