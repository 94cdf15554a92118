"""Settings for a record of unknown origin: proposed from what it looks like, confirmed by reading.

A proposal holds only what differs from the defaults. What a file does not tell, such as the mm of a
degree, is left to fill in; to try all else, a number stands in for it, and is not proposed.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from breaker.records.axes import Scale
from breaker.records.channels import Clock, Travel, chosen_travels, find_clock
from breaker.records.contact_columns import Beside, columns_beside
from breaker.records.curves import ReadRecord, read_record
from breaker.records.files import Files, RejectedCurveError
from breaker.records.grid import Grid
from breaker.records.guesses import (
    Guess,
    guess_direction,
    guess_grid,
    guess_rest,
    guess_time,
    guess_unit,
    of_default_size,
    strokes_of,
)
from breaker.records.layout import Layout, look_into
from breaker.records.noise import noise_remarks
from breaker.records.operations import Operation
from breaker.records.printed import PrintedComparison, compare_printed
from breaker.records.settings import FORMAT, TO_MS, complete

NOT_READ = "not read, as the record is long; choose a column by --channel, or export a shorter part"

_STILL = 15.0  # ms at rest, at least, after which a motion is over; a slow rebound takes longer
_NOISES = (1e-4, 10.0)  # mm, that the configuration takes; an exact curve has less
_NOISE = 1.25  # times the noise of the settings, from which another is proposed
# Cells that are read, of a record once per motion, and those that a line counts for beside its own.
_MOST, _LINE = 26_000_000, 17
_STROKE = 15.0  # mm, that stands in for what is not known


@dataclass(frozen=True)
class InspectedMotion:
    """One motion of one channel, and how it was read with the proposal.

    Attributes:
        column: Name or number of the column.
        operation: Where it is in the column.
        motion: "closing" or "opening".
        begins, arrives: Times, ms of the file, about: the first motion, and the rest after it.
        record: The record; None if it was rejected or not read.
        said: Why it was, or what is doubtful about it; empty if nothing is.
        phase: Of the column; empty where nothing says it.
        beside: Contact and coil that go with it.
    """

    column: str | int
    operation: Operation
    motion: str
    begins: float
    arrives: float
    record: ReadRecord | None = None
    said: tuple[str, ...] = ()
    phase: str = ""
    beside: Beside = field(default_factory=Beside)


@dataclass(frozen=True)
class Proposal:
    """What was found in a file.

    Attributes:
        layout, clock, travels: Its text, its time, and its columns of travel.
        settings: Keys of ``endurance.format`` that differ from their default.
        sensor: Keys of ``sensor`` that differ from the configuration; none of a drive of another
            size than those of the default prior.
        lacking: Keys of ``endurance.format`` that the file does not tell, and what they mean.
        motions: Every motion of every channel.
        remarks: What has to be looked at, in words.
        guesses: Of which the settings are, each with the remarks that are about it.
    """

    layout: Layout
    clock: Clock
    travels: Sequence[Travel]
    settings: dict
    sensor: dict
    lacking: dict[str, str]
    motions: Sequence[InspectedMotion]
    remarks: Sequence[str]
    guesses: Sequence[Guess] = ()

    @cached_property
    def compared(self) -> list[PrintedComparison]:
        """Results that the text states, beside what is measured; none where a setting lacks, as
        what stands in for it measures nothing.
        """
        used = () if self.lacking else self.motions
        return compare_printed(self.layout, self.travels, used)


def inspect_file(
    file: str | Path, sensor: Mapping, channel: str = "", files: Files | None = None
) -> Proposal:
    """Propose settings for a file, and read it with them.

    Args:
        file: File of one record.
        sensor: The section ``sensor`` of the configuration.
        channel: Name or number of the column of travel, where not all of them are meant.
        files: In which it is opened, or others that are opened, too.

    Raises:
        InspectionError: If no column of the file moves as a drive does.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    files = Files() if files is None else files
    clock = find_clock(layout := look_into(files[file]))
    every, travels, unused = chosen_travels(layout, clock, channel)
    direction = guess_direction(layout, travels)
    guesses = [guess_time(layout, clock), guess_unit(layout, travels), direction]
    settings, lacking = {**FORMAT, **layout.settings}, {}
    for guess in guesses:
        settings |= guess.settings
        lacking |= guess.lacking
    instead = {"rate": clock.likely_rate, "ratio": _STROKE / np.median(strokes_of(travels))}
    tried = settings | {key: instead[key] for key in lacking}
    mm, sign = abs(Scale.from_settings(tried).factor), settings["sign"]
    rest = guess_rest(travels, mm, sign)
    columns = {layout.column(travel.place) for travel in travels}
    found = [each for each in motions_of(layout, clock, every, sign) if each.column in columns]
    grid = _grid(found, travels, clock.likely_rate, sensor)
    settings, tried = (each | rest.settings for each in (settings, tried))
    changed = {**grid.settings}
    motions = _read(found, tried, Grid(_times(sensor | changed)), _most(layout), files)
    settings |= _common(found) | _best_column(motions)
    if "ratio" in lacking:
        settings["stroke"] = FORMAT["stroke"]
    else:
        changed |= _noise(motions, sensor)
    # Of another size of drive, `breaker fit-prior` proposes the sensor along with the prior.
    sized = "ratio" not in lacking and of_default_size(mm * strokes_of(travels))
    motions = [_judged(each, (sensor | changed) if sized else {}) for each in motions]
    guesses += [rest, grid] if sized else [rest]
    return Proposal(
        layout=layout,
        clock=clock,
        travels=travels,
        settings={key: value for key, value in settings.items() if value != FORMAT[key]},
        sensor=changed if sized else {},
        lacking=lacking,
        motions=motions,
        remarks=[*unused, *(remark for guess in guesses for remark in guess.remarks)],
        guesses=guesses,
    )


