"""The report of an inspection: verdict, measured values, changes, remarks, state and curves.

``breaker infer``, ``breaker report`` and ``breaker view`` render this document, as text or HTML.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from breaker.common.document import Cell, Document, Letterhead, Table
from breaker.common.numerals import first_of
from breaker.diagnosis.curves import Panel
from breaker.diagnosis.identity import nameplate, printed_values
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.result import DiagnosisResult, RecordResult, operations_of, result_of
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import (
    grouped,
    limits_table,
    measured_table,
    rejected_table,
    remarks_table,
    simultaneity_in_words,
    state_table,
    verdict_of,
)
from breaker.diagnosis.words import say
from breaker.model.quantities import INFERRED
from breaker.records.files import read_bytes

_SINGLE = 3  # operations of a motion that have a table; of more, one table has median and range


@dataclass(frozen=True)
class Report(Document):
    """A report: its summary is warnings, then the verdict on all limits.

    Attributes:
        panels: Curves of the operations that have a table.
    """

    panels: Sequence[Panel] = ()


def report_of(diagnosis: Diagnosis) -> Report:
    """Return the report of an inspection; the channel of a record is its operation's ``phase``.

    Raises:
        ValueError: If the logo of the configuration cannot be used.
    """
    result = result_of(
        diagnosis.estimates,
        diagnosis.verdicts,
        prior=diagnosis.given.prior,
        simultaneity=diagnosis.config["report"]["simultaneity"],
    )
    return document_of(result, diagnosis)


def document_of(
    result: DiagnosisResult, diagnosis: Diagnosis | None = None, said: Iterable[str] = ()
) -> Report:
    """Return the document of a result.

    Args:
        result: The result.
        diagnosis: The inspection, for its nameplate, changes and curves; None without these.
        said: Further remarks.
    """
    printed, changed = {}, {}
    if diagnosis is not None:
        printed = printed_values(diagnosis.records, diagnosis.speeds_of(diagnosis.records))
        changed = diagnosis.changes
    tables, shown = [], []
    groups = operations_of(result.records)
    for motion in dict.fromkeys(group[0].motion for group in groups):
        own = [group for group in groups if group[0].motion == motion]
        shown += own[:_SINGLE]
        if len(own) > _SINGLE:
            columns: dict[str, list[RecordResult]] = {}
            for record in (record for group in own for record in group):
                columns.setdefault(record.phase, []).append(record)
            title = f"{motion}: median (range) of {len(own)} operations"
            tables.append(measured_table(title, columns))
            continue
        for group in own:
            columns = {record.phase: [record] for record in group}
            tables.append(measured_table(title_of(group), columns, printed))
    limits = [each for record in result.records for each in record.limits or ()]
    others = [e for e in limits if len(e.parts) > 1 or e.parts[0].quantity in INFERRED]
    tables += [limits_table(others)] if others else []
    notes = [simultaneity_in_words(each) for each in result.simultaneity]
    tables += [Table(title="Simultaneity of poles", notes=notes)] if notes else []
    tables += change_tables(changed)
    tables += [remarks_table(result, said), rejected_table(result), state_table(result)]
    warnings = [("", note) for note in result.warnings]
    warnings = [Cell(f"WARNING: {text}", "bad") for text in grouped(warnings, warnings)]
    compared = [each for each in changed.values() if not isinstance(each, str)]
    warnings += [Cell(f"WARNING: {text}", "bad") for each in compared for text in each.warnings]
    summary = [*dict.fromkeys(warnings), verdict_of(result)]
    parts = [each for each in tables if each.rows or each.notes]
    if diagnosis is None:
        return Report("Diagnosis", summary=summary, parts=parts)
    by_record = dict(zip(map(id, result.records), diagnosis.estimates, strict=True))
    panels = [
        Panel(title_of(group), [by_record[id(each)] for each in group], diagnosis.overlays)
        for group in shown
    ]
    plate = [*nameplate(diagnosis.records, diagnosis.before), *diagnosis.given.words.items()]
    letterhead = letterhead_of(diagnosis.config["report"])
    return Report("Test report", plate, summary, parts, letterhead, panels)


def title_of(group: Sequence[RecordResult]) -> str:
    """Return the motion, its time in a file of several, its operation and file."""
    record, files = group[0], list(dict.fromkeys(each.file for each in group))
    title = record.motion
    if record.part:
        title += f" at {record.fit.first_motion:.0f} ms"
    if record.about.get("breaker") or record.about.get("date"):
        title += f", operation {record.operation}"
    return f"{title}: {first_of([file.rpartition('/')[2] for file in files], 1)}"


def letterhead_of(settings: Mapping) -> Letterhead:
    """Return what the section ``report`` puts around the report; ValueError of a wrong logo."""
    logo = b""
    if file := settings["logo"]:
        logo = read_bytes(file)
        if not logo.startswith(b"\x89PNG\r\n\x1a\n"):
            raise ValueError(say("logo-not-png", file=file))
    lines = [f"{who}: name, date" for who in settings["signatures"]]
    return Letterhead(settings["company"] or "", logo, settings["remarks"] or "", lines)
