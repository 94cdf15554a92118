"""An answer as one document of plain values, which ``--json`` writes, and this as a tidy table.

docs/usage.md explains its keys. A number that is not known is None.
"""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from breaker.drive.answers.evidence import MAY_SLIDE, WITH_CONTACT, Answer
from breaker.drive.answers.identity import doubts_about
from breaker.drive.answers.limit_verdicts import NORMAL, VERDICTS
from breaker.drive.family.mechanisms import MECHANISMS
from breaker.quantities.catalogue import quantities_of
from breaker.quantities.parameters import MOTIONS, PARAMETERS
from breaker.quantities.speeds import EVENTS
from breaker.reading.files.guards import printable
from breaker.reading.files.operations_table import ABOUT
from breaker.reading.files.safe_text import table_text

_FEWEST = 2  # records that are summed up together
_WIPE = {"closing": "way still to go at touch", "opening": "way gone at parting"}
_LEVELS = (0.5, 0.25, 0.75, 0.025, 0.975)
_KINDS = {"parameters": "parameter", "mechanisms": "mechanism", "quantities": "quantity"}
_FIRST = ("motion", "operation", "file", "kind", "output", "unit", "median")
_FIRST += tuple(f"interval_{of}_{end}" for of in (50, 95) for end in ("lower", "upper"))
FROM_TENTH = "_from10"
"""How names of inferred times end that count from 10 % of the way."""

_LEFT_OUT = (*_KINDS, "fit", "limits", "remarks")


def document(
    answers: Sequence[Answer],
    limits: Sequence[Sequence[Mapping]],
    drive: Mapping[str, object],
    settings: Mapping[str, object],
    means: Sequence[Sequence[Answer]] = (),
) -> dict:
    """Return answers as a document.

    Args:
        answers: What ``infer_drive`` returns.
        limits: Of each, what ``judged`` returns.
        drive: What is known of the drive as a whole: goes into the document as it is.
        settings: What the answers were made with: the same.
        means: What ``infer_means`` returns.

    Returns:
        ``{"warnings", "drive", "settings", "records", "together", "means"}``: sentences to be said
        first, an entry for each record, what several of a motion share, and what means tell.
    """
    known = [n for n in ABOUT if any(_about(each)[n] is not None for each in answers)]
    records = [_record(*both, known) for both in zip(answers, limits, strict=True)]
    together = {motion: each for motion in MOTIONS if (each := _together(motion, records))}
    found = {"warnings": doubts_about([a.record for a in answers]), "drive": drive}
    found["settings"] = settings
    pooled = [entry for pole in means for entry in _means(pole)]
    return plainly(found | {"records": records, "together": together, "means": pooled})


def _means(answers: Sequence[Answer]) -> list[dict]:
    """An entry for each answer on means of records of a pole, whichever motions it is from."""
    found: dict[int, dict] = {}
    for each in answers:
        about = {name: _about(each)[name] for name in ("breaker", "phase")}
        empty = about | {"records": {}, "parameters": _parameters(each), "remarks": each.remarks}
        empty["mechanisms"] = _mechanisms(each)
        entry = found.setdefault(id(each.draws), empty | {"resolved": not each.unresolved})
        entry["records"][each.record.motion] = each.records
    return [*found.values()]


def _about(answer: Answer) -> dict:
    """What a table knows of an operation, None where it does not."""
    operation = answer.record.operation
    values = {name: getattr(operation, name) for name in ABOUT}
    return {n: None if each == "" or each != each else each for n, each in values.items()}


def _record(answer: Answer, limits: Sequence[Mapping], known: Sequence[str]) -> dict:
    """One entry; what a rejected record lacks is left out."""
    record = answer.record
    entry = {"file": printable(record.operation.file), "operation": record.operation.number}
    entry |= {name: _about(answer)[name] for name in known}
    part = {"from": record.operation.begin, "to": record.operation.end}
    entry |= {name: at for name, at in part.items() if at == at}
    entry |= {"motion": record.motion, "accepted": not record.reason}
    entry |= {"reason": record.reason or None, "remarks": [*answer.remarks]}
    if record.reason:
        return entry
    entry |= {"fit": _fit(answer), "parameters": _parameters(answer)}
    entry["mechanisms"] = _mechanisms(answer)
    entry["quantities"] = _quantities(answer)
    if limits:
        worst = max((each["verdict"] for each in limits), key=VERDICTS.index)
        entry |= {"limits": [*limits], "verdict": worst}
    return entry


