"""Tables of a life: what to do after each operation, how each limit stands, and what changed.

``breaker.prognosis.page`` says the same in sentences; no table holds one.
"""

from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta

import numpy as np
import pandas as pd
import xarray as xr

from breaker.model.quantities import ABOUT, CONDITIONS, metadata_names
from breaker.prognosis.states import STATES
from breaker.records.dates import instant

DECISIONS = {
    "breaker": "name of the breaker",
    "phase": "name of the phase",
    "operation": "number of the operation",
    "date": "its date, ISO 8601",
    "temperature": "of the drive, °C",
    "voltage": "of the control circuit, as the table has it",
    "event": "what was done before it",
    "state": "of the drive: unknown, ok, planned (a service) or due",
    "limit": "the limit that the state is about; empty without one",
    "operations_left_5": "operations left, quantile at 5 %: 0 exceeded, inf beyond the horizon",
    "operations_left": "the same at 50 %",
    "operations_left_95": "the same at 95 %",
    "days_left": "days left to it at the recent rate, quantile at 50 %",
    "service_by": "operation by which to service, of the most urgent limit",
    "service_by_date": "its date at the recent rate",
    "recommended_since": "operation since when a service is recommended without a break",
    "risk": "probability to exceed that limit, or to fail suddenly, before the next inspection",
    "exceeded": "limits that are exceeded",
    "change": "kind of a change that was noticed at this operation",
    "not_used": "motions without a usable record",
}
"""Columns of ``decisions.csv``, one row per operation; of dates only where any is known."""

LIMITS = {
    "limit": "name of the limit",
    "quantity": "what it is on",
    "of": "what that is read from: record, change or model",
    "new": "its value as new",
    "now": "its value after the last operation, median",
    "now_5": "the same, quantile at 5 %",
    "now_95": "and at 95 %",
    "bound": "the limit",
    "unit": "unit of these",
    "state": "unknown, ok, planned or due",
    "p_exceeded": "probability that it is exceeded",
    "certain": "operation at which that is sure; empty where it is not exceeded",
    "crossed": "operation from which on it is likelier than not",
    "operations_left_5": "operations left, quantile at 5 %",
    "operations_left": "the same at 50 %",
    "operations_left_95": "and at 95 %",
    "service_by": "operation by which to service; empty where none is planned",
    "recommended_since": "operation since when a service is recommended without a break",
    "risk": "probability to exceed it, or to fail suddenly, before the next inspection",
}
"""Columns of ``limits.csv``, one row per part of a limit, after the last operation."""

CHANGES = {
    "noticed": "operation at which the change was noticed; of the last row, the last operation",
    "start": "first operation after it",
    "earliest": "the same, from",
    "latest": "and to, by 90 %",
    "kind": "rate (of wear), step or event; now: the last operation",
    "evidence": "of the change beside none, nats",
}
"""First columns of ``changes.csv``; behind them, of each parameter, the change since new in percent
at 5, 50 and 95 % and the probability of none, as known when the change was noticed."""


_YEAR = 365.0  # days over which operations are counted, where the records go back as far,
_LEAST = 30.0  # and over which they must have been
_FARTHEST = 36525.0  # days ahead that are told
_LEFT = ("operations_left_5", "operations_left", "operations_left_95")


def operation_metadata(curves: Mapping[str, xr.Dataset], operations: np.ndarray) -> pd.DataFrame:
    """Return what is known of each operation beside its records, and motions without one.

    Columns are ``ABOUT`` and ``not_used``: events of all motions, the mean conditions, and else
    what the first motion knows.

    Args:
        curves: Records of each motion, with ``accepted`` and what ``ABOUT`` names.
        operations: Numbers, ``(o,)``.
    """
    frames = [
        data[[*metadata_names(data), "accepted"]].to_dataframe().reindex(operations)
        for data in curves.values()
    ]
    found, empty = {}, [""] * len(operations)
    for name in ABOUT:
        rows = zip(*(frame.get(name, empty) for frame in frames), strict=True)
        found[name] = [_joined(name, [v for v in row if v == v and v != ""]) for row in rows]
    used = zip(*(frame.accepted.eq(True) for frame in frames), strict=True)
    unused = [[m for m, each in zip(curves, row, strict=True) if not each] for row in used]
    return pd.DataFrame(found | {"not_used": [", ".join(each) for each in unused]})


