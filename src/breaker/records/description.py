"""What a file tells of itself: its settings, its channels and its motions; no record is read.

What is clear is a setting. Where two values are close, one is taken and a remark has the line that
sets the other; where nothing speaks for either, or the file contradicts itself, the key is lacking.
"""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records import words
from breaker.records.channels import FAINT, STROKES, Clock, Travel, chosen_travels, find_clock
from breaker.records.contact_columns import Beside, coils_before, columns_beside, first_by_contacts
from breaker.records.files import Opened, as_opened
from breaker.records.formats.registry import look_into
from breaker.records.operations import FILL_IN, Operation
from breaker.records.settings import TO_MM, TO_MS
from breaker.records.sheet import Sheet
from breaker.records.table_proposal import Description, Part

if TYPE_CHECKING:  # no record is read here
    from breaker.records.curves import GriddedRecord
    from breaker.records.record import Record

_MARGIN = (
    0.1  # share of strokes and times that is allowed beyond them: a false gain is 10 % or more
)
_AT_ZERO = 0.3  # mm, up to which the open breaker rests at 0: a zero of transducers is as good
_PRIOR = (5.0, 40.0)  # mm, strokes for which the default prior may do

_FIRST = {letter.lower(): motion for letter, motion in words.MOTION_OF.items()}
_SEQUENCE = re.compile(r"(?<![a-z])([co])(?:[-_ ]?[co]){1,2}(?![a-z])")


class Guess(NamedTuple):
    """Settings that a file tells.

    Attributes:
        settings: By key of ``endurance.format`` or of ``sensor``.
        lacking: Keys that it does not tell, and what they mean.
        remarks: What has to be looked at, in words.
        sure: Whether text, names or contacts tell it, and not the curve alone.
    """

    settings: Mapping[str, Any]
    lacking: Mapping[str, str] = MappingProxyType({})
    remarks: tuple[str, ...] = ()
    sure: bool = True


def guesses_of(sheet: Sheet, clock: Clock, travels: Sequence[Travel]) -> list[Guess]:
    """Return the settings of the file, of its time, its travel, and the direction of that."""
    file = Guess(sheet.settings)
    return [file, _time(sheet, clock), _unit(sheet, travels), _direction(sheet, travels)]


