"""Checks of a record: which samples no sensor of this stroke gives, and what only a whole shows.

Each check compares one statistic with its distribution under white noise, of the record's own
standard deviation, at one false-alarm rate for a record, ``FALSE``. Other limits are physical: a
drive has a mass, so that travel is continuous, and its free swings decay.

- *spike*: the distance of a sample from the median of five;
- *jump*, *slip*: the step between two lines, through samples before and after a place. The step of
  a jump is as large in twice the time, and stays at its place; that of a bend grows;
- *burst*: what lies between several spikes;
- *clipped*: a top that the end of the range cuts off.

These samples are left out. The other checks give remarks: readings that come twice, noise in one
place alone, a swing that grows at rest, a stop at speed. Nothing is repaired.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from breaker.common.numerals import in_digits
from breaker.records.fits import filled, running_mean, running_median, smoothed
from breaker.records.motion import Segment, white_noise
from breaker.records.propagation import Trace
from breaker.records.rejections import Remark, UnusableError
from breaker.records.settings import TO_MM

FALSE = 1e-3
"""Share of good records in which a check of samples leaves one out, or a check has a remark."""

STROKES = (2.0, 300.0)
"""Ways of drives, mm."""

SPEEDS = {"closing": (0.2, 6.0), "opening": (0.12, 14.0)}
"""Mean speeds of drives from 10 to 90 % of the way, m/s: half as fast again as closings that are
known, of 4 m/s, and openings, of 9 m/s."""

_ABSURD = 1e6  # mm: arithmetic with more may overflow
_BURST = 5.0  # ms: longest disturbance that a running median hides
_COUNTS = 2.5  # quanta: noise that is not seen moves a rounded reading by two at most
_MATTERS = 0.003  # strokes: smaller errors change no quantity by more than its usual error
_FASTER = 2.5  # times the greatest speed over a millisecond: that of an instant after an impact
_ALIKE = 0.7, 4 / 3  # times the step of a time, that of twice the time; a bend doubles it at least
_LINE = 5  # samples of a line through samples beside a place
_PIECES = 400  # pieces that do not fit together, from which nothing is a record
_SLIPS = 0.05  # strokes: a mount that slips further holds no sensor
_FAR = 0.15  # strokes from zero at which the open breaker is not the one of the settings
_CALM = 12  # samples whose noise is compared: of fewer, a stop at the end of a stroke is noise


def _sds(count: int) -> float:
    """Standard deviations that the largest of so many normal values exceeds at the rate FALSE."""
    from statistics import NormalDist

    return -NormalDist().inv_cdf(0.5 * FALSE / max(count, 1))


# ---- samples -------------------------------------------------------------------------------------


def doubtful_samples(travel: np.ndarray, step: float, quantum: float) -> np.ndarray:
    """Say which samples no sensor can give, ``(t,) -> (t,)`` of text: their kind, or "".

    Args:
        travel: Travel, ``(t,)``, mm, evenly spaced; NaN where a sample is missing.
        step: Time between two samples, ms.
        quantum: Step to which readings are rounded, mm; 0 if they are not.
    """
    kinds, left = np.full(travel.shape, "", dtype="U12"), travel.copy()

    def leave_out(which: np.ndarray, kind: str) -> None:
        kinds[which], left[which] = kind, np.nan

    leave_out(np.abs(travel) > _ABSURD, "out of range")
    if (~np.isnan(left)).sum() < _LINE:
        return kinds
    every = max(1, round(0.01 * _BURST / step))
    smooth = smoothed(filled(left)[::every], max(1, round(_BURST / (every * step))))
    stroke, lag = float(np.ptp(smooth)), max(1, round(1.0 / (every * step)))
    speed = np.abs(smooth[lag:] - smooth[:-lag]).max(initial=0.0) / (lag * every)  # mm a sample
    pace = stroke / speed if speed else np.inf  # samples of the stroke at the greatest speed
    sds, noise = _sds(travel.size), local_noise(filled(left), step)
    coarse = np.maximum(sds * noise + 0.2 * _MATTERS * stroke, _COUNTS * quantum)

    near = running_median(filled(left), 5)
    ways = sliding_window_view(np.diff(np.pad(near, 2, mode="edge")), 4)
    bends = np.maximum(np.ptp(ways, axis=1) - sds * noise, 0.0)
    leave_out(np.abs(left - near) > coarse + bends, "spike")
    leave_out(_clipped(left, quantum, noise, pace), "clipped")
    there = np.flatnonzero(~np.isnan(left))
    if speed == 0.0 or there.size < _LINE:
        return kinds
    gaps = np.diff(there)
    apart = np.abs(np.diff(left[there])) > np.sqrt(2.0) * coarse[there[1:]] + _FASTER * speed * gaps
    apart |= _jumps(filled(left), noise, quantum, _MATTERS * stroke, pace)[there[1:]]
    apart |= _stuck(left[there], apart, coarse[there])
    kept, slips = _fitting(left[there], apart, float(coarse.max()), stroke, pace)
    leave_out(there[~kept], "jump")
    leave_out(there[slips], "slip")
    leave_out(_among(np.isin(kinds, ("spike", "jump")), round(_BURST / step)), "burst")
    return kinds


def local_noise(travel: np.ndarray, step: float) -> np.ndarray:
    """Return the sd of white noise about each sample, ``(t,)``, mm.

    It is that of the record, or of a time about the sample, whichever is larger: on some drives a
    reading is noisy while they move and steady at rest. A burst leaves no trace in such a time.
    """
    # Between samples that an instrument interpolates, the noise is hidden.
    noise = max(white_noise(travel[::each]) for each in (1, 2, 4) if each == 1 or each * step < 0.4)
    length = 4 * round(_BURST / step)
    second = np.abs(np.diff(travel, n=2))
    local = np.full(travel.shape, noise)
    for first in range(0, second.size - length + 1, max(length // 8, 1)):
        part = slice(first, first + length)
        own = np.median(second[part]) / (0.6745 * np.sqrt(6.0))
        local[part] = np.maximum(local[part], own)
    return local


def _steps(travel: np.ndarray, count: int, degree: int = 1) -> tuple[np.ndarray, float]:
    """Step before each sample, between polynomials through so many samples before and behind.

    Returns:
        Steps, ``(n,)``, mm, 0 near the ends; and their sd for white noise of sd 1.
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
    both = np.append(0.0, travel[2:] - travel[:-2])
    both = np.abs(np.append(both, 0.0) - running_median(np.append(both, 0.0), 4 * _LINE + 1))
    sudden = np.maximum(both, np.append(0.0, both[:-1]))
    steps, sd = _steps(travel, count)
    while count <= max(0.15 * pace, 2.0) and travel.size >= 8 * count:
        longer, longer_sd = _steps(travel, 2 * count)
        own = np.maximum(noise * sd, 1.4826 * np.median(np.abs(steps)))  # of coloured noise, too
        limit = np.maximum(_sds(travel.size) * own, 1.5 * quantum) + least
        high = np.abs(steps)
        top = sliding_window_view(np.pad(high, count), 2 * count + 1).max(axis=1)
        share = longer / np.where(steps == 0.0, 1.0, steps)
        jump = (high > limit) & (high == top) & (sudden > 0.6 * high)
        found |= jump & (share > _ALIKE[0]) & (share < _ALIKE[1])
        count, steps, sd = 2 * count, longer, longer_sd
    return found


