"""Checks of a record: which samples no sensor of this stroke gives, and what only a whole shows.

Each check compares one statistic with its distribution under white noise, of the record's own
standard deviation, at the rate ``FALSE``; other limits are physical. Of the 684 files that are
accepted among 1,338 damaged ones (``studies.faults``, seed 11), these would be wrong in silence
without a check, or wrong at all where it leaves samples out:

- *spike*: a sample far from the median of five, 49;
- *jump*, *slip*: a step between lines through samples before and after a place, 38. The step of a
  jump is as large in twice the time; that of a bend grows;
- *clipped*: a top that the end of the range cuts off, 2;
- *open-rest-off*: the open breaker does not rest at zero, 4;
- *no-drive*, *stops-at-speed*: none, as the study states the stroke; without it, wrong units and a
  range that ends below the stroke show here alone.
"""

from collections.abc import Mapping

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from breaker.common.numerals import in_digits
from breaker.records.fits import filled, running_median, smoothed
from breaker.records.motion import Segment, white_noise
from breaker.records.rejections import FEWEST, MATTERS, Remark, UnusableError, normal_sds
from breaker.records.settings import TO_MM

STROKES = (2.0, 300.0)
"""Ways of drives, mm."""

SPEEDS = {"closing": (0.2, 6.0), "opening": (0.12, 14.0)}
"""Mean speeds of drives from 10 to 90 % of the way, m/s: half as fast again as closings that are
known, of 4 m/s, and openings, of 9 m/s."""

_LONGEST = 150.0  # ms, from 10 to 90 % of the way
_FORCE = 1.5  # mm/ms^2, square of the speed over the stroke: twice that of 9 m/s in 100 mm
_ABSURD = 1e6  # mm: arithmetic with more may overflow
_BURST = 5.0  # ms: longest disturbance that a running median hides
_ALIKE = 0.7, 4 / 3  # times the step of a time, that of twice the time; a bend doubles it at least
_LINE = 5  # samples of a line through samples beside a place
_FAR = 0.15, 0.08  # strokes from zero at which the open breaker is not that of the settings, or odd
_CALM = 0.7  # of the noise of one rest, that of another where a range ends
_STEADY = 0.7  # of what hides a swing: a damped drive of an HV breaker moves more after its stop
_AT_SPEED = 0.4  # of the greatest speed, at which no stop leaves a drive without a swing


# ---- samples -------------------------------------------------------------------------------------


