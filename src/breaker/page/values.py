"""The table of an inspection: values of all poles, their limits and verdicts, as text."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from breaker.common.document import Cell
from breaker.common.numerals import in_digits
from breaker.diagnosis.limits import VERDICTS, worst
from breaker.diagnosis.result import RecordResult
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import RESULTS, half_of, simultaneity_in_words, value_cell
from breaker.model.quantities import INFERRED, OF_STROKE, in_words
from breaker.page.curves import Tab


class Row(NamedTuple):
    """A quantity of a tab.

    Attributes:
        name, words: Name of the quantity, in code and in words.
        about: Zone of a speed.
        cells: Value of each phase, with the tone of its verdict.
        verdict: Verdict on the quantity; empty without a limit.
        half, unit: Half width of the widest 95 % interval, and unit.
        low, high: Bounds of the limit, as texts; empty without a bound.
    """

    name: str
    words: str
    about: str
    cells: Sequence[Cell]
    verdict: str
    half: str
    unit: str
    low: str
    high: str


def table_of(tab: Tab, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the table of a tab for its template: phases, rows, reasons of missing values,
    simultaneity, and the zone of the speed.
    """
    every = zip(diagnosis.estimates, diagnosis.result["records"], strict=True)
    records = [e for estimate, e in every if estimate.record in tab.records and e["accepted"]]
    rows, missing = [], {}
    for name in dict.fromkeys(name for record in records for name in record["quantities"]):
        values = [record["quantities"].get(name, {}) for record in records]
        if name in INFERRED:
            continue
        if any("interval_95" in value for value in values):
            rows.append(_row(name, values, records))
        else:
            missing[in_words(name)] = str(next(v["reason"] for v in values if "reason" in v))
    poles = [
        simultaneity_in_words(one)
        for one in diagnosis.result["simultaneity"]
        if records and (one["motion"], one["operation"]) == (tab.motion, records[0]["operation"])
    ]
    return {
        "title": tab.title,
        "motion": tab.motion,
        "phases": [record.get("phase") or "value" for record in records],
        "rows": rows,
        "missing": missing,
        "simultaneity": poles,
        "zone": diagnosis.config["speeds"].get(f"{tab.motion}_speed") or ("", ""),
    }


def _row(name: str, values: Sequence[Mapping], records: Sequence[RecordResult]) -> Row:
    limits = [_limit_on(name, record) for record in records]
    about = next(value for value in values if "unit" in value)
    bounds = next((limit["parts"][0]["bounds"] for limit in limits if limit), (None, None))
    cells = []
    for value, limit in zip(values, limits, strict=True):
        cell = value_cell(value)
        judged = limit and "interval_95" in value
        cells.append(Cell(cell, RESULTS[limit["verdict"]].tone) if judged else cell)
    low, high = ("" if bound is None else in_digits(bound, 6) for bound in bounds)
    zone = "" if name in OF_STROKE else about.get("zone", "")
    verdict = worst(limit["verdict"] for limit in limits if limit)
    unit = about["unit"]
    return Row(name, in_words(name), zone, cells, verdict, half_of(values), unit, low, high)


def _limit_on(name: str, record: RecordResult) -> Mapping[str, Any] | None:
    """Return a record's limit on this quantity only; of several, the one with the worst verdict."""
    limits = [limit for limit in record.get("limits", ()) if _alone(limit) == name]
    return max(limits, key=lambda limit: VERDICTS.index(limit["verdict"]), default=None)


def _alone(limit: Mapping) -> str:
    """Return the quantity of a limit on one quantity; empty for a limit on several."""
    return limit["parts"][0]["quantity"] if len(limit["parts"]) == 1 else ""


def other_limits(
    tables: Sequence[Mapping], records: Sequence[RecordResult]
) -> Iterator[tuple[str, Mapping]]:
    """Yield phase and limit for limits without a row in the tables."""
    shown = {row.name for table in tables for row in table["rows"]}
    for record in records:
        for limit in record.get("limits", ()):
            if _alone(limit) not in shown:
                yield record.get("phase", ""), limit
