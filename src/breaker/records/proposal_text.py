"""A proposal in words: what was found in a file, and the lines of configuration that read it."""

import json
import re
from collections.abc import Iterable, Sequence

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
    # Within brackets, since packed lines are, where `I [A]` needs quotation marks.
    text = yaml.safe_dump([value], allow_unicode=True, **look)
    if visible_text(text) != text:  # as it is shown, it is to be read
        text = yaml.safe_dump([value], **look)
    return text.strip()[1:-1]


def words_of(proposal: Proposal) -> Document:
    """Return what was found in a file, and whether it can be read with the proposal."""
    parts = [Section(str(proposal.layout.file), [f"  {_text(proposal)}", f"  {_time(proposal)}"])]
    parts += [
        *_stated(proposal),
        _table(proposal),
        *_wired(proposal),
        *_compared(proposal),
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
    said = [
        (str(proposal.layout.file), f"{each.motion}, {each.column}", text)
        for each in proposal.motions
        for text in each.said
    ]
    lines = []
    for members in alike((file, file, text) for file, _, text in said):
        of = [where for file, where, text in said if (file, file, text) in members]
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
    layout, signs = proposal.layout, ""
    if "delimiter" in layout.settings:
        between = {"\t": "a tab", " ": "blanks"}.get(layout.settings["delimiter"])
        between = between or repr(layout.settings["delimiter"])
        signs = f": {{encoding}}, {between} between columns, decimal sign {{decimal!r}}"
        signs = signs.format(**layout.settings)
    named = "names" if any(layout.names) else "no names"
    return (
        f"{layout.kind}{signs}; {len(layout.preamble)} lines of text, {named}, "
        f"{len(layout.columns)} columns, {layout.columns[0].size} samples"
    )


def _time(proposal: Proposal) -> str:
    clock = proposal.clock
    lasts = f"{proposal.layout.columns[0].size / clock.rate:.1f} ms"
    if clock.place is not None:
        column = proposal.layout.column(clock.place)
        return f"time: column {column!r} in {clock.unit}, {in_digits(clock.rate, 4)} kHz, {lasts}"
    if np.isnan(clock.rate):
        why = "the rate is doubtful" if proposal.layout.stated.rate_doubt else "no rate is stated"
        return f"time: no column, and {why}"
    return f"time: no column, {in_digits(clock.rate, 6)} kHz, {lasts}"


def _stated(proposal: Proposal) -> list[Table]:
    """What the text above the samples says of the breaker, the test and the settings."""
    stated = proposal.layout.stated
    phases = (f"{number or 'all'} {name}" for number, name in sorted(stated.phases.items()))
    given = {
        "breaker": ", ".join(filter(None, [stated.station, stated.bay, stated.type])),
        "serial number": stated.serial,
        "test": " or ".join(stated.dates),
        "operation": stated.operation,
        "rate": "" if np.isnan(stated.rate) else f"{in_digits(stated.rate, 6)} kHz",
        "length": "" if np.isnan(stated.length) else f"{in_digits(stated.length, 6)} ms",
        "linkage ratio": "" if np.isnan(stated.ratio) else in_digits(stated.ratio, 6),
        "travel unit": stated.travel_unit,
        "phases": ", ".join(phases),
        "points of speed": ", ".join(
            f"{pair.name} {pair.text} {pair.number()[1]}".strip() for pair in stated.speed_points
        ),
    }
    rows = [(f"{name}:", value) for name, value in given.items() if value]
    return [Table(rows=rows, title="  stated above the samples", form=_STATED)] if rows else []


def _wired(proposal: Proposal) -> list[Table]:
    """The contact, the coil and the motor of each motion, where there are any."""
    rows = {}
    for each in proposal.motions:
        settings, others, *_ = each.beside
        contact, current, coil, motor = (
            str(settings.get(f"{key}_column", ""))
            for key in ("contact", "current", "trigger", "motor")
        )
        more = {"with": current, "not": ", ".join(map(str, others)) if contact else ""}
        contact += "".join(f", {word} {column}" for word, column in more.items() if column)
        coil += f", motor {motor}" if motor else ""
        if contact or coil:
            rows[str(each.column), each.motion, contact, coil] = None
    title = "  contacts and coils, which breaker report and breaker inspect FOLDER take for each"
    return [Table(rows=[*rows], title=title, form="  {:<12}  {:<8}  {}  {:<1}")] if rows else []


def _compared(proposal: Proposal) -> list[Table]:
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
    return [Table(heads, rows, title, form=_COMPARED)] if rows else []


def _table(proposal: Proposal) -> Table:
    """A line for each motion of each channel; times in ms, lengths in mm."""
    heads = ("column", "motion", "first motion", "rest by", "stroke", "noise", "colour", "quantum")
    heads += ("doubtful", "as proposed")
    rows = [*map(_row, proposal.motions)]
    return Table(heads, rows, "  times in ms, lengths in mm", form=_MOTIONS)


def _row(each: InspectedMotion) -> Sequence[str]:
    column = str(each.column)
    named = not each.phase or each.phase in column.split()
    place = [column if named else f"{column} {each.phase}", each.motion]
    record = each.record
    if record is None:
        end = "not read" if each.said == (NOT_READ,) else "REJECTED"
        return [*place, f"{each.begins:.1f}", f"{each.arrives:.1f}", *[""] * 5, end]
    return [
        *place,
        f"{record.moves:.1f}",
        f"{each.arrives:.1f}",
        in_digits(record.segment.stroke, 4),
        in_digits(each.result.noise.sd, 2),
        f"{each.result.noise.colour:.2f}",
        in_digits(record.quantum, 2) if record.quantum else "fine",
        str(record.masked),
        "accepted",
    ]
