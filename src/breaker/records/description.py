"""What a file tells of itself: its settings, its channels and its motions; no record is read.

What is clear is a setting. Where two values are close, one is taken and a remark has the line that
sets the other; where nothing speaks for either, or the file contradicts itself, the key is lacking.
"""

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.channels import (
    FAINT,
    STROKES,
    Clock,
    InspectionError,
    Travel,
    chosen_travels,
    find_clock,
)
from breaker.records.contact_columns import Beside, coils_before, columns_beside, first_by_contacts
from breaker.records.files import Opened, RejectedCurveError, as_opened
from breaker.records.layout import Layout, LayoutError, look_into
from breaker.records.operations import FILL_IN
from breaker.records.settings import TO_MM, TO_MS
from breaker.records.table_proposal import Description, Part
from breaker.records.words import MOTION_OF, holds, motion_of, motions_in, unit_of

_MARGIN = (
    0.1  # share of strokes and times that is allowed beyond them: a false gain is 10 % or more
)
_AT_ZERO = 0.3  # mm, up to which the open breaker rests at 0: a zero of transducers is as good
_PRIOR = (5.0, 40.0)  # mm, strokes for which the default prior may do

_ANGLES_AND_OTHERS = ("deg", "V", "counts")  # units of which names speak, and no mm are known
_FIRST = {letter.lower(): motion for letter, motion in MOTION_OF.items()}
_SEQUENCE = re.compile(r"(?<![a-z])([co])(?:[-_ ]?[co]){1,2}(?![a-z])")


