"""Tables and sentences of a result; text, HTML and the page show the same ones."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from breaker.common.document import Cell, Document, Table
from breaker.common.numerals import first_of, in_digits, in_p
from breaker.common.plain_values import Note, note_of
from breaker.diagnosis.limits import NORMAL, VERDICTS, JudgedPart, Simultaneity, Verdict
from breaker.diagnosis.result import DiagnosisResult, RecordResult, Value, operations_of
from breaker.diagnosis.words import say
from breaker.model.parameters import NAMES, PARAMETERS
from breaker.model.quantities import EVENTS, INFERRED, OF_STROKE
from breaker.records.printed import differs

_PRIOR = 0.8  # share of the prior's variance: above it, 90 % of an interval's width are the prior's
_PRESENT = 0.9  # probability from which on an effect is listed: one in ten may be absent
_NO_STATE = ("outside-family", "few-draws")  # reasons that the table of the state gives
_MOST = 8  # sentences of a list, labels of a sentence; JSON has all of them
_SINGLE = 3  # operations of a motion that have a table; of more, one table has median and range

RESULTS = {
    "fail": Cell("FAIL", "bad"),
    "inconclusive": Cell("inconclusive", "doubt"),
    "pass": Cell("pass", "good"),
}
"""Verdicts in words, the worst first."""

NONE = Cell("–", "faint")
"""Cell without a value."""

Columns = Mapping[str, Sequence[RecordResult]]
"""Accepted records of one motion by the name of their column: one, or several operations."""


def concerned(text: str, where: Iterable[str], everyone: Collection[str]) -> str:
    """Return a text with what it concerns, unless that is everyone."""
    names = [*filter(None, dict.fromkeys(where))]
    return f"{text} ({first_of(names, _MOST)})" if 0 < len(names) < len(everyone) else text


def grouped(notes: Iterable[tuple[str, Note | None]], everyone: Collection[str]) -> list[str]:
    """Return each kind of sentence once, by its code, with the labels that it concerns."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for label, note in notes:
        if note is not None:
            kind = note.code or re.sub(r"[\d.]+", "", note.text)
            key = kind if label else note.text  # without a label only equal sentences are one
            groups.setdefault(key, []).append((label, note.text))
    lines = []
    for some in groups.values():
        labels, texts = zip(*some, strict=True)
        if len({*texts}) == 1:
            lines.append(concerned(texts[0], labels, everyone))
        else:
            others = first_of([*dict.fromkeys(labels[1:])], _MOST)
            lines.append(f"{texts[0]} (similar for {others})")
    return lines if len(lines) <= _MOST else [*lines[:_MOST], say("more", count=len(lines) - _MOST)]


def verdict_of(result: DiagnosisResult) -> Cell:
    """Return the verdict on all limits in one line."""
    phases = {each.phase for each in result.records if each.accepted}
    texts, first = [], ""
    for verdict in VERDICTS[::-1]:
        names: dict[str, list[str]] = {}
        for name, record in result.limits[verdict]:
            names.setdefault(name, []).append(record.phase if record else "")
        if names:
            first = first or verdict
            said = [concerned(name, where, phases) for name, where in names.items()]
            texts.append(f"{RESULTS[verdict]}: {first_of(said, _MOST)}")
    if not texts:
        return Cell(say("no-limits"), "faint")
    return Cell("; ".join(texts), RESULTS[first].tone)


# ---- measured values -----------------------------------------------------------------------------


def measured_table(
    title: str, columns: Columns, printed: Mapping[tuple, tuple[float, str]] | None = None
) -> Table:
    """Return measured values of one motion with limits and verdicts: one operation, or the median
    and range of several.

    Args:
        title: Motion and operation.
        columns: Records by pole.
        printed: Values that the analyser printed, and their quantities, by file, motion, phase and
            name.
    """
    records = [each for some in columns.values() for each in some]
    several = len(records) > len(columns)
    names = dict.fromkeys(n for each in records for n in each.quantities if n not in INFERRED)
    rows = []
    for name in names:
        values = {label: _known(name, some) for label, some in columns.items()}
        known = [each for some in values.values() for each in some]
        if not known and not _limits_on(name, records):
            continue
        half = in_digits(max(each.half for each in known), 2) if known else ""
        unit = records[0].quantities[name].unit if name in records[0].quantities else ""
        count = [f"{len(known)}"] if several else []
        limit = _limit_cells(name, records, columns)
        rows.append((name, unit, *map(_cell, values.values()), half, *count, *limit))
    head = ["", "unit", *(label or "value" for label in columns), "± 95 %"]
    head += ["records"] * several
    head += ["limit", "verdict"] * any(each.limits for each in records)
    rows = [row[: len(head)] for row in rows]
    notes = _printed_notes(columns, printed) if printed and not several else []
    return Table(head, rows, title, [*notes, *_notes(records, columns)])


