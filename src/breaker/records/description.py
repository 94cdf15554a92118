"""Describe a file without reading its records: its settings, channels and motions.

Clear values become settings. A likely value is taken with a remark; if nothing decides, or the file
contradicts itself, the key is lacking.
"""

import hashlib
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records import words
from breaker.records.channels import FAINT, Clock, Travel, Wiring, chosen_travels, find_clock
from breaker.records.files import Opened, RejectedCurveError, as_opened
from breaker.records.formats.detection import look_into
from breaker.records.header import Header
from breaker.records.operations import FILL_IN
from breaker.records.settings import TO_MM, TO_MS
from breaker.records.sheet import Sheet

if TYPE_CHECKING:
    from breaker.records.curves import GriddedRecord
    from breaker.records.record import Record

_STROKES = (2.0, 300.0)  # mm, strokes from vacuum interrupters to drives for 800 kV
_MARGIN = 0.1  # share by which proposed limits exceed the strokes: a false gain is 10 % or more
_AT_ZERO = 0.3  # mm, largest reading of the open breaker that counts as 0: accuracy of transducers

_FIRST = {letter.lower(): motion for letter, motion in words.MOTION_OF.items()}
_SEQUENCE = re.compile(r"(?<![a-z])([co])(?:[-_ ]?[co]){1,2}(?![a-z])")


class InspectedMotion(NamedTuple):
    """One motion of a channel in a file; times are ms of the file.

    Attributes:
        motion, column: "closing" or "opening", and the column of its travel.
        phase: Phase of the channel, empty if nothing states it.
        begin, end: Part of the record with only this motion; NaN for the ends of the record.
        begins, arrives: Approximate times of its start and of the rest after it.
        paired: Columns that belong to the motion, by key of the settings.
        result, remarks: Record that was read with a proposal, None if rejected; its remarks.
    """

    motion: str
    column: str | int
    phase: str = ""
    begin: float = np.nan
    end: float = np.nan
    begins: float = np.nan
    arrives: float = np.nan
    paired: Mapping[str, str | int] = MappingProxyType({})
    result: "GriddedRecord | None" = None
    remarks: tuple[str, ...] = ()

    @property
    def record(self) -> "Record | None":
        """Record that was read; None if it was not."""
        return self.result.record if self.result else None


class Description(NamedTuple):
    """Contents of a file: its header, motions, and settings of ``endurance.format``, FILL IN for
    unknown settings; whether the sign is certain; the reason if the file is not a record; and a
    digest of its travels, which is the same in copies.
    """

    preamble: Header = Header()
    parts: tuple[InspectedMotion, ...] = ()
    settings: Mapping[str, Any] = MappingProxyType({})
    sure: bool = True
    reason: str = ""
    samples: str = ""


@dataclass(eq=False)
class Findings:
    """Description of a file, before any record is read.

    Attributes:
        sheet, clock: Table of the file, and the times of its samples.
        every: Columns of travel, without columns that move far less than others.
        travels: Requested columns of travel.
        remarks: Remarks on the other columns.
        settings: Settings of ``endurance.format``, by key.
        lacking, doubts: Meanings of keys without a value, and doubts about values, by key.
        sure: Whether text, names or contacts state the sign, and not only the curve.
        paired: Columns that belong to each travel of ``every``, by motion and key of the settings.
        still: As of ``Wiring.still_poles``.
    """

    sheet: Sheet
    clock: Clock
    every: Sequence[Travel]
    travels: Sequence[Travel]
    remarks: list[str]
    settings: dict[str, Any]
    lacking: dict[str, str] = field(default_factory=dict)
    doubts: dict[str, list[str]] = field(default_factory=lambda: defaultdict(list))
    sure: bool = True
    paired: Sequence[Mapping[str, Mapping[str, str | int]]] = ()
    still: Sequence[tuple[Travel, Mapping]] = ()

    def motions(self) -> list[InspectedMotion]:
        """Return the motions of the travels; motions of one kind are separated by their parts."""
        clock, start, channels = self.clock, 0.0, []
        if clock.place is not None:
            start = float(self.sheet.columns[clock.place][0]) * TO_MS.get(clock.unit, 1.0)
        for travel, paired in zip(self.every, self.paired, strict=True):
            closing = travel.rises == (self.settings["sign"] > 0)
            column = self.sheet.column(travel.place)
            for k, closes in enumerate(closing) if travel in self.travels else ():
                part = travel.part(k) if (closing == closes).sum() > 1 else (np.nan, np.nan)
                times = [start + i / clock.likely_rate for i in (*part, *travel.moves(k))]
                motion = "closing" if closes else "opening"
                pairs = paired[motion]
                channels.append(InspectedMotion(motion, column, travel.phase, *times, pairs))
        return channels

    def find_rest(self, mm: float) -> None:
        """Find zero and stroke; ``mm`` is the length of one unit of the reading."""
        strokes = mm * np.concatenate([travel.strokes for travel in self.travels])
        sign, (low, high) = self.settings["sign"], (strokes.min(), strokes.max())
        opens = [mm * (sign * travel.rests).min() for travel in self.travels]
        ends = (1.0 - _MARGIN) * low, (1.0 + _MARGIN) * high
        self.settings["zero"] = "rest" if np.abs(opens).max() > _AT_ZERO else 0.0
        self.settings["stroke"] = [float(f"{end:.3g}") for end in ends]
        if high > (1.0 + _MARGIN) * low:
            ends = " to ".join(in_digits(float(end), 4) for end in (low, high))
            self.doubts["stroke"].append(f"the strokes of the motions differ: {ends} mm")


