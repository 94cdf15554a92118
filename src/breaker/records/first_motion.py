"""The first motion of a record.

From rest, travel begins as ``A tau^p``, ``tau`` the time since the first motion. An even force
makes ``p`` 2, friction somewhat less, a force that builds up more. That is fitted to the rest and
the first rise for many starts and powers; the time is the mean of the starts, each weighted by how
likely it is. A threshold would be late by milliseconds, and later for a weak drive. Lengths are
shares of the record's own stroke, noise or duration, so neither unit nor stroke, speed or rate
matters. Samples far from the running median count as missing.

That time serves to align records. A slow start, or a creep before the main acceleration, hides when
a drive truly begins to move; ``start_interval`` returns from when to when that may be, by all
starts that the noise allows: of powers from 1 to 4, and with a creep before them. Hum of the mains
counts as noise: of slow starts in 0.05 to 0.3 mm of it, 55 % have a narrow interval (a fit of the
hum made that 70 %).
"""

from typing import NamedTuple

import numpy as np

from breaker.records.axes import seen_quantum
from breaker.records.motion import Course, white_noise
from breaker.records.rejections import FEWEST, UnusableError

# Of a fit: least height of the rise in sds of the noise, and as a share of the way, and how many
# durations before it the rest begins. A low rise has a simple shape, and less that noise hides.
_ALIGNING = (30.0, 0.03, 1.0)
_ANY_START = (15.0, 0.004, 3.5)  # with room for a creep of 0.8 durations and rest before it
_TALLEST = 0.2  # of the way: higher, the force has changed
_CALM = 8.0  # spreads of the rest, such as hum, that a rise is above
_FEW = 12  # samples from a rise to _ON times it; of fewer, one that is higher by _HIGHER is fitted
_HIGHER, _ON = 1.25, 2.25
_BLOCKS = 0.05  # of the time to the end of the rise: length of a block whose mean is fitted
_STARTS = 40  # tried at first, and as many again between those that are not unlikely
_UNLIKELY = 1e-4  # times the greatest likelihood
_POWERS = np.array([1.0, 1.25, 1.6, 1.85, 2.1, 2.4, 2.8, 3.3, 4.0])
_USUAL, _SPREAD = 1.85, 0.15  # prior of a power: Student's t with 3 degrees of freedom
_CREEPS = np.array([0.05, 0.1, 0.2, 0.4, 0.8])  # durations of the motion
_CREEP_WAY = (0.004, 0.03)  # of the stroke: less is not counted as motion
_ODD = (0.2, 0.05)  # probabilities of any power and of a creep, before anything is seen
# Times the variance, since no start has exactly such a shape: of 200 simulated drives, 94 % of the
# intervals contain the truth; 90 % at 3.
_INEXACT = 4.5
_WRONG = 5.0  # sd of the noise from the running median, from which a sample counts as missing
_MOVES = 12.0  # sd of the noise, least way of a motion
_UNSEEN = 0.3  # of the time of the rise, largest gap in it, and uncertainty of its start
_LEAST_REST = 0.2  # of the duration: a record that begins in the motion seems to rest as long


def first_motion(time: np.ndarray, travel: np.ndarray, motion: str) -> tuple[float, float]:
    """Return the time of the first motion and the standard deviation of its fit, ms.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel towards closed, ``(t,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".

    Raises:
        UnusableError: If the travel stays within its noise, has left its rest position when the
            record begins, or samples are missing or noisy where the start must be.
    """
    rise = _rise(time, travel if motion == "closing" else -travel, *_ALIGNING)
    starts, powers = np.linspace(rise.time[0], rise.time[-2], _STARTS), _POWERS[_POWERS > 1.5]
    for _ in range(2):  # once more between the likely ones
        tried = starts
        _, squares, products = rise.fitted(rise.shapes(tried, powers))
        log = np.maximum(products, 0.0) ** 2 / squares * (0.5 / rise.noise**2)
        log += np.log(_usual(powers))[:, None]
        weights = np.exp(log - log.max()).sum(axis=0)
        starts = _closer(tried, weights)
    best = float(weights @ tried / weights.sum())
    sd = float(np.sqrt(weights @ (tried - best) ** 2 / weights.sum()))
    lasts = rise.known[-1] - best
    moving = rise.known[max(0, np.searchsorted(rise.known, best) - 1) :]
    gap = np.diff(moving).max() - (time[1] - time[0])
    if gap > _UNSEEN * lasts:
        raise UnusableError(f"the first motion is not seen: {gap:.1f} ms of its rise are missing")
    if sd > _UNSEEN * lasts:
        raise UnusableError(f"the first motion is not seen: its time is uncertain by {sd:.1f} ms")
    if best - time[~np.isnan(travel)][0] < _LEAST_REST * rise.duration:
        raise UnusableError("no rest before the motion: the record begins too late")
    return best, sd


