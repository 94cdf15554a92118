"""The first motion of a record.

From rest, travel begins as ``A tau^p``, ``tau`` the time since the first motion. An
even force makes ``p`` 2, friction somewhat less, a force that builds up more. That is fitted to the
rest and the first rise, for many starts and a few ``p``; the time is the mean of the starts, each
weighted by how likely it is. A threshold alone would be late by milliseconds, and later for a weak
drive. Each length is a share of the record's own stroke, noise or time of rise, so that neither
unit nor stroke, speed or rate matters. Samples far from the running median count as missing.

That time serves to align records. A slow start, a creep before the main acceleration or hum of the
mains hides when a drive truly begins to move; ``start_interval`` returns from when to when that may
be, by all starts that the noise allows: of powers from 1 to 4, and with a creep before them.
"""

from typing import NamedTuple

import numpy as np

from breaker.records.axes import seen_quantum
from breaker.records.motion import Course, white_noise
from breaker.records.rejections import UnusableError

_RISE = (0.03, 0.2)  # of the way, least and largest rise that is fitted,
_CLEAR = 30.0  # and in between this many sd of the noise: low enough to see the start
_ON = 2.25  # times that rise: at even force half as late again
_APART = 12  # samples, least time between the two; if not, both are higher
_HIGHER, _HIGHEST = 1.25, 0.4
_REST = 8  # times as long as from the one to the other, back to where the fit begins
_HIGHER_RISES = 0.25, 0.15  # of the way, of two other fits
_AGREE, _AGREE_SDS = 0.2, 2.0  # of the time of the low rise, and sds, within which it counts
_POWERS = np.array([1.6, 1.85, 2.1, 2.4, 2.8, 3.3, 4.0])
_USUAL, _SPREAD = 1.85, 0.15  # their prior: Student's t with 3 degrees of freedom
_MOST_COLOUR = 0.5  # correlation of neighbours that counts; a counter's steps are more correlated
_STARTS = 60  # tried at first, and as many again between the likely ones
_UNLIKELY = 1e-4  # times the greatest likelihood
_SAMPLES = 250  # of the fit; of more, means of neighbours
_WRONG = 5.0  # sd of the noise from the running median, from which a sample counts as missing
_FLAT = 1e-3  # of the way, least noise: a counter has none at rest
_FEWEST = 8  # samples of the fit
_VAGUE = 0.25  # of the time of that rise, largest uncertainty of its start
_MOVES = 12.0  # sd of the noise, least way of a motion
_BEFORE = 0.1  # of the time of that rise, least rest before it
_GAP = 0.3  # of that time, longest gap in it

# The interval of a start. Its height is low, so that what is fitted has simple shapes.
_NOISES, _RESTS = 15.0, 8.0  # that height, sd of the noise, and of the rest before it,
_SHARES = (0.004, 0.2)  # and of the way, least and largest
_ENDS = 3.5  # spreads from the rest, at which the motion before still goes on
_RISEN = 8  # samples from there to where it is reached _ON times
_FITTED, _TRIED = 80, 45  # means of neighbours, and starts
_RISES = np.array([1.0, 1.25, 1.5, 1.85, 2.25, 2.8, 3.4, 4.0])
_AFTER_CREEP = np.array([1.5, 2.0, 2.8, 4.0])
_CREEPS = np.array([0.06, 0.12, 0.25, 0.5, 1.0, 2.0])  # durations of the motion
_CREEP_WAY = (0.004, 0.03)  # of the stroke: less is not counted as motion
_CREEP_ENDS = np.linspace(0.6, 1.4, 5)  # later or earlier
_ANY_POWER, _CREEP_ODDS, _HUM_ODDS = 0.2, 0.03, 0.02  # probabilities before anything is seen
_HUM = (0.05, 0.06)  # 1/ms
_INEXACT = 3.0  # times the variance, since no start has exactly one of these shapes
_LIKELY = (0.025, 0.975)


