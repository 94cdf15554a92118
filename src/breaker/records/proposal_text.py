"""A proposal in words: what a file shows, and the lines of configuration that read it."""

import re
from collections.abc import Iterable

import numpy as np
import yaml

from breaker.common.numerals import in_digits
from breaker.common.visible_text import visible_text
from breaker.documents.parts import Document, Remark, Section, Table
from breaker.records.proposal import Proposal
from breaker.records.settings import FORMAT, TO_MM

_COMPARED = "  {:<12}  {:<8}  {:<16}  {:>9}  {:>9}  {:<6}  {:<1}"
_MOTIONS = "  {:<12}  {:<8}  {:>12}  {:>9}  {:>9}  {:>8}  {:>8}  {:<1}"
_BESIDE = "  {:<12}  {:<8}  {}  {:<1}"
_LINE = {"default_flow_style": True, "width": np.inf, "sort_keys": False}
ITEM = "  - "
"""How an item of a list begins on a terminal."""


def overlay_of(proposal: Proposal) -> str:
    """Return the lines of YAML to lay over config/config.yaml, without values to be filled in."""
    given = {**proposal.settings, **dict.fromkeys(proposal.lacking)}
    lines = ["endurance:", "  format:"]
    for key in filter(given.__contains__, FORMAT):
        value = yaml.safe_dump([given[key]], allow_unicode=True, **_LINE)
        if visible_text(value) != value:  # invisible signs are written by their numbers
            value = yaml.safe_dump([given[key]], **_LINE)
        why = f"  # FILL IN: {proposal.lacking[key]}" if key in proposal.lacking else ""
        lines.append(f"    {key}: {value.strip()[1:-1]}{why}")
    return "\n".join([*lines, ""])


def words_of(proposal: Proposal) -> Document:
    """Return what a file shows, and whether it can be read with the proposal."""
    sheet, clock, at = proposal.layout, proposal.clock, "no column of time"
    if clock.place is not None:
        at = f"time in column {sheet.column(clock.place)!r}, {clock.unit or 'an unknown unit'}"
    rate = "rate not known" if np.isnan(clock.rate) else f"{in_digits(clock.rate, 6)} kHz"
    size = f"{len(sheet.columns)} columns, {sheet.columns[0].size} samples"
    tables = _motions(proposal), _wired(proposal), _compared(proposal)
    remarks, ratio = [*proposal.remarks], sheet.stated.ratio
    if {**FORMAT, **proposal.settings}["travel_unit"] in TO_MM and abs(ratio - 1.0) > 0.0:
        how = "if the stroke lacks it, set endurance.format.ratio"
        remarks.append(f"a linkage ratio of {in_digits(ratio, 6)} is stated, not applied: {how}")
    said = [("", f"{m.motion}, {m.column}", text) for m in proposal.motions for text in m.said]
    for (_, where, text), *others in alike(said):
        remarks.append(f"{where}{f' and {len(others)} more' if others else ''}: {text}")
    parts = [Section(str(sheet.file), [f"  {sheet.kind}; {size}; {at}, {rate}"])]
    parts += [table for table in tables if table.rows]
    parts += [Section("To look at:", [Remark(each, ITEM) for each in remarks])] if remarks else []
    if lacking := " and ".join(proposal.lacking):
        parts.append(Section(f"Fill in {lacking}. Above, a number stands in for what is lacking."))
    return Document(parts=parts)


def alike(said: Iterable[tuple[str, str, str]]) -> list[list[tuple[str, str, str]]]:
    """Group remarks ``(of what, where, text)`` that differ in place, numbers or cells only."""
    groups: dict[tuple[str, str], list[tuple[str, str, str]]] = {}
    for of, where, text in said:
        place = rf"^{re.escape(where)}(?:, line \d+)?: "
        key = of, re.sub(rf"{place}|'[^']*'|[\d.]+", "", text)
        groups.setdefault(key, []).append((of, where, text))
    return list(groups.values())


def _motions(proposal: Proposal) -> Table:
    """A line for each motion of each channel; times in ms, lengths in mm."""
    heads = ("column", "motion", "first motion", "rest by", "stroke", "noise", "doubtful")
    rows = []
    for motion in proposal.motions:
        column, phase, record = str(motion.column), motion.travel.phase, motion.record
        place = column if phase in (*column.split(), "") else f"{column} {phase}"
        begins, ends = motion.begins, ("", "", "", "REJECTED")
        if record:
            sizes = in_digits(record.segment.stroke, 4), in_digits(motion.result.noise.sd, 2)
            begins, ends = record.moves, (*sizes, str(record.masked), "accepted")
        rows.append((place, motion.motion, f"{begins:.1f}", f"{motion.arrives:.1f}", *ends))
    return Table((*heads, "as proposed"), rows, "  times in ms, lengths in mm", form=_MOTIONS)


def _wired(proposal: Proposal) -> Table:
    """The contact with its test current, and the coil with the motor, by channel and motion."""
    rows = {}
    for motion in proposal.motions:
        kinds = (
            ("contact", ""),
            ("current", ", test current "),
            ("trigger", ""),
            ("motor", ", motor "),
        )
        names = [(before, motion.beside.get(f"{kind}_column", "")) for kind, before in kinds]
        contact, current, coil, motor = (
            f"{before}{name}" if name else "" for before, name in names
        )
        if contact or coil or motor:
            rows[str(motion.column), motion.motion, contact + current, coil + motor] = None
    return Table(rows=[*rows], title="  contacts and coils of each travel", form=_BESIDE)


def _compared(proposal: Proposal) -> Table:
    """Results of the analyser with those measured here; a mark where they differ."""
    rows = []
    for each in proposal.compared:
        quantity, _, channel, value, unit, *_ = each.printed
        named = str(each.column) or channel, each.motion, quantity.replace("_", " ")
        measured, differs = "", each.reason
        if np.isfinite(each.measured):
            measured = in_digits(each.measured, 4)
            differs = f"{each.difference:+.1%}{'  <' if each.differs else ''}"
        rows.append((*named, in_digits(value, 4), measured, unit, differs))
    title = "  results of the analyser, and those measured here"
    heads = ("column", "motion", "quantity", "printed", "measured", "unit", "differs")
    return Table(heads, rows, title, form=_COMPARED)