@dataclass(frozen=True)
class Guess:
    """Settings that a file tells.

    Attributes:
        settings: By key of ``endurance.format`` or of ``sensor``.
        lacking: Keys that it does not tell, and what they mean.
        remarks: What has to be looked at, in words.
        sure: Whether text, names or contacts tell it, and not the curve alone.
    """

    settings: dict
    lacking: dict[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    sure: bool = True


def guess_time(sheet: Layout, clock: Clock) -> Guess:
    """Return the settings of the time."""
    if clock.place is not None:
        settings = {"time_column": sheet.column(clock.place), "time_unit": clock.unit}
        lacking = {} if clock.unit else {"time_unit": " or ".join(TO_MS)}
        return Guess(settings, lacking, clock.remarks)
    if np.isfinite(clock.rate):
        return Guess({"time_column": None, "rate": clock.rate}, remarks=clock.remarks)
    doubt = sheet.stated.rate_doubt
    lacking = {"rate": "kHz, samples in a ms" + (f"; {doubt}" if doubt else "")}
    remarks = clock.remarks or ("there is no column of the time, and no rate is stated",)
    return Guess({"time_column": None, "rate": None}, lacking, remarks)


def guess_unit(sheet: Layout, travels: Sequence[Travel]) -> Guess:
    """Return the column of the travel and its unit."""
    remarks, lacking, unit = [], {}, travels[0].unit
    stroke, stated = float(np.median(strokes_of(travels))), sheet.stated
    size, said = in_digits(stroke, 4), unit_of(stated.travel_unit)
    if unit and said and unit != said:
        remarks.append(f"the column of travel is in {unit}, but the text above states {said}")
    if (unit := unit or said) is None:
        name, readings = sheet.names[travels[0].place], travels[0].course.reading
        unit, why = _likely_unit(name, readings, stroke)
        remarks.append(f"the unit of the travel is not stated: {unit} is a guess, as {why}")
    if unit not in TO_MM:
        ratio = f"; stated is a ratio of {in_digits(stated.ratio, 6)}" if stated.ratio > 0 else ""
        lacking["ratio"] = f"mm for one {unit}; the stroke is {size} {unit}{ratio}"
        remarks.append(f"a travel in {unit} needs the mm of one: endurance.format.ratio, or table")
    if len({travel.unit for travel in travels}) > 1:
        remarks.append("the columns of travel have different units: choose one by --channel")
    settings = {"travel_column": sheet.column(travels[0].place), "travel_unit": unit}
    return Guess(settings, lacking, tuple(remarks))


def _likely_unit(name: str, readings: np.ndarray, stroke: float) -> tuple[str, str]:
    """A unit for readings ``(t,)`` of a stroke in it, and why that."""
    if spoken := next((unit for unit in _ANGLES_AND_OTHERS if holds(name, unit)), None):
        return spoken, f"the column is called {name!r}"
    size = in_digits(stroke, 4)
    if stroke > 1.0 and not np.mod(readings[np.isfinite(readings)], 1.0).any():
        return "counts", f"all readings are whole, with a stroke of {size}"
    fit = [unit for unit in ("mm", "m") if STROKES[0] <= TO_MM[unit] * stroke <= STROKES[1]]
    if not fit:
        return "counts", f"a stroke of {size} is none in mm or m, and counts stands for any unit"
    others = [
        u for u, mm in TO_MM.items() if u != fit[0] and STROKES[0] <= mm * stroke <= STROKES[1]
    ]
    lines = "".join(f", or else set travel_unit: {unit}" for unit in others)
    return fit[0], f"the stroke is {size}{lines}"


def strokes_of(travels: Iterable[Travel]) -> np.ndarray:
    """Return the ways of all motions, in the unit of the reading."""
    return np.concatenate([travel.strokes for travel in travels])


def guess_direction(sheet: Layout, travels: Sequence[Travel]) -> Guess:
    """Return the sign: by what text, names, coils or contacts tell of the first motion, or else by
    the curve. The sign is lacking where nothing tells it, or curves contradict themselves.
    """
    travel, remarks, lacking = travels[0], [], {}
    said, shown, likely = _stated_first(sheet, travel), *_shown_first(sheet, travel)
    reasons = shown or likely
    motions = {*reasons.values()}
    first = said or (motions.pop() if len(motions) == 1 else "")
    why = " and ".join(reasons)
    if said and {*shown.values()} - {said}:
        remarks.append(
            f"by its text, names or coils the file begins with {said}, but not by its contacts "
            f"({' and '.join(shown)}): if it is wrong, change endurance.format.sign"
        )
    elif first and not said:
        remarks.append(
            f"no text states which motion is the first: it is the {first} by {why}; if that is "
            "wrong, change endurance.format.sign"
        )
    elif not first:
        but = f"the curve contradicts itself ({why})" if why else "nothing tells it"
        lacking["sign"] = f"1 if the reading grows towards closed, or else -1; {but}"
        remarks.append(f"whether the first motion closes has to be filled in: {but}")
    if len({bool(each.rises[0]) for each in travels}) > 1:
        remarks.append("the columns of travel move in different directions: choose by --channel")
    sign = 1 if (first != "opening") == travel.rises[0] else -1
    sure = bool(said or shown) and not (said and {*shown.values()} - {said})
    return Guess({"sign": sign}, lacking, tuple(remarks), sure)


def _stated_first(sheet: Layout, travel: Travel) -> str:
    """The first motion as text, names or coils state it; empty where they do not."""
    texts = (
        sheet.file.stem,
        sheet.file.absolute().parent.name,
        "\n".join(" ".join(row) for row in sheet.preamble),
    )
    at = coils_before(sheet, travel, 0)
    coils = {motion_of(sheet.names[i]) for i, sample in at.items() if sample >= 0} - {""}
    found = [_FIRST.get(sheet.stated.operation[:1].lower(), ""), *map(_first_in, texts)]
    return next(filter(None, [*found, coils.pop() if len(coils) == 1 else ""]), "")


def _first_in(text: str) -> str:
    """The motion with which a text states that a record begins, empty where it does not."""
    if found := _SEQUENCE.search(text.lower()):
        return _FIRST[found[1]]
    said = motions_in(text)
    return said[0] if len(said) == 1 else ""


def _shown_first(sheet: Layout, travel: Travel) -> tuple[dict[str, str], dict[str, str]]:
    """The first motion as contacts show it, and as the curve does, by the reasons.

    Most makers have the open breaker at 0, and sequences are C-O or O-C-O (IEC 62271-100).
    """
    shown, likely = first_by_contacts(sheet, travel), {}
    if len({*shown.values()}) > 1:
        shown = {}
    before, after = np.abs(travel.rests[0]) / travel.strokes[0]
    if min(before, after) <= FAINT < max(before, after):
        where, motion = ("before", "closing") if before < after else ("after", "opening")
        likely[f"a reading near 0 {where} the first motion"] = motion
    if (count := len(travel.rises)) > 1:
        usual, motion = ("C-O", "closing") if count == 2 else ("O-C-O", "opening")
        likely[f"{count} motions, mostly {usual}"] = motion
    return shown, likely


def of_default_size(strokes: np.ndarray) -> bool:
    """Return whether strokes, mm, are those of drives of the default prior."""
    return bool(_PRIOR[0] <= np.median(strokes) <= _PRIOR[1])


def usual_ratio(travels: Sequence[Travel]) -> float:
    """Return a ratio that stands in for one that is not known: it makes strokes of usual size."""
    return float(np.sqrt(_PRIOR[0] * _PRIOR[1]) / np.median(strokes_of(travels)))


def guess_rest(travels: Sequence[Travel], mm: float, sign: int) -> Guess:
    """Return zero and stroke, from where the breaker rests.

    Args:
        travels: Columns of travel.
        mm: Size of one unit of the reading.
        sign: 1 if the reading grows towards closed, -1 if it falls.
    """
    strokes = mm * strokes_of(travels)
    ends, (low, high) = (strokes.min(), strokes.max()), (1.0 - _MARGIN, 1.0 + _MARGIN)
    least, most = (in_digits(float(end), 4) for end in ends)
    remark = f"the strokes of the motions differ: {least} to {most} mm"
    opens = mm * np.array([(sign * travel.rests).min() for travel in travels])
    settings = {
        "zero": "rest" if np.abs(opens).max() > _AT_ZERO else 0.0,
        "stroke": [float(f"{low * ends[0]:.3g}"), float(f"{high * ends[1]:.3g}")],
    }
    return Guess(settings, remarks=(remark,) if ends[1] > high * ends[0] else ())


def guess_grid(longest: float, room: float, rate: float, sensor: Mapping) -> Guess:
    """Return a grid that holds a motion, if that of the configuration does not.

    It is no longer than that motion needs, nor than what each has in the record, by whole samples.

    Args:
        longest: Time from the first motion to the rest, ms.
        room: Least time from a first motion to the next motion, or to the end of the record, ms.
        rate: Of the record, kHz.
        sensor: The section ``sensor`` of the configuration.

    Example:
        >>> sensor = {"start": -2.0, "stop": 58.0, "samples": 151}
        >>> guess_grid(50.0, 140.0, 10.0, sensor).settings
        {}
        >>> guess_grid(90.0, 140.0, 10.0, sensor).settings
        {'start': -3.5, 'stop': 101.5, 'samples': 151}
    """
    if min(longest, room) <= sensor["stop"]:
        return Guess({})
    step = (sensor["stop"] - sensor["start"]) / (sensor["samples"] - 1) * rate
    most, wanted = (step * t / sensor["stop"] for t in (room, (1.0 + _MARGIN) * longest))
    samples = np.floor(min(np.ceil(wanted), most) + np.finfo(np.float32).eps)
    k = (samples if samples >= step else min(wanted, most)) / step
    if k <= 1.0:
        return Guess({})
    settings = {key: float(f"{k * sensor[key]:.6g}") for key in ("start", "stop")}
    remark = f"a motion takes {longest:.0f} ms, longer than sensor.stop"
    return Guess(settings | {"samples": sensor["samples"]}, remarks=(remark,))


@dataclass(frozen=True)
class SeenMotion:
    """A motion of a channel.

    Attributes:
        travel, number: Its channel, and which of the motions there it is, from 0.
        column: Name or number of the column of travel.
        motion: "closing" or "opening".
        begins, arrives: Times, ms of the file, about: the first motion, and the rest after it.
        part: Part of the record with this motion alone, ms; NaN where no other is of its kind.
        beside: Columns of contact and coil that go with it.
    """

    travel: Travel
    number: int
    column: str | int
    motion: str
    begins: float
    arrives: float
    part: tuple[float, float]
    beside: Beside


def motions_of(
    sheet: Layout, clock: Clock, travels: Sequence[Travel], sign: int
) -> list[SeenMotion]:
    """Return the motions of all travels of a file.

    Args:
        sheet, clock: Of the file.
        travels: Columns of travel.
        sign: 1 if their reading grows towards closed, -1 if it falls.
    """
    rate, start = clock.likely_rate, 0.0
    if clock.place is not None:
        start = float(sheet.columns[clock.place][0]) * TO_MS.get(clock.unit, 1.0)
    found = []
    for travel, beside in zip(travels, columns_beside(sheet, travels, sign), strict=True):
        closing, column = travel.rises == (sign > 0), sheet.column(travel.place)
        for k in range(closing.size):
            part = travel.part(k) if (closing == closing[k]).sum() > 1 else (np.nan, np.nan)
            *part, begins, arrives = (
                start + i / rate for i in (*part, travel.begins(k), travel.arrives(k))
            )
            motion = "closing" if closing[k] else "opening"
            of = travel, k, column, motion, begins, arrives, tuple(part), beside[motion]
            found.append(SeenMotion(*of))
    return found


def travel_channels(file: str | Path | Opened) -> dict[str, tuple[str, Mapping[str, Beside]]]:
    """Return the channels of a file by those columns that move as a drive does: what each is
    called, and what goes with it by motion, as of ``columns_beside``.

    A channel is called by its phase, where the file states it and no other channel has the same;
    else by its column. What moves by far less than the others is left out, as by cross-talk.

    Raises:
        InspectionError: If none moves.
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.
    """
    opened = as_opened(file)
    return opened.once("channels", lambda: _travel_channels(look_into(opened)))


def _travel_channels(sheet: Layout) -> dict[str, tuple[str, Mapping[str, Beside]]]:
    _, travels, _ = chosen_travels(sheet, find_clock(sheet), "")
    sign = guess_direction(sheet, travels).settings["sign"]
    columns, phases = [str(sheet.column(t.place)) for t in travels], [t.phase for t in travels]
    names = phases if all(phases) and len({*phases}) == len(phases) else columns
    beside = columns_beside(sheet, travels, sign)
    return dict(zip(columns, zip(names, beside, strict=True), strict=True))


def describe_file(file: str | Path) -> Description:
    """Return what a file states above its samples, which motions its channels have, and how it is
    read; of one that cannot be read, or in which nothing moves, the reason.
    """
    seen = Description()
    try:
        sheet = look_into(file)
        seen = seen._replace(preamble=sheet.stated, rate=sheet.stated.rate)
        clock = find_clock(sheet)
        seen = seen._replace(rate=clock.rate, timed=clock.place is not None)
        _, travels, _ = chosen_travels(sheet, clock, "")
    except (LayoutError, RejectedCurveError, InspectionError) as error:
        return seen._replace(reason=str(error).removeprefix(f"{file}: "))
    guesses = [
        guess_time(sheet, clock),
        guess_unit(sheet, travels),
        guess_direction(sheet, travels),
    ]
    settings, lacking = dict(sheet.settings), {}
    for guess in guesses:
        settings |= guess.settings
        lacking |= guess.lacking
    if "ratio" not in lacking:
        mm = TO_MM[settings["travel_unit"]]
        settings["zero"] = guess_rest(travels, mm, settings["sign"]).settings["zero"]
    settings |= {key: FILL_IN for key in lacking if key not in ("rate", "sign")}
    del settings["travel_column"]
    sign = guesses[-1].settings["sign"]
    parts = tuple(_parts(sheet, clock, motions_of(sheet, clock, travels, sign)))
    columns = np.stack([sheet.columns[each.place] for each in travels])
    samples = hashlib.sha256(columns.tobytes()).hexdigest()
    seen = seen._replace(samples=samples, parts=parts, settings=settings)
    return seen._replace(sure=guesses[-1].sure)


def _parts(sheet: Layout, clock: Clock, motions: Sequence[SeenMotion]) -> Iterator[Part]:
    """Motions as parts of a file: where they are only if the times of samples are known."""
    for each in motions:
        part = (np.nan, np.nan) if np.isnan(clock.rate) else each.part
        ratio = sheet.stated.ratio if each.travel.unit not in (None, *TO_MM) else np.nan
        of = each.motion, str(each.column), each.travel.phase, *part, ratio
        yield Part(*of, each.beside.settings)
