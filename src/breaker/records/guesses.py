"""Settings guessed from the columns of an unknown record, each with what there is to say about it.

What is sure goes without saying; every other guess has a remark. What a file does not tell is
lacking, by key of ``endurance.format``.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.channels import Clock, Travel
from breaker.records.contact_columns import (
    closes_by_resistance,
    coils_before,
    switches_at,
)
from breaker.records.layout import Layout
from breaker.records.settings import TO_MM
from breaker.records.words import (
    MOTION_OF,
    holds,
    motion_of,
    motions_in,
    unit_of,
)

_MARGIN = 0.1  # share of the strokes seen that is allowed beyond them, so that a false gain shows
_AT_ZERO = 0.3  # mm, up to which the open breaker rests at 0
_NEAR_ZERO = 0.25  # strokes, within which the rest nearer to 0 is taken for the open one
_RESISTANCES = 8.0  # weight of those of contacts: more than all that a curve says
_CONTACTS, _MIDDLE = 5.0, 0.07  # weight of where these switch; of the way, about its half
_OVER = 1.5  # ratio of over-travels, from which motions differ
_ALIKE = 1.15  # ratio of strokes, from which motions differ
_PRIOR = (5.0, 40.0)  # mm, strokes for which the default prior may do
_WHOLE = 1e-6  # samples
_LONGER = 1.05  # times the longest motion, that a grid shall hold
_LENGTHS = {"mm": (4.0, 400.0), "m": (0.004, 0.4)}  # strokes, by size
_SPOKEN_OF = ("deg", "V", "counts")  # of which no mm are known
_FIRST = {letter.lower(): motion for letter, motion in MOTION_OF.items()}
_SEQUENCE = re.compile(r"(?<![a-z])([co])(?:[-_ ]?[co]){1,2}(?![a-z])")


@dataclass(frozen=True)
class Guess:
    """Settings, what is lacking among them, what has to be looked at, in words, and whether text,
    names or contacts say it.
    """

    settings: dict
    lacking: dict[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    sure: bool = True


def guess_time(layout: Layout, clock: Clock) -> Guess:
    """Guess the settings of the time."""
    if clock.place is not None:
        settings = {"time_column": layout.column(clock.place), "time_unit": clock.unit}
        return Guess(settings, remarks=clock.remarks)
    if np.isfinite(clock.rate):
        return Guess({"time_column": None, "rate": clock.rate}, remarks=clock.remarks)
    doubt = layout.stated.rate_doubt
    lacking = {"rate": "kHz, samples in a ms" + (f"; {doubt}" if doubt else "")}
    remarks = clock.remarks or ("there is no column of the time, and no rate is stated",)
    return Guess({"time_column": None, "rate": None}, lacking, remarks)


def guess_unit(layout: Layout, travels: Sequence[Travel]) -> Guess:
    """Guess the column of the travel and its unit."""
    remarks, unit, stated = [], travels[0].unit, layout.stated
    stroke = float(np.median(strokes_of(travels)))
    said = unit_of(stated.travel_unit)
    if unit and said and unit != said:
        remarks.append(f"the column of travel is in {unit}, but the text above states {said}")
    if (unit := unit or said) is None:
        name = layout.names[travels[0].place]
        unit, why = _unit_by_name(name) or _unit_by_size(layout.columns[travels[0].place], stroke)
        remarks.append(f"the unit of the travel is not stated; {why}")
    lacking = {}
    if unit not in TO_MM:
        ratio = f"; stated is a ratio of {in_digits(stated.ratio, 6)}" if stated.ratio > 0 else ""
        lacking["ratio"] = f"mm for one {unit}; the stroke is {in_digits(stroke, 4)} {unit}{ratio}"
        remarks.append(f"a travel in {unit} needs the mm of one: endurance.format.ratio, or table")
    if len({travel.unit for travel in travels}) > 1:
        remarks.append("the columns of travel have different units: choose one by --channel")
    settings = {"travel_column": layout.column(travels[0].place), "travel_unit": unit}
    return Guess(settings, lacking, tuple(remarks))


def _unit_by_name(name: str) -> tuple[str, str] | None:
    """A unit of which a name speaks, and why that: of an angle or a voltage no mm are known."""
    found = next((unit for unit in _SPOKEN_OF if holds(name, unit)), None)
    return found and (found, f"{found} is a guess, as the column is called {name!r}")


def _unit_by_size(readings: np.ndarray, stroke: float) -> tuple[str, str]:
    """A unit for readings ``(t,)`` of a stroke in it, and why that."""
    size = in_digits(stroke, 4)
    if stroke > 1.0 and not np.mod(readings[np.isfinite(readings)], 1.0).any():
        return "counts", f"counts is a guess, as all readings are integers, with a stroke of {size}"
    units = (unit for unit, (low, high) in _LENGTHS.items() if low <= stroke <= high)
    if unit := next(units, None):
        return unit, f"{unit} is a guess from the stroke of {size}"
    return "counts", f"a stroke of {size} is none in mm or m, so counts stands for any unit"


def strokes_of(travels: Iterable[Travel]) -> np.ndarray:
    """Return the ways of all motions, in the unit of the reading."""
    return np.concatenate([travel.strokes for travel in travels])


def guess_direction(layout: Layout, travels: Sequence[Travel]) -> Guess:
    """Guess the sign: by what text, names or coils say of the first motion, or by the curve."""
    travel, file, remarks = travels[0], layout.file, []
    texts = (
        file.stem,
        file.absolute().parent.name,
        "\n".join(" ".join(row) for row in layout.preamble),
    )
    said = _FIRST.get(layout.stated.operation[:1].lower()) or next(
        filter(None, [*map(_first_in, texts), _first_coil(layout, travel)]), ""
    )
    signs = _signs_of_first(travel)
    if switched := closes_by_resistance(layout, travel):
        falls = "fall" if switched > 0.0 else "rise"
        signs.append((_RESISTANCES * switched, f"resistances of contacts {falls} in it"))
    if abs((share := switches_at(layout, travel)) - 0.5) > _MIDDLE:
        weight, part = (1.0, "late") if share > 0.5 else (-1.0, "early")
        signs.append((_CONTACTS * weight, f"contacts switch {part} in it"))
    seen = "closing" if sum(weight for weight, _ in signs) >= 0.0 else "opening"
    first = said or seen
    fors = [why for weight, why in signs if (weight > 0.0) == (first == "closing")]
    against = " and ".join(why for _, why in signs if why not in fors)
    if said and against and seen != said:
        remarks.append(
            f"by its text, names or coils the file begins with {said}, but {against}: if it is "
            "wrong, change endurance.format.sign"
        )
    elif not said:
        why = " and ".join(fors) or "nothing tells"
        but = f", although {against}" if against else ""
        remarks.append(
            f"the sign is a guess: the file begins with {first}, as {why}{but}; no text says it: "
            "if it is wrong, change endurance.format.sign"
        )
    if len({bool(each.rises[0]) for each in travels}) > 1:
        remarks.append("the columns of travel move in different directions: choose by --channel")
    sign = 1 if (first == "closing") == travel.rises[0] else -1
    agreed = sum(weight if first == "closing" else -weight for weight, _ in signs)
    sure = agreed > -_CONTACTS if said else agreed >= _CONTACTS
    return Guess({"sign": sign}, remarks=tuple(remarks), sure=sure)


def _first_coil(layout: Layout, travel: Travel) -> str:
    """The motion of the coil that is energised before the first one, by its name."""
    at = {i: sample for i, sample in coils_before(layout, travel, 0).items() if sample >= 0}
    said = {motion_of(layout.names[i]) for i in at} - {""}
    return said.pop() if len(said) == 1 else ""


def _signs_of_first(travel: Travel) -> list[tuple[float, str]]:
    """What speaks for a closing as the first motion, by its weight, below 0 for an opening, and
    why: makers mostly have the open breaker at 0, but not all.
    """
    found, (before, after) = [], np.abs(travel.rests[0]) / travel.strokes[0]
    if min(before, after) <= _NEAR_ZERO < max(before, after):
        where = "before" if before < after else "after"
        weight = 1.5 if before < after else -1.5
        found.append((weight, f"the reading is nearer to 0 {where} the first motion"))
    own = travel.rises == travel.rises[0]
    if not own.all():
        weight, usual = (1.0, "C-O") if own.size == 2 else (-1.4, "O-C-O")
        found.append((weight, f"{own.size} motions mostly are {usual}"))
        overs = np.array([travel.goes_over(k) for k in range(own.size)])
        first, other = (float(np.median(overs[each])) for each in (own, ~own))
        if max(first, other) > _OVER * min(first, other):
            # The contact springs stop a closing beyond its rest, a damper the opening before.
            weight, than = (2.0, "farther") if first > other else (-2.0, "less far")
            found.append((weight, f"it goes {than} beyond its rest than the next one"))
    return found


def _first_in(text: str) -> str:
    """The motion with which a text says that a record begins, empty where it does not."""
    if found := _SEQUENCE.search(text.lower()):
        return _FIRST[found[1]]
    said = motions_in(text)
    return said[0] if len(said) == 1 else ""


def of_default_size(strokes: np.ndarray) -> bool:
    """Say whether strokes, mm, are those of drives of the default prior."""
    return bool(_PRIOR[0] <= np.median(strokes) <= _PRIOR[1])


def guess_rest(travels: Sequence[Travel], mm: float, sign: int) -> Guess:
    """Guess zero and stroke, from where the breaker rests.

    Args:
        travels: Columns of travel.
        mm: Size of one unit of the reading.
        sign: 1 if the reading grows towards closed, -1 if it falls.
    """
    remarks, strokes = [], mm * strokes_of(travels)
    low, high = float(strokes.min()), float(strokes.max())
    if high > _ALIKE * low:
        remarks.append(
            f"the strokes of the motions differ: {in_digits(low, 4)} to {in_digits(high, 4)} mm"
        )
    opens = mm * np.array([(sign * travel.rests).min() for travel in travels])
    settings = {
        "zero": "rest" if np.abs(opens).max() > _AT_ZERO else 0.0,
        "stroke": [float(f"{(1 - _MARGIN) * low:.3g}"), float(f"{(1 + _MARGIN) * high:.3g}")],
    }
    return Guess(settings, remarks=tuple(remarks))


def guess_grid(longest: float, room: float, rate: float, sensor: Mapping) -> Guess:
    """Guess a grid that holds a motion, if that of the configuration does not.

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
    most, wanted = (step * each / sensor["stop"] for each in (room, _LONGER * longest))
    samples = min(math.ceil(wanted - _WHOLE), math.floor(most + _WHOLE))
    k = (samples if samples >= step else min(wanted, most)) / step
    if k <= 1.0:
        return Guess({})
    settings = {key: float(f"{k * sensor[key]:.6g}") for key in ("start", "stop")}
    remark = f"a motion takes {longest:.0f} ms, longer than sensor.stop"
    return Guess(settings | {"samples": sensor["samples"]}, remarks=(remark,))
