"""Compare two inspections of a drive, as one document: data for JSON, and its sentences and tables.

The order is: measured values against limits, measured changes, explanations, then parameters that
the records determine. docs/reference/files.md lists the keys of the JSON.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from breaker.common.document import Cell, Document, Table
from breaker.common.numerals import first_of, in_digits, in_p
from breaker.common.plain_values import Plain, note_of, plainly
from breaker.common.randomness import generator
from breaker.configuration.data_files import advice_of, advice_on, family_of
from breaker.diagnosis import identity
from breaker.diagnosis.changes import (
    NetworkChanges,
    Pair,
    QuantityChange,
    compare,
    in_unit,
    mean_of,
    measured_changes,
    parameter_change,
)
from breaker.diagnosis.estimate import NOTHING, DriveRecord
from breaker.diagnosis.explanations import (
    Explanation,
    explain,
    measured_differences,
    other_measurement,
)
from breaker.diagnosis.identity import Inspections
from breaker.diagnosis.limits import Known, Verdict, judge
from breaker.diagnosis.reading import without_copies
from breaker.diagnosis.sentences import Sentence, say
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import limits_table
from breaker.family.networks import SURE, shipped_networks
from breaker.family.sensitivities import shipped_sensitivities
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, NAMES, PARAMETERS
from breaker.model.quantities import Speed
from breaker.records.files import printable
from breaker.records.record import Record
from breaker.records.rejections import DISTURBED

_NAMED = 4  # changes in a sentence; the table lists all
_HEAD = ("", "unit", "before", "today", "change", "90 % interval", "P unchanged", "P worse")


@dataclass(frozen=True, kw_only=True)
class InspectionChange(Plain):
    """The comparison of two inspections.

    Attributes:
        state, family, matches, agreement: As of ``NetworkChanges``.
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

    state: str
    family: str
    matches: Mapping[str, Mapping[str, Mapping]]
    agreement: Mapping[str, float | str]
    settings: Mapping[str, float]
    records: Mapping[str, Mapping[str, int]]
    rejected: Sequence[Mapping[str, str]]
    differences: Sequence[str]
    explanations: Sequence[Explanation]
    measured: Sequence[QuantityChange]
    inferred: Sequence[QuantityChange]
    limits: Sequence[Verdict] = ()
    advice: Sequence[str] = ()
    dates: Mapping[str, str] = field(default_factory=dict)
    doubts: Sequence[str] = ()

    def plain(self) -> dict:
        """Return the values by name, after the sentences with their codes."""
        sentences = [note_of(warning) for warning in (*self.warnings, *self.summary)]
        return {"sentences": sentences, **super().plain()}

    @property
    def reported(self) -> list[QuantityChange]:
        """Changes that are reported; none if the inspections were measured differently."""
        rows = [] if self.differences else [*self.measured, *self.inferred]
        return [row for row in rows if row.changed]

    @property
    def worse(self) -> list[str]:
        """Names of reported changes for the worse, or of quantities without a worse direction."""
        return [row.name for row in self.reported if row.p_worse is None or row.is_worse]

    @property
    def since(self) -> str:
        """Words for the earlier inspection, with its date if known."""
        date = self.dates.get("before")
        return say("earlier-dated", date=date) if date else say("earlier")

    @property
    def warnings(self) -> list[str]:
        """Warnings about the records, and about differences in the measurement."""
        differences = "; ".join(self.differences)
        other = [say("different-setup-check", differences=differences)] if differences else []
        return [*self.doubts, *other]

    @property
    def summary(self) -> list[Sentence]:
        """Sentences on limits, measured changes, explanations, parameters, and rejected records."""
        verdicts = ", ".join(f"{limit['name']} {limit['verdict']}" for limit in self.limits)
        sentences = [say("limits", verdicts=verdicts)] if verdicts else []
        measured = [row for row in self.measured if row.changed]
        measured.sort(key=lambda row: -abs(row.change[1]))
        sentences.append(_changes("measured", measured, self.since))
        sentences += [] if self.differences else [self.explained]
        if self.inferred:
            changed = [row for row in self.inferred if row.changed]
            sentences.append(_changes("parameters", changed, self.since))
        unknown = [e.words for e in self.inferred if e.name in NAMES and not e.identifiable]
        sentences += [say("not-identifiable", names=", ".join(unknown))] if unknown else []
        return [*sentences, *self.limitations, *(say("rejected", **e) for e in self.rejected)]

    @property
    def explained(self) -> Sentence:
        """Explanations with a probability above 5 %."""
        words, clauses = {parameter.name: parameter.word for parameter in PARAMETERS}, []
        for likely in (reason for reason in self.explanations if reason.probability > 1.0 - SURE):
            values = {"parameter": words.get(likely.parameter)}
            if likely.change:
                values["amount"] = "{} ({} %)".format(*in_unit(likely.change))
            code = "several" if likely.cause == "drive" and not likely.parameter else likely.cause
            clauses.append(say(f"cause-{code}", p=f"{likely.probability:.2f}", **values))
        causes = "; or ".join(clauses)
        return say("explained", causes=causes[:1].upper() + causes[1:])

    @property
    def limitations(self) -> list[Sentence]:
        """Reason why no changes of parameters are estimated; empty if they are."""
        if self.state in ("estimated", "different_setup"):
            return []
        outside = [
            f"{motion} {inspection} ({in_p(match['p_value'])})"
            for motion, by_inspection in self.matches.items()
            for inspection, match in by_inspection.items()
            if match["p_value"] < self.settings["misfit_p_value"]
        ]
        values = {"outside": ", ".join(outside), "family": self.family, **self.agreement}
        return [say(f"{self.state.replace('_', '-')}-check", **values)]