def _fit(answer: Answer) -> dict:
    raw = answer.record.raw
    found = {
        "family": answer.levels.settings["family"],
        "p_value": answer.match.p_value,
        "misfit": answer.misfit,
        "parts": answer.match.parts,
        "motions": [*answer.motions],
        "resolved": not answer.unresolved and not answer.misfit,
        "why_unresolved": answer.unresolved or None,
        "effective_size": answer.effective_size,
        "prior_p_value": answer.prior_p_value,
        "far_from_prior": answer.far_from_prior,
        "moves": raw.moves,
        "moves_sd": raw.first_motion_sd,
        "missing": int(np.isnan(raw.left).sum()),
        "masked": int((raw.doubts[raw.inside] != "").sum()),
        "noise": raw.noise_at(raw.step).sd,
    }
    if answer.record.timed:
        found |= {"contact_time": raw.contact.time - raw.moves, "contact_sd": raw.contact.sd}
        found["contact_surprise"] = answer.surprise
        if np.isfinite(raw.contact.main):
            found["main_contact_time"] = raw.contact.main - raw.moves
    return found | ({"trigger": trigger} if np.isfinite(trigger := raw.contact.trigger) else {})


def _drawn(draws: np.ndarray | None) -> dict:
    """Median and central intervals of draws, or none."""
    if draws is None:
        return {"median": None, "interval_50": None, "interval_95": None}
    middle, *ends = np.quantile(draws, _LEVELS)
    return {"median": middle, "interval_50": ends[:2], "interval_95": ends[2:]}


def _parameters(answer: Answer) -> dict:
    found = {}
    for k, each in enumerate(PARAMETERS):
        draws = None if answer.draws is None else answer.inferred(each.name)
        row = found[each.name] = {"unit": each.unit, "meaning": each.meaning} | _drawn(draws)
        if each.name in WITH_CONTACT and draws is not None and answer.may_slide:  # where it touches
            row |= _drawn(None) | {"reason": MAY_SLIDE}
        if answer.prior_share is not None:
            found[each.name]["prior_share"] = answer.prior_share[k]
        if answer.prior_sds is not None:
            found[each.name]["prior_sds"] = answer.prior_sds[k]
    return found


def _mechanisms(answer: Answer) -> dict:
    """What the drive has beside the model: how probably, and how much of it."""
    return {
        name: {"unit": "ms" if name == "build_up" else "1", "meaning": MECHANISMS[name]}
        | {"probability": np.mean(draws != 0.0)}
        | _drawn(draws)
        for name, draws in (answer.draws.mechanisms if answer.draws else {}).items()
    }


def _quantities(answer: Answer) -> dict:
    """Quantities that are no parameters, as far as the record may show them at all."""
    found = {}
    motion = answer.record.motion
    for name, each in quantities_of(motion, answer.speeds, of=None).items():
        row = {"unit": each.unit, "meaning": _WIPE[motion] if name == "wipe" else each.meaning}
        reason, source = answer.why_not(name), None
        if name == "latch_time" and reason:
            continue
        if reason:
            row |= _drawn(None)
        elif answer.is_inferred(name) and answer.draws is not None:
            row |= _drawn(answer.inferred(name))
            source = "inferred"
        else:
            measured = answer.measured[name]
            ends = [measured.value + sds * measured.sd for sds in (-NORMAL[95], NORMAL[95])]
            ends[0] = max(ends[0], min(measured.value, 0.0))  # a way or a time is not negative
            row |= {"median": measured.value, "interval_50": None, "interval_95": ends}
            source = "measured" if answer.alone(name) else f"measured, {EVENTS[motion]} inferred"
        found[name] = row | {"source": source, "reason": reason or None}
    return found | _from_a_tenth(answer)


def _from_a_tenth(answer: Answer) -> dict:
    """When the drive is released and its contact switches, from 10 % of the way on, which a record
    shows; a release that builds up slowly it does not.
    """
    if answer.draws is None:
        return {}
    motion, found = answer.record.motion, {}
    events = {"release": answer.draws.release[motion]}
    if not answer.may_slide:
        events[EVENTS[motion]] = answer.draws.switching[motion]
    for event, draws in events.items():
        about = {"unit": "ms", "meaning": f"{event}, counted from 10 % of the way"}
        about |= _drawn(draws) | {"source": "inferred", "reason": None}
        found[event + FROM_TENTH] = about
    return found


