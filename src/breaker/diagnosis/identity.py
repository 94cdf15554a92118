"""Statements of files about their breaker: nameplate, dates and phases.

Records are compared by the phases that tables, files or names state, and never by the number of a
channel or transducer.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from math import isnan

from breaker.common.clean_text import bare
from breaker.common.document import Cell
from breaker.common.numerals import first_of, in_digits
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.sentences import Sentence, say
from breaker.records.dates import earlier
from breaker.records.files import Files, printable

Inspections = Mapping[str, Sequence[DriveRecord]]
"""Records "before" and "today"."""


def contradictions(records: Iterable[DriveRecord]) -> list[Sentence]:
    """Return contradictions between serial numbers, bays or types that files state.

    Poles may have their own serial numbers; a breaker's name in a table overrides the files.
    """
    usable, conflicts = [record for record in records if not record.reason], []
    for name in () if any(e.operation.breaker for e in usable) else ("serial", "bay", "type"):
        poles = {(phase_of(record), bare(getattr(record.stated, name))) for record in usable}
        own = name == "serial" and len(poles) == len({phase for phase, _ in poles} - {""})
        stated = _stated(usable, name)
        if len(stated) > 1 and not own:
            conflicts.append(say(f"{name}-differs", values=" and ".join(sorted(stated.values()))))
    return conflicts


def _stated(records: Iterable[DriveRecord], name: str) -> dict[str, str]:
    """Return the different values that tables, or else files, state, by their bare spelling."""
    values = (getattr(e.operation, name, "") or getattr(e.stated, name) for e in records)
    return {bare(value): value for value in values if value}


def doubts_about(records: Sequence[DriveRecord]) -> list[str]:
    """Return warnings if files contradict how they were read, or state several breakers."""
    read = [record.raw.warning for record in records if record.raw and record.raw.warning]
    return list(dict.fromkeys([*read, *contradictions(records), *_unclear_dates(records)]))


def _unclear_dates(records: Iterable[DriveRecord]) -> list[Sentence]:
    """Return a remark (``date-unclear``) if the dates of files are ambiguous or cannot be read."""
    undated = [e for e in records if not (e.reason or e.operation.date)]
    texts = {e.stated.date_text: e for e in undated if re.search(r"\d", e.stated.date_text)}
    if not texts:
        return []
    readings = " or ".join(date[:10] for date in next(iter(texts.values())).stated.dates)
    why = f"ambiguous ({readings})" if readings else "not a valid date"
    return [say("date-unclear", dates=first_of([*map(repr, texts)], 3), why=why)]


def check_inspection(records: Sequence[DriveRecord], before: Sequence[DriveRecord]) -> None:
    """Raise a ValueError for an inspection without a usable record, or of several breakers."""
    for code, listed in (("nothing-usable", records), ("nothing-usable-before", before)):
        if listed and all(record.reason for record in listed):
            reasons = "\n  ".join(dict.fromkeys(record.reason for record in listed))
            raise ValueError(say(code, reasons=reasons))
    if doubts := [doubt for doubt in contradictions(records) if doubt.code != "type-differs"]:
        raise ValueError(say("report-of-several", doubt=doubts[0]))


def days_of(records: Iterable[DriveRecord]) -> str:
    """Return the first and the last day of an inspection; "" if no date is known."""
    days = sorted({record.operation.date[:10] for record in records} - {""})
    return " to ".join(dict.fromkeys([*days[:1], *days[-1:]]))


def order_doubts(inspections: Inspections) -> list[Sentence]:
    """Return a warning if the inspection "before" is later than "today"."""
    before, today = (
        sorted(e.operation.date for e in records if e.operation.date and not e.reason)
        for records in inspections.values()
    )
    if not (before and today and earlier(before[0], today[-1])):
        return []
    return [say("before-is-later", before=before[0], today=today[-1])]


def phase_of(record: DriveRecord) -> str:
    """Return the phase that the table, the file or its name states; "" without a phase.

    A report uses the column of a channel as its name, if it has no phase; this is not a phase.
    """
    operation = record.operation
    if operation.phase and operation.phase != str(operation.channel):
        return operation.phase
    usual = record.raw.settings["travel_column"] if record.raw else ""
    return record.stated.phase_of(operation.channel or usual)


def check_phases(inspections: Inspections) -> list[Sentence]:
    """Return a remark (``phase-not-stated``) if records without a stated phase are compared.

    Raises:
        ValueError: If usable records state several phases, or several channels state none.
    """
    used = {name: [e for e in values if not e.reason] for name, values in inspections.items()}
    for values in used.values():
        if len({record.operation.channel for record in values if not phase_of(record)}) > 1:
            raise ValueError(say("phases-needed"))
    phases = {name: {phase_of(record) for record in values} - {""} for name, values in used.items()}
    words = {name: ", ".join(sorted(values)) or "no phase" for name, values in phases.items()}
    if len(set().union(*phases.values())) > 1:
        several = any(len(values) > 1 for values in phases.values())
        raise ValueError(say("several-phases" if several else "different-phases", **words))
    all_used = (record for values in used.values() for record in values)
    known = all(phase_of(record) or record.operation.breaker for record in all_used)
    return [] if known else [say("phase-not-stated", **words)]


def phases_left_out(records: Iterable[DriveRecord], files: Files) -> list[Sentence]:
    """Return a remark (``phase-taken``) if files have phases that the records do not have."""
    from breaker.records.description import travel_channels  # most commands need none

    taken, names = set(), set()
    for record in (record for record in records if phase_of(record) and not record.reason):
        usual = record.raw.settings["travel_column"]
        channels = travel_channels(files[record.operation.file], usual)
        taken.add(phase_of(record))
        names |= {name for name, _ in channels.values()}
    others = ", ".join(sorted(names - taken)) if taken <= names else ""
    return [say("phase-taken", phase=", ".join(sorted(taken)), others=others)] if others else []


def stated_differences(inspections: Inspections) -> list[Sentence]:
    """Return differences in ratio, serial number, bay or type that two inspections state."""
    names = {"ratio": "linkage ratio", "serial": "serial number", "bay": "bay", "type": "type"}
    differences = []
    for key, name in names.items():
        before, today = (_stated(records, key) for records in inspections.values())
        if len(before) == len(today) == 1 and before.keys() != today.keys():
            was, now = (*before.values(), *today.values())
            differences.append(say("stated-otherwise", what=name, before=was, today=now))
    return differences


def nameplate(
    records: Sequence[DriveRecord], before: Sequence[DriveRecord] = ()
) -> list[tuple[str, str | Cell]]:
    """Return the rows of a report on nameplate and test that tables and files state."""
    rows, stated = [e.operation for e in records], [e.stated for e in records]
    files = dict.fromkeys(printable(e.operation.file) for e in records if not e.reason)
    known = {
        "Breaker": [e.breaker for e in rows if e.breaker] or [e.serial for e in stated],
        "Test date": [e.date.replace("T", " ") for e in rows],
        "Earlier inspection": [days_of(before)],
        "Files": [first_of([file.rpartition("/")[2] for file in files], 1)],
        **{n.title(): [getattr(e, n) for e in stated] for n in ("station", "bay", "type")},
        "Serial": [e.serial for e in stated],
        "Linkage ratio": [e.ratio for e in stated],
        "Temperature": [f"{in_digits(t, 4)} °C" for e in rows if not isnan(t := e.temperature)],
    }
    always = {"Breaker", "Test date", *(["Earlier inspection"] if before else [])}
    pairs = [(name, ", ".join(filter(None, dict.fromkeys(e)))) for name, e in known.items()]
    lacking = Cell("not stated", "faint")
    return [(name, text or lacking) for name, text in pairs if text or name in always]