def _changes(code: str, rows: Sequence[QuantityChange], since: str) -> Sentence:
    """Return the sentence on changes of one kind; it names the first few."""
    names = ["{} {} ({} {})".format(row.words, *row.shown) for row in rows]
    if not names:
        return say(f"{code}-unchanged")
    return say(f"{code}-changed", changes=first_of(names, _NAMED), since=since)


# ---- the comparison --------------------------------------------------------------------------


def compare_inspections(diagnosis: Diagnosis, inspections: Inspections) -> InspectionChange:
    """Return the comparison of records "before" and "today" of a drive.

    The transducer counts as the same if all records name the same one.

    Raises:
        ValueError: If records state different phases, or no motion is usable in both inspections.
    """
    doubts = [*identity.order_doubts(inspections), *identity.check_phases(inspections)]
    used, rejected = _usable(inspections)
    for records in inspections.values():
        doubts += identity.doubts_about(records)
    for record in (record for records in used.values() for record in records):
        place = {"file": printable(record.operation.file), "motion": record.motion}
        remarks = (e for e in record.raw.remarks_on() if getattr(e, "code", "") in DISTURBED)
        doubts += [say("disturbed", remark=remark, **place) for remark in remarks]
    pair = Pair.of(*map(_by_motion, used.values()))
    speeds = diagnosis.speeds_of([*used["before"], *used["today"]])
    seed, misfit = (diagnosis.settings[name] for name in ("seed", "misfit_p_value"))
    rng = generator(seed, "two visits")
    changes = compare(pair, shipped_networks(), rng, misfit_p_value=misfit)
    transducers = {record.operation.transducer for listed in used.values() for record in listed}
    explanations = explain(
        pair,
        shipped_sensitivities(changes.family),
        same_transducer=diagnosis.same_transducer or (len(transducers) == 1 and all(transducers)),
        sliding=family_of(changes.family)["contacts"]["sliding"],
    )
    document = inspection_change(
        pair,
        changes,
        explanations,
        speeds,
        identity.stated_differences(inspections),
        from_list(diagnosis.limits, [*pair.before], speeds),
        settings={"seed": seed, "misfit_p_value": misfit},
        rejected=rejected,
        dates={name: identity.days_of(listed) for name, listed in used.items()},
        doubts=[*dict.fromkeys(doubts)],
    )
    advice = advice_on(document.worse, advice_of())
    return replace(document, advice=advice)


def inspection_change(
    pair: Pair,
    changes: NetworkChanges,
    explanations: Sequence[Explanation],
    speeds: Sequence[Speed],
    differences: Sequence[str] = (),
    limits: Sequence[Limit] = (),
    **more: object,
) -> InspectionChange:
    """Return the document of changes, explanations, and stated differences in the measurement.

    Nothing inferred is reported if the inspections were measured differently. Limits apply to means
    of the later inspection and to changes. ``more`` contains the other fields.
    """
    measured = measured_changes(pair, speeds)
    differences = [*differences, *measured_differences(pair, explanations, measured)]
    p_different = 1.0 if differences else other_measurement(explanations)
    changes = changes.unless_measured_otherwise(p_different)
    shown = {m: [raw.measured(speeds) for raw in raws] for m, raws in pair.today.items()}

    def find(limit: Limit, name: str) -> Known:
        if limit.of == "record":
            mean = mean_of(shown[limit.motion], name)
            no_drive = next(filter(None, (raw.no_drive for raw in pair.today[limit.motion])), "")
            return mean._replace(reason=no_drive or mean.reason)
        if limit.of == "change" and changes.draws:
            return 100.0 * changes.draws[name]
        code = "model-limit" if limit.of == "model" else "no-change-estimated"
        return NOTHING._replace(reason=say(code))

    document = InspectionChange(
        **{name: getattr(changes, name) for name in ("state", "family", "matches", "agreement")},
        records={m: {"before": len(pair.before[m]), "today": len(pair.today[m])} for m in pair[0]},
        differences=differences,
        explanations=explanations,
        measured=measured,
        inferred=[parameter_change(*pair) for pair in changes.draws.items()],
        limits=judge(limits, find, more["settings"]["seed"], "visits"),
        **more,
    )
    return plainly(document)