class StartInterval(NamedTuple):
    """When a drive begins to move.

    Attributes:
        time: Mean of the possible times, ms.
        early, late: Ends of an interval that contains it with 95 %, ms.
        duration: About how long the motion takes, ms.
    """

    time: float
    early: float
    late: float
    duration: float

    def sd_of(self, time: float) -> float:
        """Return the standard deviation by which 95 % around a time contain the interval, ms."""
        return max(time - self.early, self.late - time) / 1.96


def start_interval(time: np.ndarray, travel: np.ndarray, motion: str) -> StartInterval:
    """Return from when to when a drive may begin to move.

    Args:
        time, travel, motion: As of ``first_motion``, and it raises as that.

    Example:
        >>> time = np.arange(0.0, 120.0, 0.1)
        >>> way = 150.0 * np.clip((time - 40.0) / 50.0, 0.0, 1.0) ** 2
        >>> noise = 0.2 * np.random.default_rng(1).standard_normal(time.size)
        >>> found = start_interval(time, way + noise, "closing")
        >>> bool(found.early < 40.0 < found.late < found.early + 5.0)
        True
    """
    rise = _rise(time, travel if motion == "closing" else -travel, *_ANY_START)
    lengths, mains = _CREEPS * rise.duration, np.linspace(rise.time[0], rise.time[-2], _STARTS)
    for _ in range(2):  # once more between the likely ones
        tried = mains
        alone, creeping = _possible(rise, tried, lengths)
        mains = _closer(tried, alone + creeping.sum(axis=0))
    # A creep of another shape begins later or earlier by 40 % of its length.
    begins = [tried - share * lengths[:, None] for share in (0.6, 1.4)]
    starts = np.concatenate([tried, *(each.ravel() for each in begins)])
    weights = np.concatenate([alone, *2 * [0.5 * creeping.ravel()]])
    order = np.argsort(starts)
    shares = np.cumsum(weights[order]) / weights.sum()
    early, late = starts[order][np.searchsorted(shares, (0.025, 0.975))]
    apart = float(tried[1] - tried[0]) + 0.5 * float(time[1] - time[0])  # of starts, of samples
    mean = float(weights @ starts / weights.sum())
    return StartInterval(mean, float(early) - apart, float(late) + apart, rise.duration)