def _known(name: str, records: Iterable[RecordResult]) -> list[Value]:
    values = (each.quantities.get(name) for each in records)
    return [each for each in values if each and each.median is not None]


def _cell(values: Sequence[Value]) -> str:
    """Return one value, or the median and the range of several; a star at an estimated contact."""
    if not values:
        return NONE
    medians = [each.median for each in values]
    star = "*" if any(each.source == "mixed" for each in values) else ""
    text = in_digits(np.median(medians), 4) + star
    return text if len(values) == 1 else f"{text} ({_range(min(medians), max(medians))})"


def _range(low: float, high: float, digits: int = 4) -> str:
    """Return two ends with as many digits as set them apart, and at least some."""
    texts = [(in_digits(low, more), in_digits(high, more)) for more in range(digits, 8)]
    first = next((pair for pair in texts if pair[0] != pair[1]), texts[0])
    return " to ".join(first)


def _printed_notes(columns: Columns, printed: Mapping) -> list[str]:
    """Return where the analyser printed another value of a quantity than the measured one."""
    notes = []
    for label, (record,) in columns.items():
        for name, known in record.quantities.items():
            key = record.file, record.motion, label, name
            value, quantity = printed.get(key, (0.0, ""))
            if not quantity or known.source != "measured":
                continue
            if differs(quantity, value, known.median, known.half / NORMAL[95]):
                percent = in_digits(100.0 * (known.median / value - 1.0), 2, sign=True)
                about = {"quantity": name, "percent": percent, "printed": in_digits(value, 4)}
                note = say("printed-differs", **about, measured=in_digits(known.median, 4))
                notes.append(concerned(note, [label], columns))
    return notes


def _notes(records: Sequence[RecordResult], columns: Columns) -> list[str]:
    """Return zones of speeds, the meaning of the star, and why values and verdicts are missing."""
    notes, doubts = [], []
    values = [(r, n, v) for r in records for n, v in r.quantities.items() if n not in INFERRED]
    if zones := {n: v.zone for _, n, v in values if v.zone and n not in OF_STROKE}:
        notes.append(say("zones", zones="; ".join(" ".join(pair) for pair in zones.items())))
    if any(value.source == "mixed" for _, _, value in values):
        notes.append(say("star", event=EVENTS[records[0].motion]))
    for record in records:
        missing: dict[str, list[str]] = {}
        for name, value in record.quantities.items():
            if name not in INFERRED and value.reason and value.reason.code not in _NO_STATE:
                missing.setdefault(value.reason.text, []).append(name)
        for reason, lacking in missing.items():
            text = f"no {', '.join(lacking)}: {reason}"
            doubts.append((record.phase, Note(re.sub(r"[\d.]+", "", text), text)))
        for limit in record.limits or ():
            if limit.reason:
                text = f"{limit.name} is inconclusive: {limit.reason}"
                doubts.append((record.phase, Note(f"{limit.reason.code} {limit.name}", text)))
    return [*notes, *grouped(doubts, columns)]


# ---- limits --------------------------------------------------------------------------------------


def _limits_on(name: str, records: Iterable[RecordResult]) -> list[tuple[RecordResult, Verdict]]:
    pairs = ((each, limit) for each in records for limit in each.limits or ())
    return [pair for pair in pairs if [part.quantity for part in pair[1].parts] == [name]]


def _limit_cells(
    name: str, records: Sequence[RecordResult], columns: Collection[str]
) -> tuple[str, str]:
    """Return the limits on a quantity, and the worst verdict, with its poles or its number."""
    judged = _limits_on(name, records)
    if not judged:
        return "", ""
    bounds = dict.fromkeys(bounds_in_words(limit.parts[0]) for _, limit in judged)
    worst = max((limit.verdict for _, limit in judged), key=VERDICTS.index)
    where = [record.phase for record, limit in judged if limit.verdict == worst]
    text = concerned(RESULTS[worst], where, columns)
    if len(judged) > len(columns):
        text = f"{RESULTS[worst]} {len(where)} of {len(judged)}"
    return ", ".join(bounds), Cell(text, RESULTS[worst].tone)


def bounds_in_words(part: JudgedPart) -> str:
    """Return which values of a quantity pass."""
    low, high = (None if bound is None else in_digits(bound, 4) for bound in part.bounds)
    if part.reference is not None and low and high:
        away = in_digits(part.bounds[1] - part.reference, 3)
        return f"{in_digits(part.reference, 4)} ± {away}"
    return f"{low} to {high}" if low and high else f"up to {high}" if high else f"from {low}"