def _joined(name: str, values: Sequence) -> object:
    """One value of ``ABOUT`` from those of the motions of an operation; empty without any."""
    if name in CONDITIONS:
        return float(np.mean(values)) if values else np.nan
    words = list(dict.fromkeys(map(str, values)))
    return ", ".join(words if name == "event" else words[:1])


def decide(life: xr.Dataset, stands: xr.Dataset, known: pd.DataFrame) -> pd.DataFrame:
    """Return one row per operation, with the columns ``DECISIONS`` of which anything is known.

    Args:
        life: What ``life.forecast_of`` returns.
        stands: What ``states_of`` returns.
        known: What ``operation_metadata`` returns.
    """
    operations, subject = life.operation.values, stands.subject.values
    rows, pace = np.arange(len(operations)), days_per_operation(operations, list(known.date))
    limits = np.append(life.limit.values, "")
    left = np.full((len(rows), 3), np.nan)
    some = subject >= 0
    left[some] = stands.remaining.values[rows[some], subject[some]]
    risk = np.full(len(rows), np.nan)
    risk[some] = stands.risk.values[rows[some], subject[some]]
    by = stands.drive_service_by.values
    changed = dict(zip(life.noticed.values.tolist(), life.kind.values.tolist(), strict=True))
    over = np.isin(stands.state.values, STATES.index("due")) & (stands.p_exceeded.values >= 0.5)
    data = {
        **{name: list(known[name]) for name in ABOUT},
        "operation": operations,
        "state": np.array(STATES)[stands.drive_state.values],
        "limit": limits[subject],
        **dict(zip(_LEFT, left.round().T, strict=True)),
        "days_left": np.where(left[:, 1] == 0.0, 0.0, left[:, 1] * pace).round(1),
        "service_by": _whole(by),
        "service_by_date": on_date(by, operations, list(known.date), pace),
        "recommended_since": _whole(stands.drive_since.values),
        "risk": risk,
        "exceeded": [", ".join(life.limit.values[row]) for row in over],
        "change": [changed.get(number, "") for number in operations.tolist()],
        "not_used": list(known.not_used),
    }
    table = pd.DataFrame({name: data[name] for name in DECISIONS})
    dated = {"date", "days_left", "service_by_date"}
    empty = [
        name
        for name in (*ABOUT, *dated)
        if not table[name].map(lambda value: value == value and value != "").any()
    ]
    return table.drop(columns=[*empty, *(dated if "date" in empty else ())], errors="ignore")


def _whole(numbers: np.ndarray) -> pd.array:
    """Whole numbers; missing where a number is not finite."""
    return pd.array([int(each) if np.isfinite(each) else pd.NA for each in numbers], dtype="Int64")


def limit_table(life: xr.Dataset, stands: xr.Dataset) -> pd.DataFrame:
    """Return one row per part of a limit, after the last operation, with the columns ``LIMITS``."""
    of = pd.Index(life.limit.values).get_indexer(life.part_limit.values)
    last, now = stands.isel(operation=-1), life.value.values[-1]
    state, left = last.state.values[of], last.remaining.values[of].round()
    data = {
        "limit": life.part_limit.values,
        "quantity": life.part_quantity.values,
        "of": life.of.values[of],
        "new": life.new.values,
        **dict(zip(("now_5", "now", "now_95"), now.T, strict=True)),
        "bound": life.part_bound.values,
        "unit": life.part_unit.values,
        "state": np.array(STATES)[state],
        "p_exceeded": last.p_exceeded.values[of],
        "certain": _whole(stands.certain.values[of]),
        "crossed": _whole(stands.crossed.values[of]),
        **dict(zip(_LEFT, left.T, strict=True)),
        "service_by": _whole(last.service_by.values[of]),
        "recommended_since": _whole(last.recommended_since.values[of]),
        "risk": last.risk.values[of],
    }
    return pd.DataFrame({name: data[name] for name in LIMITS})