def _usable(inspections: Inspections) -> tuple[dict[str, list[DriveRecord]], list[dict]]:
    """Return the usable records of motions that both inspections have, and the rejected records.

    Raises:
        ValueError: If no motion is usable in both inspections.
    """
    records = without_copies([*inspections["before"], *inspections["today"]])
    count = len(inspections["before"])
    both = {"before": records[:count], "today": records[count:]}
    shown = [{record.motion for record in own if not record.reason} for own in both.values()]
    used, rejected = {name: [] for name in both}, []
    for name, record in ((name, record) for name, own in both.items() for record in own):
        file, other = str(record.operation.file), "today" if name == "before" else "before"
        reason = record.reason.removeprefix(f"{file}: ")
        if not all(record.motion in motions for motions in shown):
            reason = reason or say("not-in-both", other=other, motion=record.motion)
        if reason:
            place = {"file": file, "motion": record.motion, "inspection": name}
            rejected.append(place | {"reason": reason})
        else:
            used[name].append(record)
    if not used["today"]:
        reasons = "".join(f"\n  {say('rejected', **rejection)}" for rejection in rejected)
        raise ValueError(say("nothing-to-compare", reasons=reasons))
    return used, rejected


def _by_motion(records: Sequence[DriveRecord]) -> dict[str, list[Record]]:
    """Return records as they are in their files, by motion."""
    raw_records = {m: [record.raw for record in records if record.motion == m] for m in MOTIONS}
    return {motion: raws for motion, raws in raw_records.items() if raws}


# ---- tables ----------------------------------------------------------------------------------


def words_of_change(document: InspectionChange) -> Document:
    """Return a comparison in words."""
    limits = [limits_table(("", limit) for limit in document.limits)] if document.limits else []
    summary = [*(f"WARNING: {warning}" for warning in document.warnings), *document.summary]
    return Document(summary=summary, parts=[*limits, _table(document), *_look(document.advice)])


def change_tables(compared: Mapping[str, InspectionChange | str]) -> list[Table]:
    """Return a table of changes for each phase of a report, and one on where to look first; a phase
    that cannot be compared has a text with the reason.
    """
    tables, advice = [], []
    for phase, document in compared.items():
        table, since = Table(notes=[document]), say("earlier")
        if isinstance(document, InspectionChange):
            changed = [row for row in document.inferred if row.changed]
            table = _table(replace(document, inferred=changed))
            table, since = replace(table, notes=document.summary), document.since
            advice += document.advice
        title = say("changes-title", since=since) + f", {phase}" * bool(phase)
        tables.append(replace(table, title=title))
    return tables + _look(advice)


def _look(advice: Sequence[str]) -> list[Table]:
    """Return a table on where to look first, if there is advice."""
    title, notes = say("look-first"), [*dict.fromkeys(advice)]
    return [Table(title=title, notes=notes)] if notes else []


def _table(document: InspectionChange) -> Table:
    """Return the table of measured changes, then of parameters that the records determine."""
    determined = [_cells(row) for row in document.inferred if row.identifiable]
    title = [say("parameters-title")] if determined else []
    return Table(_HEAD, [*map(_cells, document.measured), *title, *determined])


def _cells(row: QuantityChange) -> list[str]:
    """Return the cells of a row: red for a change for the worse, faint for no change."""
    tone = "bad" if row.is_worse else "" if row.changed else "faint"
    change = interval = ""
    if row.measured or row.changed:
        change, interval, _ = row.shown
    values = ["" if value is None else in_digits(value, 4) for value in (row.before, row.today)]
    probabilities = ("" if p is None else f"{p:.2f}" for p in (row.p_unchanged, row.p_worse))
    unit = row.unit if row.measured else ""
    return [row.words, unit, *values, Cell(change, tone), interval, *probabilities]
