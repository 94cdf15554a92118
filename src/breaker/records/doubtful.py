"""Samples that no sensor of this stroke can give: spikes, bursts, stuck readings, jumps, rails.

All limits come from the record itself: its noise and quantum, its stroke, and its greatest speed,
seen in a running median in which no burst is left. A contact that bounces or a damper that stops
the drive changes the speed, at most to its opposite. What is named here changes the *travel* faster
than any speed of the record allows, or stays where noise forbids it. Nothing is repaired.
"""

import numpy as np

from breaker.records.running import filled, running_median

__all__ = ["doubtful_samples", "doubts_in_words"]

_ABSURD = 1e6  # mm, beyond every stroke: arithmetic with more may overflow
_BLOCK = 0.5  # ms, whose median stands for it
_ENDS = 3  # blocks at an end of a record, whose median stands for the outermost
_BURST = 5.0  # ms, longest burst that leaves no trace in the running median
_RANGE = 0.5  # strokes, by which travel may be beyond its rest positions
_SPIKE = 7.0  # sd of the noise, from the median of five samples
_JUMP = 9.0  # sd of the noise, from one sample to the next
_COUNTS = 2.5  # quanta: unseen noise moves a reading by two at most
_FASTER = 2.5  # times the greatest speed of the running median, that of an instant
_FASTEST = 1.0  # strokes in a ms
_STUCK = 3  # equal samples, from which they may be stuck
_RAIL = 10  # equal samples at an end of the range, from which it may be clipped
_NOISY = 5e-4  # strokes, at 10 kHz: noise at one end that a sensor should have at the other
_PIECES = 400  # pieces that do not fit together, from which nothing is a record
_LISTED = 4  # places in a remark
_MOTION = 0.75  # strokes within a piece, which then holds the motion


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
    smooth, between = _smooth(left, step)
    low, high, noise = smooth.min(), smooth.max(), _noise(left)
    stroke = high - low
    margin = _RANGE * stroke + _JUMP * noise + _COUNTS * quantum
    leave_out((left < low - margin) | (left > high + margin), "out of range")
    lag = max(1, round(1.0 / between))
    speed = np.abs(smooth[lag:] - smooth[:-lag]).max(initial=0.0) / (lag * between)
    near = running_median(filled(left), 5)
    rounded = _COUNTS * quantum
    leave_out(np.abs(left - near) > _SPIKE * noise + rounded + 2.0 * speed * step, "spike")
    least = max(_NOISY * stroke * max(1.0, step / 0.1), quantum)
    leave_out(_clipped(left, least, stroke), "clipped")
    coarse = _JUMP * noise + rounded
    leave_out(_stuck(left, coarse + 2.0 * speed * step), "stuck")
    fastest = min(_FASTER * speed, _FASTEST * stroke) * step
    leave_out(_apart(left, coarse, fastest, _MOTION * stroke), "jump")
    return kinds


def doubts_in_words(time: np.ndarray, travel: np.ndarray, kinds: np.ndarray) -> str:
    """Say which samples are doubtful: how many, what, when and by how much; "" if none is.

    Args:
        time, travel: Of the record, ``(n,)``, ms and mm.
        kinds: Of its samples, ``(n,)``, from ``doubtful_samples``.
    """
    if not kinds.any():
        return ""
    kept = np.flatnonzero((kinds == "") & ~np.isnan(travel))
    begins = np.flatnonzero((kinds != "") & (kinds != np.append("", kinds[:-1])))
    places = []
    for first in begins[:_LISTED].tolist():
        last = first + int((np.append(kinds[first:], "") != kinds[first]).argmax()) - 1
        to = f" to {time[last]:.5g}" if last > first else ""
        near = [(first, kept[kept < first][-1:]), (last, kept[kept > last][:1])]
        ways = [abs(travel[edge] - travel[other[0]]) for edge, other in near if other.size]
        size = f"{max(ways):.3g} mm, " if ways else ""
        places.append(f"{kinds[first]} at {time[first]:.5g}{to} ms ({size}sample {first + 1})")
    more = f", and {begins.size - _LISTED} more places" if begins.size > _LISTED else ""
    count = int((kinds != "").sum())
    samples = "sample" if count == 1 else "samples"
    return f"{count} {samples} that no sensor of this stroke gives: {', '.join(places)}{more}"