def merged(guesses: Iterable[Guess]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return all settings of guesses, and all that are lacking."""
    settings, lacking = {}, {}
    for guess in guesses:
        settings |= guess.settings
        lacking |= guess.lacking
    return settings, lacking


def _time(sheet: Sheet, clock: Clock) -> Guess:
    """The settings of the time."""
    if clock.place is not None:
        lacking = {} if clock.unit else {"time_unit": " or ".join(TO_MS)}
        settings = {"time_column": sheet.column(clock.place), "time_unit": clock.unit}
        return Guess(settings, lacking, clock.remarks)
    if np.isfinite(clock.rate):
        return Guess({"time_column": None, "rate": clock.rate}, remarks=clock.remarks)
    why = "; ".join(filter(None, ["kHz, samples in a ms", sheet.stated.rate_doubt]))
    remarks = clock.remarks or ("there is no column of the time, and no rate is stated",)
    return Guess({"time_column": None, "rate": None}, {"rate": why}, remarks)


def _unit(sheet: Sheet, travels: Sequence[Travel]) -> Guess:
    """The column of the travel and its unit."""
    remarks, lacking, (travel, *_), stated = [], {}, travels, sheet.stated
    column, said = sheet.column(travel.place), words.unit_of(stated.travel_unit)
    size = in_digits(float(np.median(strokes_of(travels))), 4)
    if travel.unit and said and travel.unit != said:
        remarks.append(f"{column!r} is in {travel.unit}, but the text above states {said}")
    unit = travel.unit or said
    if unit is None:
        fit = _likely_units(sheet.names[travel.place], travel.course.reading, float(size))
        unit, lines = fit[0], "".join(f", or set travel_unit: {each}" for each in fit[1:])
        remarks.append(f"no unit of the travel is stated: {unit} for a stroke of {size}{lines}")
    if unit not in TO_MM:
        ratio = f"; stated is a ratio of {in_digits(stated.ratio, 6)}" if stated.ratio > 0 else ""
        lacking["ratio"] = f"mm for one {unit}; the stroke is {size} {unit}{ratio}"
        remarks.append(f"a travel in {unit} needs the mm of one: endurance.format.ratio, or table")
    if len({each.unit for each in travels}) > 1:
        remarks.append("the columns of travel have different units: choose one by --channel")
    return Guess({"travel_column": column, "travel_unit": unit}, lacking, tuple(remarks))


def _likely_units(name: str, readings: np.ndarray, stroke: float) -> list[str]:
    """Units for readings ``(t,)`` of a stroke, the likeliest first; counts stand for any unit."""
    if spoken := [unit for unit in ("deg", "V", "counts") if words.holds(name, unit)]:
        return spoken[:1]
    fit = [unit for unit, mm in TO_MM.items() if STROKES[0] <= mm * stroke <= STROKES[1]]
    whole = stroke > 1.0 and not np.mod(readings[np.isfinite(readings)], 1.0).any()
    usual = [unit for unit in ("mm", "m") if unit in fit]
    return ["counts"] if whole or not usual else list(dict.fromkeys([*usual, *fit]))


def strokes_of(travels: Iterable[Travel]) -> np.ndarray:
    """Return the ways of all motions, in the unit of the reading."""
    return np.concatenate([travel.strokes for travel in travels])


def _direction(sheet: Sheet, travels: Sequence[Travel]) -> Guess:
    """The sign: by what text, names, coils or contacts tell of the first motion, or else by the
    curve. The sign is lacking where nothing tells it, or the curve contradicts itself.
    """
    travel, remarks, lacking = travels[0], [], {}
    said, shown = _stated_first(sheet, travel), first_by_contacts(sheet, travel)
    by = shown if len({*shown.values()}) == 1 else _first_by_curve(travel)
    firsts, why = {*by.values()}, " and ".join(by)
    first = said or (min(firsts) if len(firsts) == 1 else "")
    against = " and ".join(reason for reason, motion in shown.items() if motion != first)
    if said and against:
        remarks.append(
            f"text, names or coils state that the file begins with {said}, and {against} does not: "
            "if it is wrong, change endurance.format.sign"
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
    sure = bool((said or shown) and not against)
    return Guess({"sign": sign}, lacking, tuple(remarks), sure)


def _stated_first(sheet: Sheet, travel: Travel) -> str:
    """The first motion as text, names or coils state it; empty where they do not."""
    above = "\n".join(" ".join(row) for row in sheet.preamble)
    texts = sheet.file.stem, sheet.file.absolute().parent.name, above
    at = coils_before(sheet, travel, 0)
    coils = {words.motion_of(sheet.names[i]) for i, on in at.items() if on >= 0} - {""}
    found = [_FIRST.get(sheet.stated.operation[:1].lower(), ""), *map(_first_in, texts)]
    return next(filter(None, [*found, min(coils) if len(coils) == 1 else ""]), "")


def _first_in(text: str) -> str:
    """The motion with which a text states that a record begins, empty where it does not."""
    if found := _SEQUENCE.search(text.lower()):
        return _FIRST[found[1]]
    said = words.motions_in(text)
    return said[0] if len(said) == 1 else ""


def _first_by_curve(travel: Travel) -> dict[str, str]:
    """The first motion by the reasons: most makers have the open breaker at 0, and sequences are
    C-O or O-C-O (IEC 62271-100).
    """
    found, count = {}, len(travel.rises)
    before, after = np.abs(travel.rests[0]) / travel.strokes[0]
    if min(before, after) <= FAINT < max(before, after):
        where, motion = ("before", "closing") if before < after else ("after", "opening")
        found[f"a reading near 0 {where} it"] = motion
    if count > 1:
        found[f"{count} motions"] = "closing" if count == 2 else "opening"
    return found


def of_default_size(strokes: np.ndarray) -> bool:
    """Return whether strokes, mm, are those of drives of the default prior."""
    return bool(_PRIOR[0] <= np.median(strokes) <= _PRIOR[1])


def usual_ratio(travels: Sequence[Travel]) -> float:
    """Return a ratio that stands in for one that is not known: it makes strokes of usual size."""
    return float(np.sqrt(np.prod(_PRIOR)) / np.median(strokes_of(travels)))


def guess_rest(travels: Sequence[Travel], mm: float, sign: int) -> Guess:
    """Return zero and stroke, from where the breaker rests, by the size of one unit of the reading,
    mm, and the sign: 1 if the reading grows towards closed, -1 if it falls.
    """
    strokes = mm * strokes_of(travels)
    low, high = float(strokes.min()), float(strokes.max())
    said = f"the strokes of the motions differ: {in_digits(low, 4)} to {in_digits(high, 4)} mm"
    opens = mm * np.array([(sign * travel.rests).min() for travel in travels])
    ends = (1.0 - _MARGIN) * low, (1.0 + _MARGIN) * high
    settings = {
        "zero": "rest" if np.abs(opens).max() > _AT_ZERO else 0.0,
        "stroke": [float(f"{end:.3g}") for end in ends],
    }
    return Guess(settings, remarks=(said,) if high > (1.0 + _MARGIN) * low else ())


def guess_grid(longest: float, room: float, rate: float, sensor: Mapping) -> Guess:
    """Return a grid that holds a motion, if that of the configuration does not: no longer than the
    motion needs, nor than each has in the record, by whole samples.

    Args:
        longest: Time from the first motion to the rest, ms.
        room: Least time from a first motion to the next motion, or to the end of the record, ms.
        rate: Of the record, kHz.
        sensor: The section ``sensor`` of the configuration.
    """
    step = (sensor["stop"] - sensor["start"]) / (sensor["samples"] - 1) * rate
    most, wanted = (step * t / sensor["stop"] for t in (room, (1.0 + _MARGIN) * longest))
    samples = np.floor(min(np.ceil(wanted), most) + np.finfo(np.float32).eps)
    k = (samples if samples >= step else min(wanted, most)) / step
    if k <= 1.0 or min(longest, room) <= sensor["stop"]:
        return Guess({})
    settings = {key: float(f"{k * sensor[key]:.6g}") for key in ("start", "stop")}
    said = f"a motion takes {longest:.0f} ms, longer than sensor.stop"
    return Guess(settings | {"samples": sensor["samples"]}, remarks=(said,))


@dataclass(frozen=True)
class InspectedMotion:
    """One motion of one channel, and how it was read with the proposal.

    Attributes:
        travel: The channel.
        column: Name or number of its column.
        operation: Where it is in the column.
        motion: "closing" or "opening".
        begins, arrives: Times, ms of the file, about: the first motion, and the rest after it.
        beside: Columns of contact and coil that go with it.
        result: The record and its remarks; None if it was rejected or not read.
        said: Why it was, or what is doubtful about it; empty if nothing is.
    """

    travel: Travel
    column: str | int
    operation: Operation
    motion: str
    begins: float
    arrives: float
    beside: Beside
    result: "GriddedRecord | None" = None
    said: tuple[str, ...] = ()

    @property
    def record(self) -> "Record | None":
        """The record that was read; None where it was not."""
        return self.result.record if self.result else None


def motions_of(
    sheet: Sheet, clock: Clock, travels: Sequence[Travel], sign: int
) -> list[InspectedMotion]:
    """Return the motions of all travels of a file; one that is there more than once needs its
    part. The sign is 1 if their reading grows towards closed, -1 if it falls.
    """
    rate, start, found = clock.likely_rate, 0.0, []
    if clock.place is not None:
        start = float(sheet.columns[clock.place][0]) * TO_MS.get(clock.unit, 1.0)
    for travel, beside in zip(travels, columns_beside(sheet, travels, sign), strict=True):
        closing, column = travel.rises == (sign > 0), sheet.column(travel.place)
        for k in range(closing.size):
            part = travel.part(k) if (closing == closing[k]).sum() > 1 else (np.nan, np.nan)
            at = [start + i / rate for i in (*part, travel.begins(k), travel.arrives(k))]
            operation = Operation(k + 1, sheet.file, begin=at[0], end=at[1], phase=travel.phase)
            motion = "closing" if closing[k] else "opening"
            of = travel, column, operation, motion, *at[2:], beside[motion]
            found.append(InspectedMotion(*of))
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


def _travel_channels(sheet: Sheet) -> dict[str, tuple[str, Mapping[str, Beside]]]:
    _, travels, _ = chosen_travels(sheet, find_clock(sheet), "")
    columns, phases = [str(sheet.column(t.place)) for t in travels], [t.phase for t in travels]
    names = phases if all(phases) and len({*phases}) == len(phases) else columns
    beside = columns_beside(sheet, travels, _direction(sheet, travels).settings["sign"])
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
    except ValueError as error:
        return seen._replace(reason=str(error).removeprefix(f"{file}: "))
    settings, lacking = merged(guesses := guesses_of(sheet, clock, travels))
    sign, unit = settings["sign"], settings["travel_unit"]
    if "ratio" not in lacking:
        settings["zero"] = guess_rest(travels, TO_MM[unit], sign).settings["zero"]
    settings |= {key: FILL_IN for key in lacking if key not in ("rate", "sign")}
    del settings["travel_column"]
    parts = []
    for each in motions_of(sheet, clock, travels, sign):
        at = each.operation.begin, each.operation.end
        part = (np.nan, np.nan) if np.isnan(clock.rate) else at
        ratio = sheet.stated.ratio if each.travel.unit not in (None, *TO_MM) else np.nan
        of = each.motion, str(each.column), each.travel.phase, *part, ratio
        parts.append(Part(*of, each.beside.settings))
    columns = np.stack([sheet.columns[each.place] for each in travels])
    samples, sure = hashlib.sha256(columns.tobytes()).hexdigest(), guesses[-1].sure
    return seen._replace(samples=samples, parts=tuple(parts), settings=settings, sure=sure)
