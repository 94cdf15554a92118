"""Settings for a record of unknown origin: proposed from what it looks like, confirmed by reading.

A proposal holds only what differs from the defaults. What a file does not tell, such as the mm of a
degree, is left to fill in; to try all else, a number stands in for it, and is not proposed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from breaker.files import FORMAT, TO_MS, Operation, RejectedCurveError, complete
from breaker.inspection.channels import Travel, find_travels, unused_among
from breaker.inspection.contents import look_into
from breaker.inspection.guesses import (
    Guess,
    guess_direction,
    guess_grid,
    guess_rest,
    guess_time,
    guess_unit,
    of_default_size,
    strokes_of,
)
from breaker.inspection.layouts import Layout
from breaker.inspection.printed_results import Compared, compare_printed, phase_of
from breaker.inspection.timing import Clock, find_clock
from breaker.inspection.wiring import columns_beside
from breaker.mechanism import in_digits
from breaker.records import Grid, Record, Scale, noise_remarks, read_record

__all__ = [
    "NOT_READ",
    "InspectedMotion",
    "InspectionError",
    "Proposal",
    "chosen_travels",
    "inspect_file",
    "motions_of",
]

NOT_READ = "not read, as the record is long; choose a column by --channel, or export a shorter part"

_STILL = 15.0  # ms at rest, at least, after which a motion is over; a slow rebound takes longer
_NOISE = 1.25  # times the noise of the settings, from which another is proposed
# Cells that are read, of a record once per motion, and those that a line counts for beside its own.
_MOST, _LINE = 26_000_000, 17
_STROKE = 15.0  # mm, that stands in for what is not known


class InspectionError(ValueError):
    """A file for which no settings can be proposed; the message has the reason."""


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
    """

    column: str | int
    operation: Operation
    motion: str
    begins: float
    arrives: float
    record: Record | None = None
    said: tuple[str, ...] = ()
    phase: str = ""


@dataclass(frozen=True)
class Proposal:
    """What was found in a file.

    Attributes:
        file: The file.
        layout, clock, travels: Its text, its time, and its columns of travel.
        settings: Keys of ``endurance.format`` that differ from their default.
        sensor: Keys of ``sensor`` that differ from the configuration; none of a drive of another
            size than those of the default prior.
        lacking: Keys of ``endurance.format`` that the file does not tell, and what they mean.
        motions: Every motion of every channel.
        remarks: What has to be looked at, in words.
    """

    file: Path
    layout: Layout
    clock: Clock
    travels: Sequence[Travel]
    settings: dict
    sensor: dict
    lacking: dict[str, str]
    motions: Sequence[InspectedMotion]
    remarks: Sequence[str]

    @cached_property
    def compared(self) -> list[Compared]:
        """Results that the text states, beside what is measured; none where a setting lacks, as
        what stands in for it measures nothing.
        """
        used = () if self.lacking else self.motions
        return compare_printed(self.layout, self.travels, used)


