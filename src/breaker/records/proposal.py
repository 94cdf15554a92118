"""Settings for a record of unknown origin: proposed from what it shows, confirmed by reading.

A proposal contains only what differs from the defaults. What a file does not state, such as the mm
of a degree, has to be filled in; to try all else, a number stands in for it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from breaker.records import description
from breaker.records.axes import Scale
from breaker.records.channels import Clock, Travel, chosen_travels, find_clock
from breaker.records.curves import put_on_grid
from breaker.records.files import Files, RejectedCurveError
from breaker.records.formats.registry import look_into
from breaker.records.grid import Grid
from breaker.records.printed import PrintedComparison, compare_printed
from breaker.records.reader import Reader
from breaker.records.settings import FORMAT
from breaker.records.sheet import Sheet
from breaker.records.words import holds

_USUAL = 15.0  # mm: a stroke that stands in where no mm are known


@dataclass(frozen=True)
class Proposal:
    """Settings that are proposed for a file, and its motions as they were read with these."""

    layout: Sheet
    clock: Clock
    travels: Sequence[Travel]
    settings: dict  # keys of ``endurance.format`` that differ from their default
    motions: Sequence[description.InspectedMotion]
    remarks: Sequence[str]
    found: description.Findings

    @property
    def lacking(self) -> Mapping[str, str]:
        """Keys of ``endurance.format`` that have to be filled in, and their meaning."""
        return self.found.lacking

    @property
    def is_read(self) -> bool:
        """Whether the settings read a motion, or may once the rate is filled in."""
        return "rate" in self.lacking or any(motion.record for motion in self.motions)

    @cached_property
    def compared(self) -> list[PrintedComparison]:
        """Printed results, and what is measured; none while a setting is lacking."""
        return compare_printed(self.layout, self.travels, [] if self.lacking else self.motions)


def inspect_file(
    file: str | Path, sensor: Mapping, channel: str = "", files: Files | None = None
) -> Proposal:
    """Propose settings for a file, and read it by them and the section ``sensor`` of settings; all
    columns of travel are meant, unless a channel names one.

    Raises:
        ValueError: If no column of the file moves as a drive does, or the file cannot be read.
    """
    files = Files() if files is None else files
    clock = find_clock(sheet := look_into(files[file]))
    every, travels, remarks = chosen_travels(sheet, clock, channel)
    found = description.findings_of(sheet, clock, travels)
    usual = _USUAL / float(np.median(travels[0].strokes))
    instead = {"rate": clock.likely_rate, "ratio": usual, "time_unit": "ms"}
    instead = {key: value for key, value in instead.items() if key in found.lacking}
    scale = Scale.from_settings(FORMAT | found.settings | instead)
    description.find_rest(found, travels, abs(scale.factor))
    places = {travel.place for travel in travels}
    motions = description.motions_of(sheet, clock, every, found.settings["sign"])
    motions = [motion for motion in motions if motion.travel.place in places]
    motions = _read(motions, FORMAT | found.settings | instead, sensor, files)
    first, *others = (motion.beside.items() for motion in motions)
    found.settings |= dict(item for item in first if all(item in of for of in others))
    found.settings["travel_column"] = _best_column(motions)
    if "ratio" in found.lacking:
        found.settings["stroke"] = FORMAT["stroke"]
    remarks += [doubt for doubts in found.doubts.values() for doubt in doubts]
    if len({(travel.unit, bool(travel.rises[0])) for travel in travels}) > 1:
        remarks.append("columns of travel differ in unit or direction: choose one by --channel")
    for column in {str(motion.beside.get("contact_column")) for motion in motions}:
        if holds(column, "52a") or holds(column, "52b"):
            remarks.append(f"{column!r} is an auxiliary switch, not timed as the main contacts")
    settings = {key: value for key, value in found.settings.items() if value != FORMAT[key]}
    return Proposal(sheet, clock, travels, settings, motions, remarks, found)


def _best_column(motions: Sequence[description.InspectedMotion]) -> str | int:
    """The column of travel of which most motions are read, with the fewest remarks, the first."""

    def rank(column: str | int) -> tuple[int, int]:
        own = [motion for motion in motions if motion.column == column]
        return sum(bool(each.record) for each in own), -sum(len(each.said) for each in own)

    return max(dict.fromkeys(motion.column for motion in motions), key=rank)


def _read(
    motions: Sequence[description.InspectedMotion], settings: Mapping, sensor: Mapping, files: Files
) -> list[description.InspectedMotion]:
    """Motions as they are read with their own columns."""
    times, read = np.linspace(sensor["start"], sensor["stop"], sensor["samples"]), []
    for motion in motions:
        own = {**settings, "travel_column": motion.column, **motion.beside}
        try:
            record = Reader(own, files).read(motion.operation, motion.motion)
            result = put_on_grid(record, Grid(times, sensor["noise_sd"]))
            read.append(replace(motion, result=result, said=result.remarks))
        except RejectedCurveError as error:
            read.append(replace(motion, said=(str(error),)))
    return read
