"""A proposal in words: what was found in a file, and the lines of configuration that read it."""

import json
import re
from collections.abc import Iterable

import numpy as np
import yaml

from breaker.common.numerals import first_of, in_digits
from breaker.common.visible_text import visible_text
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.records.printed import stated_remarks
from breaker.records.proposal import NOT_READ, InspectedMotion, Proposal
from breaker.records.settings import FORMAT

_STATED = "  {:<16} {}"
_COMPARED = "  {:<12}  {:<8}  {:<16}  {:>9}  {:>9}  {:<6}  {:<1}"
_MOTIONS = "  {:<12}  {:<8}  {:>12}  {:>9}  {:>9}  {:>8}  {:>7}  {:>8}  {:>8}  {:<1}"
_BESIDE = "  {:<12}  {:<8}  {}  {:<1}"
ITEM = "  - "
"""How an item of a list begins on a terminal."""


def overlay_of(proposal: Proposal) -> str:
    """Return the lines of YAML to lay over config/config.yaml.

    A key that the file does not tell stands there without a value, so that the configuration is
    refused until it is filled in.
    """
    given = {**proposal.settings, **dict.fromkeys(proposal.lacking)}
    notes = {key: f"  # FILL IN: {why}" for key, why in proposal.lacking.items()}
    lines = [f"    {k}: {_yaml(given[k])}{notes.get(k, '')}" for k in FORMAT if k in given]
    sensor = [f"sensor: {_yaml(proposal.sensor)}"] if proposal.sensor else []
    return "\n".join(["endurance:", "  format:", *lines, *sensor, ""])


def _yaml(value: object) -> str:
    """A value on one line of YAML; None as nothing behind the key of what is to be filled in."""
    if isinstance(value, str) and len(value) == 1:
        return json.dumps(value)  # a sign
    look = {"default_flow_style": True, "width": np.inf, "sort_keys": False}
    text = yaml.safe_dump([value], allow_unicode=True, **look)
    if visible_text(text) != text:  # as it is shown, it is to be read
        text = yaml.safe_dump([value], **look)
    return text.strip()[1:-1]


def words_of(proposal: Proposal) -> Document:
    """Return what was found in a file, and whether it can be read with the proposal."""
    parts = [
        Section(str(proposal.layout.file), [f"  {_text(proposal)}", f"  {_time(proposal)}"]),
        *(t for t in (_stated(proposal), _table(proposal), _wired(proposal)) if t.rows),
        *(t for t in [_compared(proposal)] if t.rows),
    ]
    unit = {**FORMAT, **proposal.settings}["travel_unit"]
    about = stated_remarks(proposal.layout.stated, unit, proposal.compared)
    said = [*proposal.remarks, *about, *_said_of(proposal)]
    parts += [Section("To look at:", [Remark(each, ITEM) for each in said])] if said else []
    if proposal.lacking:
        lacking = " and ".join(proposal.lacking)
        what = "In the table above, a number stands in for what is lacking."
        parts.append(Section(f"Fill in {lacking}. {what}"))
    return Document(parts=parts)


def _said_of(proposal: Proposal) -> list[str]:
    """What there is to say of single motions; once, where several differ in numbers only."""
    file, lines = str(proposal.layout.file), []
    said = [(f"{m.motion}, {m.column}", text) for m in proposal.motions for text in m.said]
    for members in alike((file, file, text) for _, text in said):
        texts = {text for _, _, text in members}
        of = [where for where, text in said if text in texts]
        lines.append(f"{first_of(of, 1)}: {members[0][2]}")
    return lines


def alike(said: Iterable[tuple[str, str, str]]) -> list[list[tuple[str, str, str]]]:
    """Group what is said, ``(of what, where, text)``: texts of one group are of the same, and
    differ in their place, in numbers or in cells only.
    """
    groups: dict[tuple[str, str], list[tuple[str, str, str]]] = {}
    for of, where, text in said:
        place = rf"^{re.escape(where)}(?:, line \d+)?: "
        key = of, re.sub(rf"{place}|'[^']*'|[\d.]+", "", text)
        groups.setdefault(key, []).append((of, where, text))
    return list(groups.values())


def _text(proposal: Proposal) -> str:
    sheet, signs = proposal.layout, ""
    if between := sheet.settings.get("delimiter"):
        shown = {"\t": "a tab", " ": "blanks"}.get(between, repr(between))
        encoding, decimal = (sheet.settings.get(key) for key in ("encoding", "decimal"))
        signs = f": {encoding}, {shown} between columns, decimal sign {decimal!r}"
    named = "names" if any(sheet.names) else "no names"
    return (
        f"{sheet.kind}{signs}; {len(sheet.preamble)} lines of text, {named}, "
        f"{len(sheet.columns)} columns, {sheet.columns[0].size} samples"
    )


