"""What speaks against a record as a whole: a motion of no drive, samples that do not fit together.

Far beyond the ranges of drives a record is in another unit or at another rate. They are from vacuum
drives of 6 mm to those of 300 mm; an opening may be braked from early on.

Noise never repeats itself and is the same everywhere, and a drive gains its speed without delay.
Where a record says otherwise, samples were sent twice, something disturbed the sensor, or the first
motion is not that of the drive. Nothing can be masked, since it is not known which samples are
right, so each finding is a remark.
"""

from collections.abc import Mapping

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from breaker.common.numerals import in_digits
from breaker.records.motion import Segment
from breaker.records.rejections import UnusableError
from breaker.records.settings import TO_MM

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

_EXACT = 1e-9  # of the range: less is the arithmetic's
_CALM = 12  # samples whose noise is compared
_UNREST = 3.9  # times the noise of the record; so many samples exceed that once in 1,000 records
_FLICKER = 0.4  # quanta: noise of a reading that changes by one from sample to sample
_CHANCE = 1e-6  # probability that equal readings are chance
_MOST = 64  # readings, more than which are not compared
_ODD = np.uint64(0x9E3779B97F4A7C15)  # whose powers are far apart
_REST = 50  # samples at the ends of a record, in which a counter is steady
_RISE = (0.1, 0.4)  # shares of the way, between which the start is extrapolated from
_FLAT = (5.0, 0.003)  # sd of the noise, strokes: no more moves at a rest that no swing follows
_HIDES = 0.012  # strokes of noise, in which a swing may hide
_TENTHS = np.arange(0.1, 0.95, 0.1)  # of the way, between which speeds are compared
_SUDDEN = 0.4  # of the greatest speed in the last tenth, with which no drive stops flat
_LESS, _CLEARLY = 1.2, 4.0  # times less noise at the end of a range, and sd of such by chance
_THIRD = 2.31  # times as many white samples know as little of their noise by third differences
_MEAN, _STEADY = 5, 0.7  # samples whose mean is at rest, within such a share of what hides a swing
_EARLY = 0.2  # of the time between these: first motions that a gradual force makes are less early
_MAINS = 0.05, 0.06  # kHz
_SHORTEST = 15.0  # ms after a motion, in which a swing of the mains shows
_SEEN = 0.8  # sd of the noise, least swing that counts
_CALMLY = 2.0  # sd, most that is left before a motion without the swing
_SWINGS, _AS_LARGE = 3.3, (0.5, 1.7)  # sd; of it, what then is there before the motion


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
        here = rest if np.isnan(settled) else settled
        return f"rests at {here:.2f} mm after the opening, which is no zero: {_REMEDY}"
    if least - clear <= segment.before <= most + clear:
        return ""
    return f"rests at {segment.before:.2f} mm before the {motion}, which is no zero: {_REMEDY}"


def _open(segment: Segment, motion: str) -> tuple[bool, float]:
    """Whether the open breaker is seen at rest, and where, mm."""
    if motion == "closing":
        return True, segment.before
    return segment.arrived and bool(np.isnan(segment.back)), segment.after


def inconsistencies(
    time: np.ndarray, travel: np.ndarray, moves: float, sd: float, quantum: float = 0.0
) -> list[str]:
    """Say in words what samples of a record do not fit to each other.

    Args:
        time: Times, ``(t,)``, ms, evenly spaced.
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
        moves: Time of the first motion, ms.
        sd: Noise of a sample that the model takes for granted, mm. The record's own counts where
            it is larger.
        quantum: Step of the reading, mm.
    """
    there = np.flatnonzero(~np.isnan(travel))
    if there.size < 4 * _CALM:
        return []
    time, travel = time[there], travel[there]
    third = np.diff(travel, n=3) / np.sqrt(20.0)
    own = max(1.4826 * float(np.median(np.abs(third))), _FLICKER * quantum)
    own = max(own, _EXACT * float(np.ptp(travel)))
    sd = max(sd, own)
    found = [
        _equal(time, travel),
        _unrest(time, third, sd),
        _early(time, travel, moves),
        _hum(time, travel, moves, own),
        _at_full_speed(time, travel, moves, sd, quantum),
    ]
    return [words for words in found if words]