def first_motion(time: np.ndarray, travel: np.ndarray, motion: str) -> tuple[float, float]:
    """Return the time of the first motion and the standard deviation of its fit, ms.

    Where a linkage ripples, a low rise alone begins too early or too late by a share of the ripple:
    two higher ones are fitted as well, and where the three disagree the middle one counts.

    Args:
        time: Times of a record, ``(t,)``, ms, evenly spaced.
        travel: Travel towards closed, ``(t,)``, mm; NaN where a sample is missing.
        motion: "closing" or "opening".

    Raises:
        UnusableError: If the travel stays within its noise, has left its rest position when the
            record begins, or samples are missing or noisy where the start must be.
    """
    travel = travel if motion == "closing" else -travel
    there, quantum = ~np.isnan(travel), seen_quantum(travel)
    for _ in range(2):  # once more, since a burst in the rise moves the running median
        smooth = Course(time, np.where(there, travel, np.nan)).smooth
        off = np.abs(travel - smooth)
        noise = max(white_noise(travel), 1.4826 * np.median(off[there]))
        first, last, way = _rise(smooth, noise)
        noise = max(noise, _FLAT * way, quantum / np.sqrt(12.0))
        kept, there = there, off <= _WRONG * noise
        if (there | np.isnan(off)).all() and (kept == ~np.isnan(travel)).all():
            break  # nothing is left out

    def start(first: int, last: int) -> tuple[float, float, np.ndarray]:
        part = first + np.flatnonzero(there[first : last + 1])
        if part.size < _FEWEST:
            raise UnusableError("the first motion is not seen: its samples are missing")
        coloured = noise * _colour(travel[part] - smooth[part])
        return *_start(time[part], travel[part], coloured), time[part]

    best, sd, known = start(first, last)
    end = time[last]
    known = np.append(known, end)
    gap = np.diff(known[max(0, np.searchsorted(known, best) - 1) :]).max() - (time[1] - time[0])
    if gap > _GAP * (end - best):
        raise UnusableError(f"the first motion is not seen: {gap:.1f} ms of its rise are missing")
    if sd > _VAGUE * (end - best):
        raise UnusableError(f"the first motion is not seen: its time is uncertain by {sd:.1f} ms")
    if first == 0 and best - known[0] < _BEFORE * (end - best):
        raise UnusableError("no rest before the motion: the record begins too late")
    apart, most, found = 0.0, max(_AGREE * (end - best), _AGREE_SDS * sd), [(best, sd)]
    for share in _HIGHER_RISES:  # the second is needed where the first disagrees
        found.append(start(*_rise(smooth, noise, share)[:2])[:2])
        if abs(found[-1][0] - best) <= most:
            break
    else:
        middle = sorted(found)[1]
        apart, (best, sd) = abs(middle[0] - best), middle
    return best, float(np.hypot(sd, 0.5 * apart))


def _largest_rise(smooth: np.ndarray, noise: float) -> tuple[int, float, float]:
    """Return the sample at the top of the largest rise, where it begins, and its height, mm.

    Raises:
        UnusableError: If the rise is within the noise.
    """
    lowest = np.minimum.accumulate(smooth)
    top = int((smooth - lowest).argmax())
    way = smooth[top] - lowest[top]
    if way <= _MOVES * noise:
        raise UnusableError(f"no motion: the travel rises by no more than {way:.2f} mm")
    return top, lowest[top], way


def _rise(smooth: np.ndarray, noise: float, least: float = 0.0) -> tuple[int, int, float]:
    """First and last sample of the rest and the rise that are fitted, and the way, mm."""
    top, low, way = _largest_rise(smooth, noise)

    # The rest may drift: it is that shortly before the motion, not the lowest of the record.
    early, late = (_last_below(smooth, low + share * way, top) for share in (0.3, 0.6))
    low = np.quantile(smooth[max(0, early - 20 * max(1, late - early)) : late + 1], 0.25)
    way = smooth[top] - low
    share, last, on = max(least, float(np.clip(_CLEAR * noise / way, *_RISE))), 0, 0
    while on - last < _APART and share < _HIGHEST:
        last, on = (_last_below(smooth, low + s * way, top) for s in (share, _ON * share))
        share *= _HIGHER
    return max(0, last - _REST * max(2, on - last)), last, way


def _colour(off: np.ndarray) -> float:
    """Factor on the noise by which correlated samples count as fewer independent ones."""
    rho = off[1:] @ off[:-1] / max(off @ off, np.finfo(float).tiny)
    rho = np.clip(rho, 0.0, _MOST_COLOUR)
    return float(np.sqrt((1.0 + rho) / (1.0 - rho)))


