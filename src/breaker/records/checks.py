"""Checks of the samples of a record (which are doubtful?) and of the entire record.

Each check compares one statistic with its distribution under white noise of the record's own
standard deviation, at the rate ``FALSE`` of false alarms; other limits are physical. Each check is
kept because damaged files of ``studies.faults`` would be wrong without a remark if it were missing.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from breaker.common.numerals import in_digits
from breaker.records.motion import Segment
from breaker.records.noise import (
    OF_SECOND,
    REST,
    filled,
    running_mean,
    running_median,
    smoothed,
    white_noise,
)
from breaker.records.rejections import FEWEST, MATTERS, Remark, UnusableError, normal_sds
from breaker.records.settings import TO_MM

STROKES = (2.0, 300.0)
"""Smallest and largest stroke of drives, mm."""

_FORCES = (0.0015, 1.0)  # mm/ms^2, limits of speed squared over stroke; known drives: 0.003 to 0.8
_FASTEST = {"closing": 6.0, "opening": 14.0}  # m/s, 1.5 times the speed of the fastest known drives
_ABSURD = 1e6  # mm, readings above which arithmetic may overflow
_BURST = 5.0  # ms, longest disturbance that a running median removes
_JUMP_RATIO = 0.7, 4 / 3  # step over twice the time by that over once: 1 at a jump, 2 in a bend
_LINE = 5  # samples to which a line is fitted on either side of a place
_DISTURBED = 0.02, 5.0  # noise of useless samples: in strokes, and in sds of the least noise
_FAR = 0.15  # strokes, distance of the open rest from zero above which the settings must be wrong
_SLIPS = 0.05  # strokes, largest slip of a transducer that is accepted
_AT_END = 0.25  # share of samples at one extreme that shows a range's end; by noise of 5 steps 0.07
_NOISY = 5  # distinct values at the other rest from which on its noise exceeds the step
_UNSTEADY = 0.0065  # strokes, movement of a rest; 3 of 640 good drives of the study exceed it
_RANGE = 0.5  # strokes, largest swing of a drive about its rest
_BEGUN = 0.1  # share of the stroke from which a motion has begun: twice the largest slip


# ---- samples -------------------------------------------------------------------------------------


def doubtful_samples(travel: np.ndarray, step: float, quantum: float) -> np.ndarray:
    """Return the kind of each doubtful sample, "" for the others, ``(t,) -> (t,)`` of text.

    A "slip" is the first sample after a step of the reading that does not return.

    Args:
        travel: Travel, ``(t,)``, mm, evenly spaced; NaN where a sample is missing.
        step: Time between two samples, ms.
        quantum: Step to which readings are rounded, mm; 0 if they are not.
    """
    kinds = np.where(np.abs(travel) > _ABSURD, "out of range", "").astype("U12")
    left = np.where(kinds == "", travel, np.nan)
    if (~np.isnan(left)).sum() < _LINE:
        return kinds
    every = max(1, round(0.01 * _BURST / step))
    smooth = smoothed(filled(left)[::every], max(1, round(_BURST / (every * step))))
    stroke, lag = float(np.ptp(smooth)), max(1, round(1.0 / (every * step)))
    speed = np.abs(smooth[lag:] - smooth[:-lag]).max(initial=0.0) / (lag * every)  # mm a sample
    sds, noise = normal_sds(travel.size), _local_noise(filled(left), step)
    coarse = np.maximum(sds * noise + 0.2 * MATTERS * stroke, 2.5 * quantum)

    near = running_median(filled(left), 5)
    steps = sliding_window_view(np.diff(np.pad(near, 2, mode="edge")), 4)
    bends = np.maximum(np.ptp(steps, axis=1) - sds * noise, 0.0)
    kinds[np.abs(left - near) > coarse + bends] = "spike"
    shape = quantum, MATTERS * stroke, stroke / speed if speed else np.inf
    if speed and (kinds == "spike").any():  # a median of 5 is wrong next to a slip in the motion
        slips = np.convolve(_jumps(filled(left), noise, *shape), np.ones(_LINE), "same") > 0.0
        kinds[slips & (kinds == "spike")] = ""
    kinds[_clipped(np.where(kinds == "", left, np.nan), quantum, noise)] = "clipped"
    kinds[noise > max(_DISTURBED[0] * stroke, _DISTURBED[1] * noise.min())] = "disturbed"
    there = np.flatnonzero((kinds == "") & ~np.isnan(left))
    if speed == 0.0 or there.size < _LINE:
        return kinds
    # Just after an impact a drive is 2.5 times as fast as on average over a millisecond.
    far = np.sqrt(2.0) * coarse[there[1:]] + 2.5 * speed * np.diff(there)
    leaps = np.abs(np.diff(left[there])) > far
    rest = filled(np.where(kinds == "", left, np.nan))
    leaps |= _jumps(rest, noise, *shape)[there[1:]]
    kinds[there] = _pieces(left[there], there, leaps, float(coarse.max()), _BURST / step)
    return kinds


def _local_noise(travel: np.ndarray, step: float) -> np.ndarray:
    """Return the sd of white noise near each sample, ``(t,)``, mm, at least that of the record."""
    # Interpolation in the instrument hides noise, so every second and fourth sample is tried too.
    noise = max(
        white_noise(travel[::stride]) for stride in (1, 2, 4) if stride == 1 or stride * step < 0.4
    )
    length, local = 4 * round(_BURST / step), np.full(travel.shape, noise)
    if travel.size < length:
        return local
    every = max(length // 8, 1)
    parts = sliding_window_view(travel, length)[::every]
    for k, sd in enumerate(OF_SECOND * np.median(np.abs(np.diff(parts, n=2)), axis=1)):
        part = slice(k * every, k * every + length)
        local[part] = np.maximum(local[part], sd)
    return local


def _steps(travel: np.ndarray, count: int) -> tuple[np.ndarray, float]:
    """Return the step before each sample between parallel lines on either side, and the step's sd
    for noise of 1; ``count`` samples determine each line.
    """
    x = (np.arange(2 * count) + 0.5) / count - 1.0
    weights = np.linalg.pinv(np.column_stack([x, np.ones(x.size), 0.5 * np.sign(x)]))[-1]
    steps = np.zeros(travel.size)
    steps[count : travel.size - count + 1] = np.convolve(travel, weights[::-1], "valid")
    return steps, float(np.linalg.norm(weights))


def _jumps(
    travel: np.ndarray, noise: np.ndarray, quantum: float, least: float, pace: float
) -> np.ndarray:
    """Return before which samples travel jumps: suddenly, and equally far over twice the time."""
    jumps, count = np.zeros(travel.size, dtype=bool), 2
    both = np.concatenate([[0.0], travel[2:] - travel[:-2], [0.0]])
    both = np.abs(both - running_median(both, 4 * _LINE + 1))
    sudden = np.maximum(both, np.append(0.0, both[:-1]))
    steps, sd = _steps(travel, count)
    while count <= max(0.15 * pace, 2.0) and travel.size >= 8 * count:
        longer, longer_sd = _steps(travel, 2 * count)
        spread = np.maximum(noise * sd, 1.4826 * np.median(np.abs(steps)))  # also coloured noise
        limit = np.maximum(normal_sds(travel.size) * spread, 1.5 * quantum) + least
        high = np.abs(steps)
        top = sliding_window_view(np.pad(high, count), 2 * count + 1).max(axis=1)
        same = longer * np.sign(steps)
        jump = (high > limit) & (high == top) & (sudden > 0.6 * high)
        jumps |= jump & (same > _JUMP_RATIO[0] * high) & (same < _JUMP_RATIO[1] * high)
        count, steps, sd = 2 * count, longer, longer_sd
    return jumps


def _clipped(travel: np.ndarray, quantum: float, noise: np.ndarray) -> np.ndarray:
    """Return which samples form a flat top because the sensor's range ends there: within half the
    length of the top, travel falls by more than noise, and faster than from the top of a parabola.
    """
    clipped = np.zeros(travel.shape, dtype=bool)
    for side in (travel, -travel):
        top = np.flatnonzero(side == np.nanmax(side))
        first, last = int(top[0]), int(top[-1])
        half = (last - first) // 2
        if half < _LINE // 2 or half > min(first, side.size - 1 - last, top.size):
            continue
        clear = normal_sds(travel.size) * max(quantum, float(noise[first]))
        if side[first] - max(side[first - half], side[last + half]) > clear:
            clipped[top] = True
    return clipped


def _pieces(
    travel: np.ndarray, places: np.ndarray, leaps: np.ndarray, coarse: float, burst: float
) -> np.ndarray:
    """Return the kinds of samples: "jump" in short pieces between leaps, "slip" at the start of a
    long piece that does not continue the piece before it.
    """
    kinds = np.full(travel.size, "", dtype="U12")
    edges, pieces = [0, *(np.flatnonzero(leaps) + 1).tolist(), travel.size], []
    for first, last in pairwise(edges):
        inner = first > 0 and last < travel.size
        if last - first < (max(burst, _LINE) if inner else _LINE):
            kinds[first:last] = "jump"
        else:
            pieces.append((first, last))
    for (_, end), (begin, _) in pairwise(pieces):
        missing = int(places[begin] - places[end - 1])
        n = min(missing, _LINE - 1)
        moved = abs(travel[end - 1] - travel[end - 1 - n]) + abs(travel[begin + n] - travel[begin])
        far = coarse + 1.5 * missing / n * moved
        if begin == end or abs(travel[begin] - travel[end - 1]) > far:
            kinds[begin] = "slip"
    return kinds


def leap_at(travel: np.ndarray, place: int) -> float:
    """Return the leap, mm, of travel ``(t,)`` at a sample, from lines on either side."""
    there = np.flatnonzero(~np.isnan(travel))
    near = [there[there < place][-_LINE:], there[there > place][:_LINE]]
    if not all(part.size for part in near):
        return 0.0  # no samples before or after it
    ends = [np.polyval(np.polyfit(k - place, travel[k], min(1, k.size - 1)), 0.0) for k in near]
    return float(ends[1] - ends[0])


def check_slips(time: np.ndarray, travel: np.ndarray, kinds: np.ndarray, segment: Segment) -> None:
    """Reject a motion whose reading slips far, by its samples ``(n,)``, ms, mm and kinds.

    Before the motion, any slip is rejected because it looks like a first motion: a slip of 1 % of
    the stroke makes the time of the first motion 40 ms too early.
    """
    begun = np.abs(travel[segment.begin : segment.end] - segment.before) > _BEGUN * segment.stroke
    begun = segment.begin + int(begun.argmax())
    for place in segment.begin + np.flatnonzero(kinds[segment.begin : segment.end] == "slip"):
        leap = leap_at(travel, place)
        if place < begun or abs(leap) > _SLIPS * segment.stroke:
            raise UnusableError(
                f"the reading leaps by {leap:.3g} mm at {time[place]:.5g} ms and does not return: "
                "mend the transducer, or leave that part out by from and to in operations.csv"
            )


def doubts_in_words(time: np.ndarray, kinds: np.ndarray) -> str:
    """Return a remark on the number, kinds and times of doubtful samples; "" if none is.

    Args:
        time: Times of the record, ``(n,)``, ms.
        kinds: Kinds of its samples, ``(n,)``, from ``doubtful_samples``.
    """
    bad = kinds != ""
    begins = np.flatnonzero(bad & (kinds != np.append("", kinds[:-1]))).tolist()
    listed = [f"{kinds[k]} at {in_digits(time[k], 5)} ms (sample {k + 1})" for k in begins[:4]]
    places = ", ".join(listed) + (", ..." if begins[4:] else "")
    return Remark("doubtful-samples", count=int(bad.sum()), places=places) if begins else ""


# ---- entire records ------------------------------------------------------------------------------


def of_no_drive(motion: str, time: np.ndarray, done: np.ndarray, stroke: float) -> str:
    """Return a remark if no drive moves so, as in a wrong unit; "" if the motion is possible.

    Args:
        motion: "closing" or "opening".
        time: Times, ``(t,)``, ms.
        done: Travel as a share of the stroke, ``(t,)``; nan where a sample is missing.
        stroke: Distance between the rests, mm.
    """
    past = np.flatnonzero(done >= 0.9)
    low = np.flatnonzero(done[: past[0]] <= 0.1) if past.size else past
    if not low.size:
        return ""
    lasts = max(float(time[past[0]] - time[low[-1]]), float(time[1] - time[0]))
    speed = 0.8 * stroke / lasts
    if _FORCES[0] <= speed**2 / stroke <= _FORCES[1] and speed <= _FASTEST[motion]:
        return ""
    values = {"stroke": stroke, "lasts": lasts, "speed": speed}
    return Remark("no-drive", motion=motion, **{k: in_digits(v, 3) for k, v in values.items()})


def ends_of_range(time: np.ndarray, travel: np.ndarray, moves: float) -> tuple[float, float]:
    """Return the ends of the transducer's range, mm, that cut off the rest before and the rest
    after the motion; nan where the samples show no such end.

    At the end of a range, many samples have the same extreme value; with noise, which the other
    rest shows, this is rare.

    Args:
        time, travel: Samples of the motion, ``(n,)``, ms and mm; NaN where one is missing.
        moves: Time of the first motion, ms.
    """
    there = ~np.isnan(travel)
    time, travel = time[there], travel[there]
    rests, levels = (travel[time < moves], travel[time > 0.5 * (moves + time[-1])]), []
    for rest, other in (rests, rests[::-1]):
        ends = () if min(rest.size, other.size) < 2 * FEWEST else (rest.min(), rest.max())
        # Second differences of white noise exceed its first differences; those of creep do not.
        steps = np.diff(other)
        noisy = ends and np.median(np.abs(np.diff(steps))) > np.median(np.abs(steps))
        noisy = noisy and np.unique(other).size >= _NOISY
        level = [end for end in ends if noisy and (rest == end).mean() > _AT_END]
        levels.append(float(level[0]) if level else np.nan)
    return levels[0], levels[1]


def unsteady_remark(time: np.ndarray, travel: np.ndarray, moves: float, segment: Segment) -> str:
    """Return a remark if the reading moves at rest, before the motion or again after it; else "".

    A drive that has arrived swings less and less, and never back by half of its stroke.

    Args:
        time, travel: Of the motion, ``(n,)``, ms and mm; NaN where a sample is missing.
        moves: Time of the first motion, ms.
        segment: The motion in its record.
    """
    half = max(1, round(0.5 / (time[1] - time[0])))
    smooth = running_mean(filled(travel), 2 * half + 1)[half:-half:half]
    at = time[half:-half:half]
    done = np.abs(smooth - segment.before) / segment.stroke
    rest = done[(at < moves - REST[1]) & (at > moves - REST[0])]
    begun, arrived = ((done >= share).argmax() for share in (_BEGUN, 1.0 - _BEGUN))
    off, lasts = np.abs(done[arrived:] - 1.0), int(arrived - begun)
    ways = [float(np.ptp(rest)) if rest.size else 0.0, float(off.max()) - _RANGE]
    if 0 < 2 * lasts < off.size:
        largest = sliding_window_view(off, lasts).max(axis=1)[:-1]
        ways.append(float((0.5 * off[lasts:] - np.minimum.accumulate(largest)).max()))
    noise = white_noise(travel) / np.sqrt(2.0 * half + 1.0) / segment.stroke
    if max(ways) < max(_UNSTEADY, np.sqrt(2.0) * normal_sds(done.size**2) * noise):
        return ""
    return Remark("unsteady", way=in_digits(max(ways) * segment.stroke, 2))


def check_stroke(stroke: float, settings: Mapping) -> None:
    """Reject a stroke, mm, outside ``endurance.format.stroke``, by default that of drives."""
    least, most = settings["stroke"] or STROKES
    if not least <= stroke <= most:
        reading = stroke / TO_MM.get(settings["travel_unit"], 1.0)
        fits = [unit for unit, mm in TO_MM.items() if least <= reading * mm <= most]
        remedy = f"endurance.format.travel_unit ({fits[0]!r} fits)" if fits else "ratio"
        raise UnusableError(
            f"the stroke is {in_digits(stroke, 4)} mm, not between {least:g} and {most:g} mm, as "
            f"endurance.format.stroke and drives allow: did the breaker move? Check {remedy}"
        )


def open_rest(
    segment: Segment, settings: Mapping, motion: str, zero_sd: float | None = None
) -> tuple[float, str]:
    """Return the reading to subtract for an open breaker at rest, mm, and a remark if this rest is
    not where the settings state it, else "".

    If an opening still creeps at the end of its record, the reading is its farthest.

    Args:
        segment: The motion in its record.
        settings: The section ``endurance.format``, complete.
        motion: "closing" or "opening".
        zero_sd: Standard deviation of the zero that a model assumes, mm, if any.

    Raises:
        UnusableError: If the open breaker is far from zero.
    """
    seen, rest = True, segment.before
    if motion == "opening":
        seen, rest = segment.arrived and bool(np.isnan(segment.back)), segment.after
    if settings["zero"] == "rest":
        return rest, "" if seen else Remark("open-rest-unseen")
    if seen and abs(rest) > _FAR * segment.stroke:
        raise UnusableError(
            f"the open breaker rests at {rest:.2f} mm, not near 0: check endurance.format.sign, or "
            "set endurance.format.zero to rest or to its reading"
        )
    far = np.inf if zero_sd is None else normal_sds(1) * zero_sd + MATTERS * segment.stroke
    return 0.0, Remark("open-rest-off", rest=f"{rest:.2f}") if seen and abs(rest) > far else ""