def doubtful_samples(travel: np.ndarray, step: float, quantum: float) -> np.ndarray:
    """Say which samples no sensor can give, ``(t,) -> (t,)`` of text: their kind, or "".

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
    pace = stroke / speed if speed else np.inf  # samples of the stroke at the greatest speed
    sds, noise = normal_sds(travel.size), local_noise(filled(left), step)
    coarse = np.maximum(sds * noise + 0.2 * MATTERS * stroke, 2.5 * quantum)

    near = running_median(filled(left), 5)
    ways = sliding_window_view(np.diff(np.pad(near, 2, mode="edge")), 4)
    bends = np.maximum(np.ptp(ways, axis=1) - sds * noise, 0.0)
    kinds[np.abs(left - near) > coarse + bends] = "spike"
    kinds[_clipped(np.where(kinds == "", left, np.nan), quantum, noise, pace)] = "clipped"
    there = np.flatnonzero((kinds == "") & ~np.isnan(left))
    if speed == 0.0 or there.size < _LINE:
        return kinds
    left = np.where(kinds == "", left, np.nan)
    # Just after an impact a drive is 2.5 times as fast as over a millisecond.
    far = np.sqrt(2.0) * coarse[there[1:]] + 2.5 * speed * np.diff(there)
    apart = np.abs(np.diff(left[there])) > far
    apart |= _jumps(filled(left), noise, quantum, MATTERS * stroke, pace)[there[1:]]
    kept, slips = _fitting(left[there], apart, float(coarse.max()), stroke, pace)
    kinds[there[~kept]] = "jump"
    kinds[there[slips]] = "slip"
    return kinds


def local_noise(travel: np.ndarray, step: float) -> np.ndarray:
    """Return the sd of white noise about each sample, ``(t,)``, mm.

    It is that of the record, or of a time about the sample, whichever is larger: on some drives a
    reading is noisy while they move and steady at rest. A burst leaves no trace in such a time.
    """
    # Between samples that an instrument interpolates, the noise is hidden.
    noise = max(white_noise(travel[::each]) for each in (1, 2, 4) if each == 1 or each * step < 0.4)
    length = 4 * round(_BURST / step)
    local = np.full(travel.shape, noise)
    for first in range(0, travel.size - length - 1, max(length // 8, 1)):
        part = slice(first, first + length)
        local[part] = np.maximum(local[part], white_noise(travel[first : first + length + 2]))
    return local


def _steps(travel: np.ndarray, count: int, degree: int = 1) -> tuple[np.ndarray, float]:
    """Step before each sample between polynomials through samples beside it, and its sd by noise 1.

    0 near the ends.
    """
    at = (np.arange(2 * count) + 0.5) / count - 1.0
    weights = np.linalg.pinv(np.column_stack([np.vander(at, degree + 1), 0.5 * np.sign(at)]))[-1]
    steps = np.zeros(travel.size)
    steps[count : travel.size - count + 1] = np.convolve(travel, weights[::-1], "valid")
    return steps, float(np.linalg.norm(weights))


def _jumps(
    travel: np.ndarray, noise: np.ndarray, quantum: float, least: float, pace: float
) -> np.ndarray:
    """Say before which samples travel ``(n,)`` jumps, ``(n,)`` of bool.

    A jump is a step beyond noise that is there from one sample to the next, and as large in twice
    the time.
    """
    found, count = np.zeros(travel.size, dtype=bool), 2
    both = np.concatenate([[0.0], travel[2:] - travel[:-2], [0.0]])
    both = np.abs(both - running_median(both, 4 * _LINE + 1))
    sudden = np.maximum(both, np.append(0.0, both[:-1]))
    steps, sd = _steps(travel, count)
    while count <= max(0.15 * pace, 2.0) and travel.size >= 8 * count:
        longer, longer_sd = _steps(travel, 2 * count)
        own = np.maximum(noise * sd, 1.4826 * np.median(np.abs(steps)))  # of coloured noise, too
        limit = np.maximum(normal_sds(travel.size) * own, 1.5 * quantum) + least
        high = np.abs(steps)
        top = sliding_window_view(np.pad(high, count), 2 * count + 1).max(axis=1)
        share = longer / np.where(steps == 0.0, 1.0, steps)
        jump = (high > limit) & (high == top) & (sudden > 0.6 * high)
        found |= jump & (share > _ALIKE[0]) & (share < _ALIKE[1])
        count, steps, sd = 2 * count, longer, longer_sd
    return found


def _clipped(travel: np.ndarray, quantum: float, noise: np.ndarray, pace: float) -> np.ndarray:
    """Say which samples are at a top, or bottom, that the end of a range cuts off.

    On either side, in half the time of the top, travel falls by more than noise, and by more than
    a parabola that stays within a step.
    """
    clipped = np.zeros(travel.shape, dtype=bool)
    for side in (travel, -travel):
        at = np.flatnonzero(side == np.nanmax(side))
        first, last = int(at[0]), int(at[-1])
        half = (last - first) // 2
        if half < _LINE // 2 or half > min(pace, first, side.size - 1 - last, at.size):
            continue
        clear = normal_sds(travel.size) * max(quantum, float(noise[first]))
        if side[first] - max(side[first - half], side[last + half]) > clear:
            clipped[at] = True
    return clipped


def _fitting(
    travel: np.ndarray, apart: np.ndarray, coarse: float, stroke: float, pace: float
) -> tuple[np.ndarray, list[int]]:
    """Say which samples of a record go with its motions, and which of these follow a slip.

    Args:
        travel: Travel of the samples that are there, ``(k,)``, mm.
        apart: Behind which of them it jumps, ``(k - 1,)``.
        coarse: Distance of two samples by noise, mm.
        stroke, pace: Way between the rests, mm, and samples of it at the greatest speed.

    Returns:
        Whether each goes with them, ``(k,)``; and those before which it jumps all the same, since
        the drive moves there, or in what follows.
    """
    ends = np.flatnonzero(apart) + 1
    first, last = np.append(0, ends), np.append(ends, travel.size)
    kept, slips = np.zeros(travel.size, dtype=bool), []
    lead = max(_LINE, round(0.1 * pace))

    def goes_on(begin: int, end: int, edge: int) -> bool:
        """Whether samples behind an edge or before it are of a motion."""
        if end - begin < lead:
            return False
        beside = [travel[max(edge - lead, 0) : edge], travel[edge : edge + lead]]
        ways = [abs(np.median(each[-3:]) - np.median(each[:3])) for each in beside if each.size]
        moves = max(ways) > 0.02 * stroke + 0.25 * coarse
        slip = abs(leap_at(travel, edge, lead)) if 0 < edge < travel.size else 0.0
        low, high = np.quantile(travel[begin:end], [0.05, 0.95])
        # A mount that slips by more than a twentieth of the stroke holds no sensor.
        small = slip < 0.05 * stroke and ways[0] > MATTERS * stroke
        return high - low > 0.5 * stroke or moves or small

    # Of so many pieces none is a record, and their chain would take long.
    parts = [(0, first.size)] if first.size <= 400 else []
    while parts:
        begin, end = parts.pop()
        chain = begin + _chain(travel, first[begin:end], last[begin:end], (coarse, stroke, pace))
        for k in chain:
            kept[first[k] : last[k]] = True
        for low, high in ((begin, chain[0]), (chain[-1] + 1, end)):
            edge = first[chain[0]] if low == begin else first[low] if low < end else 0
            if low < high and goes_on(first[low], last[high - 1], edge):
                slips.append(int(edge))
                parts.append((low, high))
    return kept, slips


def _chain(
    travel: np.ndarray, first: np.ndarray, last: np.ndarray, sizes: tuple[float, float, float]
) -> np.ndarray:
    """Which pieces fit together, hold most motions and then most samples, in their order."""
    coarse, stroke, pace = sizes
    size = last - first
    moves = [np.ptp(travel[a:b]) >= 0.75 * stroke for a, b in zip(first, last, strict=True)]
    own = size + np.where(moves, travel.size, 0)
    motions = np.cumsum(np.logical_and(moves, size >= pace))  # none is left out between two
    most, before = own.copy(), np.full(first.size, -1)
    for i in range(2, first.size):
        gap = first[i] - last[: i - 1] + 1  # the next piece never fits: it is behind a jump
        back, on = np.minimum(gap, size[: i - 1] - 1), np.minimum(gap, size[i] - 1)
        left = np.abs(travel[last[: i - 1] - 1] - travel[last[: i - 1] - 1 - back])
        right = np.abs(travel[first[i]] - travel[first[i] + on])
        way = gap * (left / np.maximum(back, 1) + right / np.maximum(on, 1))
        off = np.abs(travel[first[i]] - travel[last[: i - 1] - 1])
        fits = (off <= coarse + 1.5 * way) & (motions[: i - 1] == motions[i - 1])
        chains = np.where(fits, most[: i - 1], 0)
        if chains.max() > 0:
            before[i] = chains.argmax()
            most[i] = own[i] + chains.max()
    chain = [int(most.argmax())]
    while before[chain[-1]] >= 0:
        chain.append(int(before[chain[-1]]))
    return np.array(chain[::-1])


def leap_at(travel: np.ndarray, place: int, count: int) -> float:
    """Return by how much travel ``(t,)``, mm, leaps at a sample, by lines through ``count`` each
    before and behind it.
    """
    there = np.flatnonzero(~np.isnan(travel))
    near = [there[there < place][-max(count, _LINE) :], there[there > place][: max(count, _LINE)]]
    if not all(each.size for each in near):
        return 0.0  # nothing before or behind it is left
    ends = [np.polyval(np.polyfit(k - place, travel[k], min(1, k.size - 1)), 0.0) for k in near]
    return float(ends[1] - ends[0])


def doubts_in_words(time: np.ndarray, travel: np.ndarray, kinds: np.ndarray) -> str:
    """Say which samples are doubtful: how many, what, when and by how much; "" if none is.

    Args:
        time, travel: Of the record, ``(n,)``, ms and mm.
        kinds: Of its samples, ``(n,)``, from ``doubtful_samples``.
    """
    bad = kinds != ""
    if not bad.any():
        return ""
    kept = np.flatnonzero(~bad & ~np.isnan(travel))
    begins, listed = np.flatnonzero(bad & (kinds != np.append("", kinds[:-1]))), []
    for first in begins[:4].tolist():
        last = first + int((np.append(kinds[first:], "") != kinds[first]).argmax()) - 1
        to = f" to {in_digits(time[last], 5)}" if last > first else ""
        near = kept[kept < first][-1:]
        size = f"{abs(travel[first] - travel[near[0]]):.3g} mm, " if near.size else ""
        at = f"{in_digits(time[first], 5)}{to} ms ({size}sample {first + 1})"
        listed.append(f"{kinds[first]} at {at}")
    more = f", and {begins.size - len(listed)} more places" if begins.size > len(listed) else ""
    return Remark("doubtful-samples", count=int(bad.sum()), places=", ".join(listed) + more)


# ---- whole records -------------------------------------------------------------------------------


def of_no_drive(motion: str, time: np.ndarray, done: np.ndarray, stroke: float) -> str:
    """Say why a motion is none of a breaker's drive, as in another unit; "" if it may be one.

    Args:
        motion: "closing" or "opening".
        time: Times, ``(t,)``, ms.
        done: Shares of the way that are done, ``(t,)``; nan where a sample is missing.
        stroke: Way between the rests, mm.
    """
    past = np.flatnonzero(done >= 0.9)
    low = np.flatnonzero(done[: past[0]] <= 0.1) if past.size else past
    if not low.size:
        return ""
    lasts = max(float(time[past[0]] - time[low[-1]]), float(time[1] - time[0]))
    speed = 0.8 * stroke / lasts
    least, most = SPEEDS[motion]
    if least <= speed <= most and lasts <= _LONGEST and speed**2 <= _FORCE * stroke:
        return ""
    about = {"stroke": stroke, "lasts": lasts, "speed": speed}
    return Remark("no-drive", motion=motion, **{k: in_digits(v, 3) for k, v in about.items()})


def check_stroke(stroke: float, settings: Mapping) -> None:
    """Refuse a stroke, mm, that is not between those of ``endurance.format.stroke``, or of drives.

    A unit that is wrong is wrong by far more than drives differ.
    """
    least, most = settings["stroke"] or STROKES
    if least <= stroke <= most:
        return
    still = "did the breaker not move, or " if stroke < least else ""
    given = [name for name in ("table", "ratio") if settings[name] is not None]
    hint = f"; {still}is endurance.format.{given[0]} wrong?" if given else ""
    for unit, mm in {} if given else TO_MM.items():
        if not hint and least <= stroke / TO_MM[settings["travel_unit"]] * mm <= most:
            hint = f"; {still}is endurance.format.travel_unit {unit!r}?"
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
    if seen and abs(rest) > _FAR[0] * segment.stroke:
        raise UnusableError(
            f"the open breaker rests at {rest:.2f} mm, not near 0; set endurance.format.zero to "
            "its reading, or to rest, or record the whole motion"
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
        zero_sd: Standard deviation of the zero that the model takes for granted, mm, if any.
        settles: Where the travel settles after the motion, and its sd, mm; NaN if not seen.
    """
    seen, rest = _open(segment, motion)
    if segment.speed < -_AT_SPEED:  # no drive rebounds so fast
        return Remark("ends-going-back", share=f"{-segment.speed:.0%}")
    if settings["zero"] == "rest" or not seen:
        return Remark("open-rest-unseen") if settings["zero"] == "rest" and not seen else ""
    clear = _FAR[1] * segment.stroke if zero_sd is None else normal_sds(1) * zero_sd
    off = clear
    if motion == "opening" and np.isfinite(settles[0]):
        rest, off = settles[0], clear + MATTERS * segment.stroke + 2.0 * settles[1]
    if abs(rest) > off:
        return Remark("open-rest-off", rest=f"{rest:.2f}")
    least, most = (0.0, 0.0) if motion == "closing" else settings["stroke"] or STROKES
    if least - clear <= segment.before <= most + clear:
        return ""
    return Remark("rest-before-off", rest=f"{segment.before:.2f}", motion=motion)


