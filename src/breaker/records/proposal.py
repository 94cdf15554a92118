"""Settings for a record of unknown origin: proposed from what it tells, confirmed by reading.

A proposal holds only what differs from the defaults. What a file does not tell, such as the mm of a
degree, is left to fill in; to try all else, a number stands in for it, and is not proposed.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from breaker.records.axes import Scale
from breaker.records.channels import FAINT, Clock, Travel, chosen_travels, find_clock
from breaker.records.curves import put_on_grid
from breaker.records.description import (
    Guess,
    InspectedMotion,
    guess_grid,
    guess_rest,
    guesses_of,
    merged,
    motions_of,
    of_default_size,
    strokes_of,
    usual_ratio,
)
from breaker.records.files import Files, RejectedCurveError
from breaker.records.formats.registry import look_into
from breaker.records.grid import Grid
from breaker.records.noise import noise_remarks
from breaker.records.printed import PrintedComparison, compare_printed
from breaker.records.reader import Reader
from breaker.records.settings import FORMAT
from breaker.records.sheet import Sheet

NOT_READ = "not read, as the record is long; choose a column by --channel, or export a shorter part"

_NOISES = (1e-4, 10.0)  # mm, that the configuration takes; an exact curve has less
_MOST = 600_000  # samples that are read, of a record once per motion: some seconds


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

    layout: Sheet
    clock: Clock
    travels: Sequence[Travel]
    settings: dict
    sensor: dict
    lacking: dict[str, str]
    motions: Sequence[InspectedMotion]
    remarks: Sequence[str]
    guesses: Sequence[Guess]

    @property
    def is_read(self) -> bool:
        """Whether the settings read a motion, or may once the rate is filled in."""
        return "rate" in self.lacking or any(each.record for each in self.motions)

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
    clock = find_clock(sheet := look_into(files[file]))
    every, travels, remarks = chosen_travels(sheet, clock, channel)
    settings, lacking = merged(guesses := guesses_of(sheet, clock, travels))
    instead = {"rate": clock.likely_rate, "ratio": usual_ratio(travels), "time_unit": "ms"}
    tried = FORMAT | settings | {key: instead[key] for key in instead if key in lacking}
    mm, sign = abs(Scale.from_settings(tried).factor), settings["sign"]
    guesses.append(guess_rest(travels, mm, sign))
    columns = {sheet.column(travel.place) for travel in travels}
    found = [each for each in motions_of(sheet, clock, every, sign) if each.column in columns]
    longest = max(each.arrives - each.begins for each in found)
    room = min(each.travel.room(each.operation.number - 1) for each in found) / clock.likely_rate
    grid = guess_grid(longest, room, clock.likely_rate, sensor)
    motions = _read(found, tried | guesses[-1].settings, sensor | grid.settings, files)
    settings, lacking = merged(guesses)
    settings |= _common(motions) | _best_column(motions)
    changed = {}
    if "ratio" in lacking:
        settings["stroke"] = FORMAT["stroke"]
    elif of_default_size(mm * strokes_of(travels)):
        # Of another size of drive, `breaker fit-prior` proposes the sensor along with the prior.
        changed = {**grid.settings, **_noise(motions, sensor)}
        guesses.append(grid)
        motions = [_with_noise(each, sensor | changed) for each in motions]
    remarks += [remark for guess in guesses for remark in guess.remarks]
    for column in dict.fromkeys(each.beside.auxiliary for each in motions):
        said = f"{column!r} is an auxiliary switch: its times are not those of the main contacts"
        remarks += [said] if column else []
    settings = {key: value for key, value in settings.items() if value != FORMAT[key]}
    of = sheet, clock, travels, settings, changed, lacking, motions, remarks, guesses
    return Proposal(*of)


def _common(motions: Sequence[InspectedMotion]) -> dict[str, str | int]:
    """Columns of contact and coil that all motions have."""
    first, *others = (each.beside.settings.items() for each in motions)
    return dict(item for item in first if all(item in of for of in others))


def _best_column(motions: Sequence[InspectedMotion]) -> dict[str, str | int]:
    """The column of travel of which most motions are read, and of these the one with the fewest
    remarks, the first of several: none that was rejected or clipped while another one was not.
    """
    read = Counter(each.column for each in motions if each.record)
    remarks = Counter(each.column for each in motions for _ in each.said)
    best = max(read, key=lambda column: (read[column], -remarks[column]), default=None)
    return {} if best is None else {"travel_column": best}


def _read(
    motions: Sequence[InspectedMotion], settings: Mapping, sensor: Mapping, files: Files
) -> list[InspectedMotion]:
    """Motions as they are read: the first, and as many others as take seconds together."""
    grid, read = Grid(_times(sensor)), []
    most = max(1, _MOST // motions[0].travel.course.reading.size)
    for each in motions[:most]:
        own = {**settings, "travel_column": each.column, **each.beside.settings}
        try:
            result = put_on_grid(Reader(own, files).read(each.operation, each.motion), grid)
            read.append(replace(each, result=result, said=result.remarks))
        except RejectedCurveError as error:
            read.append(replace(each, said=(str(error),)))
    return read + [replace(each, said=(NOT_READ,)) for each in motions[most:]]


def _noise(motions: Sequence[InspectedMotion], sensor: Mapping) -> dict[str, float]:
    """The noise of the sensor, mm, where it is not that of the configuration."""
    # Before later motions, the drive may still ring from the one before.
    first = [each.result for each in motions if each.result and each.operation.number == 1]
    seen = [result.noise.sd for result in first if np.isfinite(result.noise.sd)]
    if not seen or abs(np.median(seen) / sensor["noise_sd"] - 1.0) <= FAINT:
        return {}
    return {"noise_sd": float(f"{np.clip(np.median(seen), *_NOISES):.2g}")}


def _with_noise(motion: InspectedMotion, sensor: Mapping) -> InspectedMotion:
    """A motion with remarks on its noise, compared with the sensor's."""
    if (result := motion.result) is None:
        return motion
    noise = noise_remarks(result.noise, sensor["noise_sd"], result.record.step, _times(sensor))
    return replace(motion, said=(*motion.said, *noise))


def _times(sensor: Mapping) -> np.ndarray:
    return np.linspace(sensor["start"], sensor["stop"], sensor["samples"])