def _smooth(travel: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """Running median of blocks of half a ms, and the time between them, ms.

    Where the travel only rises or only falls it is the travel itself.
    """
    block = max(1, round(_BLOCK / step))
    line = filled(travel)
    whole = line[: line.size // block * block] if line.size >= block else line[:1]
    blocks = np.median(whole.reshape(-1, min(block, whole.size)), axis=1)
    # Those at the ends stand for what is beyond: bad ones would fill half a window.
    blocks[0], blocks[-1] = np.median(blocks[:_ENDS]), np.median(blocks[-_ENDS:])
    window = 2 * round(_BURST / (block * step)) + 1
    return running_median(blocks, window), block * step


def _noise(travel: np.ndarray) -> float:
    """Standard deviation of white noise, mm, robustly from third differences."""
    third = np.diff(travel[~np.isnan(travel)], n=3)
    return 1.4826 / np.sqrt(20.0) * float(np.median(np.abs(third))) if third.size else 0.0


def _runs(travel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First sample of each run of equal samples, and the one after its last."""
    ends = np.flatnonzero(np.diff(travel) != 0.0) + 1
    return np.append(0, ends), np.append(ends, travel.size)


def _clipped(travel: np.ndarray, noise: float, stroke: float) -> np.ndarray:
    """Which samples stay at an end of the range, exactly, with more noise at the other end."""
    low, high = np.nanmin(travel), np.nanmax(travel)
    first, last = _runs(travel)
    clipped = np.zeros(travel.shape, dtype=bool)
    for rail, other in ((low, high), (high, low)):
        opposite = travel[np.abs(travel - other) < 0.1 * stroke]
        noisy = opposite.size >= _RAIL and _noise(opposite) > noise
        long = (travel[first] == rail) & (last - first >= _RAIL)
        if noisy and long.any() and (np.diff(opposite) == 0.0).mean() < 0.2:
            clipped |= travel == rail
    return clipped


def _stuck(travel: np.ndarray, limit: float) -> np.ndarray:
    """Which samples repeat the one before, until the travel is suddenly elsewhere."""
    first, last = _runs(travel)
    after = np.append(travel, np.nan)[last]
    stuck = np.zeros(travel.shape, dtype=bool)
    held = (last - first >= _STUCK) & (np.abs(after - travel[first]) > limit)
    for begin, end in zip(first[held], last[held], strict=True):
        stuck[begin + (begin > 0) : end] = True  # no reading before the first was a true one
    return stuck


def _apart(travel: np.ndarray, coarse: float, way: float, motion: float) -> np.ndarray:
    """Which samples do not fit to the others, because nothing moves so fast.

    The record falls into pieces where it jumps. Those are kept that fit together, one after the
    other, and hold most motions, then most samples.

    Args:
        travel: Travel, ``(t,)``, mm.
        coarse: Difference of two samples that noise and quantum make, mm.
        way: Longest way from one sample to the next, mm.
        motion: Least range of a piece that holds a motion, mm.
    """
    there = np.flatnonzero(~np.isnan(travel))
    breaks = np.abs(np.diff(travel[there])) > coarse + way * np.diff(there)
    first = there[np.append(True, breaks)]
    last = there[np.append(breaks, True)]
    kept = np.zeros(travel.shape, dtype=bool)
    if first.size > _PIECES:
        return ~np.isnan(travel)
    starts = np.searchsorted(there, first)
    size = np.diff(np.append(starts, there.size))
    moves = [np.ptp(travel[there[a : a + n]]) >= motion for a, n in zip(starts, size, strict=True)]
    size[moves] += there.size
    most, before = size.copy(), np.full(first.size, -1)
    for i in range(1, first.size):
        gap = np.abs(travel[first[i]] - travel[last[:i]]) - way * (first[i] - last[:i])
        chains = np.where(gap <= coarse, most[:i], 0)
        if chains.max() > 0:
            before[i] = chains.argmax()
            most[i] += chains.max()
    i = int(most.argmax())
    while i >= 0:
        kept[first[i] : last[i] + 1] = True
        i = before[i]
    return ~kept & ~np.isnan(travel)
