"""Samples that no sensor of this stroke can give: spikes, bursts, stuck readings, jumps, rails.

All limits come from the record itself: its noise and quantum, its stroke, and its greatest speed,
seen in a running median in which no burst is left. A contact that bounces or a damper that stops
the drive changes the speed, at most to its opposite. What is named here changes the *travel* faster
than any speed of the record allows, or stays where noise forbids it. Nothing is repaired.

At a jump travel goes on elsewhere from one sample to the next, as no mass does. The step from a
sample to the next, or from a mean of samples to the next, is compared with the steps beside it: a
contact or a damper changes the speed, but between those before and after. Lost samples, a sensor
that slips and one that is disturbed make a step beyond them. The record falls into pieces where it
jumps.

Noise hides smaller slips of a transducer from a look at single samples. A drive that slows down
moves smoothly. Beside a cubic through the samples about a place, a slip is a step there, as large
in twice the time; a bend of the curve makes one that grows with the time.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from breaker.common.numerals import in_digits
from breaker.records.fits import (
    filled,
    running_mean,
    running_median,
    smoothed,
)
from breaker.records.motion import white_noise
from breaker.records.propagation import Trace

_ABSURD = 1e6  # mm, beyond every stroke: arithmetic with more may overflow
_FINE = 0.05  # ms, between samples of the running median
_BURST = 5.0  # ms, longest burst that leaves no trace in the running median
_LEAST = 5e-4  # strokes, that count
_STEPS = 12  # in the time of the longest burst
_LARGEST, _BACK = 0.3, 0.5  # of the way in such a time, a motion's largest step, and its way back
_RANGE = 0.5  # strokes, by which travel may be beyond its rest positions
_THINNED, _SOON = (1, 2, 4), 0.4  # every so many samples, no more than so many ms apart
_SPIKE = 6.0  # sd of the noise, from the median of five samples
_STRAIGHT = 4.0  # sd of the noise, by which steps of such medians differ within five
_JUMP = 9.0  # sd of the noise, from one sample to the next
_COUNTS = 2.5  # quanta: unseen noise moves a reading by two at most
_FASTER = 2.5  # times the greatest speed of the running median, that of an instant
_FASTEST = 1.0  # strokes in a ms
_BURSTS, _WITHIN = 3, 5  # disturbed samples that make a burst, each within so many of the next
_STUCK = 3  # equal samples, from which they may be stuck
_BESIDE = 20  # samples beside these, in which the drive then moves
_STILL = 10  # samples of a rest that are looked at together
_DENSE = 0.4  # share of these at an end of the range, from which it may be clipped
_CREEPS = 0.01  # share of samples that a slow motion makes leave their levels
_STEEP = 7.0  # quanta or sd, way beside a flat end of the range, half as far as this is long
_BENT = 0.1  # of noise more bends are followed by opposite ones than by like ones, by far
_RAIL = 10  # such samples in all
_BEYOND = 8.0  # samples that noise should have taken beyond, more than by chance
_EXACT = 1e-9  # of the range: less is the arithmetic's
_LISTED = 4  # places in a remark

_STEPS_BESIDE = 3  # steps before a step and after it, between which it is
_ROOM = 0.5  # times the range of these
_LONGER, _LONGEST = 2, 0.15  # times as long each; strokes at the greatest speed: time of means
_SDS, _FEW = 7.0, 10  # sd of such a mean, of few means more
_SUDDEN = 0.6  # of what means leap, that two samples do, or noise that hides it
_COUNTS_OF_JUMP = 1.5  # and quanta, by which means differ without a jump
_LEAST_JUMP = 0.003  # strokes, jump that counts
_PIECES = 400  # pieces that do not fit together, from which nothing is a record
_MOTION = 0.75  # strokes within a piece, which then holds the motion; of more pieces
_OFTEN = 0.5  # strokes, which then hold one
_SLIPS = 0.05  # strokes, by which a sensor slips: behind it is a rest that is not seen before
_REST, _STANDS = 0.25, 0.01  # strokes at the greatest speed, in which rests keep so many strokes
_GOES = (0.1, 0.02)  # strokes at the greatest speed, and strokes in that time from which it moves
_ONWARD = 1.5  # times the ways beside a gap as long: way within it
_LINE = 5  # samples of the lines that show how far a record leaps
_DEGREE = 3
_EACH, _BOTH = 4, 0.05  # samples on either side; of the time of the motion, at most
_CLEAR = 6.0  # sd of a step by noise, from which it is seen; of the thousands that are tried
_SHORT = 4.0  # sd of the step of the shorter time, from which that of twice the time may be clear
_RIPPLES = 2.0  # times the root mean square of a ripple, which makes steps, too
_ALIKE = 0.7, 4 / 3  # of a step, that of twice the time


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
    if (~np.isnan(left)).sum() < 5:
        return kinds
    every = max(1, round(_FINE / step))
    between = every * step
    smooth = smoothed(filled(left)[::every], max(1, round(_BURST / between)))
    low, high = smooth.min(), smooth.max()
    # Samples between which others were interpolated show noise that these hide.
    thinned = [left[::each] for each in _THINNED if each == 1 or each * step <= _SOON]
    noise = max(map(white_noise, thinned))
    stroke = high - low
    coarse = max(_JUMP * noise, _COUNTS * quantum)  # noise that is seen holds the rounding
    ends = _going_on(filled(left), round(_BURST / step), coarse)
    low, high = min([low, *ends]), max([high, *ends])
    margin = _RANGE * stroke + coarse
    leave_out((left < low - margin) | (left > high + margin), "out of range")
    lag = max(1, round(1.0 / between))
    speed = np.abs(smooth[lag:] - smooth[:-lag]).max(initial=0.0) / (lag * between)
    near = running_median(filled(left), 5)
    speeds = sliding_window_view(np.diff(np.pad(near, 2, mode="edge")), 4)
    bends = np.maximum(np.ptp(speeds, axis=1) - _STRAIGHT * noise, 0.0)
    seen = max(_SPIKE * noise + quantum, _COUNTS * quantum) + _LEAST * stroke
    leave_out(np.abs(left - near) > seen + bends, "spike")
    pace = stroke / (speed * step) if speed else np.inf
    leave_out(_clipped(left, quantum, stroke, pace), "clipped")
    coarse += _LEAST * stroke
    leave_out(_stuck(left, coarse, seen + speed * step), "stuck")
    there = np.flatnonzero(~np.isnan(left))
    if speed == 0.0 or there.size < 2:
        return kinds
    fastest = min(_FASTER * speed, _FASTEST * stroke) * step
    apart = np.abs(np.diff(left[there])) > coarse + fastest * np.diff(there)
    apart |= jumps(left, quantum, coarse, stroke, pace)
    kept, slips = fitting(left[there], apart, coarse, stroke, pace)
    leave_out(there[~kept], "jump")
    leave_out(there[slips], "slip")
    leave_out(_among(np.isin(kinds, ("spike", "jump")), round(_BURST / step)), "burst")
    return kinds


def _among(disturbed: np.ndarray, longest: int) -> np.ndarray:
    """Which samples lie between those of a burst, ``(t,)`` of bool.

    A burst has samples that are where the drive may be, by chance.
    """
    found, bad = np.zeros(disturbed.shape, dtype=bool), np.flatnonzero(disturbed)
    for group in np.split(bad, np.flatnonzero(np.diff(bad) > _WITHIN) + 1):
        if group.size >= _BURSTS and group[-1] - group[0] <= longest:
            found[group[0] : group[-1]] = True
    return found & ~disturbed


def doubts_in_words(time: np.ndarray, travel: np.ndarray, kinds: np.ndarray) -> str:
    """Say which samples are doubtful: how many, what, when and by how much; "" if none is.

    Args:
        time, travel: Of the record, ``(n,)``, ms and mm.
        kinds: Of its samples, ``(n,)``, from ``doubtful_samples``.
    """
    if not (kinds != "").any():
        return ""
    kept = np.flatnonzero((kinds == "") & ~np.isnan(travel))
    begins = np.flatnonzero((kinds != "") & (kinds != np.append("", kinds[:-1])))
    places = []
    for first in begins[:_LISTED].tolist():
        last = first + int((np.append(kinds[first:], "") != kinds[first]).argmax()) - 1
        to = f" to {in_digits(time[last], 5)}" if last > first else ""
        near = [(first, kept[kept < first][-1:]), (last, kept[kept > last][:1])]
        ways = [abs(travel[edge] - travel[other[0]]) for edge, other in near if other.size]
        size = f"{max(ways):.3g} mm, " if ways else ""
        places.append(
            f"{kinds[first]} at {in_digits(time[first], 5)}{to} ms ({size}sample {first + 1})"
        )
    more = f", and {begins.size - _LISTED} more places" if begins.size > _LISTED else ""
    count = int((kinds != "").sum())
    samples = "sample" if count == 1 else "samples"
    return f"{count} {samples} that no sensor of this stroke gives: {', '.join(places)}{more}"


def _going_on(travel: np.ndarray, count: int, coarse: float) -> list[float]:
    """Travel at an end of a record at which the drive still moves, which a running median hides.

    A motion goes one way in small steps; a burst jumps.
    """
    ends = []
    for part in (travel[: count + 3][::-1], travel[-count - 3 :]):
        side = running_median(part, 5)[-count - 1 :]
        side = side[:: -max(1, count // _STEPS)][::-1]
        steps, way = np.diff(side), float(side[-1] - side[0])
        back = float(np.abs(steps).sum()) - abs(way)
        if np.abs(steps).max(initial=0.0) < _LARGEST * abs(way) and back < coarse + _BACK * abs(
            way
        ):
            ends.append(float(side[-1]))
    return ends


def _runs(travel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First sample of each run of equal samples, and the one after its last."""
    ends = np.flatnonzero(np.diff(travel) != 0.0) + 1
    return np.append(0, ends), np.append(ends, travel.size)


