"""The first motion of a record.

From rest, travel begins as ``A tau^p``, ``tau`` the time since the first motion. An
even force makes ``p`` 2, friction somewhat less, a force that builds up more. That is fitted to the
rest and the first rise, for many starts and a few ``p``; the time is the mean of the starts, each
weighted by how likely it is. A threshold alone would be late by milliseconds, and later for a weak
drive. Each length is a share of the record's own stroke, noise or time of rise, so that neither
unit nor stroke, speed or rate matters. Samples far from the running median count as missing.
"""

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
        there = off <= _WRONG * noise

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


def _rise(smooth: np.ndarray, noise: float, least: float = 0.0) -> tuple[int, int, float]:
    """First and last sample of the rest and the rise that are fitted, and the way, mm."""
    lowest = np.minimum.accumulate(smooth)
    top = int((smooth - lowest).argmax())
    way, low = smooth[top] - lowest[top], lowest[top]
    if way <= _MOVES * noise:
        raise UnusableError(f"no motion: the travel rises by no more than {way:.2f} mm")

    def last_below(height: float, before: int) -> int:
        return before - int((smooth[before::-1] < height).argmax())

    # The rest may drift: it is that shortly before the motion, not the lowest of the record.
    early, late = (last_below(low + share * way, top) for share in (0.3, 0.6))
    low = np.quantile(smooth[max(0, early - 20 * max(1, late - early)) : late + 1], 0.25)
    way = smooth[top] - low
    share, last, on = max(least, float(np.clip(_CLEAR * noise / way, *_RISE))), 0, 0
    while on - last < _APART and share < _HIGHEST:
        last, on = (last_below(low + each * way, top) for each in (share, _ON * share))
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
    whole = time.size // every * every  # from the end, where the rise is
    time, travel = (each[-whole:].reshape(-1, every).mean(axis=1) for each in (time, travel))
    starts = np.linspace(time[0], time[-2], _STARTS)
    likely = np.flatnonzero(_likelihood(time, travel, starts, noise / np.sqrt(every)) > _UNLIKELY)
    ends = [max(likely[0] - 1, 0), min(likely[-1] + 1, _STARTS - 1)]
    starts = np.linspace(*starts[ends], _STARTS)
    weights = _likelihood(time, travel, starts, noise / np.sqrt(every))
    best = weights @ starts / weights.sum()
    return float(best), float(np.sqrt(weights @ (starts - best) ** 2 / weights.sum()))


def _likelihood(
    time: np.ndarray, travel: np.ndarray, starts: np.ndarray, noise: float
) -> np.ndarray:
    """Likelihood of each start ``(s,)``, the greatest of a power 1; rest and height are fitted."""
    tau = np.maximum(time - starts[:, None], 0.0) / (time[-1] - starts[:, None])
    with np.errstate(divide="ignore"):
        log_tau = np.log(tau)
    risen = travel - travel.mean()
    explained = np.empty((_POWERS.size, starts.size))
    for k, power in enumerate(_POWERS):  # one at a time stays in the cache
        shapes = np.exp(power * log_tau)
        scatter = np.einsum("st,st->s", shapes, shapes) - shapes.sum(axis=1) ** 2 / time.size
        explained[k] = np.maximum(shapes @ risen, 0.0) ** 2 / scatter
    log = explained / (2.0 * noise**2)
    log -= 2.0 * np.log1p(((_POWERS[:, None] - _USUAL) / _SPREAD) ** 2 / 3.0)
    return np.exp(log - log.max()).sum(axis=0)