def look_at(
    file: str | Path | Opened, channel: str = "", line: int = 0, usual: str | int = ""
) -> Findings:
    """Describe a file: the column of travel ``channel``, or all columns of travel in the first
    sheet, or in the sheet with the column ``usual``.

    Raises:
        ValueError: If no column moves as a drive does, or the file cannot be read.
    """
    clock = find_clock(sheet := look_into(file, channel or usual, line))
    findings = Findings(sheet, clock, *chosen_travels(sheet, clock, channel), dict(sheet.settings))
    _find_time(findings)
    _find_unit(findings)
    _find_sign(findings)
    return findings


def _find_time(findings: Findings) -> None:
    sheet, clock = findings.sheet, findings.clock
    findings.doubts["time_column"] += clock.remarks
    if clock.place is not None:
        findings.settings |= {"time_column": sheet.column(clock.place), "time_unit": clock.unit}
        findings.lacking |= {} if clock.unit else {"time_unit": " or ".join(TO_MS)}
        return
    known = bool(np.isfinite(clock.rate))
    findings.settings |= {"time_column": None, "rate": clock.rate if known else None}
    doubt = sheet.stated.rate_doubt or "no rate is stated"
    findings.lacking |= {} if known else {"rate": f"kHz, samples in a ms; {doubt}"}


def _find_unit(findings: Findings) -> None:
    sheet, travel = findings.sheet, findings.travels[0]
    unit, stroke = travel.unit or words.unit_of(sheet.stated.travel_unit), travel.strokes.max()
    above = sheet.preamble[-1] if sheet.preamble else ()
    if unit is None and any(words.split_unit(cell)[1] in TO_MM for cell in above):
        reason = "has names or units of its columns on two lines; write both on one, as Travel (mm)"
        raise RejectedCurveError(sheet.file, reason)
    if unit is None:
        integers = not np.mod(np.nan_to_num(travel.course.reading), 1.0).any()
        named = [e for e in ("deg", "V", "counts") if words.holds(sheet.names[travel.place], e)]
        likely = "mm" if _STROKES[0] <= stroke <= _STROKES[1] and not integers else "counts"
        unit = [*named, likely][0]
        doubt = f"no unit of the travel is stated: {unit} for a stroke of {in_digits(stroke, 4)}"
        findings.doubts["travel_unit"].append(f"{doubt}; if that is wrong, set travel_unit")
    if unit not in TO_MM:
        shown = f"the stroke is {in_digits(stroke, 4)} {unit}"
        findings.lacking["ratio"] = f"mm for one {unit}; {shown}"
    findings.settings |= {"travel_column": sheet.column(travel.place), "travel_unit": unit}