def _equal(time: np.ndarray, travel: np.ndarray) -> str:
    """Readings that come twice, one stretch like another."""
    tied = np.diff(travel) == 0.0
    # Where a counter rests, its readings are equal; where nothing is rounded, hardly any two are.
    ties = max(1e-4, *(float(part.mean()) for part in (tied, tied[:_REST], tied[-_REST:])))
    length = np.inf if ties >= 1.0 else np.log(_CHANCE / travel.size**2) / np.log(ties)
    if length > min(_MOST, travel.size // 4):
        return ""
    length = int(np.ceil(length))
    # Stretches side by side would take much memory: equal ones have equal sums, modulo 2^64.
    readings = np.unique(travel, return_inverse=True)[1].astype(np.uint64) + _ODD
    sums = np.convolve(readings, np.cumprod(np.full(length, _ODD)), "valid")
    order = np.argsort(sums, kind="stable")
    same = np.flatnonzero(sums[order[1:]] == sums[order[:-1]])
    windows = sliding_window_view(travel, length)
    same = same[[np.array_equal(windows[order[i]], windows[order[i + 1]]) for i in same]]
    if same.size == 0:
        return ""
    again = same[order[same].argmin()]
    first, second = (in_digits(time[order[again + i]], 4) for i in (0, 1))
    return (
        f"the readings from {first} ms on come again from {second} ms on: were samples sent twice?"
    )


def _unrest(time: np.ndarray, third: np.ndarray, sd: float) -> str:
    """Noise of third differences in a short stretch; a stop changes a few of them alone."""
    local = 1.4826 * np.median(sliding_window_view(np.abs(third), _CALM), axis=1)
    most = int(local.argmax())
    if local[most] <= _UNREST * sd:
        return ""
    return (
        f"noise of {in_digits(local[most], 2)} mm at {in_digits(time[most], 4)} ms, far more "
        "than elsewhere"
    )


def _early(time: np.ndarray, travel: np.ndarray, moves: float) -> str:
    """A first motion long before the one that the rise has under an even force."""
    after = time >= moves
    if not after.any():
        return ""
    start, way = np.median(travel[~after][-20:]) if (~after).any() else travel[0], np.ptp(travel)
    risen = np.abs(travel - start)[after] / way
    low, high = (time[after][(risen >= share).argmax()] for share in _RISE)
    roots = np.sqrt(_RISE)
    even = low - (high - low) * roots[0] / (roots[1] - roots[0])
    if even - moves <= _EARLY * (high - low) + 0.5 * (time[1] - time[0]):
        return ""
    early = in_digits(even - moves, 2)
    return (
        f"the first motion, at {in_digits(moves, 4)} ms, is {early} ms earlier than the rise "
        "suggests: was something disturbed before it?"
    )


def _hum(time: np.ndarray, travel: np.ndarray, moves: float, sd: float) -> str:
    """A swing of the mains' frequency after the motion that is there before it, too.

    A drive that settles makes a swing after its motion alone.
    """
    start, end = (float(np.median(each)) for each in (travel[:_CALM], travel[-_CALM:]))
    there = np.abs(travel - start) >= 0.9 * abs(end - start)
    arrival = float(time[int(there.argmax())])
    before, after = time < moves, time > 2.0 * arrival - moves
    lasts = time[-1] - (2.0 * arrival - moves)
    if min(before.sum(), after.sum()) < _CALM or lasts < _SHORTEST:
        return ""
    for frequency in _MAINS:
        phase = 2.0 * np.pi * frequency * (time - arrival)
        waves = np.column_stack([np.cos(phase), np.sin(phase)])
        shapes = np.column_stack([waves, np.vander((time - arrival) / np.ptp(time), 3)])[after]
        sizes = np.linalg.lstsq(shapes, travel[after], rcond=None)[0][:2]
        swing = (waves @ sizes)[before]
        swing -= swing.mean()
        square = float(swing @ swing)
        found = float(swing @ travel[before]) / square if square > 0.0 else 0.0
        alike = _AS_LARGE[0] < found < _AS_LARGE[1] and found * np.sqrt(square) > _SWINGS * sd
        # Nothing else moves before it, such as a drive that comes to rest after another motion.
        alike &= float(np.std(travel[before] - found * swing)) < _CALMLY * sd
        if alike and (size := float(np.hypot(*sizes))) > _SEEN * sd:
            return (
                f"the reading swings by +-{in_digits(size, 2)} mm at "
                f"{1e3 * frequency:.0f} Hz before and after the motion, as by hum of the mains: "
                "shield the transducer's cable"
            )
    return ""


def _at_full_speed(
    time: np.ndarray, travel: np.ndarray, moves: float, sd: float, quantum: float
) -> str:
    """A stop at speed without any swing, or a stop or start at speed at a rest that is calmer than
    the other: the end of the range, whatever noise lies on it.

    What stops a drive so suddenly throws it back, and its noise is that of the sensor at both
    rests.
    """
    start, end = (float(np.median(each)) for each in (travel[:_CALM], travel[-_CALM:]))
    if end == start:
        return ""
    done, before = (travel - start) / (end - start), int((time < moves).sum())
    stop, last = _stop(time, done, sd / abs(end - start))
    begin, first = _stop(-time[::-1], 1.0 - done[::-1], sd / abs(end - start))
    rests = travel[: before - _CALM], travel[max(stop + _CALM, travel.size - before) :]
    calm = _calmer(*rests, quantum)
    if last > _SUDDEN and (calm > 0 or _no_swing(done[stop:], sd / abs(end - start))):
        what, at, share = "stops", time[stop], last
    elif first > _SUDDEN and calm < 0:
        what, at, share = "starts", time[::-1][begin], first
    else:
        return ""
    side, speed = "behind" if what == "stops" else "before", f"{share:.0%} of its greatest speed"
    return (
        f"the travel {what} at {in_digits(at, 4)} ms at {speed}, and is flat {side} it: does the "
        "range of the transducer end there? If so, the stroke is longer"
    )


def _stop(time: np.ndarray, done: np.ndarray, noise: float) -> tuple[int, float]:
    """Sample at which a way, from 0 to 1, is gone but for noise, and the share of the greatest
    speed of a tenth of it that is left in the last.
    """
    stop = int((done >= 1.0 - _near(noise)).argmax())
    marks = time[[int((done >= share).argmax()) for share in _TENTHS]]
    step = float(np.median(np.diff(time)))
    speeds = np.diff(_TENTHS) / np.maximum(np.diff(marks), step)
    return stop, (done[stop] - _TENTHS[-1]) / max(time[stop] - marks[-1], step) / speeds.max()


def _near(noise: float) -> float:
    """Share of a way within which noise of such a share leaves a rest."""
    return max(_FLAT[0] * noise, _FLAT[1])


def _no_swing(done: np.ndarray, noise: float) -> bool:
    """Whether a way ``(n,)`` from its stop on is 1 at once, in noise that hides no swing."""
    rest, near = np.convolve(done - 1.0, np.full(_MEAN, 1.0 / _MEAN), "valid"), _near(noise)
    return near <= _HIDES and rest.size >= _CALM and np.abs(rest[1:]).max() <= _STEADY * near


def _calmer(first: np.ndarray, second: np.ndarray, quantum: float) -> int:
    """Which of two rests has less noise than the other by far: 1 the second, -1 the first, or 0.

    All that moves at the calm one counts, and noise alone at the other, where a drive may settle.
    """
    if min(first.size, second.size) < 2 * _CALM:
        return 0
    for sign, calm, other in ((1, second, first), (-1, first, second)):
        line = np.polynomial.Polynomial.fit(np.arange(calm.size), calm, 1)
        least = float(np.std(calm - line(np.arange(calm.size))))
        noise = float(np.sqrt(np.mean(np.square(np.diff(other, n=3))) / 20.0))
        chance = np.sqrt(0.5 / calm.size + 0.5 * _THIRD / other.size)  # sd of the logarithm
        if noise > quantum and np.log(noise / max(least, 0.1 * noise)) > max(
            np.log(_LESS), _CLEARLY * chance
        ):
            return sign
    return 0