def _clipped(travel: np.ndarray, quantum: float, stroke: float, pace: float) -> np.ndarray:
    """Which samples are at an end of the range, exactly, where noise must take some beyond, or
    where the travel comes and goes too fast for a top so flat.
    """
    low, high = np.nanmin(travel), np.nanmax(travel)
    first, last = _runs(travel)
    length = last - first
    steep = _STEEP * max(quantum, white_noise(travel)) + _LEAST * stroke
    sides = (
        travel[np.maximum(first - length // 2, 0)],
        travel[np.minimum(last + length // 2, travel.size) - 1],
    )
    clipped = np.zeros(travel.shape, dtype=bool)
    for rail, other in ((low, high), (high, low)):
        at = travel == rail
        dense = at & (running_mean(at.astype(float), _STILL + 1) > _DENSE)
        if dense.sum() < _RAIL:
            continue
        flat = (travel[first] == rail) & (length >= _RAIL) & (length <= pace)
        opposite = travel[np.abs(travel - other) < 0.1 * stroke]
        if (flat & (np.abs(np.subtract(sides, rail)) > steep).all(axis=0)).any() or (
            dense.sum() * _third_level(opposite, quantum) > _BEYOND
        ):
            clipped |= at
    return clipped


def _third_level(travel: np.ndarray, quantum: float) -> float:
    """Share of samples at rest that are at neither of the two levels that most are at.

    Noise that is small beside the quantum makes two levels at most, and one alone where that is far
    from the next. Noise that makes a third leaves any level at least as often.
    """
    second = np.diff(travel, n=2)
    if not np.sign(second[1:] * second[:-1]).sum() < -_BENT * second.size:
        return 0.0  # it goes smoothly
    blocks = travel[: travel.size // _STILL * _STILL].reshape(-1, 2, _STILL // 2)
    moved = np.diff(blocks.mean(axis=2))
    blocks = blocks.reshape(-1, _STILL) - moved * np.arange(_STILL) / (_STILL // 2)
    blocks = blocks[np.abs(moved[:, 0]) <= max(1.5 * quantum, white_noise(travel))]
    if not blocks.size:
        return 0.0
    off = (blocks[:, :, None] - blocks[:, None, :]) / max(quantum, _EXACT * np.ptp(travel))
    two = ((off > -0.5) & (off < 1.5)).sum(axis=1).max(axis=1)
    return float(1.0 - two.mean() / _STILL) - _CREEPS


def _stuck(travel: np.ndarray, coarse: float, least: float) -> np.ndarray:
    """Which samples repeat the one before, until the travel is suddenly elsewhere: by a least way,
    beside a motion that noise does not make.
    """
    first, last = _runs(travel)
    after = np.append(travel, np.nan)[last]
    stuck = np.zeros(travel.shape, dtype=bool)
    held = (last - first >= _STUCK) & (np.abs(after - travel[first]) > least)
    for begin, end in zip(first[held], last[held], strict=True):
        long = min(end - begin, _BESIDE)
        ways = travel[begin] - travel[max(begin - long, 0)], travel[end : end + long]
        if max(abs(ways[0]), np.ptp(ways[1])) <= coarse:
            continue  # at rest readings may be equal: it jumps
        stuck[begin + (begin > 0) : end] = True  # no reading before the first was a true one
    return stuck


def jumps(travel: np.ndarray, quantum: float, coarse: float, stroke: float, pace: float):
    """Say behind which samples travel jumps, ``(k - 1,)`` of bool for ``k`` samples that are there.

    Args:
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
        quantum: Step of the reading, mm.
        coarse: Difference of two samples that noise and quantum make, mm.
        stroke: Way between the rests, mm.
        pace: Samples in which the drive does this way at its greatest speed.
    """
    there = np.flatnonzero(~np.isnan(travel))
    gaps = np.diff(there)
    least = _LEAST_JUMP * stroke
    found = _beyond(np.diff(travel[there]) / gaps, 1) * gaps > coarse + least
    whole = filled(travel)
    length = 1
    while (length := _LONGER * length) <= max(_LONGEST * pace, 2) and whole.size >= 4 * length:
        total = np.append(0.0, np.cumsum(whole - whole[0]))
        means = (total[length:] - total[:-length]) / length
        sds = _SDS * (1.0 + _FEW * length / means.size)
        limit = max(sds * white_noise(means[::length]), _COUNTS_OF_JUMP * quantum) + least
        leaps = means[length:] - means[:-length]
        leap = _beyond(leaps, length)
        over = leap - limit
        over[:length] = over[-length:] = 0.0
        sudden = _sudden(travel[there], length) if over.max() > 0.0 else over
        while over[k := int(over.argmax())] > 0.0:
            over[max(k - length, 0) : k + length + 1] = 0.0
            place = max(int(np.searchsorted(there, k + length)) - 1, 0)
            near = slice(max(place - length, 0), place + length)
            if not found[near].any() and sudden[near].max(initial=0.0) > _SUDDEN * leap[k]:
                found[min(place, found.size - 1)] = True
    return found


def _sudden(travel: np.ndarray, length: int) -> np.ndarray:
    """By how much travel ``(k,)`` moves from a sample to the one after the next, beyond what is
    usual within so many samples, mm.
    """
    steps = np.append(travel[2:] - travel[:-2], [0.0, 0.0])
    return np.abs(steps - running_median(steps, 2 * length + 1))


def _beyond(steps: np.ndarray, length: int) -> np.ndarray:
    """By how much steps ``(n,)`` are beyond those beside them, so many samples apart, mm."""
    reach = _STEPS_BESIDE * length
    padded = np.pad(steps, reach, constant_values=np.nan)
    low = high = np.full(steps.size, np.nan)
    for shift in range(0, 2 * reach + 1, length):
        if shift != reach:
            beside = padded[shift : shift + steps.size]
            low, high = np.fmin(low, beside), np.fmax(high, beside)
    return np.maximum(steps - high, low - steps) - _ROOM * (high - low)


def fitting(
    travel: np.ndarray, apart: np.ndarray, coarse: float, stroke: float, pace: float
) -> tuple[np.ndarray, list[int]]:
    """Say which samples of a record go with its motions, and which of these follow a slip.

    Args:
        travel: Travel of the samples that are there, ``(k,)``, mm.
        apart: Behind which of them it jumps, ``(k - 1,)``.
        coarse, stroke, pace: As of ``jumps``.

    Returns:
        Whether each goes with them, ``(k,)``; and those before which it jumps all the same, since
        there is a motion before as behind, or within.
    """
    ends = np.flatnonzero(apart) + 1
    first, last = np.append(0, ends), np.append(ends, travel.size)
    kept, slips = np.zeros(travel.size, dtype=bool), []
    lead = max(_LINE, round(_GOES[0] * pace))

    def goes_on(begin: int, end: int, edge: int) -> bool:
        """Whether samples from one to another, behind an edge or before it, are of a motion."""
        if end - begin < lead:
            return False
        if (
            0 < edge < travel.size
            and abs(leap_at(travel, edge, lead)) < _SLIPS * stroke
            and not _rests(travel[:edge], max(lead, round(_REST * pace)), stroke)
        ):
            return True
        low, high = np.quantile(travel[begin:end], [0.05, 0.95])
        beside = [travel[max(edge - lead, 0) : edge], travel[edge : edge + lead]]
        ways = [abs(np.median(each[-3:]) - np.median(each[:3])) for each in beside if each.size]
        return high - low > _OFTEN * stroke or max(ways) > _GOES[1] * stroke + 0.25 * coarse

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


def _rests(travel: np.ndarray, count: int, stroke: float) -> bool:
    """Whether the last samples, so many, are of a rest."""
    thirds = np.array_split(travel[-count:], 3)
    return np.ptp([np.median(each) for each in thirds if each.size]) < _STANDS * stroke


def _chain(
    travel: np.ndarray, first: np.ndarray, last: np.ndarray, sizes: tuple[float, float]
) -> np.ndarray:
    """Which pieces fit together, hold most motions and then most samples, in their order.

    What is left out between them is no motion of the drive, which takes its time.
    """
    coarse, stroke, pace = sizes
    size = last - first
    moves = [np.ptp(travel[a:b]) >= _MOTION * stroke for a, b in zip(first, last, strict=True)]
    most = size + np.where(moves, travel.size, 0)
    motions = np.cumsum(np.logical_and(moves, size >= pace))
    own, before = most.copy(), np.full(first.size, -1)
    for i in range(2, first.size):
        gap = first[i] - last[: i - 1] + 1  # the next piece never fits: it is behind a jump
        back = np.minimum(gap, size[: i - 1] - 1)
        on = np.minimum(gap, size[i] - 1)
        left = np.abs(travel[last[: i - 1] - 1] - travel[last[: i - 1] - 1 - back])
        right = np.abs(travel[first[i]] - travel[first[i] + on])
        way = gap * (left / np.maximum(back, 1) + right / np.maximum(on, 1))
        off = np.abs(travel[first[i]] - travel[last[: i - 1] - 1])
        fits = (off <= coarse + _ONWARD * way) & (motions[: i - 1] == motions[i - 1])
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
    count = max(count, _LINE)
    there = np.flatnonzero(~np.isnan(travel))
    near = there[there < place][-count:], there[there > place][:count]
    if not all(each.size for each in near):
        return 0.0  # nothing before or behind it is left
    ends = [np.polyval(np.polyfit(k - place, travel[k], min(1, k.size - 1)), 0.0) for k in near]
    return float(ends[1] - ends[0])


def hidden_slip(trace: Trace, arrival: float) -> tuple[int, float] | None:
    """Return the clearest slip after a motion's arrival that is not among the trace's own.

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
    tried = list(_steps(trace))
    least = max(_LEAST_JUMP * trace.stroke, _RIPPLES * trace.ripple)
    best, found = _CLEAR, None
    for (count, steps, sd), (_, longer, longer_sd) in pairwise(tried):
        low, high = np.sort([share * steps for share in _ALIKE], axis=0)
        alike = (longer > low) & (longer < high) & (np.abs(steps) > max(least, _SHORT * sd))
        clear = np.where(alike, np.maximum(np.abs(steps) / sd, np.abs(longer) / longer_sd), 0.0)
        clear[: np.searchsorted(trace.time, arrival)] = 0.0
        for place, _ in trace.slips:
            clear[max(place - 2 * count, 0) : place + 2 * count] = 0.0
        place = int(clear.argmax())
        if clear[place] > best:
            best, found = clear[place], (place, float(steps[place]))
    return found


def _steps(trace: Trace) -> Iterator[tuple[int, np.ndarray, float]]:
    """Samples on either side, the step before each sample beside a cubic through these, ``(n,)``,
    mm, and its sd by noise; of more and more samples, twice as many as the longest at last.
    """
    travel, count = filled(trace.travel), _EACH
    if not trace.noise:
        return  # it hides nothing
    noise = max(trace.noise, white_noise(travel)) * float(np.sqrt(trace.alike))
    longest = max(_BOTH * trace.duration / trace.step, _EACH)
    while count <= 2.0 * longest and travel.size > 2 * count:
        at = (np.arange(2 * count) + 0.5) / count - 1.0
        shapes = np.column_stack([np.vander(at, _DEGREE + 1), 0.5 * np.sign(at)])
        weights = np.linalg.pinv(shapes)[-1]
        steps = np.zeros(travel.size)
        steps[count : travel.size - count + 1] = np.convolve(travel, weights[::-1], "valid")
        yield count, steps, noise * float(np.linalg.norm(weights))
        count *= 2
