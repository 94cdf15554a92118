"""Tables and sentences of a result; text, HTML and the page show the same ones."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence

from breaker.common.document import Cell, Document, Table
from breaker.common.numerals import distinct, first_of, in_digits, in_p
from breaker.common.plain_values import Note, note_of
from breaker.diagnosis.limits import NORMAL, Verdict, worst
from breaker.diagnosis.result import RecordResult, Result, Value, accepted, operations_of
from breaker.diagnosis.sentences import say
from breaker.model.parameters import PARAMETERS
from breaker.model.quantities import EVENTS, INFERRED, OF_STROKE, in_words

_PRIOR = 0.8  # share of the prior variance, at which an interval is 90 % as wide as the prior's
_PRESENT = 0.9  # probability from which an effect is listed: at most one in ten is absent
_NO_STATE = ("outside-family", "few-draws")  # reasons that the table of the state gives
_MOST = 8  # labels in a sentence; JSON lists all
_NAMED = 4  # limits in the line of the verdict; the table lists all
_SHOWN = 3  # operations of a motion that have a table and curves; JSON and CSV list all

RESULTS = {
    "fail": Cell("FAIL", "bad"),
    "inconclusive": Cell("inconclusive", "doubt"),
    "pass": Cell("pass", "good"),
}
"""Verdicts in words, the worst first."""

_NONE = Cell("–", "faint")  # cell without a value


def concerned(text: str, where: Iterable[str], everyone: Collection[str]) -> str:
    """Return a text with the names that it concerns, unless it concerns all."""
    names = [*filter(None, dict.fromkeys(where))]
    return f"{text} ({first_of(names, _MOST)})" if 0 < len(names) < len(everyone) else text


def grouped(notes: Iterable[tuple[str, Note]], everyone: Collection[str]) -> list[str]:
    """Return each kind of sentence once, with its code and the labels that it concerns."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for label, note in notes:
        kind = note.code or re.sub(r"[\d.]+", "", note.text)
        key = kind if label else note.text  # without labels only equal sentences are merged
        text = note.text + f" [{note.code}]" * bool(note.code)
        groups.setdefault(key, []).append((label, text))
    lines = []
    for group in groups.values():
        labels, texts = zip(*group, strict=True)
        if len({*texts}) > 1:
            others = first_of([*dict.fromkeys(labels[1:])], _MOST)
            lines.append(f"{texts[0]} (similar for {others})")
        else:
            lines.append(concerned(texts[0], labels, everyone))
    return lines


def verdict_of(result: Result) -> Cell:
    """Return the verdict on all limits, and the values that decide it, in one line."""
    if not (verdict := result["verdict"]):
        return Cell(say("no-limits"), "faint")
    groups: dict[tuple, list[tuple[str, Verdict]]] = {}
    for record in accepted(result):
        for limit in record.get("limits", ()):
            if limit["verdict"] == verdict:
                key = record["motion"], limit["name"], limit["words"]
                groups.setdefault(key, []).append((record.get("phase", ""), limit))
    texts = [_limit_in_words(motion, group) for (motion, *_), group in groups.items()]
    poles = [e for e in result["simultaneity"] if "limit" in e]
    judged = [e for e in poles if e.get("verdict", "inconclusive") == verdict]
    texts += map(simultaneity_in_words, judged)
    count = sum(map(len, groups.values())) + len(judged)
    more = len(texts) - _NAMED
    words = "; ".join(texts[:_NAMED]) + f" and {more} more" * (more > 0)
    if verdict == "pass":
        words = say("within-limits", count=count, s="s" * (count > 1))
    return Cell(f"{RESULTS[verdict]}: {words}", RESULTS[verdict].tone)


def _limit_in_words(motion: str, poles: Sequence[tuple[str, Verdict]]) -> str:
    """Return a limit with values and bounds, as "closing stroke R 176, Y 178 mm (180 to 184)".

    Args:
        motion: Motion of the limit.
        poles: Phase and verdict of each pole.
    """
    texts, (_, first) = [], poles[0]
    for k, part in enumerate(first["parts"]):
        known = [(phase, limit["parts"][k]["value"]) for phase, limit in poles]
        values = [f"{phase} {in_digits(v, 4)}".strip() for phase, v in known if v is not None]
        words = [in_words(part["quantity"]), first_of(values, _MOST), _unit(part["unit"])]
        if not values:
            words[1:] = [say("not-measured")]
        words.append(f"({bounds_in_words(part['bounds'])})")
        texts.append(" ".join(filter(None, words)))
    words = " and ".join(texts)
    named = in_words(first["parts"][0]["quantity"]) not in in_words(first["name"])
    words_of = f"{first['name']}:" * named, motion * (motion not in words), words
    return " ".join(filter(None, words_of))