class _Rise(NamedTuple):
    """The lowest rise above the noise, and the rest before it.

    Attributes:
        time, travel: Means of ``b`` blocks of samples, ms and mm.
        root: Square root of the number of samples of each, ``(b,)``.
        known: Times of the samples, ``(n,)``, ms.
        noise: Standard deviation of a sample if they were independent, mm.
        way: Of the entire motion, mm.
        duration: About how long it takes, ms.
    """

    time: np.ndarray
    travel: np.ndarray
    root: np.ndarray
    known: np.ndarray
    noise: float
    way: float
    duration: float

    def shapes(self, starts: np.ndarray, powers: np.ndarray) -> np.ndarray:
        """Rises of powers from starts ``(s,)`` on, ``(p, s, b)``; they end at 1."""
        since = np.maximum(self.time - starts[:, None], 0.0) / (self.time[-1] - starts[:, None])
        with np.errstate(divide="ignore"):
            log = np.log(since)
        return np.exp(powers[:, None, None] * log)

    def varying(self, values: np.ndarray) -> np.ndarray:
        """Weighted values of blocks, without what a constant has of them, ``(..., b)``."""
        rest = self.root / np.linalg.norm(self.root)
        weighted = values * self.root
        return weighted - (weighted @ rest)[..., None] * rest

    def fitted(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Varying shapes, their sums of squares, and of products with the travel, ``(...)``."""
        varying = self.varying(shapes)
        squares = np.maximum(np.square(varying).sum(axis=-1), np.finfo(float).tiny)
        return varying, squares, varying @ self.varying(self.travel)


def _rise(time: np.ndarray, travel: np.ndarray, sds: float, least: float, rests: float) -> _Rise:
    """Find the rise of a travel in which greater values are later."""
    step = float(time[1] - time[0])
    smooth, quantum = Course(time, travel).smooth, seen_quantum(travel)
    off = travel - smooth
    noise = max(white_noise(travel), 1.4826 * np.nanmedian(np.abs(off)))
    lowest = np.minimum.accumulate(smooth)
    top = int((smooth - lowest).argmax())
    if (way := smooth[top] - lowest[top]) <= _MOVES * noise:
        raise UnusableError(f"no motion: the travel rises by no more than {way:.2f} mm")

    def passes(share: float) -> int:
        below = smooth[top::-1] < low + share * (smooth[top] - low)
        return top - int(below.argmax())

    low = lowest[top]
    noise = max(noise, quantum / np.sqrt(12.0), 1e-3 * way)  # a counter has none at rest
    begun = passes(0.1)
    duration = 1.25 * max(float(time[passes(0.9)] - time[begun]), 4.0 * step)
    # The rest may drift: it is that shortly before the motion, not the lowest of the record.
    rest = smooth[slice(*np.searchsorted(time, time[begun] - duration * np.array([3.0, 0.5])))]
    rest = rest if rest.size >= FEWEST else smooth[: begun + 1]
    low = float(np.median(rest))
    spread = 1.4826 * float(np.median(np.abs(rest - low)))
    way = float(smooth[top] - low)
    share = float(np.clip(max(sds * noise, _CALM * spread) / way, least, _TALLEST))
    last, on = passes(share), passes(_ON * share)
    while on - last < _FEW and _ON * _HIGHER * share < 0.9:
        share *= _HIGHER
        last, on = passes(share), passes(_ON * share)
    first = int(np.searchsorted(time, time[last] - rests * duration))
    calm = int(np.searchsorted(time, time[last] - duration))
    other = np.flatnonzero(np.abs(smooth[:calm] - low) > _WRONG * max(spread, noise))
    first = max(first, int(other[-1]) + 1 if other.size else 0)  # where another motion has ended
    part = first + np.flatnonzero(np.abs(off[first : last + 1]) <= _WRONG * noise)
    if part.size < FEWEST:
        raise UnusableError("the first motion is not seen: its samples are missing")
    noise *= _colour(off[part])
    size = max(1.0, (on - last) / 15.0)  # of a block at the end, samples; longer ones before it
    number = np.floor(np.log1p((last - part) * (_BLOCKS / size)) / _BLOCKS)
    edges = np.flatnonzero(np.diff(number, prepend=-1.0))
    counts = np.diff(edges, append=part.size)
    means = (np.add.reduceat(each[part], edges) / counts for each in (time, travel))
    return _Rise(*means, np.sqrt(counts), time[part], noise, way, duration)


def _colour(off: np.ndarray) -> float:
    """Factor on the noise by which correlated samples count as fewer independent ones."""
    rho = off[1:] @ off[:-1] / max(off @ off, np.finfo(float).tiny)
    rho = np.clip(rho, 0.0, 0.5)  # the steps of a counter are more correlated
    return float(np.sqrt((1.0 + rho) / (1.0 - rho)))


def _possible(rise: _Rise, mains: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How likely starts ``(s,)`` of the main motion are: alone, and after creeps, ``(c, s)``."""
    main, squares, products = rise.fitted(rise.shapes(mains, _POWERS))
    alone = np.maximum(products, 0.0) ** 2 / squares
    some = slice(2, None, 3)  # powers after a creep
    main, squares, products = main[some], squares[some], products[some]
    done = np.clip((rise.time - mains[:, None]) / lengths[:, None, None] + 1.0, 0.0, 1.0)
    creep, own, share = rise.fitted(done * np.sqrt(done))
    both = np.stack([(creep * each).sum(axis=-1) for each in main], axis=1)
    precision = np.maximum(own[:, None] - both**2 / squares, 1e-12)  # of the creep's way
    size = (share[:, None] - both * products / squares) / precision
    beyond = size - np.clip(size, *np.multiply(_CREEP_WAY, rise.way))
    after = products**2 / squares + precision * (size**2 - beyond**2)
    after = np.where(mains - lengths[:, None, None] < rise.time[0], -np.inf, after)
    best = max(alone.max(), after.max())
    left = float(np.square(rise.varying(rise.travel)).sum()) - best
    scale = 2.0 * _INEXACT * max(rise.noise**2, left / rise.time.size)
    any_power, creeps = _ODD
    prior = (1.0 - any_power) * _usual(_POWERS) / _usual(_POWERS).sum() + any_power / _POWERS.size
    alone = (1.0 - creeps) * prior @ np.exp((alone - best) / scale)
    return alone, creeps / lengths.size * np.exp((after - best) / scale).mean(axis=1)


def _closer(starts: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """As many starts between the likely ones."""
    likely = np.flatnonzero(weights > _UNLIKELY * weights.max())
    ends = [max(likely[0] - 1, 0), min(likely[-1] + 1, starts.size - 1)]
    return np.linspace(*starts[ends], starts.size)


def _usual(powers: np.ndarray) -> np.ndarray:
    """Prior density of powers, not normalised."""
    return (1.0 + ((powers - _USUAL) / _SPREAD) ** 2 / 3.0) ** -2.0
