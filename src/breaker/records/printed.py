"""What an analyser printed beside what is measured here of the same samples."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from breaker.common.numerals import in_digits
from breaker.model.quantities import SPEEDS, Point, Speed
from breaker.records.channels import Travel
from breaker.records.header import Preamble, Printed
from breaker.records.layout import Layout
from breaker.records.lexicon import WORDS
from breaker.records.settings import TO_MM
from breaker.records.words import channel_of, motion_of, phase_in

_DIFFERS = {"stroke": 0.01, "speed": 0.03}
_CLOSE = 0.05  # share by which strokes may differ that tell whether samples are multiplied
_MEASURED = {
    ("stroke", "closing"): "stroke",
    ("stroke", "opening"): "stroke",
    ("over_travel", "closing"): "over_travel",
    ("over_travel", "opening"): "rebound",
    ("wipe", "closing"): "wipe_at_touch",
    ("wipe", "opening"): "wipe_at_parting",
    ("speed", "closing"): "closing_speed",
    ("speed", "opening"): "opening_speed",
    ("closing_time", "closing"): "closing_time",
    ("opening_time", "opening"): "opening_time",
}
_NOT_MEASURED = {
    "rebound": "makers mean different things by it",
    "mechanism_travel": "the way of the drive before its linkage, which no column shows",
    "datum_speed": "at a point of the maker's, which is not stated",
    "maximum_travel": "not measured here: see the stroke and the over-travel",
    "travel_time": "makers count it between different points",
}


@dataclass(frozen=True)
class PrintedComparison:
    """A result of the analyser, and the same quantity measured here.

    Attributes:
        column: Of the travel; empty where the result is of no column of travel.
        motion: "closing" or "opening"; empty where neither is known.
        printed: The result.
        measured: In the unit of the result; NaN where it is not measured.
        reason: Why not; empty where it is.
        sd: Of the measured one, in that unit.
    """

    column: str | int
    motion: str
    printed: Printed
    measured: float = math.nan
    reason: str = ""
    sd: float = 0.0

    @property
    def difference(self) -> float:
        """Share of the printed value by which the measured one differs; NaN without either."""
        value = self.printed.value
        return self.measured / value - 1.0 if value else math.nan

    @property
    def differs(self) -> bool:
        """Whether it does by more than such values do, and than its error is."""
        return differs(self.printed.quantity, self.printed.value, self.measured, self.sd)


def differs(quantity: str, printed: float, measured: float, sd: float) -> bool:
    """Say whether a printed value is not the measured one, which has an sd, all in one unit: that
    they differ by more than such values do, and than the error is.

    No value that is zero or NaN differs, and none of a quantity that makers count in other ways.

    >>> differs("stroke", 150.0, 135.3, 0.2), differs("stroke", 136.0, 135.3, 0.2)
    (True, False)
    """
    most = _DIFFERS.get(quantity, math.inf)
    value = abs(printed)
    return bool(value and abs(measured - printed) > most * value + 2.0 * sd)


def measured_name(printed: Printed, motion: str) -> str:
    """Return what the quantity of a result is called where it is measured; empty if it is not.

    An over-travel is the way beyond the rest after the motion, in an opening called rebound. What
    an analyser calls rebound is another: the way back behind that rest.
    """
    return _MEASURED.get((printed.quantity, motion), "")


def meant_motions(printed: Printed, motions: Iterable[str]) -> list[str]:
    """Return of which motions of a record a result is: all of them where it names none, but of an
    over-travel the closing, where there is one.
    """
    there = list(dict.fromkeys(motions))
    if not printed.motion and printed.quantity == "over_travel" and "closing" in there:
        return ["closing"]
    return [printed.motion] if printed.motion else there


def stated_speeds(stated: Preamble) -> dict[str, Speed]:
    """Return the speeds between the points that a text states in % of the stroke, by motion."""
    found, points = {}, [(pair.name, *pair.number()) for pair in stated.speed_points]
    units = {pair.text.strip().lower() for pair in stated.speed_points}
    usual = "%" if units & {*WORDS["share_of_stroke"]} else ""  # a unit of all, by itself
    for motion in ("closing", "opening"):
        amounts = [
            amount
            for name, amount, unit in points
            if motion_of(name) in (motion, "") and (unit or usual) == "%" and math.isfinite(amount)
        ]
        if len(amounts) == 2 and 0 < amounts[0] < amounts[1] < 100:
            points = (Point(amount, "%") for amount in amounts)
            found[motion] = Speed(f"{motion}_speed", *points)
    return found


def compare_printed(
    layout: Layout, travels: Sequence[Travel], motions: Sequence
) -> list[PrintedComparison]:
    """Set the results that a text states beside what is measured of every ``InspectedMotion``."""
    stated, found = layout.stated, []
    speeds = stated_speeds(stated)
    columns = _columns(layout, travels)
    measured: dict[int, dict] = {}
    for printed in stated.results:
        column = columns.get(printed.channel.casefold(), "")
        own = [m for m in motions if m.column == column]
        meant = meant_motions(printed, (m.motion for m in own))
        own = [m for m in own if m.motion in meant]
        if not printed.value:
            continue  # a zero stands for what the analyser has not seen
        if not own:
            why = "no motion of it is read" if motions else "a setting is to be filled in"
            found.append(PrintedComparison("", printed.motion, printed, reason=why))
            continue
        motion = own[0]
        if id(motion) not in measured:
            speed = speeds.get(motion.motion)
            used = (speed,) if speed else SPEEDS
            measured[id(motion)] = motion.record.measured(used) if motion.record else {}
        name = measured_name(printed, motion.motion)
        why = _NOT_MEASURED.get(printed.quantity, "not measured here")
        value, sd, reason = measured[id(motion)].get(name, (math.nan, 0.0, why))
        if motion.record is None:
            reason = "the motion is not read"
        if printed.quantity == "speed" and motion.motion not in speeds:
            value, reason = math.nan, "between which points is not stated"
        value, sd = value / printed.size, sd / printed.size
        found.append(PrintedComparison(column, motion.motion, printed, value, reason, sd))
    return found


def _columns(layout: Layout, travels: Sequence[Travel]) -> dict[str, str | int]:
    """Columns of travel by what results call their channel."""
    labels = list(dict.fromkeys(each.channel.casefold() for each in layout.stated.results))
    columns = [layout.column(each.place) for each in travels]
    by_number, by_phase = {}, {}
    for order, (each, column) in enumerate(zip(travels, columns, strict=True), start=1):
        by_number[channel_of(layout.names[each.place]) or order] = column
        by_phase.setdefault(each.phase.casefold() or None, column)
    meant = {
        label: by_number.get(channel_of(label), by_phase.get(phase_in(label).casefold()))
        for label in labels
    }
    found = {label: column for label, column in meant.items() if column is not None}
    if len(columns) == 1 and "" in labels:
        found[""] = columns[0]
    return found or (dict(zip(labels, columns, strict=True)) if len(labels) == len(columns) else {})


def stated_remarks(stated: Preamble, unit: str, compared: Sequence[PrintedComparison]) -> list[str]:
    """Return what is doubtful about a text, and what there is to say of a ratio it states."""
    ratio = stated.ratio
    if math.isnan(ratio) or ratio == 1.0 or unit not in TO_MM:
        return [*stated.doubts]
    size = in_digits(ratio, 6)
    said = f"the text states a linkage ratio of {size}, which is not applied, as samples are {unit}"
    strokes = [1.0 + c.difference for c in compared if c.printed.quantity == "stroke"]
    share = float(np.nanmedian(strokes)) if np.isfinite(strokes).any() else math.nan
    why = "compare the stroke with the drive's; if it lacks the ratio, set endurance.format.ratio"
    if abs(share - 1.0) <= _CLOSE:
        why = "and have the printed stroke already"
    elif abs(share * ratio - 1.0) <= _CLOSE:
        why = f"times {size} they have the printed stroke: set endurance.format.ratio to it"
    return [*stated.doubts, f"{said}: {why}"]