def _find_sign(findings: Findings) -> None:
    """Find the sign by text, names, coils or contacts, or else by the curve; doubt contacts."""
    travel, wiring = findings.travels[0], Wiring(findings.sheet, findings.every)
    stated, shown = _stated_first(wiring, travel), wiring.first_motions(travel)
    seen = ({stated} - {""}) | shown or _first_by_curve(travel)
    first = stated or (min(seen) if len(seen) == 1 else "")
    if not first:
        but = "what the file shows contradicts itself" if seen else "nothing decides it"
        findings.lacking["sign"] = f"1 if the reading grows towards closed, or else -1; {but}"
    elif not stated or len(seen) > 1:
        by = "text or names, against contacts" if stated else "contacts" if shown else "the curve"
        doubt = f"the first motion is taken as {first}, by {by}; if it is wrong, change sign"
        findings.doubts["sign"].append(doubt)
    findings.settings["sign"] = 1 if (first != "opening") == travel.rises[0] else -1
    findings.sure = bool(stated or shown) and len(seen) == 1
    findings.paired = wiring.paired(findings.settings["sign"])
    findings.still = wiring.still_poles(findings.settings["sign"])
    still = (repr(findings.sheet.column(travel.place)) for travel, _ in findings.still)
    findings.remarks += [f"{column}: stands still, while its contact switches" for column in still]
    paired = [columns["closing"] for columns in findings.paired]
    if wiring.contacts and not all("contact_column" in columns for columns in paired):
        columns = map(findings.sheet.column, wiring.contacts)
        lines = " or ".join(f"contact_column: {column}" for column in columns)
        doubt = f"which contact belongs to which travel is not clear; set {lines}"
        findings.doubts["contact_column"].append(doubt)


def _stated_first(wiring: Wiring, travel: Travel) -> str:
    """Return the first motion that text, names or coils state; empty if they do not."""
    sheet = wiring.sheet
    if first := _FIRST.get(sheet.stated.operation[:1].lower()):
        return first
    above = "\n".join(" ".join(row) for row in sheet.preamble)
    for text in (sheet.file.stem, sheet.file.absolute().parent.name, above):
        sequence, named = _SEQUENCE.search(text.lower()), words.motions_in(text)
        if sequence or len(named) == 1:
            return _FIRST[sequence[1]] if sequence else named[0]
    named = {words.motion_of(sheet.names[i]) for i in wiring.coils_before(travel, 0)} - {""}
    return min(named) if len(named) == 1 else ""


def _first_by_curve(travel: Travel) -> set[str]:
    """Return the first motion by a rest at 0, and by sequences C-O or O-C-O; two if they differ."""
    directions, count = set(), len(travel.rises)
    before, after = np.abs(travel.rests[0]) / travel.strokes[0]
    if min(before, after) <= FAINT < max(before, after):
        directions.add("closing" if before < after else "opening")
    return directions | ({"closing" if count == 2 else "opening"} if count > 1 else set())


def travel_channels(
    file: str | Path | Opened, usual: str | int = ""
) -> dict[str, tuple[str, Mapping[str, Mapping[str, str | int]]]]:
    """Return the name of the channel, and the columns that belong to it, by column of travel, also
    for poles that stand still.

    The columns are from the first sheet, or from the sheet with the column ``usual``. The name is
    the phase if the file states one for each channel; otherwise it is the column.
    """

    def channels() -> dict[str, tuple[str, Mapping]]:
        findings = look_at(opened, usual=usual)
        both = [*zip(findings.every, findings.paired, strict=True), *findings.still]
        travels, paired = zip(*both, strict=True)
        columns = [str(findings.sheet.column(travel.place)) for travel in travels]
        phases = [travel.phase for travel in travels]
        names = phases if all(phases) and len({*phases}) == len(phases) else columns
        return dict(zip(columns, zip(names, paired, strict=True), strict=True))

    opened = as_opened(file)
    return opened.once(("channels", *look_into(opened, usual).names), channels)


def describe_file(file: str | Path | Opened, line: int = 0) -> Description:
    """Return the header and the motions of a file, or of a line that is a record, or the reason why
    it is not a record.
    """
    opened, stated = as_opened(file), Header()
    try:
        stated = look_into(opened, line=line).stated
        findings = look_at(opened, line=line)
    except ValueError as error:
        return Description(stated, reason=str(error).removeprefix(f"{opened.file}: "))
    if "ratio" not in findings.lacking:
        findings.find_rest(TO_MM[findings.settings["travel_unit"]])
    settings = findings.settings | {key: FILL_IN for key in findings.lacking if key != "sign"}
    settings = {k: value for k, value in settings.items() if k not in ("travel_column", "stroke")}
    parts = findings.motions()
    if np.isnan(findings.clock.rate):  # the times of the parts are unknown
        parts = [part._replace(begin=np.nan, end=np.nan) for part in parts]
    columns = np.stack([findings.sheet.columns[travel.place] for travel in findings.travels])
    samples = hashlib.sha256(columns.tobytes()).hexdigest()
    return Description(stated, tuple(parts), settings, findings.sure, samples=samples)
