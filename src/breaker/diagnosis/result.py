"""The result of a diagnosis as data: its records, what they share, and the verdict.

A result has the layout of the JSON; docs/reference/files.md lists its keys. ``tables`` and
``report`` render it. An unknown number is None, or its key is absent.
"""

from collections.abc import Iterator, Mapping, Sequence
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from breaker.common.clean_text import table_text
from breaker.common.numerals import in_digits, in_p, natural
from breaker.common.plain_values import note_of, plainly
from breaker.diagnosis.estimate import Estimate, Given
from breaker.diagnosis.identity import doubts_about
from breaker.diagnosis.limits import Known, interval_of, known_of, simultaneity_of, worst
from breaker.diagnosis.sentences import say
from breaker.family.networks import EFFECTS
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import ABOUT, ANSWERED, CURRENTS, SHARES, quantities_of
from breaker.records.files import printable
from breaker.records.measurements import Measured

if TYPE_CHECKING:
    from breaker.diagnosis.session import Diagnosis
    from breaker.model.limits import Limit

_OF_OTHER_CHANNELS = {*ANSWERED, *CURRENTS, "main_closing_time", "main_opening_time", "arcing_wipe"}

Value = Mapping[str, object]
"""A parameter, an additional effect or a quantity, such as its "median" and "interval_95"."""

RecordResult = Mapping[str, object]
"""Values estimated and measured from a record, or the "reason" why it was rejected."""

Result = Mapping[str, object]
"""Records, with their common warnings, settings and verdict."""


def result_of(diagnosis: "Diagnosis") -> Result:
    """Return the estimates of a diagnosis, with its verdicts on limits, as data."""
    given, most = diagnosis.given, diagnosis.config["report"]["simultaneity"]
    read = [estimate.record for estimate in diagnosis.estimates]
    no_drive = [record.raw.no_drive for record in read if record.raw and record.raw.no_drive]
    both = zip(diagnosis.estimates, diagnosis.judge(diagnosis.estimates), strict=True)
    records = [_record(estimate, verdicts, given) for estimate, verdicts in both]
    absent, of_change = _not_judged(diagnosis)
    doubts = [*doubts_about(read), *diagnosis.doubts]
    result = {
        # Remarks list all motions that no drive makes.
        "warnings": [*map(note_of, [*doubts, *no_drive[:1], *absent])],
        "remarks": [*map(note_of, of_change)],
        "settings": diagnosis.settings
        | {"known": given.known, "size": given.size and vars(given.size)},
        "records": records,
        "simultaneity": [
            simultaneity_of(poles, most) for poles in operations_of(records) if len(poles) > 1
        ],
    }
    for poles in result["simultaneity"] if no_drive else ():
        poles.pop("verdict", None)
    verdicts = [limit["verdict"] for record in records for limit in record.get("limits", ())]
    limited = (poles for poles in result["simultaneity"] if "limit" in poles)
    verdicts += [poles.get("verdict", "inconclusive") for poles in limited]
    verdict = worst(verdicts) or None
    return plainly({"verdict": verdict, **result})


def _not_judged(diagnosis: "Diagnosis") -> tuple[list[str], list[str]]:
    """Return warnings on limits and records that the verdict does not contain, and remarks on
    limits of changes.
    """
    motions = {e.record.motion for e in diagnosis.estimates if e.record.raw is not None}
    limits = diagnosis.limits_on(diagnosis.estimates)
    absent = [e for e in limits if e.of != "change" and e.motion not in motions]
    warnings = _named("limits-without-record", absent)
    count = sum(e.record.raw is None for e in diagnosis.estimates)
    warnings += [say("rejected-not-judged", count=count)] if limits and count else []
    return warnings, _named("limits-of-change", [e for e in limits if e.of == "change"])


def _named(code: str, limits: Sequence["Limit"]) -> list[str]:
    """Return the sentence of a code with the names of limits, if there are any."""
    names = ", ".join(dict.fromkeys(e.pair or e.name for e in limits))
    return [say(code, names=names)] if names else []


def accepted(result: Result) -> list[RecordResult]:
    """Return the records that could be used."""
    return [record for record in result["records"] if record["accepted"]]


def operations_of(records: Sequence[RecordResult]) -> list[list[RecordResult]]:
    """Return accepted records by operation and motion, all poles together, in order of files."""
    groups: dict[tuple, list[RecordResult]] = {}
    for record in records:
        if record["accepted"]:
            key = record["operation"], record["motion"]
            phases = {other.get("phase") for other in groups.get(key, ())}
            key = (*key, record["file"]) if record.get("phase") in phases else key
            groups.setdefault(key, []).append(record)
    for group in groups.values():
        group.sort(key=lambda record: natural(record["file"]))
    first = lambda group: (natural(group[0]["file"]), group[0]["fit"]["first_motion"])  # noqa: E731
    return sorted(groups.values(), key=first)


def _record(estimate: Estimate, verdicts: Sequence[Mapping], given: Given) -> RecordResult:
    record, operation = estimate.record, estimate.record.operation
    stated = {name: getattr(operation, name) for name in ABOUT}
    stated |= {"from": operation.begin, "to": operation.end}
    entry = {
        "file": printable(operation.file),
        "operation": operation.number,
        "motion": record.motion,
        **{name: v for name, v in stated.items() if v == v and v not in ("", None)},
        "accepted": not record.reason,
        "reason": note_of(record.reason),
        "remarks": [*map(note_of, estimate.remarks)],
    }
    if record.reason:
        return entry
    entry |= {"fit": _fit(estimate), "parameters": _parameters(estimate, given)}
    entry |= {"effects": _effects(estimate), "quantities": _quantities(estimate)}
    judged = {"limits": verdicts, "verdict": worst(verdict["verdict"] for verdict in verdicts)}
    return entry | (judged if verdicts else {})