def bounds_in_words(bounds: Sequence[float | None]) -> str:
    """Return two bounds in words; one of them may be None.

    >>> bounds_in_words((170.0, 184.0)), bounds_in_words((None, 184.0))
    ('170 to 184', 'at most 184')
    """
    low, high = (None if bound is None else in_digits(bound, 6) for bound in bounds)
    if low and high:
        return f"{low} to {high}"
    return f"at least {low}" if low else f"at most {high}"


# ---- measured values -----------------------------------------------------------------------------


def measured_table(title: str, records: Sequence[RecordResult]) -> Table:
    """Return measured values of one motion of an operation, with poles as columns."""
    rows = []
    for name, unit in {n: v["unit"] for e in records for n, v in _measured(e).items()}.items():
        values = [record["quantities"].get(name, {}) for record in records]
        # The lower end of an interval may be cut at zero.
        halves = [e["interval_95"][1] - e["median"] for e in values if "interval_95" in e]
        if halves:
            rows.append((name, unit, *map(_value_cell, values), in_digits(max(halves), 2)))
    head = ["", "unit", *(record.get("phase", "value") for record in records)]
    head.append("± 95 %, widest" if len(records) > 1 else "± 95 %")
    return Table(head, rows, title, _notes(records))


def _measured(record: RecordResult) -> dict[str, Value]:
    return {name: v for name, v in record["quantities"].items() if name not in INFERRED}


def _value_cell(value: Value) -> str:
    """Return the cell of a value, with a star if it is measured at an estimated contact."""
    if "interval_95" not in value:
        return _NONE
    return in_digits(value["median"], 4) + "*" * (value["source"] == "mixed")


def _range(ends: Sequence[float], digits: int = 4) -> str:
    return " to ".join(distinct(ends, digits))


def _notes(records: Sequence[RecordResult]) -> list[str]:
    """Return notes on zones of speeds, the star, and reasons of missing values."""
    zones, stars, doubts = {}, [], []
    for record in records:
        phase, missing = record.get("phase", ""), {}
        for name, value in _measured(record).items():
            if "zone" in value and name not in OF_STROKE:
                zones[name] = f"{name} {value['zone']}"
            if value.get("source") == "mixed":
                stars = [say("star", event=EVENTS[record["motion"]])]
            if "reason" in value and value["reason"].code not in _NO_STATE:
                missing.setdefault(value["reason"].text, []).append(name)
        doubts += [(phase, f"no {', '.join(names)}: {text}") for text, names in missing.items()]
    notes = [say("zones", zones="; ".join(zones.values()))] if zones else []
    return notes + stars + grouped(((phase, Note("", text)) for phase, text in doubts), records)


# ---- limits --------------------------------------------------------------------------------------