def motions_of(
    layout: Layout, clock: Clock, travels: Sequence[Travel], sign: int
) -> list[InspectedMotion]:
    """Return the motions of all travels of a file; one that is there more than once needs its
    part. The sign is 1 if their reading grows towards closed, -1 if it falls.
    """
    rate, start = clock.likely_rate, 0.0
    if clock.place is not None:
        start = float(layout.columns[clock.place][0]) * TO_MS[clock.unit]
    found = []
    for travel, beside in zip(travels, columns_beside(layout, travels, sign), strict=True):
        closing, column = travel.rises == (sign > 0), layout.column(travel.place)
        for k in range(closing.size):
            part = travel.part(k) if (closing == closing[k]).sum() > 1 else (np.nan, np.nan)
            begins = travel.begins(k)
            still = max(round(_STILL * rate), 2 * (travel.course.middles[k] - begins))
            times = [start + i / rate for i in (*part, begins, travel.arrives(k, still))]
            operation = Operation(k + 1, layout.file, begin=times[0], end=times[1])
            motion = "closing" if closing[k] else "opening"
            about = {"phase": travel.phase, "beside": beside[motion]}
            found.append(InspectedMotion(column, operation, motion, *times[2:], **about))
    return found


def _grid(
    motions: Sequence[InspectedMotion], travels: Sequence[Travel], rate: float, sensor: Mapping
) -> Guess:
    """A grid that holds the longest motion, in the room that each has in its record."""
    longest = max(each.arrives - each.begins for each in motions)
    room = min(travel.room(k) for travel in travels for k in range(len(travel.rises)))
    return guess_grid(longest, room / rate, rate, sensor)


def _common(motions: Sequence[InspectedMotion]) -> dict[str, str | int]:
    """Contact and coil that all motions have."""
    first, *others = (dict(each.beside.settings) for each in motions)
    return {
        key: value for key, value in first.items() if all(of.get(key) == value for of in others)
    }


def _best_column(motions: Sequence[InspectedMotion]) -> dict[str, str | int]:
    """The column of travel of which most motions are read, the first of several; none is proposed
    that was rejected while another one was not.
    """
    read = Counter(each.column for each in motions if each.record)
    return {"travel_column": max(read, key=read.__getitem__)} if read else {}


def _most(layout: Layout) -> int:
    """How many motions are read: the first, and as many others as take seconds together."""
    return max(1, _MOST // (layout.columns[0].size * (len(layout.columns) + _LINE)))


def _read(
    motions: Sequence[InspectedMotion], settings: Mapping, grid: Grid, most: int, files: Files
) -> list[InspectedMotion]:
    """Motions as they are read, up to a number of them."""
    settings = complete(settings)
    scale = Scale.from_settings(settings)
    read = []
    for each in motions[:most]:
        try:
            own = settings | {"travel_column": each.column, **each.beside.settings}
            record = read_record(each.operation, own, scale, grid, each.motion, files)
            read.append(replace(each, record=record))
        except RejectedCurveError as error:
            read.append(replace(each, said=(str(error),)))
    return read + [replace(each, said=(NOT_READ,)) for each in motions[most:]]


def _noise(motions: Sequence[InspectedMotion], sensor: Mapping) -> dict:
    """The noise of the sensor, mm, where it is not that of the configuration."""
    # Before later motions, the drive may still ring from the one before.
    first = [each.record for each in motions if each.record and each.operation.number == 1]
    seen = [record.noise.sd for record in first if np.isfinite(record.noise.sd)]
    if not seen or 1 / _NOISE <= np.median(seen) / sensor["noise_sd"] <= _NOISE:
        return {}
    return {"noise_sd": float(f"{np.clip(np.median(seen), *_NOISES):.2g}")}


def _judged(motion: InspectedMotion, sensor: Mapping) -> InspectedMotion:
    """A motion with what is doubtful about its record, the noise compared with the sensor's, if
    that is of such drives.
    """
    record = motion.record
    if record is None:
        return motion
    if not sensor:
        return replace(motion, said=tuple(record.remarks))
    step = float(record.time[1] - record.time[0])
    noise = noise_remarks(record.noise, sensor["noise_sd"], step, _times(sensor))
    return replace(motion, said=(*record.remarks, *noise))


def _times(sensor: Mapping) -> np.ndarray:
    return np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
