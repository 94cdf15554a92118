"""A proposal in words: what a file shows, and the lines of configuration that read it."""

import json
import re
from collections.abc import Iterable

import numpy as np
import yaml

from breaker.common.numerals import in_digits
from breaker.common.visible_text import visible_text
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.records.printed import stated_remarks
from breaker.records.proposal import Proposal
from breaker.records.settings import FORMAT

_COMPARED = "  {:<12}  {:<8}  {:<16}  {:>9}  {:>9}  {:<6}  {:<1}"
_MOTIONS = "  {:<12}  {:<8}  {:>12}  {:>9}  {:>9}  {:>8}  {:>8}  {:<1}"
_BESIDE = "  {:<12}  {:<8}  {}  {:<1}"
ITEM = "  - "
"""How an item of a list begins on a terminal."""


def overlay_of(proposal: Proposal) -> str:
    """Return the lines of YAML to lay over config/config.yaml, without values to be filled in."""
    given = {**proposal.settings, **dict.fromkeys(proposal.lacking)}
    notes = {key: f"  # FILL IN: {why}" for key, why in proposal.lacking.items()}
    lines = [f"    {k}: {_yaml(given[k])}{notes.get(k, '')}" for k in FORMAT if k in given]
    return "\n".join(["endurance:", "  format:", *lines, ""])


def _yaml(value: object) -> str:
    """A value on one line of YAML; nothing for None behind a key that is to be filled in."""
    if isinstance(value, str) and len(value) == 1:
        return json.dumps(value)  # a sign
    look = {"default_flow_style": True, "width": np.inf, "sort_keys": False}
    text = yaml.safe_dump([value], allow_unicode=True, **look)
    if visible_text(text) != text:  # as it is shown, it is to be read
        text = yaml.safe_dump([value], **look)
    return text.strip()[1:-1]


def words_of(proposal: Proposal) -> Document:
    """Return what a file shows, and whether it can be read with the proposal."""
    sheet, clock, at = proposal.layout, proposal.clock, "no column of time"
    if clock.place is not None:
        at = f"time in column {sheet.column(clock.place)!r}, {clock.unit or 'an unknown unit'}"
    rate = "rate not known" if np.isnan(clock.rate) else f"{in_digits(clock.rate, 6)} kHz"
    size = f"{len(sheet.columns)} columns, {sheet.columns[0].size} samples"
    tables = _table(proposal), _wired(proposal), _compared(proposal)
    parts = [Section(str(sheet.file), [f"  {sheet.kind}; {size}; {at}, {rate}"])]
    parts += [table for table in tables if table.rows]
    unit = {**FORMAT, **proposal.settings}["travel_unit"]
    remarks = [*proposal.remarks, *stated_remarks(sheet.stated, unit)]
    lines = [Remark(line, ITEM) for line in (*remarks, *_said_of(proposal))]
    parts += [Section("To look at:", lines)] if lines else []
    if lacking := " and ".join(proposal.lacking):
        parts.append(Section(f"Fill in {lacking}. Above, a number stands in for what is lacking."))
    return Document(parts=parts)


def _said_of(proposal: Proposal) -> list[str]:
    """Remarks on single motions; once, where several differ in numbers only."""
    said = [("", f"{m.motion}, {m.column}", text) for m in proposal.motions for text in m.said]
    lines = []
    for (_, where, text), *others in alike(said):
        more = f" and {len(others)} more" if others else ""
        lines.append(f"{where}{more}: {text}")
    return lines


def alike(said: Iterable[tuple[str, str, str]]) -> list[list[tuple[str, str, str]]]:
    """Group remarks ``(of what, where, text)`` that differ in place, numbers or cells only."""
    groups: dict[tuple[str, str], list[tuple[str, str, str]]] = {}
    for of, where, text in said:
        place = rf"^{re.escape(where)}(?:, line \d+)?: "
        key = of, re.sub(rf"{place}|'[^']*'|[\d.]+", "", text)
        groups.setdefault(key, []).append((of, where, text))
    return list(groups.values())


def _wired(proposal: Proposal) -> Table:
    """The contact with its test current, and the coil with the motor, by channel and motion."""
    rows = {}
    for motion in proposal.motions:
        kinds = "contact", "current", "trigger", "motor"
        names = [str(motion.beside.get(f"{kind}_column", "")) for kind in kinds]
        contact = names[0] + (f", test current {names[1]}" if names[1] else "")
        coil = names[2] + (f", motor {names[3]}" if names[3] else "")
        if contact or coil:
            rows[str(motion.column), motion.motion, contact, coil] = None
    return Table(rows=[*rows], title="  contacts and coils of each travel", form=_BESIDE)


def _compared(proposal: Proposal) -> Table:
    """Results of the analyser with those measured here; a mark where they differ."""
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
    heads = ("column", "motion", "first motion", "rest by", "stroke", "noise", "doubtful")
    rows = []
    for motion in proposal.motions:
        column, phase, record = str(motion.column), motion.travel.phase, motion.record
        place = column if phase in (*column.split(), "") else f"{column} {phase}"
        begins = record.moves if record else motion.begins
        ends = "", "", "", "REJECTED"
        if record:
            sizes = in_digits(record.segment.stroke, 4), in_digits(motion.result.noise.sd, 2)
            ends = *sizes, str(record.masked), "accepted"
        rows.append((place, motion.motion, f"{begins:.1f}", f"{motion.arrives:.1f}", *ends))
    return Table((*heads, "as proposed"), rows, "  times in ms, lengths in mm", form=_MOTIONS)