def limits_table(limits: Iterable[tuple[str, Verdict]]) -> Table:
    """Return a row for each quantity of each limit, from pairs of phase and verdict: the worst
    verdict with its poles or their number, and the values of the most probable exceedance.
    """
    groups: dict[tuple, list[tuple[str, Verdict]]] = {}
    for phase, limit in limits:
        key = limit["name"], limit["motion"], limit["words"]
        groups.setdefault(key, []).append((phase, limit))
    phases = {phase for group in groups.values() for phase, _ in group}
    rows, notes, doubts = [], [], []
    for (name, _, words), group in groups.items():
        verdict = worst(limit["verdict"] for _, limit in group)
        deciding = [pair for pair in group if pair[1]["verdict"] == verdict]
        text = concerned(RESULTS[verdict], [phase for phase, _ in deciding], phases)
        if len(group) > len(phases):
            text = f"{RESULTS[verdict]} {len(deciding)} of {len(group)}"
        phase, shown = max(deciding, key=lambda pair: pair[1]["p_exceeded"] or 0.0)
        for part in shown["parts"]:
            cells = _NONE, ""
            if part["value"] is not None:
                value = concerned(in_digits(part["value"], 4), [phase], phases)
                cells = value, _range(part["interval_95"])
            pairs = zip(("from", "up to"), part["bounds"], strict=True)
            bounds = (f"{word} {in_digits(bound, 4)}" for word, bound in pairs if bound is not None)
            passes = " ".join([part["quantity"], *bounds])
            verdict_cell = Cell(text, RESULTS[verdict].tone)
            rows.append((name, verdict_cell, *cells, passes, _unit(part["unit"])))
        reasons = [(phase, limit["reason"]) for phase, limit in group if limit["reason"]]
        doubts += [(phase, Note("", f"{name} is inconclusive: {why}")) for phase, why in reasons]
        notes += [f"{name} fails where {words}"] * (len(group[0][1]["parts"]) > 1)
    head = ("limit", "verdict", "value", "95 % interval", "passes", "unit")
    return Table(head, rows, "Limits", notes + grouped(doubts, phases))


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def simultaneity_in_words(poles: Mapping) -> Cell:
    """Return the simultaneity of poles in words, with its verdict."""
    if "reason" in poles:
        return Cell(poles["reason"].text, "doubt")
    half, event = NORMAL[95] * poles["sd"], EVENTS[poles["motion"]]
    order = "" if poles["first"] == poles["last"] else say("simultaneity-order", **poles)
    text = say(f"simultaneity-of-{poles['base']}", half=half, event=event, order=order, **poles)
    if "verdict" not in poles:
        return Cell(text)
    result = RESULTS[poles["verdict"]]
    return Cell(f"{text}; limit {poles['limit']:g} ms: {result}", result.tone)


# ---- the state, by the model ---------------------------------------------------------------------


def state_table(result: Result) -> Table:
    """Return the table of parameters that the records determine, with notes on the others."""
    records = accepted(result)
    resolved = [record for record in records if record["fit"]["resolved"]]
    several = len({tuple(record["fit"]["motions"]) for record in resolved}) > 1
    states: dict[str, RecordResult] = {}  # first record of each pole and set of motions
    for record in resolved:
        motions = " + ".join(record["fit"]["motions"]) if several else ""
        states.setdefault(f"{record.get('phase', '')} {motions}".strip(), record)
    rows = []
    for parameter in PARAMETERS:
        cells = [_state_cell(state["parameters"][parameter.name]) for state in states.values()]
        if any(cell is not _NONE for cell in cells):
            rows.append((f"{parameter.word} {parameter.name}", _unit(parameter.unit), *cells))
    head = ["", "unit", *(label or "value" for label in states)]
    notes = _state_notes(states, {row[0] for row in rows})
    several = bool(resolved) and len({record["operation"] for record in records}) > 1
    notes += [say("first-operation")] if several else []
    if inside := [record["fit"] for record in records if record["fit"]["inside_family"]]:
        p = in_p(min(fit["p_value"] for fit in inside))
        notes.append(say("inside-family", family=inside[0]["family"], p=p))
    reasons = [(_label(record, records), record["fit"]["reason"]) for record in records]
    notes += grouped((pair for pair in reasons if pair[1]), records)
    return Table(head if rows else (), rows, "State of the drive, by the model", notes)


def _state_notes(states: Mapping[str, RecordResult], determined: Collection[str]) -> list[str]:
    """Return sentences on additional effects and on the values of parameters."""
    notes = []
    for label, state in states.items():
        present = {n: e for n, e in state["effects"].items() if e["probability"] >= _PRESENT}
        pairs = ((name.replace("_", " "), effect) for name, effect in present.items())
        texts = [f"{n} {in_digits(e['median'], 2)} {_unit(e['unit'])}".rstrip() for n, e in pairs]
        sentence = say("effects", effects=", ".join(texts))
        notes += [f"{label}: {sentence}" if label else sentence] if texts else []
    values = [value for state in states.values() for value in state["parameters"].values()]
    notes += [say("percentile")] if any("percentile" in value for value in values) else []
    names = (f"{parameter.word} {parameter.name}" for parameter in PARAMETERS)
    others = [name for name in names if name not in determined]
    return notes + ([say("not-identifiable", names=", ".join(others))] if states and others else [])


