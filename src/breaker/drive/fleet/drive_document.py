"""One drive of a fleet: what is known of it, as one document.

A job writes it, as JSON; table and page of the fleet are made from it.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from breaker.common.plain_values import Plain


@dataclass(frozen=True)
class Due(Plain):
    """What is due: limit, date and operation, and operations left; None where it is not known."""

    limit: str | None = None
    date: str | None = None
    operation: float | None = None
    left: float | None = None


class Shown(NamedTuple):
    """A number of a quantity of the last visit."""

    name: str
    motion: str
    value: float

    @property
    def label(self) -> str:
        """Name of the quantity, with its motion where the name does not tell it."""
        return label(self.name, self.motion)


@dataclass(frozen=True)
class DriveChange(Plain):
    """By how much a quantity or parameter has changed: its 5, 50 and 95 % quantiles, percent."""

    name: str
    motion: str
    change: Sequence[float]

    @property
    def label(self) -> str:
        """Name of the quantity, with its motion where the name does not tell it."""
        return label(self.name, self.motion)


def label(name: str, motion: str) -> str:
    """Return the name of a quantity, with its motion where the name does not tell it."""
    return name if motion in name else f"{name} {motion}"


@dataclass(frozen=True, kw_only=True)
class DriveDocument(Plain):
    """What is known of one drive.

    Attributes:
        breaker, phase, type: Names; empty where they are not known.
        records, visits: How many there are.
        operation: Number of the last one.
        first, last: Dates; empty where they are not known.
        how: "life", "visits", "visit" or "none".
        state: One of ``FLEET_STATES``.
        due: What is due; None without any.
        limits: Verdicts or states, by name.
        differences: How visits were measured differently.
        changed: What has changed for sure.
        since: The change of all that is measured since the first visit.
        trust: Why something is not told.
        rejected: Reasons.
        measured: Values of the last visit.
        zones: Of speeds, by name.
        spread: Of values of the last visit, sd in percent.
        family, p_value: Of drives that it is like; "" and None where nothing was inferred.
        file: A record.
    """

    breaker: str
    phase: str
    type: str
    records: int
    visits: int
    operation: int
    first: str
    last: str
    how: str = "none"
    state: str = "unknown"
    due: Due = field(default_factory=Due)
    limits: Mapping[str, str] = field(default_factory=dict)
    differences: Sequence[str] = ()
    changed: Sequence[DriveChange] = ()
    since: Sequence[DriveChange] = ()
    trust: Sequence[str]
    rejected: Sequence[str]
    measured: Sequence[Shown]
    zones: Mapping[str, str]
    spread: Sequence[Shown]
    family: str
    p_value: float | None
    file: str

    @classmethod
    def from_json(cls, text: str) -> "DriveDocument":
        """Read a document as ``to_json`` writes it."""
        found = json.loads(text)
        of = {"changed": _change_of, "since": _change_of, "measured": Shown._make}
        of |= {"spread": Shown._make}
        found |= {name: [read_row(row) for row in found[name]] for name, read_row in of.items()}
        return cls(**found | {"due": Due(**found["due"])})


def _change_of(values: Mapping) -> DriveChange:
    return DriveChange(**values)
