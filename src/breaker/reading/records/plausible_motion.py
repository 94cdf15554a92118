"""Whether a motion is one of a breaker's drive: its stroke, speed and time, and where it rests.

Far beyond the ranges of drives a record is in another unit or at another rate. They are from vacuum
drives of 6 mm to those of 300 mm; an opening may be braked from early on.
"""

from collections.abc import Mapping

import numpy as np

from breaker.common.numerals import in_digits
from breaker.reading.files.format_settings import TO_MM
from breaker.reading.records.motion import Segment
from breaker.reading.records.rejections import UnusableError

STROKES = (2.0, 300.0)
"""Ways of drives, mm."""

SPEEDS = {"closing": (0.2, 6.0), "opening": (0.12, 14.0)}
"""Mean speeds of drives from 10 to 90 % of the way, m/s: up to half as fast again as closings that
are known, of 4 m/s, and openings, of 9 m/s."""

TIMES = (0.5, 150.0)
"""Times that they take for that, ms."""

_GAINED = 1.5  # mm/ms^2, largest square of that speed over the stroke: 9 m/s in 100 mm have 0.8
_SHARES = 0.1, 0.9
# Rest of the open breaker, in strokes: further from zero the record is refused, or has a remark.
_FAR = 0.15
# 4 sd of a zero of 0.1 mm, at a stroke of 10 mm; some openings are not quite at rest at their end.
_SDS = 4.0  # sd of the zero
_OFF = {"closing": 0.04, "opening": 0.08}
_ABOUT = 0.005  # strokes, by which a drive that settles rests elsewhere than it opens to
_BACK = -0.4  # of the greatest speed: so fast no drive rebounds at the end of a record
_REMEDY = "set endurance.format.zero to its reading, or to rest"


def of_no_drive(motion: str, time: np.ndarray, done: np.ndarray, stroke: float) -> str:
    """Say why a motion is none of a breaker's drive; "" if it may be one.

    Args:
        motion: "closing" or "opening".
        time: Times, ``(t,)``, ms.
        done: Shares of the way that are done, ``(t,)``; nan where a sample is missing.
        stroke: Way between the rests, mm.
    """
    past = np.flatnonzero(done >= _SHARES[1])
    if not past.size:
        return ""
    low = np.flatnonzero(done[: past[0]] <= _SHARES[0])
    if not low.size:
        return ""
    lasts = max(float(time[past[0]] - time[low[-1]]), float(time[1] - time[0]))
    speed = (_SHARES[1] - _SHARES[0]) * stroke / lasts
    least, most = SPEEDS[motion]
    usual = least <= speed <= most and TIMES[0] <= lasts <= TIMES[1]
    if usual and speed**2 <= _GAINED * stroke:
        return ""
    return (
        f"{in_digits(stroke, 3)} mm in {in_digits(lasts, 3)} ms, {in_digits(speed, 3)} m/s, is no "
        f"{motion} of a breaker's drive: check the rate or unit of the time, and the unit or ratio "
        "of the travel"
    )


def check_stroke(stroke: float, settings: Mapping) -> None:
    """Refuse a stroke, mm, that is not between those of ``endurance.format.stroke``.

    Where it is null, those of any breaker: a unit that is wrong by far more than drives differ.
    """
    least, most = settings["stroke"] or STROKES
    if least <= stroke <= most:
        return
    still = "did the breaker not move, or " if stroke < least else ""
    if settings["table"] is not None or settings["ratio"] is not None:
        given = "table" if settings["table"] is not None else "ratio"
        hint = f"; {still}is endurance.format.{given} wrong?"
    else:
        here = stroke / TO_MM[settings["travel_unit"]]
        likely = [unit for unit, mm in TO_MM.items() if least <= here * mm <= most]
        hint = f"; {still}is endurance.format.travel_unit {likely[0]!r}?" if likely else ""
    whose = "which endurance.format.stroke allows" if settings["stroke"] else "as of any breaker"
    raise UnusableError(
        f"the stroke is {in_digits(stroke, 4)} mm, not between {least:g} and {most:g} mm, "
        f"{whose}{hint}"
    )


def rest_of_open(segment: Segment, settings: Mapping, motion: str) -> float:
    """Return the reading to subtract for an open breaker at rest, mm.

    Where an opening creeps on to the end of its record, that is its last reading.

    Raises:
        UnusableError: If the open breaker is far from zero.
    """
    seen, rest = _open(segment, motion)
    if settings["zero"] == "rest":
        return rest
    if seen and abs(rest) / segment.stroke > _FAR:
        raise UnusableError(
            f"the open breaker rests at {rest:.2f} mm, not near 0; {_REMEDY}, or record the whole "
            "motion"
        )
    return 0.0


def rest_remark(
    segment: Segment,
    settings: Mapping,
    motion: str,
    zero_sd: float | None = None,
    settles: tuple[float, float] = (np.nan, np.nan),
) -> str:
    """Say where the breaker's rests are not those that the settings state; "" if they are.

    Args:
        segment: The motion in its record.
        settings: The section ``endurance.format``, complete.
        motion: "closing" or "opening".
        zero_sd: Standard deviation of the zero that the model takes for granted, mm. With it, the
            rest before the motion is compared: it is at 0, or a stroke of
            ``endurance.format.stroke`` from it.
        settles: Where the travel settles after the motion, and how well that is known, mm; NaN
            where it is not seen.
    """
    seen, rest = _open(segment, motion)
    if segment.speed < _BACK:
        return f"ends while the travel goes back, at {-segment.speed:.0%} of the greatest speed"
    if settings["zero"] == "rest" and not seen:
        return "ends before the open breaker rests: its last reading stands for that rest"
    if settings["zero"] == "rest" or not seen:
        return ""
    if abs(rest) / segment.stroke > _OFF[motion]:
        return f"the open breaker rests at {rest:.2f} mm: {_REMEDY}, if sensor.zero_sd is less"
    least, most = (0.0, 0.0) if motion == "closing" else settings["stroke"] or STROKES
    clear = np.inf if zero_sd is None else _SDS * zero_sd
    # A drive may creep on to its rest, but not from below, and it may still swing about it.
    settled, error = settles[0], 2.0 * settles[1]
    highest, off = min(max(rest, settled), settled + error), clear + _ABOUT * segment.stroke
    if motion == "opening" and (highest < -off or settled - error > off):
        here = highest if highest < -off else settled
        return f"rests at {here:.2f} mm after the opening, which is no zero: {_REMEDY}"
    if least - clear <= segment.before <= most + clear:
        return ""
    return f"rests at {segment.before:.2f} mm before the {motion}, which is no zero: {_REMEDY}"


def _open(segment: Segment, motion: str) -> tuple[bool, float]:
    """Whether the open breaker is seen at rest, and where, mm."""
    if motion == "closing":
        return True, segment.before
    return segment.arrived and bool(np.isnan(segment.back)), segment.after