def _open(segment: Segment, motion: str) -> tuple[bool, float]:
    """Whether the open breaker is seen at rest, and where, mm."""
    if motion == "closing":
        return True, segment.before
    return segment.arrived and bool(np.isnan(segment.back)), segment.after


def range_remark(time: np.ndarray, travel: np.ndarray, moves: float, quantum: float = 0.0) -> str:
    """Say that the range of the transducer ends within the stroke; "" if nothing shows it.

    What stops a drive suddenly throws it back, and its noise is that of the sensor at both rests.
    So a stop at speed without a swing is none, nor one at a rest that is calmer than the other; a
    level that no noise leaves, where the other rest has some, is enough.

    Args:
        time: Times, ``(t,)``, ms, evenly spaced.
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
        moves: Time of the first motion, ms.
        quantum: Step of the reading, mm.
    """
    there = np.flatnonzero(~np.isnan(travel))
    if there.size < 4 * FEWEST:
        return ""
    time, travel = time[there], travel[there]
    sd = max(white_noise(travel), 0.4 * quantum)
    start, end = (float(np.median(each)) for each in (travel[:FEWEST], travel[-FEWEST:]))
    before = int((time < moves).sum()) - FEWEST
    if end == start or before < FEWEST:
        return ""
    way, near = (travel - start) / (end - start), max(5.0 * sd / abs(end - start), MATTERS)
    step, tenths = float(np.median(np.diff(time))), np.arange(0.1, 0.95, 0.1)
    sides = ("stops-at-speed", time, way), ("starts-at-speed", -time[::-1], 1.0 - way[::-1])
    for code, at, done in sides:
        stop = int((done >= 1.0 - near).argmax())
        marks = at[[int((done >= share).argmax()) for share in tenths]]
        fastest = (np.diff(tenths) / np.maximum(np.diff(marks), step)).max()
        speed = (done[stop] - tenths[-1]) / max(at[stop] - marks[-1], step) / fastest
        rest = done[stop + FEWEST :][-before:]
        other = done[:before]
        calm = _calmer(rest, other, quantum / abs(end - start))
        means = np.convolve(done[stop:] - 1.0, np.full(_LINE, 1.0 / _LINE), "valid")[1:]
        # A drive that its damper stops takes some samples from near its rest to there.
        flat = near <= 4.0 * MATTERS and means.size > 0 and np.abs(means).max() < _STEADY * near
        if (speed > _AT_SPEED and (calm or (flat and done is way))) or (
            calm and np.ptp(rest) == 0.0
        ):
            return Remark(code, at=in_digits(abs(at[stop]), 4), share=f"{speed:.0%}")
    return ""


def _calmer(rest: np.ndarray, other: np.ndarray, quantum: float) -> bool:
    """Whether third differences, in which slow motion is nothing, show less noise than others."""
    if min(rest.size, other.size) < 2 * FEWEST:
        return False
    own, noise = (np.sqrt(np.mean(np.square(np.diff(x, n=3))) / 20.0) for x in (rest, other))
    # Those of 2.31 n white samples know as much of their noise as n samples.
    chance = normal_sds(1) * np.sqrt(1.155 / rest.size + 1.155 / other.size)
    return bool(noise > quantum and own < noise * min(_CALM, np.exp(-chance)))
