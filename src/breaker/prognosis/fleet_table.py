"""The drives of a fleet in one table: the most urgent first, each compared with its type."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from pydantic import TypeAdapter
from scipy.stats import t as student

from breaker.common.clean_text import bare, usual_spelling
from breaker.common.numerals import first_of
from breaker.common.plain_values import Note, Plain
from breaker.diagnosis.changes import QuantityChange

STATES = ("due", "planned", "unknown", "ok")
"""States of a limit and of a drive, the most urgent first."""

_FALSE = 0.05  # probability that any drive of a type is reported, if all drives vary equally
_NAMED = 2  # remarks in a cell; the JSON of the drive lists all


@dataclass(frozen=True)
class LimitState(Plain):
    """State of a limit, probability that it is exceeded, and time of service; None if unknown."""

    limit: str
    state: str
    p_exceeded: float | None
    service_by: float | None = None
    service_by_date: str | None = None


@dataclass(frozen=True)
class MeasuredValue(Plain):
    """Mean of a measured quantity over the records of an inspection, and its standard deviation."""

    quantity: str
    unit: str
    value: float
    sd: float


@dataclass(frozen=True, kw_only=True)
class DriveResult(Plain):
    """Result for one drive; names and dates are empty if unknown.

    Attributes:
        state: State of the most urgent limit; "unknown" without one.
        operation, rejected: Number of the last operation; unusable records of the last inspection.
        limits: States of the limits, the most urgent first.
        measured, changes: Means in the last inspection, and changes since the first.
        remarks: Reasons and remedies.
    """

    breaker: str
    phase: str
    type: str
    state: str = "unknown"
    first: str
    last: str
    operation: int
    records: int
    inspections: int
    rejected: int = 0
    limits: Sequence[LimitState] = ()
    measured: Sequence[MeasuredValue] = ()
    changes: Sequence[QuantityChange] = ()
    remarks: Sequence[Note] = ()

    def columns(self) -> dict[str, object]:
        """Return the columns of the table that depend on this drive alone."""
        row = {name: value for name, value in vars(self).items() if isinstance(value, str | int)}
        row |= vars(self.limits[0] if self.limits else LimitState("", self.state, None))
        changes = [(item.change[1], item.words) for item in self.changes if item.changed]
        most = max(changes, key=lambda change: abs(change[0]), default=(np.nan, ""))
        remarks = first_of([note.text for note in self.remarks], _NAMED)
        return row | {"most_changed": most[1], "change": most[0], "remarks": remarks}


def read_results(text: str) -> list[DriveResult]:
    """Return the results in a JSON text."""
    return TypeAdapter(list[DriveResult]).validate_json(text)


def fleet_table(drives: Sequence[DriveResult]) -> pd.DataFrame:
    """Return a row for each drive, most urgent first; docs/how-to/fleet.md lists the columns."""
    usual = usual_spelling(drive.type for drive in drives)
    rows = [drive.columns() | {"type": usual[bare(drive.type)]} for drive in drives]
    measured = [
        {"drive": place, "type": rows[place]["type"], **vars(value)}
        for place, drive in enumerate(drives)
        for value in drive.measured
    ]
    table = pd.DataFrame(rows).join(differences_from_type(pd.DataFrame(measured)))
    order = table.assign(state=table.state.map(STATES.index), change=-table.change.abs())
    order = order.sort_values(["state", "service_by_date", "p_value", "change"], kind="stable")
    return table.loc[order.index].reset_index(drop=True)


def differences_from_type(measured: pd.DataFrame) -> pd.DataFrame:
    """Return the measured quantity in which each drive differs most from the others of its type, as
    columns of the table, by drive.

    ``measured`` has rows of ``MeasuredValue`` with ``drive`` and ``type``. The p-value is the
    probability that any quantity of any drive of the type differs as much by chance.
    """
    texts = []
    for _, of_type in measured.groupby("type") if len(measured) else ():
        counts = of_type.groupby("quantity").size()
        for name in counts.index[counts > 2]:
            rows = of_type[of_type.quantity == name].rename(columns={"quantity": "most_different"})
            false = _FALSE / len(counts)
            usual, p = outliers(rows.value.to_numpy(), rows.sd.to_numpy(), false)
            middle = rows.value[usual].median()
            rows = rows.assign(p_value=p * len(counts), differs=p < false, type_median=middle)
            texts.append(rows.assign(difference=100.0 * (rows.value / middle - 1.0)))
    columns = ["most_different", "value", "unit", "type_median", "difference", "p_value", "differs"]
    if not texts:
        return pd.DataFrame(columns=columns)
    first = pd.concat(texts).sort_values("p_value").drop_duplicates("drive").set_index("drive")
    return first.assign(p_value=first.p_value.clip(upper=1.0))[columns]


def outliers(values: np.ndarray, sds: np.ndarray, false: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which of three or more values are usual, and p-values of their distances from usual
    values, ``(n,)``: the generalised ESD test (Rosner 1983) of level ``false``. The farthest values
    are removed one by one, and all up to the last significant one are outliers, so that outliers
    do not hide each other.
    """
    kept = usual = np.ones(len(values), dtype=bool)
    while kept.sum() > len(values) - len(values) // 4:  # more would double the false alarms
        p = _chances(values, sds, kept)
        worst = np.where(kept, p, np.inf).argmin()
        kept = kept & (np.arange(len(values)) != worst)
        usual = kept if p[worst] < false else usual
    return usual, _chances(values, sds, usual)


def _chances(values: np.ndarray, sds: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return the probability that any value is as far from the other kept values, ``(n,)``."""
    x, others = values - np.median(values), kept.sum() - kept
    mean = (x[kept].sum() - kept * x) / others
    squares = np.square(x[kept]).sum() - kept * np.square(x) - others * np.square(mean)
    variance = np.maximum(squares, 0.0) / (others - 1) * (1.0 + 1.0 / others)
    t = np.abs(x - mean) / np.sqrt(variance + np.square(sds))
    return 2.0 * len(x) * student.sf(t, others - 1)
