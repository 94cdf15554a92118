"""Estimate the first motion of a record, and an interval for the start of motion.

From rest, travel begins as ``A tau^p``, where ``tau`` is the time since the first motion. ``p`` is
2 for a constant force, somewhat less with friction, and more for a force that builds up. This power
law is fitted to the rest and the first rise for many starts and a few ``p``; the first motion is
the mean of the starts, weighted by their likelihood. A threshold alone would be late by
milliseconds, and later for a weak drive. All limits are relative to the record's own stroke, noise
or rise time, so unit, stroke, speed and rate do not matter.

The first motion serves to align records. A slow start, a creep before the main acceleration or
mains hum hides the true start of motion. ``start_interval`` returns an interval for it, from all
starts that the noise allows, with any of the powers and with a creep before them.
"""

import numpy as np

from breaker.records.conversion import seen_quantum
from breaker.records.motion import CLEAR, Course
from breaker.records.noise import white_noise
from breaker.records.rejections import FEWEST, UnusableError

# Height up to which the rise is fitted: for the interval (low, so its shape is simple), for a start
_HEIGHTS = 15.0, 30.0  # sd of the noise
_LEAST, _MOST = (0.004, 0.03), 0.2  # smallest and largest height, strokes
_ON = 2.25  # second height over the first: a constant force takes 1.5 times as long to reach it
_SEPARATION = 10  # samples, least time between the two heights; otherwise both are increased
_HIGHER, _HIGHEST = 1.25, 0.4  # factor of the increase, and its limit in strokes
_REST = 8  # length of the fitted rest, in times between the two heights
_POWERS = np.array([1.0, 1.25, 1.5, 1.85, 2.25, 2.8, 3.4, 4.0])  # powers for an interval
_GRADUAL = np.array([1.6, 1.85, 2.1, 2.4, 2.8, 3.3, 4.0])  # powers for a start
_USUAL, _SPREAD = 1.85, 0.15  # prior of the powers: Student's t with 3 degrees of freedom
_FLAT = 1e-3  # strokes, least noise of a rise: no drive follows a power law exactly
_MOST_COLOUR = 0.5  # correlation of neighbours that counts; a counter's steps are more correlated
_STARTS = 45  # number of starts tried at first, and again between the likely ones
_UNLIKELY = 1e-4  # share of the greatest likelihood below which a start is dropped
_MEANS = 80  # means of neighbouring samples that are fitted; more give the same coverage
_VAGUE = 0.25  # largest run of missing samples, and sd of the start, as a share of the rise time
_BEFORE = 0.1  # least rest before the start, as a share of the rise time
_CREEPS = np.array([0.06, 0.12, 0.25, 0.5, 1.0, 2.0])  # lengths of creeps, durations of the motion
_CREEP_TRAVEL = (0.004, 0.03)  # travel of a creep, strokes: less does not count as motion
_CREEP_ENDS = np.linspace(0.6, 1.4, 5)  # lengths of a creep relative to that fitted, by its shape
_ANY_POWER, _ODDS = 0.2, 0.03  # probabilities of other powers, and of a creep or of hum
_HUM = (0.05, 0.06)  # frequencies of the mains, 1/ms
_INEXACT = 3.5  # factor of the variance, since no start has exactly one of these shapes


