"""An answer as one document: its records, each with what is known of it, and what they share.

Words, tables, JSON and the test report are renderings of it. docs/usage.md explains the keys of the
JSON. A number that is not known is None.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.common.plain_values import Plain, plainly
from breaker.common.safe_text import table_text
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.identity import doubts_about
from breaker.diagnosis.limits import NORMAL, VERDICTS, Verdict
from breaker.family.networks import EFFECTS
from breaker.model.parameters import MOTIONS, PARAMETERS
from breaker.model.quantities import (
    ABOUT,
    ANSWERED,
    CURRENTS,
    EVENTS,
    SHARES,
    quantities_of,
)
from breaker.records.files import printable

_FEWEST = 2  # records that are summed up together
_LEVELS = (0.5, 0.25, 0.75, 0.025, 0.975)
_KINDS = {"parameters": "parameter", "mechanisms": "mechanism", "quantities": "quantity"}
_FIRST = ("motion", "operation", "file", "kind", "output", "unit", "median")
_FIRST += tuple(f"interval_{of}_{end}" for of in (50, 95) for end in ("lower", "upper"))
_LEFT_OUT = (*_KINDS, "fit", "limits", "remarks")


@dataclass(frozen=True)
class Value(Plain):
    """A number with the ends of its central intervals."""

    unit: str
    meaning: str
    median: float | None
    interval_50: Sequence[float] | None
    interval_95: Sequence[float] | None
    reason: str | None = None  # why it is not told, though others are
    prior_share: float | None = None  # variance of the prior that is left, as a share of it
    probability: float | None = None  # that the drive has a mechanism at all

    @property
    def half(self) -> float:
        """Half of the 95 % interval."""
        low, high = self.interval_95
        return (high - low) / 2.0


@dataclass(frozen=True, kw_only=True)
class QuantityValue(Value):
    """A quantity that is no parameter: its source, such as "measured", or why it is not known; of
    a speed the zone, from where to where it is the mean.
    """

    source: str | None
    zone: str | None = None

    def plain(self) -> dict:
        """Return the values by name, the reason also where it is None."""
        return super().plain() | {"reason": self.reason}


@dataclass(frozen=True, kw_only=True)
class Fit(Plain):
    """How a record is like the drives of a family, and how it was read."""

    family: str
    p_value: float
    misfit: bool
    parts: Mapping[str, float | None]
    motions: Sequence[str]
    resolved: bool
    why_unresolved: str | None
    effective_size: float | None
    moves: float
    moves_sd: float
    missing: int
    masked: int
    noise: float
    contact_time: float | None = None  # ms after the first motion
    contact_sd: float | None = None
    contact_surprise: float | None = None
    main_contact_time: float | None = None
    trigger: float | None = None

    @property
    def switches(self) -> float:
        """When the contact switches in the record, ms; nan where it was not timed."""
        return np.nan if self.contact_time is None else self.moves + self.contact_time

    def plain(self) -> dict:
        """Return the values by name, with the surprise of a contact that was timed."""
        timed = {} if self.contact_time is None else {"contact_surprise": self.contact_surprise}
        return super().plain() | timed


@dataclass(frozen=True)
class RecordResult(Plain):
    """What is known of a record; of a rejected one, why it is."""

    file: str
    operation: int
    motion: str
    about: Mapping[str, object]  # what the table of operations states, of what it states of any
    part: Mapping[str, float]  # "from" and "to", ms, of a part of the file
    reason: str | None
    remarks: Sequence[str]
    fit: Fit | None = None
    parameters: Mapping[str, Value] | None = None
    mechanisms: Mapping[str, Value] | None = None
    quantities: Mapping[str, QuantityValue] | None = None
    limits: Sequence[Verdict] | None = None

    @property
    def accepted(self) -> bool:
        """Whether the record could be used."""
        return self.reason is None

    @property
    def phase(self) -> str:
        """Name of the phase or channel; empty where none is known."""
        return self.about.get("phase") or ""

    @property
    def verdict(self) -> str:
        """The worst verdict on its limits; empty without limits."""
        return max((each.verdict for each in self.limits or ()), key=VERDICTS.index, default="")

    def plain(self) -> dict:
        """Return the values by name, those of ``about`` and ``part`` among them."""
        found = super().plain()
        first = {name: found.pop(name) for name in ("file", "operation")}
        first |= found.pop("about") | found.pop("part")
        first |= {"motion": found.pop("motion"), "accepted": self.accepted}
        return first | found | ({"verdict": self.verdict} if self.limits else {})


@dataclass(frozen=True)
class Spread(Plain):
    """Medians of a parameter or quantity in several records: in how many it is told, and why not
    in the others; and half of the interval of one record, as most have it.
    """

    unit: str
    told: int
    of: int
    reasons: Mapping[str, int]
    median: float | None
    lowest: float | None
    highest: float | None
    sd: float | None
    half_interval_95: float | None


@dataclass(frozen=True, kw_only=True)
class QuantitySpread(Spread):
    """The same of a quantity, with its source where it is known, and the zone of a speed."""

    source: str | None
    zone: str | None = None


@dataclass(frozen=True)
class Together(Plain):
    """What the accepted records of a motion have in common, and how many have which verdict."""

    records: int
    parameters: Mapping[str, Spread]
    quantities: Mapping[str, QuantitySpread]
    limits: Mapping[str, Mapping[str, int]] | None = None


@dataclass(frozen=True)
class DiagnosisResult(Plain):
    """All answers of a call: what is said first, each record, and what several share."""

    warnings: Sequence[str]
    drive: Mapping[str, object]
    settings: Mapping[str, object]
    records: Sequence[RecordResult]
    together: Mapping[str, Together]
    reference: Sequence[Mapping] | None = None  # differences from a good record


def document(
    answers: Sequence[Estimate],
    limits: Sequence[Sequence[Verdict]],
    drive: Mapping[str, object],
    settings: Mapping[str, object],
) -> DiagnosisResult:
    """Return answers as a document.

    Args:
        answers: What ``infer_drive`` returns.
        limits: Of each, what ``judged`` returns.
        drive: What is known of the drive as a whole: goes into the document as it is.
        settings: What the answers were made with: the same.
    """
    known = [n for n in ABOUT if any(_about(each)[n] is not None for each in answers)]
    records = [_record(*both, known) for both in zip(answers, limits, strict=True)]
    together = {motion: each for motion in MOTIONS if (each := _together(motion, records))}
    warnings = doubts_about([each.record for each in answers])
    return plainly(DiagnosisResult(warnings, drive, settings, records, together))


def _about(answer: Estimate) -> dict:
    """What a table knows of an operation, None where it does not."""
    operation = answer.record.operation
    values = {name: getattr(operation, name) for name in ABOUT}
    return {n: None if each == "" or each != each else each for n, each in values.items()}


def _record(answer: Estimate, limits: Sequence[Verdict], known: Sequence[str]) -> RecordResult:
    """The answer of one record."""
    record, operation = answer.record, answer.record.operation
    part = {"from": operation.begin, "to": operation.end}
    found: dict = {}
    if not record.reason:
        found = {"fit": _fit(answer), "parameters": _parameters(answer)}
        found |= {"mechanisms": _mechanisms(answer), "quantities": _quantities(answer)}
        found["limits"] = limits or None
    return RecordResult(
        printable(operation.file),
        operation.number,
        record.motion,
        {name: _about(answer)[name] for name in known},
        {name: at for name, at in part.items() if at == at},
        record.reason or None,
        answer.remarks,
        **found,
    )


def _fit(answer: Estimate) -> Fit:
    raw = answer.record.raw
    contact: dict = {"trigger": raw.contact.trigger}
    if answer.record.timed:
        contact |= {"contact_time": raw.contact.time - raw.moves, "contact_sd": raw.contact.sd}
        contact["contact_surprise"] = answer.surprise
        contact["main_contact_time"] = raw.contact.main - raw.moves
    return Fit(
        family=answer.levels.settings["family"],
        p_value=answer.match.p_value,
        misfit=answer.misfit,
        parts=answer.match.parts,
        motions=answer.motions,
        resolved=not answer.unresolved and not answer.misfit,
        why_unresolved=answer.unresolved or None,
        effective_size=answer.effective_size,
        moves=raw.moves,
        moves_sd=raw.reading.start_sd,
        missing=int(np.isnan(raw.left).sum()),
        masked=int((raw.doubts[raw.inside] != "").sum()),
        noise=raw.noise_at(raw.step).sd,
        **contact,
    )


def _drawn(draws: np.ndarray | None) -> dict:
    """Median and central intervals of draws, or none."""
    if draws is None:
        return dict.fromkeys(("median", "interval_50", "interval_95"))
    middle, *ends = np.quantile(draws, _LEVELS)
    return {"median": middle, "interval_50": ends[:2], "interval_95": ends[2:]}


def _parameters(answer: Estimate) -> dict[str, Value]:
    found = {}
    for k, each in enumerate(PARAMETERS):
        reason = "" if answer.draws is None else answer.why_not(each.name)
        known = {"reason": reason or None}
        known |= _drawn(None if reason or answer.draws is None else answer.inferred(each.name))
        if answer.prior_share is not None:
            known["prior_share"] = answer.prior_share[k]
        found[each.name] = Value(each.unit, each.meaning, **known)
    return found


def _mechanisms(answer: Estimate) -> dict[str, Value]:
    """What the drive has beside the model: how probably, and how much of it."""
    return {
        name: Value(
            "ms" if name == "build_up" else "1",
            EFFECTS[name],
            **_drawn(draws),
            probability=np.mean(draws != 0.0),
        )
        for name, draws in (answer.draws.effects if answer.draws else {}).items()
    }


def _quantities(answer: Estimate) -> dict[str, QuantityValue]:
    """Quantities that are no parameters, as far as the record may show them at all."""
    found = {}
    motion = answer.record.motion
    zones = {each.name: each.words for each in answer.speeds if each.motion == motion}
    for name, each in quantities_of(motion, answer.speeds, of=None).items():
        reason, source, known = answer.why_not(name), None, _drawn(None)
        if reason and name in {*ANSWERED, *CURRENTS}:
            continue
        if name in {"reaction_time", *SHARES} and np.isnan(answer.record.raw.contact.trigger):
            continue
        if not reason and answer.is_inferred(name) and answer.draws is not None:
            known, source = _drawn(answer.inferred(name)), "inferred"
        elif not reason:
            measured = answer.measured[name]
            ends = [measured.value + sds * measured.sd for sds in (-NORMAL[95], NORMAL[95])]
            ends[0] = max(ends[0], min(measured.value, 0.0))  # a way or a time is not negative
            direct = answer.measured_directly(name)
            source = "measured" if direct else f"measured, {EVENTS[motion]} inferred"
            known |= {"median": measured.value, "interval_95": ends}
        about = {"source": source, "reason": reason or None, "zone": zones.get(name)}
        found[name] = QuantityValue(each.unit, each.meaning, **known, **about)
    return found


def _together(motion: str, records: Sequence[RecordResult]) -> Together | None:
    """What the accepted records of a motion have in common; nothing of fewer than two."""
    there = [each for each in records if each.accepted and each.motion == motion]
    if len(there) < _FEWEST:
        return None
    quantities = {}
    for name, some in _by_name([each.quantities for each in there]).items():
        about = {"source": next((each.source for each in some if each.source), None)}
        about["zone"] = some[0].zone
        quantities[name] = QuantitySpread(some[0].unit, **_spread(some), **about)
    parameters = _by_name([each.parameters for each in there]).items()
    of = {name: Spread(some[0].unit, **_spread(some)) for name, some in parameters}
    by_limit = {
        limit.name: Counter(each.limits[k].verdict for each in there)
        for k, limit in enumerate(there[0].limits or ())
    }
    counts = {name: {each: count[each] for each in VERDICTS} for name, count in by_limit.items()}
    return Together(len(there), of, quantities, counts or None)


def _by_name(found: Sequence[Mapping[str, Value]]) -> dict[str, list]:
    """Estimates of several records by name."""
    names = dict.fromkeys(name for each in found for name in each)
    return {name: [each[name] for each in found if name in each] for name in names}


def _spread(rows: Sequence[Value]) -> dict:
    """Of a parameter or quantity in several records, how many tell it, and why others do not."""
    known = [row for row in rows if row.median is not None]
    reasons = Counter(row.reason or "not inferred" for row in rows if row.median is None)
    found = {"told": len(known), "of": len(rows), "reasons": reasons}
    if not known:
        return found | dict.fromkeys(("median", "lowest", "highest", "sd", "half_interval_95"))
    medians = np.array([row.median for row in known])
    return found | {
        "median": np.median(medians),
        "lowest": medians.min(),
        "highest": medians.max(),
        "sd": medians.std(ddof=1) if len(known) >= _FEWEST else np.nan,
        "half_interval_95": np.median([row.half for row in known]),
    }


def table_of(document: DiagnosisResult) -> str:
    """Return the records of a document as CSV.

    Beside what stands in the document of each parameter and quantity, every row has what is known
    of its record: ``part_PART`` of each part of the motion, ``exceeded_LIMIT``, the probabilities
    of limits, and ``verdict``. A rejected record is one row without numbers.
    """
    rows = [row for record in document.records for row in _rows(record)]
    names = dict.fromkeys([*_FIRST, *(name for row in rows for name in row)])
    return table_text([*names], rows)


def _rows(record: RecordResult) -> Iterator[dict]:
    """A row for each parameter and quantity of a record, or one of a rejected record."""
    about = {name: each for name, each in record.plain().items() if name not in _LEFT_OUT}
    about["remarks"] = "; ".join(record.remarks)
    if not record.accepted:
        yield about
        return
    fit = record.fit.plain()
    parts = {f"part_{name.replace(' ', '_')}": each for name, each in fit.pop("parts").items()}
    about |= fit | {"motions": " ".join(fit["motions"])} | parts
    about |= {f"exceeded_{each.name}": each.p_exceeded for each in record.limits or ()}
    for group, kind in _KINDS.items():
        for name, each in (getattr(record, group) or {}).items():
            yield {"kind": kind, "output": name, **_numbers(each), **about}


def _numbers(estimate: Value) -> dict:
    """A parameter or quantity in columns; its meaning and reason are no numbers."""
    found = estimate.plain()
    first = {name: found.pop(name) for name in ("unit", "median")}
    for name in ("interval_50", "interval_95"):
        ends = found.pop(name, None) or (None, None)
        first |= {f"{name}_{end}": v for end, v in zip(("lower", "upper"), ends, strict=True)}
    return first | {name: each for name, each in found.items() if name not in ("meaning", "reason")}