def _start(time: np.ndarray, travel: np.ndarray, noise: float) -> tuple[float, float]:
    """Mean and sd of the likely starts of a rise, ms, from its samples and those of the rest."""
    every = -(-time.size // _SAMPLES)
    time, travel = _means(time, travel, every)
    rest = np.full((time.size, 1), time.size**-0.5)
    starts = np.linspace(time[0], time[-2], _STARTS)
    for _ in range(2):  # once more between the likely ones
        tried = starts
        _, squares, shares = _fitted(_rises(time, tried, _POWERS), travel, rest)
        log = np.maximum(shares, 0.0) ** 2 / squares * (0.5 * every / noise**2)
        log += np.log(_usual(_POWERS))[:, None]
        weights = np.exp(log - log.max()).sum(axis=0)
        starts = _closer(tried, weights)
    best = weights @ tried / weights.sum()
    return float(best), float(np.sqrt(weights @ (tried - best) ** 2 / weights.sum()))


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
        >>> found = start_interval(time, way + 0.2 * np.sin(0.1 * np.pi * time), "closing")
        >>> bool(found.early < 40.0 < found.late < found.early + 5.0)
        True
    """
    travel = travel if motion == "closing" else -travel
    time, travel, variance, way, duration = _lowest_rise(time, travel)
    hums = dict.fromkeys(_HUM, _HUM_ODDS / len(_HUM)) | {0.0: 1.0 - _HUM_ODDS}
    if time[-1] - time[0] < 1.0 / min(_HUM):
        hums = {0.0: 1.0}
    usual = _usual(_RISES) / _usual(_RISES).sum()
    rises = ((1.0 - _ANY_POWER) * usual + _ANY_POWER / usual.size)[:, None]
    lengths, mains = _CREEPS * duration, np.linspace(time[0], time[-2], _TRIED)
    for _ in range(2):  # once more between the likely ones
        step = float(mains[1] - mains[0])
        shapes = _shapes(time, mains, lengths)
        found = [_explained(time, travel, hum, shapes, way) for hum in hums]
        found = [
            (a, np.where(mains - lengths[:, None, None] < time[0], -np.inf, c)) for a, c in found
        ]
        alone, creep = (np.stack(each) for each in zip(*found, strict=True))
        best = max(alone.max(), creep.max())
        left = float(travel @ travel) - best
        scale = 2.0 * _INEXACT * max(variance, left / time.size, np.finfo(float).tiny)
        alone, creep = np.exp((alone - best) / scale), np.exp((creep - best) / scale)
        odds = np.array(list(hums.values()))
        hums = {list(hums)[int((odds * alone.sum(axis=(1, 2))).argmax())]: 1.0}
        alone = np.einsum("f,fps->s", odds, alone * rises) * (1.0 - _CREEP_ODDS)
        creep = np.einsum("f,fcps->cs", odds, creep) * _CREEP_ODDS
        creep /= lengths.size * _AFTER_CREEP.size
        starts, weights = [mains], [alone]
        starts.append(mains - (_CREEP_ENDS[:, None] * lengths).reshape(-1, 1))
        weights.append(np.tile(creep, (_CREEP_ENDS.size, 1)) / _CREEP_ENDS.size)
        mains = _closer(mains, alone + creep.sum(axis=0))
    starts, weights = (np.concatenate([x.ravel() for x in each]) for each in (starts, weights))
    order = np.argsort(starts)
    share = np.cumsum(weights[order]) / weights.sum()
    early, late = starts[order][np.searchsorted(share, _LIKELY)]
    apart = step + 0.5 * float(time[1] - time[0])  # of starts, and of samples
    mean = float(weights @ starts / weights.sum())
    return StartInterval(mean, float(early) - apart, float(late) + apart, duration)


def _lowest_rise(
    time: np.ndarray, travel: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float, float, float]:
    """Times and travel of the rest and of the lowest rise above its noise, ``(n,)``, without their
    mean; the variance of its noise, the way, and about how long the motion takes.
    """
    smooth, quantum = Course(time, travel).smooth, seen_quantum(travel)
    noise = max(white_noise(travel), 1.4826 * np.nanmedian(np.abs(travel - smooth)))
    noise = max(noise, quantum / np.sqrt(12.0))
    top, low, way = _largest_rise(smooth, noise)
    tenth, most = (_last_below(smooth, low + share * way, top) for share in (0.1, 0.9))
    duration = 1.25 * max(float(time[most] - time[tenth]), 4.0 * float(time[1] - time[0]))
    rest = slice(*np.searchsorted(time, time[tenth] - duration * np.array([3.0, 0.5])))
    rest = smooth[rest] if rest.stop > rest.start else smooth[: tenth + 1]
    low = float(np.median(rest))
    spread = 1.4826 * float(np.median(np.abs(rest - low)))
    height = max(_NOISES * noise, _RESTS * spread)
    share = float(np.clip(height / way, *_SHARES))
    last = on = 0
    while on - last < _RISEN and share < _HIGHEST:
        last, on = (_last_below(smooth, low + s * way, top) for s in (share, _ON * share))
        share *= _HIGHER
    first = int(np.searchsorted(time, time[last] - (_CREEPS[-1] + 1.5) * duration))
    # Another motion may end in the rest; hum stays within this.
    far = max(_ENDS * spread, 3.0 * noise)
    apart = np.flatnonzero(np.abs(smooth[time < time[last] - duration] - low) > far)
    first = max(first, int(apart[-1]) + 1 if apart.size else 0)
    part = first + np.flatnonzero(~np.isnan(travel[first : last + 1]))
    if part.size < _FEWEST:
        raise UnusableError("the first motion is not seen: its samples are missing")
    noise *= _colour(travel[part] - smooth[part])
    every = -(-part.size // _FITTED)
    time, travel = _means(time[part], travel[part], every)
    return time, travel - travel.mean(), noise**2 / every, float(way), duration


def _shapes(time: np.ndarray, mains: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, ...]:
    """Rises alone ``(p, s, t)``, rises after creeps, and the creeps ``(c, s, t)``."""
    done = np.clip((time - mains[:, None]) / lengths[:, None, None] + 1.0, 0.0, 1.0)
    creeps = done * np.sqrt(done)  # another shape, even or gradual, starts by 40 % of its length
    return _rises(time, mains, _RISES), _rises(time, mains, _AFTER_CREEP), creeps


def _explained(
    time: np.ndarray, travel: np.ndarray, hum: float, shapes: tuple[np.ndarray, ...], way: float
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of squares that starts of the main motion ``(s,)`` explain: of each power, ``(p, s)``,
    and of each length of a creep and power after it, ``(c, p, s)``.
    """
    known = [np.ones(time.size)]
    known += [each(2.0 * np.pi * hum * time) for each in (np.cos, np.sin)] if hum else []
    basis = np.linalg.qr(np.column_stack(known))[0]
    alone = (basis.T @ travel) @ (basis.T @ travel)  # of rest and hum
    _, squares, shares = _fitted(shapes[0], travel, basis)
    rises = alone + np.maximum(shares, 0.0) ** 2 / squares
    main, squares, shares = _fitted(shapes[1], travel, basis)
    creep, own, share = _fitted(shapes[2], travel, basis)
    both = np.einsum("cst,pst->cps", creep, main)
    precision = np.maximum(own[:, None] - both**2 / squares, 1e-12)  # of the creep's way
    size = (share[:, None] - both * shares / squares) / precision
    off = size - np.clip(size, *np.multiply(_CREEP_WAY, way))
    return rises, alone + shares**2 / squares + precision * (size**2 - off**2)


def _rises(time: np.ndarray, starts: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Rises of some powers from starts ``(s,)`` on, which end at 1, ``(p, s, t)``."""
    with np.errstate(divide="ignore"):
        log = np.log(np.maximum(time - starts[:, None], 0.0) / (time[-1] - starts[:, None]))
    return np.exp(powers[:, None, None] * log)


def _fitted(
    shapes: np.ndarray, travel: np.ndarray, basis: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shapes ``(..., t)`` without what an orthonormal basis ``(t, b)`` has of them, their sums of
    squares, and of products with the travel, ``(...)``.
    """
    others = shapes - (shapes @ basis) @ basis.T
    squares = np.maximum(np.einsum("...t,...t->...", others, others), np.finfo(float).tiny)
    return others, squares, others @ travel


def _closer(starts: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """As many starts between the likely ones."""
    likely = np.flatnonzero(weights > _UNLIKELY * weights.max())
    ends = [max(likely[0] - 1, 0), min(likely[-1] + 1, starts.size - 1)]
    return np.linspace(*starts[ends], starts.size)


def _usual(powers: np.ndarray) -> np.ndarray:
    """Prior density of powers, not normalised."""
    return (1.0 + ((powers - _USUAL) / _SPREAD) ** 2 / 3.0) ** -2.0


def _means(time: np.ndarray, travel: np.ndarray, every: int) -> list[np.ndarray]:
    """Means of so many neighbouring samples, from the end, where the rise is."""
    whole = time.size // every * every
    return [each[-whole:].reshape(-1, every).mean(axis=1) for each in (time, travel)]


def _last_below(smooth: np.ndarray, height: float, before: int) -> int:
    return before - int((smooth[before::-1] < height).argmax())