class _Rise:
    """Largest rise of a record: its height ``stroke``, mm, the approximate ``duration`` of the
    motion, and the median ``low`` of the rest shortly before, which may drift.
    """

    def __init__(self, time: np.ndarray, travel: np.ndarray, motion: str) -> None:
        self.time, self.travel = time, travel if motion == "closing" else -travel  # increasing
        self.smooth = smooth = Course(time, self.travel).smooth
        noise = max(white_noise(travel), _spread(self.travel - smooth))
        self.noise = max(noise, seen_quantum(travel) / np.sqrt(12.0))
        lowest = np.minimum.accumulate(smooth)
        self._top = int((smooth - lowest).argmax())
        self.low = lowest[self._top]
        self.stroke = float(smooth[self._top] - self.low)
        if self.stroke <= CLEAR * self.noise:
            raise UnusableError(f"no motion: the travel rises by no more than {self.stroke:.2f} mm")
        tenth, most = self.last_below(0.1), self.last_below(0.9)
        self.duration = 1.25 * max(float(time[most] - time[tenth]), 4.0 * float(time[1] - time[0]))
        rest = slice(*np.searchsorted(time, time[tenth] - self.duration * np.array([3.0, 0.5])))
        rest = smooth[rest] if rest.stop > rest.start else smooth[: tenth + 1]
        self.low = float(np.median(rest))
        self.stroke = float(smooth[self._top] - self.low)

    def last_below(self, share: float) -> int:
        """Return the last sample before the top that is below a share of the stroke."""
        below = self.smooth[self._top :: -1] < self.low + share * self.stroke
        return self._top - int(below.argmax())

    def clear(self, which: int) -> tuple[int, int]:
        """Return the last samples below a height that is clear of noise, and below ``_ON`` times
        this height, increased until they are well separated: 0 is for an interval, 1 for a start.
        """
        share = float(np.clip(_HEIGHTS[which] * self.noise / self.stroke, _LEAST[which], _MOST))
        last = on = 0
        while on - last < _SEPARATION and share < _HIGHEST:
            last, on = self.last_below(share), self.last_below(_ON * share)
            share *= _HIGHER
        return last, on

    def part(
        self, first: int, last: int, least: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Return times and centred travel between two samples, as means of neighbours, ``(n,)``,
        and the variance of their noise; the noise of a sample is at least ``least``, mm.
        """
        there = first + np.flatnonzero(~np.isnan(self.travel[first : last + 1]))
        if there.size < FEWEST:
            raise UnusableError("the first motion is not seen: its samples are missing")
        off = self.travel[there] - self.smooth[there]
        rho = off[1:] @ off[:-1] / max(off @ off, np.finfo(float).tiny)
        rho = float(np.clip(rho, 0.0, _MOST_COLOUR))
        every = -(-there.size // _MEANS)
        there = there[there.size % every :].reshape(-1, every)  # to the end, where the rise is
        time, travel = (values[there].mean(axis=1) for values in (self.time, self.travel))
        variance = max(self.noise, least) ** 2 * (1.0 + rho) / (1.0 - rho) / every
        return time, travel - travel.mean(), variance


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
    rise = _Rise(time, travel, motion)
    last, on = rise.clear(1)
    first = max(0, last - _REST * max(2, on - last))
    start, sd = _start(*rise.part(first, last, _FLAT * rise.stroke))
    _check(rise, first, last, start)
    if sd > _VAGUE * (time[last] - start):
        raise UnusableError(f"the first motion is not seen: its time is uncertain by {sd:.1f} ms")
    return start, sd


def _check(rise: _Rise, first: int, last: int, start: float) -> None:
    """Reject a start where samples are missing, or without rest before it."""
    lasts = rise.time[last] - start
    there = np.flatnonzero(~np.isnan(rise.travel[first:last]))
    known = np.append(rise.time[first + there], rise.time[last])
    missing = np.diff(known[max(0, np.searchsorted(known, start) - 1) :]).max()
    missing -= rise.time[1] - rise.time[0]
    if missing > _VAGUE * lasts:
        reason = f"{missing:.1f} ms of its rise are missing"
        raise UnusableError(f"the first motion is not seen: {reason}")
    if np.isnan(rise.travel[:first]).all() and start - known[0] < _BEFORE * lasts:
        raise UnusableError("no rest before the motion: the record begins too late")


def _start(time: np.ndarray, travel: np.ndarray, variance: float) -> tuple[float, float]:
    """Return mean and sd of the likely starts of a rise, ms, from samples of the rest and rise."""
    rest, usual = _basis(time, 0.0), _usual(_GRADUAL)[:, None]
    starts = np.linspace(time[0], time[-2], _STARTS)
    for _ in range(2):  # once more between the likely ones
        tried = starts
        _, squares, shares = _fitted(_rises(time, tried, _GRADUAL), travel, rest)
        explained = np.maximum(shares, 0.0) ** 2 / squares
        weights = np.exp((explained - explained.max()) / (2.0 * variance)) * usual
        weights = weights.sum(axis=0)
        starts = _closer(tried, weights)
    best = weights @ tried / weights.sum()
    return float(best), float(np.sqrt(weights @ (tried - best) ** 2 / weights.sum()))


def start_interval(time: np.ndarray, travel: np.ndarray, motion: str) -> tuple[float, float]:
    """Return the ends of a 95 % interval for the start of motion, ms.

    Args:
        time, travel, motion: As in ``first_motion``, which states the errors, too.

    Example:
        >>> time = np.arange(0.0, 120.0, 0.1)
        >>> travel = 150.0 * np.clip((time - 40.0) / 50.0, 0.0, 1.0) ** 2
        >>> hum = 0.2 * np.sin(0.1 * np.pi * time)
        >>> early, late = start_interval(time, travel + hum, "closing")
        >>> early < 40.0 < late < early + 5.0
        True
    """
    rise = _Rise(time, travel, motion)
    last, _ = rise.clear(0)
    first = np.searchsorted(time, time[last] - (_CREEPS[-1] + 1.5) * rise.duration)
    time, travel, variance = rise.part(int(first), last)
    hums = dict.fromkeys(_HUM, _ODDS / len(_HUM)) | {0.0: 1.0}
    if time[-1] - time[0] < 1.0 / min(_HUM):
        hums = {0.0: 1.0}
    rises = ((1.0 - _ANY_POWER) * _usual(_POWERS) + _ANY_POWER / _POWERS.size)[:, None]
    lengths, mains = _CREEPS * rise.duration, np.linspace(time[0], time[-2], _STARTS)
    for _ in range(2):  # once more between the likely ones
        step = float(mains[1] - mains[0])
        begun = mains - lengths[:, None]
        done = np.clip((time - begun[:, :, None]) / lengths[:, None, None], 0.0, 1.0)
        shapes = _rises(time, mains, _POWERS), done * np.sqrt(done)  # rises, and creeps before
        fits = [_explained(time, travel, hum, shapes, rise.stroke) for hum in hums]
        alone, creep = (np.stack(item) for item in zip(*fits, strict=True))
        creep = np.where(begun[:, None] < time[0], -np.inf, creep)
        best = max(alone.max(), creep.max())
        left = float(travel @ travel) - best
        scale = 2.0 * _INEXACT * max(variance, left / time.size, np.finfo(float).tiny)
        alone, creep = np.exp((alone - best) / scale), np.exp((creep - best) / scale)
        odds = np.array(list(hums.values()))
        hums = {list(hums)[int((odds * alone.sum(axis=(1, 2))).argmax())]: 1.0}
        alone = np.einsum("f,fps->s", odds, alone * rises)
        creep = np.einsum("f,fcps->cs", odds, creep) * _ODDS / creep[0, :, :, 0].size
        tried, mains = mains, _closer(mains, alone + creep.sum(axis=0))
    starts = [tried, *(tried - end * lengths[:, None] for end in _CREEP_ENDS)]
    weights = [alone, *[creep / _CREEP_ENDS.size] * _CREEP_ENDS.size]
    starts, weights = (np.concatenate([x.ravel() for x in grids]) for grids in (starts, weights))
    order = np.argsort(starts)
    share = np.cumsum(weights[order]) / weights.sum()
    early, late = starts[order][np.searchsorted(share, (0.025, 0.975))]
    margin = step + 0.5 * float(time[1] - time[0])  # spacing of starts, and of samples
    return float(early) - margin, float(late) + margin


def _explained(
    time: np.ndarray, travel: np.ndarray, hum: float, shapes: tuple[np.ndarray, ...], stroke: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of squares that starts of the main motion ``(s,)`` explain: for each power,
    ``(p, s)``, and for each length of a creep and power after the creep, ``(c, p, s)``.
    """
    basis = _basis(time, hum)
    alone = (basis.T @ travel) @ (basis.T @ travel)  # explained by rest and hum
    main, squares, shares = _fitted(shapes[0], travel, basis)
    rises = alone + np.maximum(shares, 0.0) ** 2 / squares
    creep, norms, share = _fitted(shapes[1], travel, basis)
    both = np.einsum("cst,pst->cps", creep, main)
    precision = np.maximum(norms[:, None] - both**2 / squares, 1e-12)  # of the creep's travel
    size = (share[:, None] - both * shares / squares) / precision
    off = size - np.clip(size, *np.multiply(_CREEP_TRAVEL, stroke))
    return rises, alone + shares**2 / squares + precision * (size**2 - off**2)


def _basis(time: np.ndarray, hum: float) -> np.ndarray:
    """Return an orthonormal basis of a rest and its hum, ``(t, b)``."""
    known = [np.ones(time.size)]
    known += [wave(2.0 * np.pi * hum * time) for wave in (np.cos, np.sin)] if hum else []
    return np.linalg.qr(np.column_stack(known))[0]


def _rises(time: np.ndarray, starts: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Return rises of powers ``(p,)`` from starts ``(s,)`` on, which end at 1, ``(p, s, t)``."""
    with np.errstate(divide="ignore"):
        log = np.log(np.maximum(time - starts[:, None], 0.0) / (time[-1] - starts[:, None]))
    return np.exp(powers[:, None, None] * log)


def _fitted(
    shapes: np.ndarray, travel: np.ndarray, basis: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return shapes ``(..., t)`` orthogonal to an orthonormal basis ``(t, b)``, their sums of
    squares, and their products with the travel, ``(...)``.
    """
    others = shapes - (shapes @ basis) @ basis.T
    squares = np.maximum(np.einsum("...t,...t->...", others, others), np.finfo(float).tiny)
    return others, squares, others @ travel


def _closer(starts: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return equally many starts, between the likely ones."""
    likely = np.flatnonzero(weights > _UNLIKELY * weights.max())
    ends = [max(likely[0] - 1, 0), min(likely[-1] + 1, starts.size - 1)]
    return np.linspace(*starts[ends], starts.size)


def _usual(powers: np.ndarray) -> np.ndarray:
    """Return the prior probabilities of powers ``(p,)``."""
    density = (1.0 + ((powers - _USUAL) / _SPREAD) ** 2 / 3.0) ** -2.0
    return density / density.sum()


def _spread(off: np.ndarray) -> float:
    """Return the standard deviation about 0, by the median."""
    return 1.4826 * float(np.nanmedian(np.abs(off)))
