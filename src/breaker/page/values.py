"""The table of an inspection: values of all poles, their limits and verdicts, as text."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from breaker.common.document import Cell, tone_of
from breaker.common.numerals import first_of, in_digits
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.limits import VERDICTS, worst
from breaker.diagnosis.result import RecordResult, Result, accepted
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import RESULTS, simultaneity_in_words
from breaker.model.quantities import INFERRED, OF_STROKE, in_words
from breaker.page.curves import Tab, origins_of, spots_of

_NAMED = 4  # values in the verdict; the table shows all of them


class Value(NamedTuple):
    """A value of a pole: its text, its tone, and where the curve shows it, from and to in ms of the
    tab; empty where that is nowhere.
    """

    text: str
    tone: str
    spot: tuple[float, ...]


class Row(NamedTuple):
    """A quantity of a tab.

    Attributes:
        name, words, unit, zone: Name, name in words, unit, and zone of a speed.
        values, half: Value of each phase, and half of the widest 95 % interval.
        low, high: Bounds of its limit, as texts; empty for none.
        deviation: How far the worst pole is from the middle of its bounds, or beyond its bound.
        verdict: Verdict on it; empty without a limit.
    """

    name: str
    words: str
    unit: str
    zone: str
    values: Sequence[Value]
    half: str
    low: str
    high: str
    deviation: str
    verdict: str


class TabValues(NamedTuple):
    """A table: phases, rows, reasons of missing values and rejected records, simultaneity, and the
    zone of the speed.
    """

    title: str
    motion: str
    phases: Sequence[str]
    rows: Sequence[Row]
    missing: Mapping[str, str]
    simultaneity: Sequence[Cell]
    rejected: Sequence[str]
    zone: Sequence[str]


def table_of(tab: Tab, estimates: Sequence[Estimate], diagnosis: Diagnosis) -> TabValues:
    """Return the table of a tab."""
    results = dict(zip(map(id, diagnosis.estimates), diagnosis.result["records"], strict=True))
    pairs = [(each, results[id(each)]) for each in estimates]
    used = [(each, record) for each, record in pairs if record["accepted"]]
    records = [record for _, record in used]
    phases = [record.get("phase") or "value" for record in records]
    names = dict.fromkeys(name for record in records for name in record["quantities"])
    origins, _ = origins_of(tab)
    spots = [
        {
            name: [t - origins[id(each.record)] for t in ends]
            for name, ends in spots_of(each).items()
        }
        for each, _ in used
    ]
    rows, missing = [], {}
    for name in (name for name in names if name not in INFERRED):
        values = [record["quantities"].get(name, {}) for record in records]
        if any("interval_95" in value for value in values):
            rows.append(_row(name, values, records, spots))
        else:
            missing[in_words(name)] = str(next(v["reason"] for v in values if "reason" in v))
    poles = [
        simultaneity_in_words(each)
        for each in diagnosis.result["simultaneity"]
        if records and (each["motion"], each["operation"]) == (tab.motion, records[0]["operation"])
    ]
    rejected = [str(record["reason"]) for _, record in pairs if not record["accepted"]]
    zone = diagnosis.config["speeds"].get(f"{tab.motion}_speed") or ("", "")
    about = phases, rows, missing, poles, rejected, zone
    return TabValues(tab.title, tab.motion, *about)


def _row(
    name: str,
    values: Sequence[Mapping],
    records: Sequence[RecordResult],
    spots: Sequence[Mapping[str, Sequence[float]]],
) -> Row:
    limits = [_limit_on(name, record) for record in records]
    about = next(value for value in values if "unit" in value)
    bounds = next((limit["parts"][0]["bounds"] for limit in limits if limit), [None, None])
    cells, halves = [], []
    for value, limit, own in zip(values, limits, spots, strict=True):
        if "interval_95" not in value:
            cells.append(Value("–", "faint", ()))
            continue
        halves.append(float(np.ptp(value["interval_95"])) / 2.0)
        text = in_digits(value["median"], 4) + "*" * (value["source"] == "mixed")
        tone = tone_of(RESULTS[limit["verdict"]]) if limit else ""
        cells.append(Value(text, tone, tuple(own.get(name, ()))))
    verdict = worst(limit["verdict"] for limit in limits if limit)
    known = [value["median"] for value in values if value.get("median") is not None]
    ends = ["" if bound is None else in_digits(bound, 6) for bound in bounds]
    words = in_words(name)
    zone = value_zone if name not in OF_STROKE and (value_zone := about.get("zone")) else ""
    deviation = _deviation(known, bounds)
    half = in_digits(max(halves), 2)
    return Row(name, words, about["unit"], zone, cells, half, *ends, deviation, verdict)


def _limit_on(name: str, record: RecordResult) -> Mapping[str, Any] | None:
    """Return the limit on a quantity alone, of a record."""
    alone = [each for each in record.get("limits", ()) if len(each["parts"]) == 1]
    found = [each for each in alone if each["parts"][0]["quantity"] == name]
    return max(found, key=lambda each: VERDICTS.index(each["verdict"]), default=None)


def _deviation(values: Iterable[float], bounds: Sequence[float | None]) -> str:
    """Return the largest deviation from the middle of two bounds in percent of it, or from one."""
    low, high = bounds
    if low is high is None:
        return ""
    if None in bounds:
        bound = high if low is None else low
        off = max((value - bound for value in values), key=lambda e: e if low is None else -e)
        return in_digits(off, 2, sign=True)
    middle = 0.5 * (low + high)
    off = max((value - middle for value in values), key=abs)
    return in_digits(100.0 * off / middle, 2, sign=True) + " %" if middle else ""


def verdict_in_words(result: Result) -> tuple[str, str]:
    """Return the verdict on all limits, "" without one, and what decides it."""
    verdict = result["verdict"] or ""
    if not verdict:
        return "", "Set limits in the table."
    texts, records = [], accepted(result)
    for record in records:
        for limit in record.get("limits", ()):
            if limit["verdict"] == verdict:
                part, phase = limit["parts"][0], record.get("phase", "")
                name = in_words(part["quantity"])
                name = name if record["motion"] in name else f"{record['motion']} {name}"
                ends = [in_digits(b, 6) if b is not None else "" for b in part["bounds"]]
                bounds = (
                    " to ".join(filter(None, ends))
                    if all(ends)
                    else (f"at least {ends[0]}" if ends[0] else f"at most {ends[1]}")
                )
                value = "–" if part["value"] is None else in_digits(part["value"], 4)
                texts.append(f"{name} {phase}".strip() + f" {value} {part['unit']} ({bounds})")
    texts += [
        simultaneity_in_words(poles)
        for poles in result["simultaneity"]
        if poles.get("verdict") == verdict
    ]
    if verdict == "pass":
        return verdict, f"{len(texts)} values within their limits"
    return verdict, first_of(texts, _NAMED)