def change_table(life: xr.Dataset) -> pd.DataFrame:
    """Return one row per change that was noticed, and one of the last operation.

    Columns are ``CHANGES``, and of each parameter ``NAME_5``, ``NAME``, ``NAME_95`` and
    ``NAME_unchanged``.
    """
    last, ends = int(life.operation[-1]), ("noticed", "start", "earliest", "latest")
    data = {name: np.append(life[name].values, last) for name in ends} | {
        "kind": np.append(life.kind.values, "now"),
        "evidence": np.append(life.certainty.values, np.nan),
    }
    known = life[["changed", "unchanged"]].reindex(asked=data["noticed"], method="bfill")
    for k, name in enumerate(life.parameter.values):
        for column, values in zip(("_5", "", "_95"), known.changed.values[:, k].T, strict=True):
            data[f"{name}{column}"] = values
        data[f"{name}_unchanged"] = known.unchanged.values[:, k]
    return pd.DataFrame(data)


def days_per_operation(operations: np.ndarray, dates: Sequence[str]) -> np.ndarray:
    """Return the recent mean number of days between operations, ``(o,)``, nan if not known.

    Counted from the last dated operation that is a year back or more, else from the first one, and
    not at all within a month.

    Args:
        operations: Numbers of the operations, rising, ``(o,)``.
        dates: Date of each as ISO 8601, empty where not known.

    >>> dates = ["2020-01-01", "2020-01-01", "2024-01-01", "2024-01-01"]
    >>> days_per_operation(np.array([1, 5, 100, 104]), dates).round(1).tolist()
    [nan, nan, 15.4, 14.8]
    """
    numbers, days = _dated(operations, dates)
    result = np.full(len(operations), np.nan)
    for i, last in enumerate(np.searchsorted(numbers, operations, "right") - 1):
        if last < 0:
            continue
        past = np.flatnonzero(days[: last + 1] <= days[last] - _YEAR)
        since = past[-1] if past.size else 0
        made, passed = numbers[last] - numbers[since], days[last] - days[since]
        if made > 0 and passed >= _LEAST:
            result[i] = passed / made
    return result


def _dated(operations: np.ndarray, dates: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and days, since year 1, of the operations that have a date."""
    there = [i for i, date in enumerate(dates) if date]
    found = [instant(dates[i]) for i in there]
    days = [(date - datetime.min) / timedelta(days=1) for date in found]
    return np.asarray(operations)[there], np.array(days, dtype=float)


def on_date(
    wanted: np.ndarray, operations: np.ndarray, dates: Sequence[str], per_operation: np.ndarray
) -> list[str]:
    """Return the date at which an operation is expected, as known at each operation, ``(o,)``.

    Empty where rate or number are not known, or more than a century away. The other arguments are
    those of ``days_per_operation``, and what it returns.

    Args:
        wanted: Number of an operation, ``(o,)``.
    """
    numbers, days = _dated(operations, dates)
    found = []
    lasts = np.searchsorted(numbers, operations, "right") - 1
    for number, last, each in zip(wanted, lasts, per_operation, strict=True):
        ahead = (number - numbers[last]) * each if last >= 0 else np.nan
        day = days[last] + ahead if abs(ahead) < _FARTHEST else np.nan
        there = 0 <= day < (datetime.max - datetime.min).days
        date = datetime.min + timedelta(days=float(day)) if there else None
        found.append(date.date().isoformat() if date else "")
    return found