def limits_table(limits: Iterable[Verdict]) -> Table:
    """Return a row for each quantity of each limit."""
    rows, notes = [], []
    for limit in limits:
        for part in limit.parts:
            value, (low, high) = part.value, part.interval_95
            ends = "" if value is None else _range(low, high)
            text = NONE if value is None else in_digits(value, 4)
            passes = f"{part.quantity} {bounds_in_words(part)}"
            unit = "" if part.unit == "1" else part.unit
            rows.append((limit.name, RESULTS[limit.verdict], text, ends, passes, unit))
        notes += [f"{limit.name} is inconclusive: {limit.reason}"] if limit.reason else []
        notes += [f"{limit.name} fails where {limit.words}"] if len(limit.parts) > 1 else []
    return Table(("limit", "verdict", "value", "95 % interval", "passes", "unit"), rows, "", notes)


def simultaneity_in_words(poles: Simultaneity) -> Cell:
    """Return how simultaneously poles switch, and whether they may."""
    if poles.reason:
        return Cell(poles.reason.text, "doubt")
    value, sd = in_digits(poles.value, 3), in_digits(NORMAL[95] * poles.sd, 2)
    about = {"event": EVENTS[poles.motion], "first": poles.first, "last": poles.last}
    text = say(f"simultaneity-of-{poles.base}", value=value, half=sd, **about)
    if poles.verdict is None:
        return Cell(text)
    limit = f"; limit {in_digits(poles.limit, 3)} ms: {RESULTS[poles.verdict]}"
    return Cell(text + limit, RESULTS[poles.verdict].tone)


# ---- the state, by the model ---------------------------------------------------------------------


def state_table(result: DiagnosisResult) -> Table:
    """Return the parameters that records determine; one line on those that they do not."""
    records = [each for each in result.records if each.accepted]
    columns = _states(records)
    phases = {each.phase for each in records}
    resolved = {label: each for label, each in columns.items() if each.fit.resolved}
    names = [n for n in NAMES if any(_determined(s.parameters[n]) for s in resolved.values())]
    judged = any(_limits_on(name, records) for name in NAMES)
    rows = []
    for name in names:
        parameter = PARAMETERS[NAMES.index(name)]
        cells = [_state_cell(each.parameters[name]) for each in resolved.values()]
        unit = "" if parameter.unit == "1" else parameter.unit
        limit = _limit_cells(name, records, phases) if judged else ()
        rows.append((f"{parameter.word} {name}", unit, *cells, *limit))
    notes = [f"{label}: {note}" if label else note for label, note in _effects(resolved)]
    values = [v for each in resolved.values() for v in each.parameters.values()]
    notes += [say("percentiles")] if any(v.percentile is not None for v in values) else []
    others = [f"{each.word} {each.name}" for each in PARAMETERS if each.name not in names]
    notes += [say("not-identifiable", names=", ".join(others))] if resolved and others else []
    several = bool(resolved) and len({each.operation for each in records}) > 1
    notes += [say("first-operation")] if several else []
    inside = [each.fit for each in records if each.fit.inside_family]
    if inside:
        about = {"family": inside[0].family, "p": in_p(min(fit.p_value for fit in inside))}
        notes.append(say("inside-family", **about))
    reasons = [(_label(each, records), each.fit.reason) for each in records]
    notes += grouped(reasons, reasons)
    head = ["", "unit", *(label or "value" for label in resolved), *["limit", "verdict"] * judged]
    return Table(head if rows else (), rows, "State of the drive, by the model", notes)


def _states(records: Sequence[RecordResult]) -> dict[str, RecordResult]:
    """Return the first record of each pole and of the motions that it was estimated from."""
    states: dict[str, RecordResult] = {}
    motions = {tuple(each.fit.motions) for each in records}
    for each in records:
        of = "+".join(each.fit.motions) if len(motions) > 1 else ""
        states.setdefault(f"{each.phase} {of}".strip(), each)
    return states


def _determined(value: Value) -> bool:
    return value.median is not None and (value.prior_share or 0.0) < _PRIOR


def _state_cell(value: Value) -> str:
    if not _determined(value):
        return NONE
    text = f"{in_digits(value.median, 3)} ({_range(*value.interval_95, 3)})"
    return text if value.percentile is None else f"{text}, {value.percentile:.0f} %"


def _effects(states: Mapping[str, RecordResult]) -> list[tuple[str, str]]:
    """Return one line on the additional effects that are present, by column."""
    lines = []
    for label, state in states.items():
        present = {n: e for n, e in state.effects.items() if e.probability >= _PRESENT}
        texts = [
            f"{name.replace('_', ' ')} {in_digits(each.median, 2)}{' ms' * (each.unit == 'ms')}"
            for name, each in present.items()
        ]
        lines += [(label, say("effects", effects=", ".join(texts)))] if texts else []
    return lines