def _clipped(travel: np.ndarray, quantum: float, noise: np.ndarray, pace: float) -> np.ndarray:
    """Say which samples are at a top, or bottom, that the end of a range cuts off.

    The travel leaves the last level on either side, in half the time that it stays there, by far
    more than the parabola does that stays within a step.
    """
    clipped = np.zeros(travel.shape, dtype=bool)
    for side in (travel, -travel):
        at = side == np.nanmax(side)
        ends = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int)))
        longest = int((ends[1::2] - ends[::2]).argmax())
        first, last = ends[2 * longest], ends[2 * longest + 1] - 1
        half = max((last - first) // 2, 1)
        if last - first < _LINE or half > pace or min(first, side.size - 1 - last) < half:
            continue
        clear = 7.0 * max(quantum, float(noise[first]))
        if side[first] - max(side[first - half], side[last + half]) > clear:
            clipped |= at
    return clipped


def _stuck(travel: np.ndarray, apart: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """Say behind which samples a reading stays until it jumps, ``(k - 1,)``; the drive moves."""
    stuck, same = np.zeros(apart.shape, dtype=bool), np.append(np.diff(travel) == 0.0, False)
    for end in np.flatnonzero(apart).tolist():
        begin = end - int((~same[end - 1 :: -1]).argmax()) if end else 0
        long = min(end - begin, 4 * _LINE)
        ways = travel[begin] - travel[max(begin - long, 0)], np.ptp(travel[end + 1 :][: long + 1])
        if long > 1 and max(abs(ways[0]), ways[1]) > coarse[end]:
            stuck[begin] = True
    return stuck


def _among(disturbed: np.ndarray, longest: int) -> np.ndarray:
    """Say which samples lie between those of a burst, where the drive may be by chance alone."""
    found, bad = np.zeros(disturbed.shape, dtype=bool), np.flatnonzero(disturbed)
    for group in np.split(bad, np.flatnonzero(np.diff(bad) > _LINE) + 1):
        if group.size > 2 and group[-1] - group[0] <= longest:
            found[group[0] : group[-1]] = True
    return found & ~disturbed


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
        small = abs(leap_at(travel, edge, lead)) < _SLIPS * stroke if 0 < edge < travel.size else 0
        low, high = np.quantile(travel[begin:end], [0.05, 0.95])
        return high - low > 0.5 * stroke or moves or (small and ways[0] > _MATTERS * stroke)

    parts = [(0, first.size)] if first.size <= _PIECES else []
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
    """Return by how much travel ``(t,)``, mm, leaps at a sample, by lines before and behind it.

    Args:
        count: Samples of each line; a few at least are taken.
    """
    there = np.flatnonzero(~np.isnan(travel))
    near = [there[there < place][-max(count, _LINE) :], there[there > place][: max(count, _LINE)]]
    if not all(each.size for each in near):
        return 0.0  # nothing before or behind it is left
    ends = [np.polyval(np.polyfit(k - place, travel[k], min(1, k.size - 1)), 0.0) for k in near]
    return float(ends[1] - ends[0])


def hidden_slip(trace: Trace, arrival: float) -> tuple[int, float] | None:
    """Return the clearest slip after a motion's arrival that is not among the trace's own.

    A drive that slows down moves smoothly, so that cubics through the samples beside a place show
    smaller steps than single samples do.

    Args:
        arrival: Time from which the drive slows down, ms.

    Returns:
        The sample from which on the travel is elsewhere, and by how much, mm; None without one.

    Example:
        >>> time = np.arange(0.0, 100.0, 0.1)
        >>> way = 150.0 * np.sin(0.5 * np.pi * np.clip(time / 50.0, 0.0, 1.0))
        >>> way += 0.1 * np.random.default_rng(1).standard_normal(time.size)
        >>> trace = Trace(time, way + 1.2 * (time > 45.0), 0.1, 0.0, 0.0, 35.0, 150.0)
        >>> sample, size = hidden_slip(trace, 35.0)
        >>> bool(abs(time[sample] - 45.0) < 0.5 and abs(size - 1.2) < 0.3)
        True
        >>> hidden_slip(Trace(time, way, 0.1, 0.0, 0.0, 35.0, 150.0), 35.0) is None
        True
    """
    least = max(_MATTERS * trace.stroke, 2.0 * trace.ripple)  # a ripple makes steps, too
    best, found = 1.25 * _sds(trace.time.size), None  # several times are tried
    for (count, steps, sd), (_, longer, longer_sd) in pairwise(_of_trace(trace)):
        low, high = np.sort([share * steps for share in _ALIKE], axis=0)
        alike = (longer > low) & (longer < high) & (np.abs(steps) > np.maximum(least, 4.0 * sd))
        clear = np.where(alike, np.maximum(np.abs(steps) / sd, np.abs(longer) / longer_sd), 0.0)
        clear[: np.searchsorted(trace.time, arrival)] = 0.0
        for place, _ in trace.slips:
            clear[max(place - 2 * count, 0) : place + 2 * count] = 0.0
        place = int(clear.argmax())
        if clear[place] > best:
            best, found = clear[place], (place, float(steps[place]))
    return found


def _of_trace(trace: Trace) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Samples on either side, steps between cubics and their sd; of more and more samples."""
    travel, count = filled(trace.travel), 4
    noise = np.sqrt(trace.alike) * np.maximum(trace.noise, local_noise(travel, trace.step))
    longest = max(0.05 * trace.duration / trace.step, 4)
    while trace.noise and count <= 2.0 * longest and travel.size > 2 * count:
        steps, sd = _steps(travel, count, 3)
        yield count, steps, noise * sd
        count *= 2


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
        near = [(first, kept[kept < first][-1:]), (last, kept[kept > last][:1])]
        ways = [abs(travel[edge] - travel[other[0]]) for edge, other in near if other.size]
        size = f"{max(ways):.3g} mm, " if ways else ""
        at = f"{in_digits(time[first], 5)}{to} ms ({size}sample {first + 1})"
        listed.append(f"{kinds[first]} at {at}")
    more = f", and {begins.size - len(listed)} more places" if begins.size > len(listed) else ""
    return Remark("doubtful-samples", count=int(bad.sum()), places=", ".join(listed) + more)


# ---- whole records -------------------------------------------------------------------------------


def of_no_drive(motion: str, time: np.ndarray, done: np.ndarray, stroke: float) -> str:
    """Say why a motion is none of a breaker's drive; "" if it may be one.

    Far beyond the ranges of drives a record is in another unit or at another rate.

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
    # The square of the speed over the stroke is an acceleration: 9 m/s in 100 mm have 0.8 mm/ms^2.
    if least <= speed <= most and 0.5 <= lasts <= 150.0 and speed**2 <= 1.5 * stroke:
        return ""
    about = {"stroke": stroke, "lasts": lasts, "speed": speed}
    return Remark("no-drive", motion=motion, **{k: in_digits(v, 3) for k, v in about.items()})


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
        zero_sd: Standard deviation of the zero that the model takes for granted, mm. With it, the
            rest before the motion is compared: it is at 0, or a stroke of
            ``endurance.format.stroke`` from it.
        settles: Where the travel settles after the motion, and how well that is known, mm; NaN
            where it is not seen.
    """
    seen, rest = _open(segment, motion)
    if segment.speed < -0.4:  # no drive rebounds at more than that share of its greatest speed
        return Remark("ends-going-back", share=f"{-segment.speed:.0%}")
    if settings["zero"] == "rest" or not seen:
        return Remark("open-rest-unseen") if settings["zero"] == "rest" and not seen else ""
    clear = np.inf if zero_sd is None else _sds(1) * zero_sd
    off = clear + 0.005 * segment.stroke  # an opening that settles is so far from its rest
    settled, error = settles[0], 2.0 * settles[1]
    highest = min(max(rest, settled), settled + error)  # it may creep on, but not from below
    if motion == "opening" and (highest < -off or settled - error > off):
        return Remark("open-rest-off", rest=f"{rest if np.isnan(settled) else settled:.2f}")
    if abs(rest) > (0.04 if motion == "closing" else 0.08) * segment.stroke:
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
    own = max(1.4826 * float(np.median(np.abs(third))), 0.4 * quantum)  # of a last digit
    sd = max(sd, own, 1e-9 * float(np.ptp(travel)))
    found = [
        _repeated(time, travel),
        _unrest(time, third, sd),
        _grows(time, travel, moves, sd),
        _at_speed(time, travel, moves, sd, quantum),
    ]
    return [words for words in found if words]


def _repeated(time: np.ndarray, travel: np.ndarray) -> str:
    """Readings that come twice, one stretch like another, as samples that are sent twice."""
    tied = np.diff(travel) == 0.0
    # Where a counter rests, its readings are equal; where nothing is rounded, hardly any two are.
    ties = max(1e-4, *(float(part.mean()) for part in (tied, tied[:50], tied[-50:])))
    length = np.log(1e-3 * FALSE / travel.size**2) / np.log(ties) if ties < 1.0 else np.inf
    if length > min(64, travel.size // 4):
        return ""
    windows = np.ascontiguousarray(sliding_window_view(travel, int(np.ceil(length))))
    rows = windows.view(np.dtype((np.void, windows.strides[0]))).ravel()
    first, counts = np.unique(rows, return_index=True, return_counts=True)[1:]
    if (counts == 1).all():
        return ""
    begin = int(first[counts > 1].min())
    again = begin + 1 + int((rows[begin + 1 :] == rows[begin]).argmax())
    return Remark("repeated", first=in_digits(time[begin], 4), again=in_digits(time[again], 4))


def _unrest(time: np.ndarray, third: np.ndarray, sd: float) -> str:
    """Noise of third differences in a short stretch; a stop changes a few of them alone.

    So many samples exceed 3.9 times the noise of the record at the rate FALSE, by simulation.
    """
    local = 1.4826 * np.median(sliding_window_view(np.abs(third), _CALM), axis=1)
    most = int(local.argmax())
    if local[most] <= 3.9 * sd:
        return ""
    return Remark("noisy-there", noise=in_digits(local[most], 2), at=in_digits(time[most], 4))


def _grows(time: np.ndarray, travel: np.ndarray, moves: float, sd: float) -> str:
    """A swing at the rest after the motion that grows: those of a drive decay."""
    start, end = (float(np.median(each)) for each in (travel[:_CALM], travel[-_CALM:]))
    arrival = time[int((np.abs(travel - start) >= 0.9 * abs(end - start)).argmax())]
    rest = np.flatnonzero(time >= arrival)
    blocks = travel[rest[: rest.size // _CALM * _CALM]].reshape(-1, _CALM).mean(axis=1)
    # A swing takes less than twice the time of the motion from one turn to the next.
    swing = int(2.0 * (arrival - moves) / (_CALM * (time[1] - time[0]))) + 1
    if blocks.size < swing + 2:
        return ""
    off = np.abs(blocks - np.median(blocks[swing:]))
    before = sliding_window_view(off[:-1], swing).max(axis=1)
    noise = _sds(off.size) * sd * np.sqrt(2.0 / _CALM) + _MATTERS * abs(end - start)
    grows = off[swing:] - before - noise
    if grows.max() <= 0.0:
        return ""
    k = swing + int(grows.argmax())
    at = time[rest[0] + k * _CALM]
    return Remark("grows", way=in_digits(off[k], 2), at=in_digits(at, 4))


def _at_speed(time: np.ndarray, travel: np.ndarray, moves: float, sd: float, quantum: float) -> str:
    """A stop at speed without any swing, or a stop or start at speed at a rest that is calmer than
    the other: the end of the range, whatever noise lies on it.

    What stops a drive so suddenly throws it back, and its noise is that of the sensor at both
    rests.
    """
    start, end = (float(np.median(each)) for each in (travel[:_CALM], travel[-_CALM:]))
    if end == start:
        return ""
    done, noise = (travel - start) / (end - start), sd / abs(end - start)
    before = int((time < moves).sum())
    stop, last = _stop(time, done, noise)
    begin, first = _stop(-time[::-1], 1.0 - done[::-1], noise)
    rests = travel[: before - _CALM], travel[max(stop + _CALM, travel.size - before) :]
    calm = _calmer(*rests, quantum)
    flat = [each.size > 0 and np.ptp(each) == 0.0 for each in rests]  # noise leaves no level alone
    if (last > 0.4 and (calm > 0 or _no_swing(done[stop:], noise))) or (calm > 0 and flat[1]):
        return Remark("stops-at-speed", at=in_digits(time[stop], 4), share=f"{last:.0%}")
    if calm < 0 and (first > 0.4 or flat[0]):
        return Remark("starts-at-speed", at=in_digits(time[::-1][begin], 4), share=f"{first:.0%}")
    return ""


def _stop(time: np.ndarray, done: np.ndarray, noise: float) -> tuple[int, float]:
    """Sample at which a way, from 0 to 1, is gone but for noise, and the share of the greatest
    speed of a tenth of it that is left in the last.
    """
    tenths = np.arange(0.1, 0.95, 0.1)
    stop = int((done >= 1.0 - max(5.0 * noise, _MATTERS)).argmax())
    marks = time[[int((done >= share).argmax()) for share in tenths]]
    step = float(np.median(np.diff(time)))
    speeds = np.diff(tenths) / np.maximum(np.diff(marks), step)
    return stop, (done[stop] - tenths[-1]) / max(time[stop] - marks[-1], step) / speeds.max()


def _no_swing(done: np.ndarray, noise: float) -> bool:
    """Whether a way ``(n,)`` from its stop on is 1 at once, in noise that hides no swing."""
    rest, near = running_mean(done - 1.0, _LINE)[_LINE // 2 + 1 :], max(5.0 * noise, _MATTERS)
    return near <= 4.0 * _MATTERS and rest.size >= _CALM and np.abs(rest).max() <= 0.7 * near


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
        # Third differences of 2.31 n white samples know as much of their noise as n samples.
        chance = _sds(1) * np.sqrt(0.5 / calm.size + 0.5 * 2.31 / other.size)  # of the logarithm
        if noise > quantum and np.log(noise / max(least, 0.1 * noise)) > max(0.2, 1.2 * chance):
            return sign
    return 0
