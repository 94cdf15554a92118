"""Samples that no sensor of this stroke can give: spikes, bursts, stuck readings, jumps, rails.

All limits come from the record itself: its noise and quantum, its stroke, and its greatest speed,
seen in a running median in which no burst is left. A contact that bounces or a damper that stops
the drive changes the speed, at most to its opposite. What is named here changes the *travel* faster
than any speed of the record allows, or stays where noise forbids it. Nothing is repaired.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from breaker.common.numerals import in_digits
from breaker.reading.records.curve_fits import (
    filled,
    running_mean,
    running_median,
    smoothed,
)
from breaker.reading.records.jumps import fitting, jumps
from breaker.reading.records.motion import white_noise

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