# ---- remarks and rejected records ----------------------------------------------------------------


def _label(record: RecordResult, records: Sequence[RecordResult]) -> str:
    """Return the motion of a record, and its pole or file where there are several."""
    same = [each for each in records if each.motion == record.motion]
    phases = [each.phase for each in same]
    alone = record.phase and phases.count(record.phase) == 1
    name = record.phase if alone else record.file.rpartition("/")[2]
    return f"{record.motion} {name}" if len(same) > 1 else record.motion


def remarks_table(result: DiagnosisResult, more: Iterable[str] = ()) -> Table:
    """Return remarks on records, with what they concern, and others."""
    records = [each for each in result.records if each.accepted]
    labels = {id(each): _label(each, records) for each in records}
    notes = [(labels[id(each)], note) for each in records for note in each.remarks]
    notes += [("", note) for note in [*result.remarks, *map(note_of, more)]]
    return Table(title="Remarks", notes=grouped(notes, set(labels.values())))


def rejected_table(result: DiagnosisResult) -> Table:
    """Return why records were rejected, by reason."""
    reasons: dict[str, dict[str, None]] = {}
    for each in result.records:
        if not each.accepted:
            reason = each.reason.text.removeprefix(f"{each.file}: ")
            reasons.setdefault(reason, {})[each.file] = None
    notes = [f"{first_of([*files], 3)}: {reason}" for reason, files in reasons.items()]
    return Table(title="Rejected records", notes=notes)


# ---- the document --------------------------------------------------------------------------------


def _by_motion(result: DiagnosisResult) -> dict[str, list[list[RecordResult]]]:
    found: dict[str, list[list[RecordResult]]] = {}
    for group in operations_of(result.records):
        found.setdefault(group[0].motion, []).append(group)
    return found


def shown_of(result: DiagnosisResult) -> list[list[RecordResult]]:
    """Return the operations whose curves are shown: the first few of each motion."""
    return [group for own in _by_motion(result).values() for group in own[:_SINGLE]]


def document_of(
    result: DiagnosisResult,
    said: Iterable[str] = (),
    *,
    printed: Mapping[tuple, tuple[float, str]] | None = None,
    changes: Iterable[Table] = (),
    doubts: Iterable[str] = (),
) -> Document:
    """Return the document of a result.

    Args:
        result: The result.
        said: Further remarks.
        printed: As of ``measured_table``.
        changes, doubts: Tables of changes since the inspection before, and warnings about them.
    """
    tables = _operation_tables(result, printed)
    limits = [each for record in result.records for each in record.limits or ()]
    others = [e for e in limits if len(e.parts) > 1 or e.parts[0].quantity in INFERRED]
    tables += [limits_table(others)] if others else []
    notes = [simultaneity_in_words(each) for each in result.simultaneity]
    tables += [Table(title="Simultaneity of poles", notes=notes)] if notes else []
    tables += [*changes, remarks_table(result, said), rejected_table(result), state_table(result)]
    warnings = [("", note) for note in result.warnings]
    warnings = dict.fromkeys([*grouped(warnings, warnings), *doubts])
    summary = [Cell(f"WARNING: {text}", "bad") for text in warnings]
    parts = [each for each in tables if each.rows or each.notes]
    return Document("Diagnosis", summary=[*summary, verdict_of(result)], parts=parts)


def _operation_tables(result: DiagnosisResult, printed: Mapping | None) -> list[Table]:
    """Return measured values of each motion: of a few operations one by one, of more together."""
    tables = []
    for motion, own in _by_motion(result).items():
        columns: dict[str, list[RecordResult]] = {}
        for group in own:
            for record in group:
                columns.setdefault(record.phase, []).append(record)
            if len(own) <= _SINGLE:
                tables.append(measured_table(title_of(group), columns, printed))
                columns = {}
        if columns:
            title = f"{motion}: median (range) of {len(own)} operations"
            tables.append(measured_table(title, columns))
    return tables


def title_of(group: Sequence[RecordResult]) -> str:
    """Return the motion, its time in a file of several, its operation and file."""
    record, files = group[0], list(dict.fromkeys(each.file for each in group))
    title = record.motion
    if record.part:
        title += f" at {record.fit.first_motion:.0f} ms"
    if record.about.get("breaker") or record.about.get("date"):
        title += f", operation {record.operation}"
    return f"{title}: {first_of([file.rpartition('/')[2] for file in files], 1)}"