def _together(motion: str, records: Sequence[Mapping]) -> dict:
    """What the accepted records of a motion have in common; nothing of fewer than two."""
    there = [each for each in records if each["accepted"] and each["motion"] == motion]
    if len(there) < _FEWEST:
        return {}
    found: dict = {"records": len(there)}
    for group in ("parameters", "quantities"):
        names = dict.fromkeys(name for each in there for name in each[group])
        rows = {name: [e[group][name] for e in there if name in e[group]] for name in names}
        found[group] = {n: {"unit": each[0]["unit"]} | _spread(each) for n, each in rows.items()}
        for name, each in rows.items() if group == "quantities" else ():
            found[group][name]["source"] = next((e["source"] for e in each if e["source"]), None)
    if "limits" in there[0]:
        found["limits"] = {
            limit["name"]: {
                verdict: sum(each["limits"][k]["verdict"] == verdict for each in there)
                for verdict in VERDICTS
            }
            for k, limit in enumerate(there[0]["limits"])
        }
    return found


def _spread(rows: Sequence[Mapping]) -> dict:
    """Of a parameter or quantity in several records, how many tell it, and why others do not."""
    known = [row for row in rows if row["median"] is not None]
    reasons = Counter(row.get("reason") or "not inferred" for row in rows if row["median"] is None)
    found = {"told": len(known), "of": len(rows), "reasons": dict(reasons)}
    if not known:
        return found | dict.fromkeys(("median", "lowest", "highest", "sd", "half_interval_95"))
    medians = np.array([row["median"] for row in known])
    halves = [(row["interval_95"][1] - row["interval_95"][0]) / 2.0 for row in known]
    return found | {
        "median": np.median(medians),
        "lowest": medians.min(),
        "highest": medians.max(),
        "sd": medians.std(ddof=1) if len(known) >= _FEWEST else np.nan,
        "half_interval_95": np.median(halves),
    }


def table_of(document: Mapping) -> str:
    """Return the records of a document as CSV.

    Beside what stands in the document of each parameter and quantity, every row has what is known
    of its record: ``part_PART`` of each part of the motion, ``exceeded_LIMIT``, the probabilities
    of limits, and ``verdict``. A rejected record is one row without numbers.
    """
    rows = [row for record in document["records"] for row in _rows(record)]
    names = dict.fromkeys([*_FIRST, *(name for row in rows for name in row)])
    return table_text([*names], rows)


def _rows(record: Mapping) -> list[dict]:
    """A row for each parameter and quantity of a record, or one of a rejected record."""
    about = {name: each for name, each in record.items() if name not in _LEFT_OUT}
    about["remarks"] = "; ".join(record["remarks"])
    if not record["accepted"]:
        return [about]
    fit = dict(record["fit"])
    parts = {f"part_{name.replace(' ', '_')}": each for name, each in fit.pop("parts").items()}
    about |= fit | {"motions": " ".join(fit["motions"])} | parts
    about |= {f"exceeded_{e['name']}": e["probability"] for e in record.get("limits", [])}
    return [
        {"kind": kind, "output": name, **_numbers(each), **about}
        for group, kind in _KINDS.items()
        for name, each in record[group].items()
    ]


def _numbers(each: Mapping) -> dict:
    """A parameter or quantity in columns; its meaning is no number."""
    found = {"unit": each["unit"], "median": each["median"]}
    for name in ("interval_50", "interval_95"):
        ends = each[name] or (None, None)
        found |= {f"{name}_{end}": v for end, v in zip(("lower", "upper"), ends, strict=True)}
    more = ("source", "prior_share", "prior_sds", "probability")
    return found | {name: each[name] for name in more if name in each}


def plainly(value: object) -> object:
    """A number, flag, text or array of them as JSON has it, numbers to six digits.

    >>> plainly({"sd": np.array([2.0 / 3.0, np.nan])})
    {'sd': [0.666667, None]}
    """
    if isinstance(value, Mapping):
        return {key: plainly(each) for key, each in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plainly(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.6g}") if np.isfinite(value) else None
    return value
