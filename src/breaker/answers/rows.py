"""Answers as a tidy table: one row for each record and parameter or quantity."""

from collections.abc import Mapping

import pandas as pd
import xarray as xr

from breaker.answers.judgement import VERDICTS
from breaker.posterior import table

__all__ = ["table_of"]


def table_of(answers: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Return all answers as one table.

    Its columns are those of ``posterior.table``, and ``motion``, ``kind`` ("parameter" or
    "quantity"), ``undefined``, the share of draws in which a quantity does not exist, and of the
    record as a whole ``error_PART``, the median of what the model leaves out in each part of the
    motion, mm, ``exceeded_LIMIT``, the probabilities of limits, and ``verdict``. Rejected records
    have rows without numbers.
    """
    return pd.concat([_rows(motion, each) for motion, each in answers.items()], ignore_index=True)


def _rows(motion: str, answer: xr.Dataset) -> pd.DataFrame:
    parameters = table(answer).assign(kind="parameter")
    per_record = ["output", "unit", "median", "kind"]
    per_record += [name for name in parameters if name.startswith("interval_")]
    records = parameters.drop(columns=per_record).drop_duplicates("operation")
    quantities = (
        xr.Dataset(
            {
                "median": answer.quantity_median,
                **{
                    f"interval_95_{end}": answer.quantity_interval.sel(bound=end, drop=True)
                    for end in ("lower", "upper")
                },
                "undefined": answer.quantity_undefined,
                **{name: answer[name] for name in ("measured", "measured_sd") if name in answer},
            }
        )
        .to_dataframe()
        .reset_index()
        .rename(columns={"quantity": "output", "quantity_unit": "unit"})
        .assign(kind="quantity")
        .merge(records, on="operation")
    )
    rows = pd.concat([parameters, quantities], ignore_index=True)
    rows = rows.merge(_of_records(answer), on="operation")
    rows.insert(0, "motion", motion)
    first = ["motion", "operation", "file", "kind", "output", "unit", "median"]
    rows = rows[[*first, *(name for name in rows if name not in first)]]
    return rows.sort_values("operation", kind="stable", ignore_index=True)


def _of_records(answer: xr.Dataset) -> pd.DataFrame:
    """What there is to say of each record beside what ``posterior.table`` says."""
    columns = {"operation": answer.operation.values, "prior_p_value": answer.prior_p_value.values}
    error = answer.model_error.sel(quantile=0.5)
    for part in answer["part"].values:
        columns[f"error_{part.replace(' ', '_')}"] = error.sel(part=part).values
    if "limit" in answer.coords:
        for limit in answer.limit.values:
            columns[f"exceeded_{limit}"] = answer.exceeded.sel(limit=limit).values
        words = answer.limit_verdict.values.tolist()
        columns["verdict"] = [max(row, key=VERDICTS.index) for row in words]
    return pd.DataFrame(columns)
