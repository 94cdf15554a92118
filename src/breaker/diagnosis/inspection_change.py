"""Compare two inspections of a drive, as one document: data for JSON, and its sentences and tables.

The order is: measured values against limits, measured changes, explanations, then parameters that
the records determine. docs/usage.md explains the keys of the JSON.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from breaker.common.document import Cell, Document, Remark, Section, Table
from breaker.common.numerals import distinct, first_of, in_digits, in_p
from breaker.common.plain_values import note_of, plainly
from breaker.common.randomness import generator
from breaker.common.wording import Sentence
from breaker.configuration.definitions import advice_on, family_of
from breaker.diagnosis.changes import (
    SURE,
    NetworkChanges,
    Pair,
    QuantityChange,
    compare,
    inferred_changes,
    mean_error,
    mean_stroke,
    measured_changes,
    readings_of,
)
from breaker.diagnosis.estimate import NOTHING, EstimateSettings
from breaker.diagnosis.explanations import (
    Explanation,
    explain,
    measured_differences,
    other_measurement,
    slack_differences,
)
from breaker.diagnosis.identity import (
    Difference,
    Inspections,
    check_phases,
    days_of,
    doubts_about,
    order_doubts,
    stated_differences,
)
from breaker.diagnosis.limits import Known, Verdict, judge
from breaker.diagnosis.reading import samples_of
from breaker.diagnosis.tables import limits_table
from breaker.diagnosis.words import say
from breaker.family.networks import shipped_networks
from breaker.family.sensitivities import shipped_sensitivities
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, NAMES, PARAMETERS
from breaker.model.quantities import Speed
from breaker.records.files import printable
from breaker.records.measurements import Measured
from breaker.records.record import Record
from breaker.records.rejections import DISTURBED
from breaker.shipped import KINDS

_NAMED = 4  # changes in a sentence; the table has all
_HEAD = ("", "unit", "before", "today", "change", "90 % interval", "P unchanged", "P worse")


@dataclass(frozen=True, eq=False, kw_only=True)
class InspectionChange(NetworkChanges):
    """The comparison of two inspections; its state may also be "different_setup".

    Attributes:
        settings: "seed" and "misfit_p_value".
        records: Number of records, by motion and inspection.
        rejected: "file", "motion" and "inspection" of records that were not used, and the "reason".
        differences: Differences in the measurement of both inspections.
        explanations: Explanations of the change, the most probable first.
        measured: Changes of measured quantities.
        inferred: Changes of parameters, then of additional effects.
        limits: Verdicts on the later inspection.
        advice: Parts to look at first.
        dates: Date of each inspection; empty where it is not known.
        doubts: Warnings about the records.
    """

    settings: Mapping[str, float]
    records: Mapping[str, Mapping[str, int]]
    rejected: Sequence[Mapping[str, str]]
    differences: Sequence[Difference]
    explanations: Sequence[Explanation]
    measured: Sequence[QuantityChange]
    inferred: Sequence[QuantityChange]
    limits: Sequence[Verdict] = ()
    advice: Sequence[str] = ()
    dates: Mapping[str, str] = field(default_factory=dict)
    doubts: Sequence[str] = ()

    def plain(self) -> dict:
        """Return the values by name but those of draws, after the sentences with their codes."""
        sentences = [note_of(each) for each in (*self.warnings, *self.summary)]
        values = super().plain()
        del values["draws"], values["wear"]
        return {"sentences": sentences, **values}

    @property
    def since(self) -> str:
        """The earlier inspection, by its date where it is known."""
        date = self.dates.get("before")
        return say("earlier-dated", date=date) if date else say("earlier")

    @property
    def reported(self) -> list[QuantityChange]:
        """Changes that are reported: none of inspections that were measured differently; inferred
        ones only where a measured quantity, or the records as a whole, changed.
        """
        if self.differences:
            return []
        measured = [row for row in self.measured if row.changed]
        same = sum(each.probability for each in self.explanations if each.cause == "none")
        inferred = self.inferred if measured or same <= 1.0 - SURE else ()
        return measured + [row for row in inferred if row.changed]

    @property
    def worse(self) -> list[str]:
        """Names of reported changes to the worse, or where neither side is worse."""
        return [row.name for row in self.reported if row.p_worse is None or row.is_worse]

    @property
    def warnings(self) -> list[str]:
        """Sentences that come first: about the records, and about another measurement."""
        if not self.differences:
            return [*self.doubts]
        differences = "; ".join(each.words for each in self.differences)
        return [*self.doubts, say("different-setup-check", differences=differences)]

    @property
    def summary(self) -> list[Sentence]:
        """Sentences on limits, measured changes, explanations, parameters, and rejected records."""
        by: dict[str, list[str]] = {}
        for limit in self.limits:
            by.setdefault(limit["verdict"], []).append(limit["name"])
        verdicts = "; ".join(f"{verdict}: {', '.join(names)}" for verdict, names in by.items())
        sentences = [say("limits", verdicts=verdicts)] if by else []
        rows = [row for row in self.measured if row.changed]
        rows.sort(key=lambda row: -abs(row.change[1]))
        sentences.append(_changes("measured", rows, self.since))
        changed = rows or any(each.cause != "none" for each in self.explanations[:1])
        if changed and not (self.differences and self.explained.code == "explained"):
            sentences.append(self.explained)
        own = [row for row in self.reported if not row.measured]
        sentences += [_changes("parameters", own, self.since)] if self.inferred else []
        unknown = [e.words for e in self.inferred if e.name in NAMES and not e.identifiable]
        sentences += [say("not-identifiable", names=", ".join(unknown))] if unknown else []
        sentences += self.limitations
        return sentences + [say("rejected", **each) for each in self.rejected]

    @property
    def explained(self) -> Sentence:
        """Explanations with a probability above 5 %."""
        likely = [each for each in self.explanations if each.probability > 1.0 - SURE]
        words, clauses = {parameter.name: parameter.word for parameter in PARAMETERS}, []
        for each in likely:
            about = {"parameter": words.get(each.parameter), "amount": _amount(each.change)}
            code = "several" if each.cause == "drive" and not each.parameter else each.cause
            clauses.append(say(f"cause-{code}", p=f"{each.probability:.2f}", **about))
        causes = "; or ".join(clauses)
        code = "explained-by-setup" if other_measurement(likely) else "explained"
        return say(code, causes=causes[:1].upper() + causes[1:])

    @property
    def limitations(self) -> list[Sentence]:
        """Reason why no change of a parameter is estimated; nothing if one is."""
        if self.state in ("estimated", "different_setup"):
            return []
        outside = [
            f"{motion} {inspection} ({in_p(match['p_value'])})"
            for motion, by in self.matches.items()
            for inspection, match in by.items()
            if match["p_value"] < self.settings["misfit_p_value"]
        ]
        about = {"outside": ", ".join(outside), "family": self.family, **self.agreement}
        return [say(f"{self.state.replace('_', '-')}-check", **about)]


def _changes(code: str, rows: Sequence[QuantityChange], since: str) -> Sentence:
    """Return the sentence on changes of one kind, the first few by name."""
    names = [f"{row.words} {_amount(row.if_changed)}" for row in rows]
    if not names:
        return say(f"{code}-unchanged")
    return say(f"{code}-changed", changes=first_of(names, _NAMED), since=since)


def _amount(change: Sequence[float]) -> str:
    """Return a change in words, such as "8 % lower (5 to 11 %)"."""
    if change[0] < 0.0 < change[2]:
        code, texts = "uncertain", distinct(change, 2, sign=True)
    else:
        code = "lower" if change[1] < 0.0 else "higher"
        texts = distinct(sorted(map(abs, change)), 2)
    return say(f"amount-{code}", low=texts[0], middle=texts[1], high=texts[2])


# ---- the comparison --------------------------------------------------------------------------


def compare_inspections(
    inspections: Inspections,
    speeds: Sequence[Speed],
    settings: EstimateSettings,
    *,
    limits: Sequence[Mapping[str, object]],
    advice: Mapping[str, str],
    same_transducer: bool,
) -> InspectionChange:
    """Return the comparison of two inspections.

    Args:
        inspections: Records "before" and "today", as ``read_operations`` returns them.
        speeds: Definitions of speeds.
        settings: Settings of the inference.
        limits: Entries of the section ``limits`` on which to judge the later inspection.
        advice: Parts to look at first, by name of a quantity that became worse.
        same_transducer: Whether both inspections have the same transducer and ratio. They also do
            if all records name one transducer.

    Raises:
        ValueError: If they state different phases, or no motion has a usable record in both.
    """
    doubts = check_phases(inspections)
    pair, rejected = _usable(inspections)
    used = {name: [e for e in some if not e.reason] for name, some in inspections.items()}
    rng, misfit = generator(settings.seed, "two visits"), settings.misfit_p_value
    changes = compare(pair, shipped_networks(*KINDS), rng, misfit_p_value=misfit)
    named_by = {each.operation.transducer for some in used.values() for each in some}
    explanations = explain(
        pair,
        shipped_sensitivities(changes.family),
        same_transducer=same_transducer or (len(named_by) == 1 and named_by != {""}),
        sliding=family_of(changes.family)["contacts"]["sliding"],
    )
    measured = measured_changes(pair, speeds)
    document = inspection_change(
        changes,
        measured,
        explanations,
        stated_differences(inspections) + slack_differences(used, measured),
        settings={"seed": settings.seed, "misfit_p_value": misfit},
        records={m: {"before": len(pair.before[m]), "today": len(pair.today[m])} for m in pair[0]},
        rejected=rejected,
        dates={name: days_of(some) for name, some in used.items()},
        doubts=[*_doubts(inspections, used), *doubts],
    )
    entries = from_list(limits, [*pair.before], speeds)
    verdicts = judge_today(document, pair.today, entries, speeds)
    return replace(document, limits=verdicts, advice=advice_on(document.worse, advice))


def inspection_change(
    changes: NetworkChanges,
    measured: Sequence[QuantityChange],
    explanations: Sequence[Explanation],
    differences: Sequence[Difference] = (),
    **about: object,
) -> InspectionChange:
    """Return the document of changes, explanations, and other differences in the measurement.

    Draws of the networks take a share of no change: the probability of another measurement. Of
    inspections that were measured differently, nothing inferred is reported. ``about`` has the
    other fields.
    """
    differences = [*differences, *measured_differences(explanations)]
    inferred = [] if differences else inferred_changes(changes, other_measurement(explanations))
    amounts = {row.name: row.if_changed for row in inferred if any(row.if_changed)}
    own = [replace(each, change=amounts.get(each.parameter, each.change)) for each in explanations]
    about |= {"measured": measured, "inferred": inferred, "explanations": plainly(own)}
    about |= {"differences": plainly(differences), **vars(changes)}
    return InspectionChange(**about | ({"state": "different_setup"} if differences else {}))


def _doubts(inspections: Inspections, used: Inspections) -> list[str]:
    """Return warnings about the records: dates, identities, disturbances and copies."""
    doubts = [*order_doubts(inspections)]
    doubts += [doubt for records in inspections.values() for doubt in doubts_about(records)]
    for record in (record for records in used.values() for record in records):
        about = {"file": printable(record.operation.file), "motion": record.motion}
        remarks = (e for e in record.raw.remarks_on() if getattr(e, "code", "") in DISTURBED)
        doubts += [say("disturbed", remark=remark, **about) for remark in remarks]
    first = {samples_of(record): printable(record.operation.file) for record in used["before"]}
    for record in used["today"]:
        if file := first.get(samples_of(record)):
            other = printable(record.operation.file)
            doubts.append(say("copy-of-before", file=file, other=other))
    return list(dict.fromkeys(doubts))


def _usable(inspections: Inspections) -> tuple[Pair, list[dict]]:
    """Return usable records of motions of both inspections, and the rejected records.

    Raises:
        ValueError: If there is no such motion.
    """
    shown = [{e.motion for e in some if not e.reason} for some in inspections.values()]
    motions = [motion for motion in MOTIONS if all(motion in some for some in shown)]
    rejected, by = [], {name: {m: [] for m in motions} for name in inspections}
    for name, record in ((name, each) for name, some in inspections.items() for each in some):
        file, reason = str(record.operation.file), record.reason
        if not reason and record.motion in motions:
            by[name][record.motion].append(record.raw)
            continue
        other = "today" if name == "before" else "before"
        reason = reason.removeprefix(f"{file}: ")
        reason = reason or say("not-in-both", other=other, motion=record.motion)
        about = {"file": file, "motion": record.motion, "inspection": name}
        rejected.append(about | {"reason": reason})
    if not motions:
        reasons = "".join(f"\n  {say('rejected', **each)}" for each in rejected)
        raise ValueError(say("nothing-to-compare", reasons=reasons))
    return Pair.of(**by), rejected


def judge_today(
    document: InspectionChange,
    today: Mapping[str, Sequence[Record]],
    limits: Sequence[Limit],
    speeds: Sequence[Speed],
) -> list[Verdict]:
    """Return verdicts on limits: on the means of the later inspection, and on changes."""
    if not limits:
        return []
    still = other_measurement(document.explanations)
    draws = {} if document.differences else document.shares(still)
    shown = {m: [raw.measured(speeds) for raw in raws] for m, raws in today.items()}

    def find(limit: Limit, name: str) -> Known:
        if limit.of == "model":
            return NOTHING._replace(reason=say("model-limit"))
        if limit.of == "change":
            if not draws:
                return NOTHING._replace(reason=say("no-change-estimated"))
            return 100.0 * draws[name]
        measured = shown[limit.motion]
        readings = readings_of(measured, name)
        if not len(readings):
            return measured[0][name]
        error = mean_error([readings], name, mean_stroke(measured))
        return Measured(float(readings[:, 0].mean()), error, "")

    return plainly(judge(limits, find, document.settings["seed"], "visits"))


# ---- tables ----------------------------------------------------------------------------------


def words_of_change(document: InspectionChange) -> Document:
    """Return a comparison in words."""
    limits = [limits_table(("", each) for each in document.limits)] if document.limits else []
    parts = [*limits, _table(document)]
    if document.advice:
        parts.append(Section(say("look-first"), [*map(Remark, document.advice)]))
    warnings = [f"WARNING: {each}" for each in document.warnings]
    return Document(summary=[*warnings, *document.summary], parts=parts)


def change_tables(compared: Mapping[str, InspectionChange | str]) -> list[Table]:
    """Return the tables of changes of a report, by phase; a text says why one is not compared."""
    tables = []
    for phase, document in compared.items():
        since = say("earlier") if isinstance(document, str) else document.since
        title = say("changes-title", since=since) + f", {phase}" * bool(phase)
        if isinstance(document, str):
            tables.append(Table(title=title, notes=[document]))
            continue
        look = [f"{say('look-first')}: {words}" for words in document.advice]
        notes = [*document.summary, *look]
        tables.append(replace(_table(document), title=title, notes=notes))
    return tables


def _table(document: InspectionChange) -> Table:
    """Return measured changes, then those of parameters that the records determine."""
    rows: list = [_cells(row) for row in document.measured]
    determined = [row for row in document.inferred if row.identifiable]
    rows += [say("parameters-title"), *map(_cells, determined)] if determined else []
    return Table(_HEAD, rows)


def _cells(row: QuantityChange) -> list[str]:
    """Return the cells of a change: red where it is to the worse, faint where there is none."""
    tone = "bad" if row.is_worse else "" if row.changed else "faint"
    change = interval = ""
    if row.measured or row.changed:
        low, middle, high = distinct(row.if_changed, 2, sign=True)
        change, interval = Cell(f"{middle} %", tone), f"{low} to {high}"
    values = ["" if each is None else in_digits(each, 4) for each in (row.before, row.today)]
    known = ("" if each is None else f"{each:.2f}" for each in (row.p_unchanged, row.p_worse))
    unit = row.unit if row.measured else ""
    return [row.words, unit, *values, change, interval, *known]