def inspect_file(file: str | Path, sensor: Mapping, channel: str = "") -> Proposal:
    """Propose settings for a file, and read it with them.

    Args:
        file: File of one record.
        sensor: The section ``sensor`` of the configuration.
        channel: Name or number of the column of travel, where not all of them are meant.

    Raises:
        InspectionError: If no column of the file moves as a drive does.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    file = Path(file)
    clock = find_clock(layout := look_into(file))
    travels, unused = chosen_travels(file, layout, clock, channel)
    direction = guess_direction(file, layout, travels)
    guesses = [guess_time(layout, clock), guess_unit(layout, travels), direction]
    settings, lacking = {**FORMAT, **layout.settings}, {}
    for guess in guesses:
        settings |= guess.settings
        lacking |= guess.lacking
    instead = {"rate": clock.likely_rate, "ratio": _STROKE / np.median(strokes_of(travels))}
    tried = settings | {key: instead[key] for key in lacking}
    mm = abs(Scale.from_settings(tried).factor)
    sign = settings["sign"]
    rest = guess_rest(travels, mm, sign, known="ratio" not in lacking)
    found = [
        replace(each, phase=phase_of(layout, travel.place, order))
        for order, travel in enumerate(travels, start=1)
        for each in motions_of(travel, file, layout, clock, sign)
    ]
    beside = _beside(layout, travels, sign, found[0].motion)
    grid = _grid(found, travels, clock.likely_rate, sensor)
    guesses += [rest, beside, grid]
    settings, tried = (each | rest.settings | beside.settings for each in (settings, tried))
    changed = {**grid.settings}
    motions = _read(found, layout, tried, sensor | changed)
    if "ratio" in lacking:
        settings["stroke"] = FORMAT["stroke"]
    else:
        changed |= _noise(motions, sensor)
    motions = [_judged(each, sensor | changed) for each in motions]
    return Proposal(
        file=file,
        layout=layout,
        clock=clock,
        travels=travels,
        settings={key: value for key, value in settings.items() if value != FORMAT[key]},
        # Of another size of drive, `breaker fit-prior` proposes the sensor along with the prior.
        sensor=changed if of_default_size(mm * strokes_of(travels)) else {},
        lacking=lacking,
        motions=motions,
        remarks=[*unused, *(remark for guess in guesses for remark in guess.remarks)],
    )


def chosen_travels(
    file: Path, layout: Layout, clock: Clock, channel: str
) -> tuple[list[Travel], list[str]]:
    """Return the columns of travel, or the one that is asked for, and what is left out of them."""
    if clock.place is not None:
        time = layout.columns[clock.place]
        time = time[np.isfinite(time)]
        steps = np.diff(time)
        anew = (steps < 0) & (np.abs(time[1:] - time[0]) <= 2 * np.median(steps))
        if anew.any():
            raise InspectionError(
                f"{file}: its time begins anew after {anew.argmax() + 1} samples, so channels or "
                "records stand one below the other; export a column for each channel, and a file "
                "for each record"
            )
    travels = find_travels(layout, clock)
    if not travels:
        raise InspectionError(
            f"{file}: none of {len(layout.columns)} columns moves between two rests as a drive "
            "does; did the breaker move, and is the record longer than the motion?"
        )
    if not channel:
        unused = unused_among(travels)
        names = ", ".join(repr(layout.column(travel.place)) for travel in unused)
        least = max((travel.strokes.max() for travel in unused), default=0.0)
        most = in_digits(strokes_of(travels).max(), 4)
        way = f"{names} moved by at most {in_digits(least, 3)} beside {most}"
        said = f"{way}: not used, as by cross-talk; if one is a travel, choose it by --channel"
        used = [each for each in travels if each.place not in {of.place for of in unused}]
        return used, [said] if unused else []
    for travel in travels:
        place = travel.place
        if channel in (layout.names[place], str(layout.column(place)), str(place + 1)):
            return [travel], []
    listed = ", ".join(repr(layout.column(travel.place)) for travel in travels)
    raise InspectionError(f"{file}: {channel!r} is no column of travel; there are {listed}")


def motions_of(
    travel: Travel, file: Path, layout: Layout, clock: Clock, sign: int
) -> list[InspectedMotion]:
    """Return the motions of a channel; one that is there more than once needs its part."""
    rate, start = clock.likely_rate, 0.0
    if clock.place is not None:
        start = float(layout.columns[clock.place][0]) * TO_MS[clock.unit]
    closing = travel.rises == (sign > 0)
    found = []
    for k in range(closing.size):
        part = travel.part(k) if (closing == closing[k]).sum() > 1 else (np.nan, np.nan)
        begins = travel.begins(k)
        still = max(round(_STILL * rate), 2 * (travel.course.middles[k] - begins))
        times = [start + i / rate for i in (*part, begins, travel.arrives(k, still))]
        operation = Operation(k + 1, file, begin=times[0], end=times[1])
        motion = "closing" if closing[k] else "opening"
        found.append(InspectedMotion(layout.column(travel.place), operation, motion, *times[2:]))
    return found


def _grid(
    motions: Sequence[InspectedMotion], travels: Sequence[Travel], rate: float, sensor: Mapping
) -> Guess:
    """A grid that holds the longest motion, in the room that each has in its record."""
    longest = max(each.arrives - each.begins for each in motions)
    room = min(travel.room(k) for travel in travels for k in range(len(travel.rises)))
    return guess_grid(longest, room / rate, rate, sensor)


def _beside(layout: Layout, travels: Sequence[Travel], sign: int, motion: str) -> Guess:
    """The contact and the coil of the one column of travel; of several, what goes with each."""
    every = [each[motion] for each in columns_beside(layout, travels, sign)]
    remarks = []
    if several := [k for k, each in enumerate(every) if each.others]:
        taken, others = every[several[0]]
        contact, left = taken.get("contact_column"), ", ".join(map(repr, others))
        of = f"{motion} of {layout.column(travels[several[0]].place)!r}"
        more = f" and {len(several) - 1} more" if several[1:] else ""
        remarks.append(f"{of}{more}: contact {contact!r} is taken, not {left}")
    if len(every) == 1:
        return Guess(dict(every[0].settings), remarks=tuple(remarks))
    if any(taken for taken, _ in every):
        remarks.append(
            "contacts and coils are proposed for one channel, by --channel; breaker report and "
            "breaker manifest take those of each"
        )
    return Guess({}, remarks=tuple(remarks))


def _read(
    motions: Sequence[InspectedMotion], layout: Layout, settings: Mapping, sensor: Mapping
) -> list[InspectedMotion]:
    """Motions as they are read: the first, and as many others as take seconds together."""
    cells = layout.columns[0].size * (len(layout.columns) + _LINE)
    most = max(1, _MOST // cells)
    settings = complete(settings)
    scale = Scale.from_settings(settings)
    grid = Grid(_times(sensor))
    read = []
    for each in motions[:most]:
        try:
            own = settings | {"travel_column": each.column}
            record = read_record(each.operation, own, scale, grid, each.motion)
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
    return {"noise_sd": float(f"{np.median(seen):.2g}")}


def _judged(motion: InspectedMotion, sensor: Mapping) -> InspectedMotion:
    """A motion with what is doubtful about its record, the noise compared with the sensor's."""
    record = motion.record
    if record is None:
        return motion
    step = float(record.time[1] - record.time[0])
    noise = noise_remarks(record.noise, sensor["noise_sd"], step, _times(sensor))
    return replace(motion, said=(*record.remarks, *noise))


def _times(sensor: Mapping) -> np.ndarray:
    return np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