def _fit(estimate: Estimate) -> dict[str, object]:
    raw, match, reason = estimate.record.raw, estimate.match, estimate.unresolved
    family = estimate.levels.settings["family"] if estimate.levels else None
    if estimate.misfit:
        far = {name: times for name, times in match.parts.items() if times > 1.0}
        parts = [f"{name} {in_digits(times, 2)} times" for name, times in far.items()]
        code = "no-parameters-in-parts" if parts else "no-parameters"
        reason = say(code, family=family, p=in_p(match.p_value), parts=", ".join(parts))
    contact = {
        "trigger": raw.contact.trigger,
        "contact_time": raw.contact.time - raw.moves,
        "contact_sd": raw.contact.sd,
        "contact_deviation": estimate.surprise,
        "main_contact_time": raw.contact.main - raw.moves,
    }
    return {
        "family": family,
        "p_value": match.p_value if match else None,
        "inside_family": match is not None and not estimate.misfit,
        "parts": match.parts if match else {},
        "motions": estimate.motions,
        "resolved": not reason,
        "reason": note_of(reason),
        "effective_size": estimate.effective_size,
        "first_motion": raw.moves,
        "first_motion_sd": raw.reading.start_sd,
        "missing": int(np.isnan(raw.left).sum()),
        "masked": int((raw.doubts[raw.inside] != "").sum()),
        "noise": raw.noise.sd,
        **{name: value for name, value in contact.items() if np.isfinite(value)},
    }


def _known(known: Known) -> dict[str, object]:
    if isinstance(known, Measured) and known.reason:
        return {"median": None, "reason": note_of(known.reason)}
    middle, ends = interval_of(known)
    return {"median": middle, "interval_95": ends}


def _parameters(estimate: Estimate, given: Given) -> dict[str, Value]:
    values = {}
    for k, parameter in enumerate(PARAMETERS):
        known = known_of(estimate, parameter.name)
        value = {"unit": parameter.unit, "meaning": parameter.meaning, **_known(known)}
        if given.prior is not None and value["median"] is not None:
            sds = np.log(value["median"] / given.prior.medians[k]) / given.prior.log_sds[k]
            value["percentile"] = 100.0 * NormalDist().cdf(sds)
        if estimate.prior_share is not None:
            value["prior_share"] = estimate.prior_share[k]
        values[parameter.name] = value
    return values


def _effects(estimate: Estimate) -> dict[str, Value]:
    """Return probability and size of the additional effects of the family."""
    values = {}
    for name, draws in (estimate.draws.effects if estimate.draws else {}).items():
        entry = {"unit": "ms" if name == "build_up" else "1", "meaning": EFFECTS[name]}
        values[name] = entry | _known(draws) | {"probability": np.mean(draws != 0.0)}
    return values


def _quantities(estimate: Estimate) -> dict[str, Value]:
    """Return the quantities of the motion that the channels of the record can show."""
    values, record = {}, estimate.record
    for name, values_of in quantities_of(record.motion, estimate.speeds, of=None).items():
        known = known_of(estimate, name)
        value = {"unit": values_of.unit, "meaning": values_of.meaning, **_known(known)}
        no_trigger = np.isnan(record.raw.contact.trigger) and name in {"reaction_time", *SHARES}
        if no_trigger or ("reason" in value and name in _OF_OTHER_CHANNELS):
            continue
        if estimate.is_inferred(name) and "reason" not in value:
            value["source"] = "estimated"
        elif "reason" not in value:
            value["source"] = "measured" if estimate.measured_directly(name) else "mixed"
        values[name] = value | ({"zone": values_of.zone} if values_of.zone else {})
    return values


# ---- a table for spreadsheets --------------------------------------------------------------------

_KINDS = {"parameters": "parameter", "effects": "effect", "quantities": "quantity"}


def csv_of(result: Result) -> str:
    """Return the records of a result as CSV: a row for each parameter, effect and quantity, with
    the values of its record, and one row for a rejected record.
    """
    rows = [row for record in result["records"] for row in _rows(record)]
    return table_text([*dict.fromkeys(name for row in rows for name in row)], rows)


def _rows(record: RecordResult) -> Iterator[dict]:
    remarks = {"remarks": "; ".join(map(str, record["remarks"]))}
    columns = _cells(record) | remarks | _cells(record.get("fit", {}))
    values = [(kind, *pair) for key, kind in _KINDS.items() for pair in record.get(key, {}).items()]
    for kind, name, reading in values or [("", "", record)]:
        low, high = reading.get("interval_95", (None, None))
        ends = {
            "interval_95_lower": low,
            "interval_95_upper": high,
            "reason": reading.get("reason"),
        }
        yield columns | {"kind": kind, "output": name} | _cells(reading) | ends


def _cells(values: Mapping) -> dict[str, object]:
    """Return the single values of a mapping."""
    return {name: v for name, v in values.items() if not isinstance(v, Mapping | list)}
