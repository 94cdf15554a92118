"""Propose settings for a record of unknown origin from its content, and read it to confirm them.

A proposal contains only settings that differ from the defaults. The user fills in values that a
file does not state, such as the mm of a degree; a usual number replaces them in the trial reading.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mode

import numpy as np
import yaml

from breaker.common.document import Document, Remark, Table
from breaker.common.numerals import in_digits
from breaker.records.curves import Grid, put_on_grid
from breaker.records.description import Findings, InspectedMotion, look_at
from breaker.records.files import Files, RejectedCurveError
from breaker.records.operations import Operation
from breaker.records.reader import Reader
from breaker.records.settings import FORMAT, TO_MM
from breaker.records.words import BESIDE

_USUAL = 15.0  # mm, stroke that is assumed in the trial reading if the ratio is unknown
_LINE = {"default_flow_style": True, "width": np.inf, "sort_keys": False}
ITEM = "  - "
"""Beginning of an item of a list on a terminal."""


@dataclass(frozen=True)
class Proposal:
    """Settings that are proposed for a file, and its motions as read with these settings."""

    findings: Findings
    settings: dict  # keys of ``endurance.format`` that differ from their default
    motions: Sequence[InspectedMotion]
    remarks: Sequence[str]

    @property
    def lacking(self) -> Mapping[str, str]:
        """Keys of ``endurance.format`` that the user has to fill in, and their meaning."""
        return self.findings.lacking

    @property
    def is_read(self) -> bool:
        """Whether the settings read a motion, or may do so once the rate is filled in."""
        return "rate" in self.lacking or any(motion.record for motion in self.motions)


def inspect_file(
    file: str | Path, sensor: Mapping, channel: str = "", files: Files | None = None
) -> Proposal:
    """Propose settings for a file, and read the file with these settings and the section
    ``sensor``: all columns of travel, or only ``channel``.

    Raises:
        ValueError: If no column of the file moves as a drive does, or the file cannot be read.
    """
    files = Files() if files is None else files
    findings = look_at(files[file], channel)
    travels, remarks = findings.travels, findings.remarks
    usual = _USUAL / float(np.median(travels[0].strokes))
    instead = {"rate": findings.clock.likely_rate, "ratio": usual, "time_unit": "ms"}
    instead = {key: value for key, value in instead.items() if key in findings.lacking}
    findings.find_rest(instead.get("ratio") or TO_MM[findings.settings["travel_unit"]])
    read_by = findings.sheet.file, FORMAT | findings.settings | instead, sensor, files
    motions = [_as_read(entry, *read_by) for entry in findings.motions()]
    first, *others = (motion.paired.items() for motion in motions)
    findings.settings |= dict(item for item in first if all(item in of for of in others))
    read = [motion.column for motion in motions if motion.record] or [motions[0].column]
    findings.settings["travel_column"] = mode(read)  # the column with most motions that are read
    if "ratio" in findings.lacking:
        findings.settings["stroke"] = FORMAT["stroke"]
    remarks += [doubt for doubts in findings.doubts.values() for doubt in doubts]
    if len({(travel.unit, bool(travel.rises[0])) for travel in travels}) > 1:
        remarks.append("columns of travel differ in unit or direction: choose one by --channel")
    settings = {key: value for key, value in findings.settings.items() if value != FORMAT[key]}
    return Proposal(findings, settings, motions, remarks)


def _as_read(
    motion: InspectedMotion, file: Path, settings: Mapping, sensor: Mapping, files: Files
) -> InspectedMotion:
    """Return a motion, read with the columns that belong to it."""
    part = {"begin": motion.begin, "end": motion.end, "phase": motion.phase}
    settings = {**settings, "travel_column": motion.column, **motion.paired}
    times = np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
    try:
        record = Reader(settings, files).read(Operation(1, file, **part), motion.motion)
        result = put_on_grid(record, Grid(times, sensor["noise_sd"]))
    except RejectedCurveError as error:
        return motion._replace(remarks=(str(error),))
    return motion._replace(result=result, remarks=result.remarks)


def overlay_of(proposal: Proposal) -> str:
    """Return the lines of YAML to lay over config/config.yaml, without values to be filled in."""
    given = {**proposal.settings, **dict.fromkeys(proposal.lacking)}
    lines = ["endurance:", "  format:"]
    for key in filter(given.__contains__, FORMAT):
        value = yaml.safe_dump([given[key]], allow_unicode=True, **_LINE)
        meaning = f"  # FILL IN: {proposal.lacking[key]}" if key in proposal.lacking else ""
        lines.append(f"    {key}: {value.strip()[1:-1]}{meaning}")
    return "\n".join([*lines, ""])


def words_of(proposal: Proposal) -> Document:
    """Return the content of a file, and whether it can be read with the proposal."""
    sheet, clock = proposal.findings.sheet, proposal.findings.clock
    time = "no column of time"
    if clock.place is not None:
        time = f"time in column {sheet.column(clock.place)!r}, {clock.unit or 'an unknown unit'}"
    rate = "rate not known" if np.isnan(clock.rate) else f"{in_digits(clock.rate, 6)} kHz"
    size = f"{len(sheet.columns)} columns, {sheet.columns[0].size} samples"
    remarks = [*proposal.remarks]
    texts = [("", f"{m.motion}, {m.column}", text) for m in proposal.motions for text in m.remarks]
    for (_, where, text), *others in grouped(texts):
        remarks.append(f"{where}{f' and {len(others)} more' if others else ''}: {text}")
    parts = [Table(title=str(sheet.file), rows=[f"  {sheet.kind}; {size}; {time}, {rate}"])]
    looked = Table(title="To look at:", rows=[Remark(e, ITEM) for e in remarks])
    parts += [table for table in (_motions(proposal), _wired(proposal), looked) if table.rows]
    if lacking := " and ".join(proposal.lacking):
        what = "Above, a number stands in for what is lacking."
        parts.append(Table(title=f"Fill in {lacking}. {what}"))
    return Document(parts=parts)


def grouped(remarks: Iterable[tuple[str, str, str]]) -> list[list[tuple[str, str, str]]]:
    """Group remarks ``(group, place, text)`` whose texts differ only in place, numbers or cells."""
    groups: dict[tuple[str, str], list[tuple[str, str, str]]] = {}
    for group, where, text in remarks:
        place = rf"^{re.escape(where)}(?:, line \d+)?: "
        key = group, re.sub(rf"{place}|'[^']*'|[\d.]+", "", text)
        groups.setdefault(key, []).append((group, where, text))
    return list(groups.values())


def _motions(proposal: Proposal) -> Table:
    """Return a table with a row for each motion of each channel; times in ms, lengths in mm."""
    heads = ("column", "motion", "first motion", "rest by", "stroke", "noise", "doubtful")
    rows = []
    for motion in proposal.motions:
        column, phase, record = str(motion.column), motion.phase, motion.record
        place = column if phase in (*column.split(), "") else f"{column} {phase}"
        begins, ends = motion.begins, ("", "", "", "REJECTED")
        if record:
            sizes = in_digits(record.segment.stroke, 4), in_digits(motion.result.record.noise.sd, 2)
            begins, ends = record.moves, (*sizes, str(record.masked), "accepted")
        rows.append((place, motion.motion, f"{begins:.1f}", f"{motion.arrives:.1f}", *ends))
    return Table((*heads, "as proposed"), rows, "  times in ms, lengths in mm")


def _wired(proposal: Proposal) -> Table:
    """Return a table of contact with test current, and coil, by channel and motion."""
    rows = {}
    for motion in proposal.motions:
        contact, current, coil = (motion.paired.get(f"{kind}_column", "") for kind in BESIDE)
        current = current and f", test current {current}"
        if contact or coil:
            rows[str(motion.column), motion.motion, f"{contact}{current}", f"{coil}"] = None
    return Table(rows=[*rows], title="  contacts and coils of each travel")
