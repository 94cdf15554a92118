"""The result of a diagnosis as data: its records, what they share, and the verdict.

JSON is this data; ``tables`` and ``report`` render it. docs/usage.md explains the keys. A number
that is not known is None.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from breaker.common.numerals import in_digits, in_p, natural
from breaker.common.plain_values import Note, Plain, note_of, plainly
from breaker.common.text import table_text
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.identity import doubts_about
from breaker.diagnosis.limits import VERDICTS, Evidence, Simultaneity, Verdict, simultaneity_of
from breaker.diagnosis.words import say
from breaker.family.networks import EFFECTS
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import ABOUT, ANSWERED, CURRENTS, SHARES, quantities_of
from breaker.records.files import printable

if TYPE_CHECKING:
    from breaker.model.prior import Prior

_OF_OTHER_CHANNELS = {*ANSWERED, *CURRENTS, "main_closing_time", "main_opening_time", "arcing_wipe"}


@dataclass(frozen=True, kw_only=True)
class Value(Plain):
    """A parameter, an effect or a quantity, with its central 95 % interval.

    Attributes:
        reason: Why there is no value.
        source: "measured", "estimated", or "mixed": read from the record at the estimated contact
            touch or separation.
        zone: Points between which a speed is the mean.
        prior_share: Variance of the logarithm as a share of the prior's.
        percentile: Percentile of the median in a given prior.
        probability: Probability that the drive has an effect.
    """

    unit: str
    meaning: str
    median: float | None
    interval_95: Sequence[float] | None = None
    reason: Note | None = None
    source: str | None = None
    zone: str | None = None
    prior_share: float | None = None
    percentile: float | None = None
    probability: float | None = None

    @property
    def half(self) -> float:
        """Half of the 95 % interval."""
        low, high = self.interval_95
        return (high - low) / 2.0


@dataclass(frozen=True, kw_only=True)
class Fit(Plain):
    """How a record lies in the family, and how it was read. Times are in ms of the file, or after
    the first motion (``contact_time``, ``main_contact_time``).

    Attributes:
        p_value: Share of simulated drives that are more unusual.
        parts: Residual in each part of the motion, over that which 99 % of drives stay below.
        motions: Motions from which parameters are estimated.
        resolved: Whether parameters are estimated; else ``reason`` says why not.
        contact_deviation: Of the recorded contact from the time that the travel implies, in sds.
        missing, masked: Number of samples.
    """

    family: str
    p_value: float
    inside_family: bool
    parts: Mapping[str, float | None]
    motions: Sequence[str]
    resolved: bool
    reason: Note | None
    effective_size: float | None
    first_motion: float
    first_motion_sd: float
    missing: int
    masked: int
    noise: float
    trigger: float | None = None
    contact_time: float | None = None
    contact_sd: float | None = None
    contact_deviation: float | None = None
    main_contact_time: float | None = None

    @property
    def switches(self) -> float:
        """Time of the recorded contact, ms of the file; nan without one."""
        return np.nan if self.contact_time is None else self.first_motion + self.contact_time


@dataclass(frozen=True)
class RecordResult(Plain):
    """What is known of a record, or why it was rejected.

    Attributes:
        about: What the table of operations states.
        part: "from" and "to", ms, of a part of the file.
    """

    file: str
    operation: int
    motion: str
    about: Mapping[str, object]
    part: Mapping[str, float]
    reason: Note | None
    remarks: Sequence[Note]
    fit: Fit | None = None
    parameters: Mapping[str, Value] | None = None
    effects: Mapping[str, Value] | None = None
    quantities: Mapping[str, Value] | None = None
    limits: Sequence[Verdict] | None = None

    @property
    def accepted(self) -> bool:
        """Whether the record could be used."""
        return self.reason is None

    @property
    def phase(self) -> str:
        """Name of the phase or channel; empty if unknown."""
        return self.about.get("phase") or ""

    @property
    def verdict(self) -> str:
        """The worst verdict on its limits; empty without limits."""
        return max((each.verdict for each in self.limits or ()), key=VERDICTS.index, default="")

    def plain(self) -> dict:
        """Return the values by name, those of ``about`` and ``part`` among them."""
        values = super().plain()
        first = {name: values.pop(name) for name in ("file", "operation", "motion")}
        first |= values.pop("about") | values.pop("part") | {"accepted": self.accepted}
        return first | values | ({"verdict": self.verdict} if self.limits else {})


@dataclass(frozen=True)
class DiagnosisResult(Plain):
    """The result of a call.

    Attributes:
        warnings: To be read first.
        remarks: On what is given beside the records.
        reference: Differences from a good record.
    """

    warnings: Sequence[Note]
    remarks: Sequence[Note]
    settings: Mapping[str, object]
    records: Sequence[RecordResult]
    simultaneity: Sequence[Simultaneity]
    reference: Sequence[Mapping] | None = None

    @property
    def limits(self) -> dict[str, list[tuple[str, RecordResult | None]]]:
        """Names of limits by verdict, with the record; without one for simultaneity."""
        by: dict[str, list] = {verdict: [] for verdict in VERDICTS}
        for record in self.records:
            for limit in record.limits or ():
                by[limit.verdict].append((limit.name, record))
        for each in self.simultaneity:
            if each.limit is not None:
                by[each.verdict or "inconclusive"].append((f"simultaneity {each.motion}", None))
        return by

    def plain(self) -> dict:
        """Return the values by name, after the worst verdict of all limits."""
        limits = self.limits
        verdict = next((each for each in VERDICTS[::-1] if limits[each]), None)
        return {"verdict": verdict} | super().plain()


def result_of(
    estimates: Sequence[Estimate],
    verdicts: Sequence[Sequence[Verdict]],
    *,
    prior: "Prior | None" = None,
    remarks: Sequence[str] = (),
    settings: Mapping[str, object] | None = None,
    simultaneity: Mapping[str, float | None] | None = None,
) -> DiagnosisResult:
    """Return estimates as data.

    Args:
        estimates: What ``Inference.infer`` returns.
        verdicts: What ``judged`` returns, for each estimate.
        prior: A prior of the type, if one is given.
        remarks: On what is given beside the records.
        settings: With which the estimates were made.
        simultaneity: Largest allowed time between poles by motion, ms; None for any.
    """
    records = [_record(*both, prior) for both in zip(estimates, verdicts, strict=True)]
    poles = [group for group in operations_of(records) if len(group) > 1]
    result = DiagnosisResult(
        warnings=[*map(note_of, doubts_about([each.record for each in estimates]))],
        remarks=[*map(note_of, remarks)],
        settings=settings or {},
        records=records,
        simultaneity=[simultaneity_of(group, simultaneity or {}) for group in poles],
    )
    return plainly(result)


def operations_of(records: Sequence[RecordResult]) -> list[list[RecordResult]]:
    """Return accepted records by operation and motion, all poles together, in order of files."""
    groups: dict[tuple, list[RecordResult]] = {}
    for each in records:
        if each.accepted:
            key = each.operation, each.motion
            there = {other.phase for other in groups.get(key, ())}
            groups.setdefault((*key, each.file) if each.phase in there else key, []).append(each)
    for group in groups.values():
        group.sort(key=lambda each: natural(each.file))
    first = lambda group: (natural(group[0].file), group[0].fit.first_motion)  # noqa: E731
    return sorted(groups.values(), key=first)


def _record(estimate: Estimate, verdicts: Sequence[Verdict], prior: "Prior | None") -> RecordResult:
    record, operation = estimate.record, estimate.record.operation
    part = {"from": operation.begin, "to": operation.end}
    part = {name: at for name, at in part.items() if at == at}
    about = {name: getattr(operation, name) for name in ABOUT}
    about = {name: v for name, v in about.items() if v == v and v not in ("", None)}
    first = (printable(operation.file), operation.number, record.motion, about, part)
    if record.reason:
        return RecordResult(*first, note_of(record.reason), [*map(note_of, estimate.remarks)])
    return RecordResult(
        *first,
        reason=None,
        remarks=[*map(note_of, estimate.remarks)],
        fit=_fit(estimate),
        parameters=_parameters(estimate, prior),
        effects=_effects(estimate),
        quantities=_quantities(estimate),
        limits=verdicts or None,
    )


def _fit(estimate: Estimate) -> Fit:
    raw, match = estimate.record.raw, estimate.match
    contact: dict = {"trigger": raw.contact.trigger}
    if estimate.record.timed:
        contact["contact_time"] = raw.contact.time - raw.moves
        contact["contact_sd"] = raw.contact.sd
        contact["contact_deviation"] = estimate.surprise
        contact["main_contact_time"] = raw.contact.main - raw.moves
    return Fit(
        family=estimate.levels.settings["family"],
        p_value=match.p_value,
        inside_family=not estimate.misfit,
        parts=match.parts,
        motions=estimate.motions,
        resolved=not estimate.unresolved and not estimate.misfit,
        reason=note_of(_outside(estimate) if estimate.misfit else estimate.unresolved),
        effective_size=estimate.effective_size,
        first_motion=raw.moves,
        first_motion_sd=raw.reading.start_sd,
        missing=int(np.isnan(raw.left).sum()),
        masked=int((raw.doubts[raw.inside] != "").sum()),
        noise=raw.noise_at(raw.step).sd,
        **contact,
    )


def _outside(estimate: Estimate) -> str:
    parts = estimate.match.parts.items()
    parts = ", ".join(f"{name} {in_digits(of, 2)} times" for name, of in parts if of > 1.0)
    code = "no-parameters-in-parts" if parts else "no-parameters"
    family, p = estimate.levels.settings["family"], in_p(estimate.match.p_value)
    return say(code, family=family, p=p, parts=parts)


def _parameters(estimate: Estimate, prior: "Prior | None") -> dict[str, Value]:
    values = {}
    for k, each in enumerate(PARAMETERS):
        reason = "" if estimate.draws is None else estimate.why_not(each.name)
        known = {"median": None, "reason": note_of(reason)}
        if estimate.draws is not None and not reason:
            known = Evidence(draws=estimate.inferred(each.name)).known
        if prior is not None and known["median"] is not None:
            sds = np.log(known["median"] / prior.medians[k]) / prior.log_sds[k]
            known["percentile"] = 100.0 * NormalDist().cdf(sds)
        if estimate.prior_share is not None:
            known["prior_share"] = estimate.prior_share[k]
        values[each.name] = Value(unit=each.unit, meaning=each.meaning, **known)
    return values


def _effects(estimate: Estimate) -> dict[str, Value]:
    """Return the additional effects of the family: their probability and size."""
    values = {}
    for name, draws in (estimate.draws.effects if estimate.draws else {}).items():
        unit = "ms" if name == "build_up" else "1"
        about = {"meaning": EFFECTS[name], "probability": np.mean(draws != 0.0)}
        values[name] = Value(unit=unit, **about, **Evidence(draws=draws).known)
    return values


def _quantities(estimate: Estimate) -> dict[str, Value]:
    """Return the quantities of the motion, as far as the record may show them at all."""
    values = {}
    record = estimate.record
    for name, each in quantities_of(record.motion, estimate.speeds, of=None).items():
        reason = estimate.why_not(name)
        no_trigger = np.isnan(record.raw.contact.trigger) and name in {"reaction_time", *SHARES}
        if no_trigger or (reason and name in _OF_OTHER_CHANNELS):
            continue
        known: dict = {}
        if reason:
            known = {"median": None, "reason": note_of(reason)}
        elif estimate.is_inferred(name) and estimate.draws is not None:
            known = Evidence(draws=estimate.inferred(name)).known | {"source": "estimated"}
        else:
            measured = estimate.measured[name]
            known = Evidence(measured.value, measured.sd).known
            ends = known["interval_95"]
            ends[0] = max(ends[0], min(measured.value, 0.0))  # a distance or time is not negative
            known["source"] = "measured" if estimate.measured_directly(name) else "mixed"
        about = {"unit": each.unit, "meaning": each.meaning, "zone": each.zone or None}
        values[name] = Value(**about, **known)
    return values


# ---- a table for spreadsheets --------------------------------------------------------------------

_OF_FIT = ("family", "p_value", "inside_family", "resolved", "first_motion", "noise")
_OF_VALUE = ("unit", "median", "source", "zone", "prior_share", "percentile", "probability")
_ENDS = ("interval_95_lower", "interval_95_upper")
_KINDS = {"parameters": "parameter", "effects": "effect", "quantities": "quantity"}


def csv_of(result: DiagnosisResult) -> str:
    """Return the records of a result as CSV: a row for each parameter, effect and quantity, or one
    row of a rejected record. JSON has more.
    """
    about = dict.fromkeys(name for record in result.records for name in record.about)
    names = ["file", "operation", "motion", *about, "kind", "output", *_OF_VALUE, *_ENDS]
    names += ["reason", *_OF_FIT, "verdict", "remarks"]
    return table_text(names, (row for record in result.records for row in _rows(record)))


def _rows(record: RecordResult) -> Iterator[dict]:
    own = vars(record) | record.about | {"verdict": record.verdict}
    own["remarks"] = "; ".join(map(str, record.remarks))
    if not record.accepted:
        yield own
    for group, kind in _KINDS.items():
        for name, each in (getattr(record, group) or {}).items():
            value = vars(each) | dict(zip(_ENDS, each.interval_95 or (None, None), strict=True))
            yield own | vars(record.fit) | value | {"kind": kind, "output": name}
