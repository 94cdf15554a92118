"""The columns of the tables ``decisions.csv`` and ``alarms.csv``: names, kinds, units, meaning.

One schema for every drive: a column whose content is not known is there and empty.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import pandas as pd

__all__ = ["ALARMS", "DECISIONS", "Column", "read_table", "table_of"]


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        kind: "text", "number" (``inf`` is beyond the horizon, empty not known) or "count", a whole
            number.
        unit: Its unit, empty without one.
        meaning: What is in it.
    """

    kind: str
    unit: str
    meaning: str


_QUANTILE = "quantile at {} of the {} left to `limit`: 0 exceeded, `inf` beyond the horizon"

DECISIONS: Mapping[str, Column] = {
    "breaker": Column("text", "", "name of the breaker"),
    "phase": Column("text", "", "name of the phase"),
    "operation": Column("count", "", "number of the operation"),
    "date": Column("text", "", "its date, ISO 8601"),
    "temperature": Column("number", "°C", "temperature of the drive"),
    "event": Column("text", "", "what was done before it"),
    "state": Column("text", "", "state of the drive"),
    "action": Column("text", "", "code of the action"),
    "limit": Column("text", "", "the limit that the action is about, empty without one"),
    "operations_left_5": Column("number", "operations", _QUANTILE.format("5 %", "operations")),
    "operations_left": Column("number", "operations", _QUANTILE.format("50 %", "operations")),
    "operations_left_95": Column("number", "operations", _QUANTILE.format("95 %", "operations")),
    "days_left_5": Column("number", "days", _QUANTILE.format("5 %", "days")),
    "days_left": Column("number", "days", _QUANTILE.format("50 %", "days")),
    "days_left_95": Column("number", "days", _QUANTILE.format("95 %", "days")),
    "service_by": Column("count", "", "operation by which to service; in the past: overdue"),
    "service_by_date": Column("text", "", "its date"),
    "why": Column("text", "", "why `service_by` is later than in the row before"),
    "to_do": Column("text", "", "the action in words"),
    "exceeded": Column("text", "", "limits exceeded, each with the operation since when"),
    "wearing": Column(
        "text", "", "parameters and measured quantities that surely wear, and in which direction"
    ),
    "change": Column("text", "", "change of wear or step that was noticed at this operation"),
    "trust": Column("text", "", "how well the limit is known, and what cannot be told"),
    "not_used": Column("text", "", "which record of the operation could not be used, and why"),
}
"""Columns of ``decisions.csv``, one row per operation."""

ALARMS: Mapping[str, Column] = {
    "breaker": Column("text", "", "name of the breaker"),
    "limit": Column("text", "", "the limit that was exceeded, empty for a step"),
    "words": Column("text", "", "limit or step in words"),
    "motion": Column("text", "", "motion of the limit, source of the step"),
    "from_operation": Column("count", "", "first operation of the spell, first after the step"),
    "from_date": Column("text", "", "its date, ISO 8601"),
    "to_operation": Column("count", "", "last operation of the spell, empty if it lasts"),
    "to_date": Column("text", "", "its date, ISO 8601"),
    "highest_probability": Column("number", "1", "largest probability to be beyond the limit"),
}
"""Columns of ``alarms.csv``, one row per spell in which a limit was exceeded, and per step."""

_KINDS = {"text": str, "count": "Int64", "number": float}


def table_of(data: Mapping | pd.DataFrame, columns: Mapping[str, Column]) -> pd.DataFrame:
    """Return a table with exactly these columns, of these kinds; what is not given is empty.

    Args:
        data: Values by the name of the column, all of the same length.
        columns: ``DECISIONS`` or ``ALARMS``.

    >>> table_of({"limit": ["slow"], "from_operation": [1250]}, ALARMS).to_csv(index=False)
    'breaker,limit,words,motion,from_operation,from_date,to_operation,to_date,highest_probability\\n\
,slow,,,1250,,,,\\n'

    Raises:
        ValueError: If there is a column of another name.
    """
    frame = pd.DataFrame(data)
    if strange := sorted(set(frame.columns) - set(columns)):
        raise ValueError(f"no column is called {strange[0]!r}; there are {', '.join(columns)}")
    result = frame.reindex(columns=list(columns)).astype(object)
    for name, column in columns.items():
        if column.kind == "text":
            result[name] = result[name].where(result[name].notna(), "")
    return result.astype({name: _KINDS[column.kind] for name, column in columns.items()})


def read_table(file: str | Path, columns: Mapping[str, Column]) -> pd.DataFrame:
    """Read a table that was written as CSV; a name such as "007" or "NA" is as it was.

    Args:
        columns: ``DECISIONS`` or ``ALARMS``.
    """
    texts = {name: str for name, column in columns.items() if column.kind == "text"}
    return table_of(pd.read_csv(file, dtype=texts, keep_default_na=False, na_values=[""]), columns)