def _state_cell(value: Value) -> str:
    """Return the cell of a parameter; without a value if the records do not determine it."""
    if value["median"] is None or value.get("prior_share", 0.0) >= _PRIOR:
        return _NONE
    text = f"{in_digits(value['median'], 3)} ({_range(value['interval_95'], 3)})"
    return text + (f", {value['percentile']:.0f} %" if "percentile" in value else "")


# ---- remarks and rejected records ----------------------------------------------------------------


def _label(record: RecordResult, records: Sequence[RecordResult]) -> str:
    """Return the motion of a record, and its pole or file where there are several."""
    motion, phase = record["motion"], record.get("phase")
    phases = [pole.get("phase") for pole in records if pole["motion"] == motion]
    name = phase if phase and phases.count(phase) == 1 else record["file"].rpartition("/")[2]
    return f"{motion} {name}" if len(phases) > 1 else motion


def remarks_table(result: Result, more: Iterable[str] = ()) -> Table:
    """Return remarks on records, with the labels of these, and further remarks."""
    records = accepted(result)
    labels = [_label(record, records) for record in records]
    pairs = zip(labels, records, strict=True)
    notes = [(label, note) for label, record in pairs for note in record["remarks"]]
    notes += [("", note) for note in [*result["remarks"], *map(note_of, more)]]
    return Table(title="Remarks on the records", notes=grouped(notes, {*labels}))


def rejected_table(result: Result) -> Table:
    """Return the rejected files, grouped by reason."""
    reasons: dict[str, dict[str, None]] = {}
    for record in result["records"]:
        if not record["accepted"]:
            reason = record["reason"].text.removeprefix(f"{record['file']}: ")
            name = f"{record['file']} {record.get('phase', '')}".strip()
            reasons.setdefault(reason, {})[name] = None
    notes = [f"{first_of([*files], 3)}: {reason}" for reason, files in reasons.items()]
    return Table(title="Rejected records", notes=notes)


# ---- the document --------------------------------------------------------------------------------


def document_of(
    result: Result,
    *,
    changes: Iterable[Table] = (),
    doubts: Iterable[str] = (),
) -> Document:
    """Return the document of a result, with tables of changes since the earlier inspection and
    warnings about them.
    """
    poles = [simultaneity_in_words(pair) for pair in result["simultaneity"]]
    shown, every = shown_of(result), operations_of(result["records"])
    more = len(every) - len(shown)
    remarks = [say("more-operations", count=more, shown=_SHOWN)] if more else []
    parts = [measured_table(title_of(group), group) for group in shown]
    records = result["records"]
    limits = [(e.get("phase", ""), limit) for e in records for limit in e.get("limits", ())]
    parts += [limits_table(limits), Table(title="Simultaneity of poles", notes=poles)]
    after = [*changes, remarks_table(result, remarks), rejected_table(result), state_table(result)]
    warnings = [*grouped((("", note) for note in result["warnings"]), ()), *doubts]
    summary = [Cell(f"WARNING: {text}", "bad") for text in dict.fromkeys(warnings)]
    parts, after = ([e for e in tables if e.rows or e.notes] for tables in (parts, after))
    summary += [verdict_of(result)] if accepted(result) else []
    return Document("Diagnosis", summary=summary, parts=parts, after=after)


def shown_of(result: Result) -> list[list[RecordResult]]:
    """Return the first operations of each motion, which have a table and curves."""
    motions: dict[str, list[list[RecordResult]]] = {}
    for group in operations_of(result["records"]):
        motions.setdefault(group[0]["motion"], []).append(group)
    return [group for groups in motions.values() for group in groups[:_SHOWN]]


def title_of(group: Sequence[RecordResult]) -> str:
    """Return a title: the motion, its time if the file has several, its operation and file."""
    record, files = group[0], dict.fromkeys(row["file"].rpartition("/")[2] for row in group)
    title = record["motion"]
    if {"from", "to"} & record.keys():
        title += f" at {record['fit']['first_motion']:.0f} ms"
    if {"breaker", "date"} & record.keys():
        title += f", operation {record['operation']}"
    return f"{title}: {first_of([*files], 1)}"