def _time(proposal: Proposal) -> str:
    clock, sheet = proposal.clock, proposal.layout
    at = "no column"
    if clock.place is not None:
        at = f"column {sheet.column(clock.place)!r} in {clock.unit or 'an unknown unit'}"
    if np.isnan(clock.rate):
        return f"time: {at}, and the rate is {'doubtful' if sheet.stated.rate_doubt else 'unknown'}"
    lasts = f"{sheet.columns[0].size / clock.rate:.1f} ms"
    return f"time: {at}, {in_digits(clock.rate, 6)} kHz, {lasts}"


def _stated(proposal: Proposal) -> Table:
    """What the text above the samples says of the breaker, the test and the settings."""
    stated = proposal.layout.stated
    numbers = {"rate": (stated.rate, "kHz"), "length": (stated.length, "ms")}
    numbers |= {"linkage ratio": (stated.ratio, "")}
    points = (f"{p.name} {p.text} {p.number()[1]}".strip() for p in stated.speed_points)
    given = {
        "breaker": ", ".join(filter(None, [stated.station, stated.bay, stated.type])),
        "serial number": stated.serial,
        "test": " or ".join(stated.dates),
        "operation": stated.operation,
        **{key: f"{in_digits(n, 6)} {u}" for key, (n, u) in numbers.items() if not np.isnan(n)},
        "travel unit": stated.travel_unit,
        "phases": ", ".join(f"{k or 'all'} {name}" for k, name in sorted(stated.phases.items())),
        "points of speed": ", ".join(points),
    }
    rows = [(f"{name}:", value) for name, value in given.items() if value]
    return Table(rows=rows, title="  stated above the samples", form=_STATED)


def _wired(proposal: Proposal) -> Table:
    """The contact, the coil and the motor, once for each channel and motion."""
    rows = {}
    for each in proposal.motions:
        settings, others, *_ = each.beside
        kinds = "contact", "current", "trigger", "motor"
        contact, current, coil, motor = (str(settings.get(f"{of}_column", "")) for of in kinds)
        contact += f", test current {current}" if current else ""
        contact += f", not {', '.join(map(str, others))}" if contact and others else ""
        coil += f", motor {motor}" if motor else ""
        if contact or coil:
            rows[str(each.column), each.motion, contact, coil] = None
    title = "  contacts and coils, which breaker report and breaker inspect FOLDER take for each"
    return Table(rows=[*rows], title=title, form=_BESIDE)


def _compared(proposal: Proposal) -> Table:
    """Results of the analyser beside those measured here; a mark where they differ."""
    rows = []
    for each in proposal.compared:
        quantity, _, channel, value, unit, *_ = each.printed
        there = np.isfinite(each.measured)
        differs = f"{each.difference:+.1%}{'  <' if each.differs else ''}" if there else each.reason
        shown = in_digits(each.measured, 4) if there else ""
        named = str(each.column) or channel, each.motion, quantity.replace("_", " ")
        rows.append((*named, in_digits(value, 4), shown, unit, differs))
    title = "  results of the analyser, and those measured here"
    heads = ("column", "motion", "quantity", "printed", "measured", "unit", "differs")
    return Table(heads, rows, title, form=_COMPARED)


def _table(proposal: Proposal) -> Table:
    """A line for each motion of each channel; times in ms, lengths in mm."""
    heads = ("column", "motion", "first motion", "rest by", "stroke", "noise", "colour", "quantum")
    heads += ("doubtful", "as proposed")
    rows = [_row(each) for each in proposal.motions]
    return Table(heads, rows, "  times in ms, lengths in mm", form=_MOTIONS)


def _row(each: InspectedMotion) -> tuple[str, ...]:
    column, phase, record = str(each.column), each.travel.phase, each.record
    place = column if phase in (*column.split(), "") else f"{column} {phase}", each.motion
    arrives = f"{each.arrives:.1f}"
    if record is None:
        end = "not read" if each.said == (NOT_READ,) else "REJECTED"
        return *place, f"{each.begins:.1f}", arrives, *[""] * 5, end
    quantum = in_digits(record.quantum, 2) if record.quantum else "fine"
    sizes = in_digits(record.segment.stroke, 4), in_digits(each.result.noise.sd, 2)
    noise = f"{each.result.noise.colour:.2f}", quantum, str(record.masked)
    return *place, f"{record.moves:.1f}", arrives, *sizes, *noise, "accepted"
