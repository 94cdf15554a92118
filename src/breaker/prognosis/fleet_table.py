"""The drives of a fleet in one table: the most urgent first, each beside its type."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from pydantic import TypeAdapter
from scipy.stats import t as student

from breaker.common.document import Cell, Document, Table
from breaker.common.numerals import first_of
from breaker.common.plain_values import Note, Plain
from breaker.common.text import bare, usual_spelling
from breaker.diagnosis.changes import QuantityChange

TONES = {"due": "bad", "planned": "doubt", "unknown": "doubt", "ok": "good"}
"""Tone of each state of a limit and of a drive, the most urgent state first."""

_FALSE = 0.01  # chance that any drive of a type is said to differ, if all of them vary alike
_NAMED = 2  # remarks in a cell; the JSON of the drive has all


@dataclass(frozen=True)
class LimitState(Plain):
    """State of a limit, probability that it is exceeded, and when to service; None if unknown."""

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
    """Knowledge of one drive.

    Attributes:
        breaker, phase, type, first, last: Names, and dates of inspections; empty where unknown.
        state: State of the most urgent limit; "unknown" without one.
        operation, records, inspections: Number of the last operation; counts.
        rejected: Number of records of the last inspection that cannot be used.
        limits: States of the limits, the most urgent first.
        measured: Measured values of the last inspection.
        changes: Changes since the first inspection.
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
        row = {name: each for name, each in vars(self).items() if isinstance(each, str | int)}
        row |= vars(self.limits[0] if self.limits else LimitState("", self.state, None))
        changes = [(e.change[1], label(e.name, e.motion)) for e in self.changes if e.changed]
        most, name = max(changes, key=lambda change: abs(change[0]), default=(np.nan, ""))
        row |= {"most_changed": name, "change": most}
        return row | {"remarks": first_of([note.text for note in self.remarks], _NAMED)}


def read_results(text: str) -> list[DriveResult]:
    """Return the results in a JSON text."""
    return TypeAdapter(list[DriveResult]).validate_json(text)


def label(name: str, motion: str) -> str:
    """Return the name of a quantity, after its motion unless the name contains it."""
    return name if motion in name else f"{motion} {name}"


def fleet_table(drives: Sequence[DriveResult]) -> pd.DataFrame:
    """Return a row for each drive, the most urgent first; docs/usage.md explains the columns."""
    usual = usual_spelling(drive.type for drive in drives)
    rows = [drive.columns() | {"type": usual[bare(drive.type)]} for drive in drives]
    measured = [
        {"drive": place, "type": rows[place]["type"], **vars(value)}
        for place, drive in enumerate(drives)
        for value in drive.measured
    ]
    table = pd.DataFrame(rows).join(differences_from_type(pd.DataFrame(measured)))
    urgency = table.assign(
        state=table.state.map([*TONES].index), change=-table.change.abs().fillna(0.0)
    )
    by = ["state", "service_by_date", "p_value", "change", "breaker", "phase"]
    return table.loc[urgency.sort_values(by, kind="stable").index].reset_index(drop=True)


def differences_from_type(measured: pd.DataFrame) -> pd.DataFrame:
    """Return the measured quantity in which each drive differs most from the others of its type, as
    columns of the table, by drive.

    ``measured`` has rows of ``MeasuredValue`` with ``drive`` and ``type``. The p-value is the
    chance that any quantity of any drive of the type differs as much, if all drives vary alike.
    """
    found = []
    for _, own in measured.groupby("type") if len(measured) else ():
        counts = own.groupby("quantity").size()
        for name in counts.index[counts > 2]:
            some, count = own[own.quantity == name], len(counts)
            usual, p = outliers(some.value.to_numpy(), some.sd.to_numpy(), _FALSE / count)
            middle = some.value[usual].median()
            some = some.assign(type_median=middle, p_value=p * count, differs=p * count < _FALSE)
            found.append(some.assign(difference=100.0 * (some.value / middle - 1.0)))
    columns = ["most_different", "value", "unit", "type_median", "difference", "p_value", "differs"]
    if not found:
        return pd.DataFrame(columns=columns)
    first = pd.concat(found).sort_values("p_value").drop_duplicates("drive").set_index("drive")
    return first.assign(most_different=first.quantity, p_value=first.p_value.clip(upper=1.0))[
        columns
    ]


def outliers(values: np.ndarray, sds: np.ndarray, false: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which of three or more values are usual, and the chance that any of as many normal
    values is as far from the usual ones as each, ``(n,)``.

    By the generalised ESD test (Rosner 1983) of level ``false``: the farthest values are removed
    one after the other, and all up to the last significant one are outliers, so that several do not
    hide each other.

    >>> values = np.array([10.0, 10.1, 9.9, 10.05, 9.95, 10.02, 9.97, 12.0, 12.1])
    >>> np.flatnonzero(~outliers(values, np.full(9, 0.01), 0.01)[0]).tolist()
    [7, 8]
    """
    kept = usual = np.ones(len(values), dtype=bool)
    while kept.sum() > len(values) - len(values) // 4:  # more would double the false alarms
        p = _chances(values, sds, kept)
        worst = np.where(kept, p, np.inf).argmin()
        kept = kept & (np.arange(len(values)) != worst)
        usual = kept if p[worst] < false else usual
    return usual, _chances(values, sds, usual)


def _chances(values: np.ndarray, sds: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return the chance that any value is as far from the kept other ones, ``(n,)``."""
    x, others = values - np.median(values), kept.sum() - kept
    mean = (x[kept].sum() - kept * x) / others
    squares = np.square(x[kept]).sum() - kept * np.square(x) - others * np.square(mean)
    variance = np.maximum(squares, 0.0) / np.maximum(others - 1, 1) * (1.0 + 1.0 / others)
    t = np.abs(x - mean) / np.sqrt(variance + np.square(sds))
    return 2.0 * len(x) * student.sf(t, np.maximum(others - 1, 1))


def fleet_document(table: pd.DataFrame) -> Document:
    """Return the table of a fleet as a page; ``fleet.csv`` has further columns."""
    shown = ["breaker", "phase", "type", "last", "state", "limit", "service_by_date"]
    shown += ["most_changed", "change", "most_different", "difference", "differs", "remarks"]
    texts = table[shown].map(lambda cell: f"{cell:.3g}" if isinstance(cell, float) else cell)
    texts = texts.where(table[shown].notna(), "").astype(str)
    rows = [[Cell(cell, TONES.get(cell, "")) for cell in row] for row in texts.to_numpy()]
    states = table.state.value_counts().rename(None).to_dict()
    summary = ", ".join(f"{count} {state}" for state, count in states.items())
    head = [name.replace("_", " ") for name in shown]
    return Document("Fleet", summary=[summary], parts=[Table(head, rows)])
