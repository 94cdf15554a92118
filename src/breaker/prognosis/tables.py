"""Tables of a life, and the sentences of its first page: recommended actions and their reasons.

One row for each operation, limit or change. docs/reference/life-tables.md explains the columns.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from breaker.common.numerals import about, in_digits, in_p, in_percent, span
from breaker.configuration.data_files import advice_on
from breaker.diagnosis.sentences import say
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import ABOUT
from breaker.prognosis.limit_states import STATES

_DATED = ("date", "days_left", "service_by_date")
_LEFT = ("operations_left_5", "operations_left", "operations_left_95")


def decide(life: xr.Dataset, stands: xr.Dataset) -> pd.DataFrame:
    """Return one row per operation, from the results of ``life.follow`` and ``states_of``. Stated
    columns without any value are left out.
    """
    there = stands.subject >= 0
    main = stands.isel(limit=stands.subject.clip(0)).where(there)
    soonest = stands.isel(limit=stands.service_by.argmin("limit"))
    left = main.remaining.values.round()
    changed = dict(zip(life.noticed.values.tolist(), life.kind.values.tolist(), strict=True))
    over = (stands.state == STATES.index("due")) & (stands.p_exceeded >= 0.5)
    table = pd.DataFrame(
        {
            **{name: life[name].values for name in ("breaker", "phase")},
            "operation": life.operation.values,
            **{name: life[name].values for name in ABOUT if name not in ("breaker", "phase")},
            "state": np.array(STATES)[stands.drive_state.values],
            "limit": np.where(there, main.limit.values, ""),
            **dict(zip(_LEFT, left.T, strict=True)),
            "days_left": np.where(left[:, 1] == 0.0, 0.0, left[:, 1] * main.days.values).round(1),
            "service_by": _whole(soonest.service_by.values),
            "service_by_date": soonest.service_by_date.values,
            "recommended_since": _whole(stands.drive_since.values),
            "risk": main.risk.values,
            "exceeded": [", ".join(life.limit.values[row]) for row in over.values],
            "change": [changed.get(number, "") for number in life.operation.values.tolist()],
            "not_used": life.not_used.values,
        }
    )
    empty = [name for name in (*ABOUT, *_DATED) if table[name].isin(["", np.nan]).all()]
    return table.drop(columns=[*empty, *(_DATED if "date" in empty else ())], errors="ignore")


def _whole(numbers: np.ndarray) -> pd.Series:
    """Return integers; missing where a number is not finite."""
    return pd.Series(numbers).replace([np.inf], np.nan).astype("Int64")


def limit_table(life: xr.Dataset, stands: xr.Dataset) -> pd.DataFrame:
    """Return one row per part of a limit, after the last operation."""
    index = pd.Index(life.limit.values).get_indexer(life.part_limit.values)
    last = stands.isel(operation=-1, limit=index)
    low, now, high = life.value.values[-1].T
    return pd.DataFrame(
        {
            "limit": life.part_limit.values,
            "quantity": life.part_quantity.values,
            "of": life.of.values[index],
            "new": life.new.values,
            "now": now,
            "now_5": low,
            "now_95": high,
            "bound": life.part_bound.values,
            "unit": life.part_unit.values,
            "state": np.array(STATES)[last.state.values],
            "p_exceeded": last.p_exceeded.values,
            "certain": _whole(last.certain.values),
            "crossed": _whole(last.crossed.values),
            **dict(zip(_LEFT, last.remaining.values.round().T, strict=True)),
            "service_by": _whole(last.service_by.values),
            "recommended_since": _whole(last.recommended_since.values),
            "risk": last.risk.values,
        }
    )


def change_table(life: xr.Dataset) -> pd.DataFrame:
    """Return one row per detected change, and one for the last operation, with ``NAME_5``,
    ``NAME``, ``NAME_95`` and ``NAME_unchanged`` for each parameter.
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


def sentences(
    life: xr.Dataset, decisions: pd.DataFrame, limits: pd.DataFrame, advice: Mapping[str, str]
) -> list[str]:
    """Return sentences on the action after the last operation, on changes, on where to look first
    for limits that are due or planned, and on the validity of the result.
    """
    row, urgent = decisions.iloc[-1], limits[limits.state.isin(["planned", "due"])]
    first = urgent.limit == row.limit
    looks = advice_on([*urgent.quantity[first], *urgent.quantity[~first]], advice)
    looks = [say("life-look-first", advice="; ".join(looks))] if looks else []
    return [_headline(row, limits), _since_new(life), *looks, _trust(life)]


def _headline(row: pd.Series, limits: pd.DataFrame) -> str:
    """Return the recommended action after an operation, by its row of the decisions."""
    over = limits[limits.certain.notna()].drop_duplicates("limit").limit
    date, ends = row.get("service_by_date"), span(row.operations_left_5, row.operations_left_95)
    return say(
        f"life-{row.state}" + ("-exceeded" if row.state == "due" and len(over) else ""),
        operation=f"{row.operation:,}",
        limit=row.limit or "-",
        limits=", ".join(over),
        left=f"{about(row.operations_left)} ({ends})",
        by=f"{row.service_by} ({date})" if date else row.service_by,
        since=row.recommended_since,
        risk=in_percent(row.risk) if row.risk == row.risk else "unknown",
    )


def _since_new(life: xr.Dataset) -> str:
    """Return the sentence on parameters that changed since new: 90 % intervals exclude 0."""
    if not life.attrs["family"]:
        return say("life-withheld")
    if life.operation.values[-1] < life.attrs["reported_from"]:
        records = {"needed": life.attrs["needed"], "there": life.sizes["operation"]}
        return say("life-few-records", **records)
    low, middle, high = life.changed.values[-1].T
    if np.isnan(middle).any():
        return say("life-beyond-wear")
    words = []
    for k in np.argsort(-np.abs(middle)):
        if low[k] * high[k] > 0.0:
            numbers = (in_digits(level[k], 2, sign=True) for level in (middle, low, high))
            words.append("{} {} % ({} to {})".format(PARAMETERS[k].word, *numbers))
    return say("life-changed", changes=", ".join(words)) if words else say("life-unchanged")


def _trust(life: xr.Dataset) -> str:
    """Return the sentence on whether the drive is inside a family, and its motions agree."""
    least, agree = in_p(float(life.p_value.min())), in_p(life.attrs["agreement"])
    if life.attrs["family"]:
        return say("life-inside", family=life.attrs["family"], p=least, agree=agree)
    if life.attrs["agreement"] < 1.0:
        return say("life-motions-contradict", agree=agree)
    return say("life-outside", p=least)
