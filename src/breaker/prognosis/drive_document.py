"""One drive of a fleet: what is known of it, as JSON, from which table and page are made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np
from pydantic import TypeAdapter

from breaker.common.plain_values import Plain
from breaker.prognosis.limit_states import STATES

# Where visits were measured differently, or the stroke has changed, which stops of a drive hold to
# far less, the transducer was mounted elsewhere or a ratio changed: then no trend is told.
DIFFERENT = "measured differently"
UNJUDGED = "not judged"  # records can be used, but no limit tells how the drive stands
FLEET_STATES = (STATES[0], STATES[1], UNJUDGED, DIFFERENT, *STATES[2:])
"""States of a drive of a fleet, the most urgent last."""

_SAME = ("breaker", "phase", "type", "state", "last", "operation", "records", "visits", "how")


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


@dataclass(frozen=True)
class DriveChange(Plain):
    """By how much a quantity or parameter has changed: its 5, 50 and 95 % quantiles, percent."""

    name: str
    motion: str
    change: Sequence[float]


def label(name: str, motion: str) -> str:
    """Return the name of a quantity, with its motion where the name does not tell it."""
    return name if motion in name else f"{name} {motion}"


@dataclass(frozen=True, kw_only=True)
class DriveDocument(Plain):
    """What is known of one drive.

    Attributes:
        breaker, phase, type, first, last: Names and dates; empty where they are not known.
        records, visits: How many there are.
        operation: Number of the last one.
        how: "life", "visits", "visit" or "none".
        state: One of ``FLEET_STATES``.
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
        return _reader().validate_json(text)


@cache
def _reader() -> TypeAdapter:
    return TypeAdapter(DriveDocument)


FLEET = {
    "breaker": "name of the breaker",
    "phase": "name of the phase",
    "type": "of the breaker: column type of the table, or the nameplate of its last file",
    "state": "unknown, healthy, plan (a service) or now, as of a single drive; not judged, where "
    "no limit tells; measured differently, where visits were, or a stroke has changed",
    "odd": "parameters in which it is unlike its type; empty without any",
    "evidence": "of the most odd one, nats",
    "due": "limit that is due, or the next one",
    "due_date": "date by which to service, or on which the limit is reached",
    "due_operation": "operation by which to service",
    "operations_left": "operations left, median",
    "failed": "limits that are exceeded",
    "last": "date of the last visit",
    "operation": "number of the last operation",
    "records": "records in the table",
    "visits": "visits, from one to the next at least 30 days",
    "change": "largest measured change since the first visit, percent",
    "change_of": "of which quantity",
    "off_type": "how far it is measured off the median of its type, percent",
    "off_type_of": "in which quantity: that which is farthest off beside the spread of the type",
    "how": "life: followed; visits: first and last compared; visit: judged alone; none: not at all",
    "pole_spread": "largest less least time over the phases of the breaker, ms",
    "pole_spread_of": "closing_time or opening_time, from the trigger; travel_time without these",
    "reason": "why it is where it is, what is measured first",
}
"""First columns of ``fleet.csv``, one row for each phase of a breaker; behind them, of each
parameter, the median and 90 % interval under the prior of the type."""


class Farthest(NamedTuple):
    """The quantity of the last visit farthest off the type: its value, and the type's median."""

    name: str
    motion: str
    value: float
    usual: float


@dataclass(eq=False)
class FleetRow:
    """A drive in the table of a fleet: its document, and how it compares with the others.

    Attributes:
        parameters: Median and ends of the 90 % interval of each, by the column.
        odd, evidence, off: Parameter in which it is unlike its type; evidence for that, nats; by
            which share it is off the median of the type.
        shown: The measured quantity farthest off the type, where there are others of it.
        pole_spread, pole_spread_of: How far the phases of the breaker are apart, ms, and in what.
    """

    document: DriveDocument
    parameters: Mapping[str, float] = field(default_factory=dict)
    odd: str = ""
    evidence: float = np.nan
    off: float = np.nan
    shown: Farthest | None = None
    pole_spread: float = np.nan
    pole_spread_of: str = ""
    reason: str = ""

    @property
    def failed(self) -> str:
        """Names of the limits that are exceeded."""
        return ", ".join(n for n, e in self.document.limits.items() if e in ("fail", "now"))

    def columns(self) -> dict[str, object]:
        """Return the row by column: see ``FLEET``."""
        document, due, shown = self.document, self.document.due, self.shown
        most = max(document.since, key=lambda each: abs(each.change[1]), default=None)
        known = shown is not None and shown.usual
        return {name: getattr(document, name) for name in _SAME} | {
            "odd": self.odd,
            "evidence": self.evidence,
            "due": due.limit or "",
            "due_date": due.date or "",
            "due_operation": np.nan if due.operation is None else due.operation,
            "operations_left": np.nan if due.left is None else due.left,
            "failed": self.failed,
            "change": most.change[1] if most else np.nan,
            "change_of": label(most.name, most.motion) if most else "",
            "off_type": 100.0 * (shown.value / shown.usual - 1.0) if known else np.nan,
            "off_type_of": label(shown.name, shown.motion) if known else "",
            **self.parameters,
            "pole_spread": self.pole_spread,
            "pole_spread_of": self.pole_spread_of,
            "reason": self.reason,
        }
