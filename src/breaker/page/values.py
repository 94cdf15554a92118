"""The table of an inspection: values of all poles, their limits and verdicts, as text."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from breaker.common.numerals import in_digits
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.limits import VERDICTS, worst
from breaker.diagnosis.result import RecordResult
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import RESULTS, half_of, simultaneity_in_words
from breaker.model.quantities import INFERRED, OF_STROKE, in_words
from breaker.page.curves import Tab, origins_of, spots_of


class Value(NamedTuple):
    """A value of a pole: its text, its tone, and where the curve shows it, from and to in ms of the
    tab; empty where that is nowhere.
    """

    text: str
    tone: str
    spot: Sequence[float] = ()


class Row(NamedTuple):
    """A quantity of a tab, or a limit that no quantity of the tab has alone.

    Attributes:
        words, about: Name in words, and the zone of a speed or the words of the limit.
        values: Value of each phase.
        verdict: Verdict on it; empty without a limit.
        key: Key by which its limit is set; empty where the page sets none.
        half, unit: Half of the widest 95 % interval, and unit.
        low, high: Bounds of its limit, as texts; empty for none.
        deviation: How far the worst pole is from the middle of its bounds, or beyond its bound.
    """

    words: str
    about: str
    values: Sequence[Value]
    verdict: str
    key: str = ""
    half: str = ""
    unit: str = ""
    low: str = ""
    high: str = ""
    deviation: str = ""


def table_of(tab: Tab, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the table of a tab, as its template takes it: phases, rows, reasons of missing values
    and of rejected records, simultaneity, and the zone of the speed.
    """
    pairs = [
        (estimate, record)
        for estimate, record in zip(diagnosis.estimates, diagnosis.result["records"], strict=True)
        if estimate.record in tab.records
    ]
    used = [(estimate, record) for estimate, record in pairs if record["accepted"]]
    records, (origins, _) = [record for _, record in used], origins_of(tab)
    spots = [_shifted(estimate, origins[id(estimate.record)]) for estimate, _ in used]
    names = dict.fromkeys(name for record in records for name in record["quantities"])
    rows, missing = [], {}
    for name in (name for name in names if name not in INFERRED):
        values = [record["quantities"].get(name, {}) for record in records]
        if any("interval_95" in value for value in values):
            rows.append(_row(name, tab.motion, values, records, spots))
        else:
            missing[in_words(name)] = str(next(v["reason"] for v in values if "reason" in v))
    shown = {row.key.rpartition(" ")[2] for row in rows}
    poles = [
        simultaneity_in_words(one)
        for one in diagnosis.result["simultaneity"]
        if records and (one["motion"], one["operation"]) == (tab.motion, records[0]["operation"])
    ]
    return {
        "title": tab.title,
        "motion": tab.motion,
        "phases": [record.get("phase") or "value" for record in records],
        "rows": [*rows, *_other_limits(records, shown)],
        "missing": missing,
        "simultaneity": poles,
        "rejected": [str(record["reason"]) for _, record in pairs if not record["accepted"]],
        "zone": diagnosis.config["speeds"].get(f"{tab.motion}_speed") or ("", ""),
    }


def _shifted(estimate: Estimate, zero: float) -> dict[str, list[float]]:
    """Return where quantities are measured, in times of the tab."""
    return {name: [time - zero for time in ends] for name, ends in spots_of(estimate).items()}


def _row(
    name: str,
    motion: str,
    values: Sequence[Mapping],
    records: Sequence[RecordResult],
    spots: Sequence[Mapping[str, Sequence[float]]],
) -> Row:
    limits = [_limit_on(name, record) for record in records]
    about = next(value for value in values if "unit" in value)
    bounds = next((limit["parts"][0]["bounds"] for limit in limits if limit), [None, None])
    cells = []
    for value, limit, own in zip(values, limits, spots, strict=True):
        if "interval_95" in value:
            text = in_digits(value["median"], 4) + "*" * (value["source"] == "mixed")
            tone = RESULTS[limit["verdict"]].tone if limit else ""
            cells.append(Value(text, tone, own.get(name, ())))
        else:
            cells.append(Value("–", "faint"))
    medians = [value["median"] for value in values if "interval_95" in value]
    low, high = ("" if bound is None else in_digits(bound, 6) for bound in bounds)
    return Row(
        in_words(name),
        "" if name in OF_STROKE else about.get("zone", ""),
        cells,
        worst(limit["verdict"] for limit in limits if limit),
        key=f"limits.{motion} {name}",
        half=half_of(values),
        unit=about["unit"],
        low=low,
        high=high,
        deviation=_deviation(medians, *bounds),
    )


def _limit_on(name: str, record: RecordResult) -> Mapping[str, Any] | None:
    """Return the limit on a quantity alone, of a record; of several the one of worst verdict."""
    alone = [limit for limit in record.get("limits", ()) if len(limit["parts"]) == 1]
    limits = [limit for limit in alone if limit["parts"][0]["quantity"] == name]
    return max(limits, key=lambda limit: VERDICTS.index(limit["verdict"]), default=None)


def _other_limits(records: Sequence[RecordResult], shown: set[str]) -> Iterator[Row]:
    """Yield a row for each limit on several quantities, or on one that has no row."""
    groups: dict[str, list[tuple[int, Mapping]]] = {}
    for k, record in enumerate(records):
        for limit in record.get("limits", ()):
            if len(limit["parts"]) > 1 or limit["parts"][0]["quantity"] not in shown:
                groups.setdefault(limit["name"], []).append((k, limit))
    for name, some in groups.items():
        cells = [Value("–", "faint")] * len(records)
        for k, limit in some:
            result = RESULTS[limit["verdict"]]
            cells[k] = Value(result, result.tone)
        verdict = worst(limit["verdict"] for _, limit in some)
        yield Row(name.replace("_", " "), f"fails where {some[0][1]['words']}", cells, verdict)


def _deviation(values: Sequence[float], low: float | None, high: float | None) -> str:
    """Return the largest deviation from the middle of two bounds in percent of it, or from one."""
    if low is None and high is None:
        return ""
    if low is None:
        return in_digits(max(values) - high, 2, sign=True)
    if high is None:
        return in_digits(min(values) - low, 2, sign=True)
    middle = 0.5 * (low + high)
    off = max((value - middle for value in values), key=abs)
    return in_digits(100.0 * off / middle, 2, sign=True) + " %" if middle else ""
