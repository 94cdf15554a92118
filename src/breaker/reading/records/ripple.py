"""Ripple of a reading: a transducer on an elastic linkage swings about the drive's own way.

During the motion such a reading is a smooth curve and a sine, as large as the motion is fast. The
drive does not move so: what the sine adds is no mechanism, and for times, speeds and networks it is
an error of the reading that no mean of neighbouring samples takes away.
"""

from typing import NamedTuple

import numpy as np

_PART = 0.05, 0.95  # of the way, in which a ripple is looked for
_FEWEST, _MOST = 25, 400  # samples there; of more, means of neighbours
# Of polynomials that stand for the drive's own way. What either leaves of a bump swings, too, but
# the faster the higher its degree; a sine is the same beside both.
_DEGREES = 8, 11
_SLOWEST = 0.1  # speed over the largest, at which a ripple is as large as at lower ones
_SHORTEST, _LONGEST, _PERIODS = 4, 0.25, 60  # samples; of the time of that part; tried in between
_SHARE, _CLEAR = 0.7, 50.0  # of what the polynomial leaves, and over what is left (F statistic)
_SEEN = 0.1  # of the square of the least amplitude, as what it leaves of each sample at least
_LEAST = 0.004  # of the stroke: where elastic parts swing by less, networks know it


class Ripple(NamedTuple):
    """A ripple of a reading.

    Attributes:
        amplitude: Where the motion is fastest, mm.
        period: In ms.
    """

    amplitude: float
    period: float

    @property
    def rms(self) -> float:
        """Root mean square of what it adds, mm."""
        return self.amplitude / float(np.sqrt(2.0))


_NONE = Ripple(0.0, np.nan)


def ripple_of(time: np.ndarray, way: np.ndarray, stroke: float) -> Ripple:
    """Return the ripple of a motion, of amplitude 0 where none is clear.

    Args:
        time: Times, ``(n,)``, ms.
        way: Way from the rest before, in the direction of the motion, ``(n,)``, mm; NaN where a
            sample is missing.
        stroke: From there to the rest after it, mm.

    Example:
        >>> time = np.arange(0.0, 40.0, 0.1)
        >>> way = 150.0 * np.clip(time / 40.0, 0.0, 1.0) ** 2
        >>> found = ripple_of(time, way + 2.0 * np.sin(2.0 * np.pi * time / 5.0), 150.0)
        >>> f"{found.period:.1f} ms"
        '5.0 ms'
        >>> ripple_of(time, way, 150.0).amplitude
        0.0
    """
    there = np.flatnonzero(~np.isnan(way))
    ends = there[way[there] >= _PART[1] * stroke]
    rests = there[: np.searchsorted(there, ends[0])] if ends.size else there[:0]
    rests = rests[way[rests] <= _PART[0] * stroke]
    if not rests.size:
        return _NONE
    own = there[(there > rests[-1]) & (there < ends[0])]
    every = max(1, own.size // _MOST)
    own = own[: own.size // every * every]
    if own.size < _FEWEST * every:
        return _NONE
    time, way = (each[own].reshape(-1, every).mean(axis=1) for each in (time, way))
    span = float(time[-1] - time[0])
    shortest = min(_SHORTEST * span / (time.size - 1), _LONGEST * span)
    periods = np.geomspace(shortest, _LONGEST * span, _PERIODS)
    (best, amplitude, total, rest), (other, *_) = (
        _sine(time, way, degree, _LEAST * stroke, periods) for degree in _DEGREES
    )
    free = time.size - max(_DEGREES) - 4
    clear = 0.5 * (total - rest) * free > _CLEAR * rest and rest < (1.0 - _SHARE) * total
    if not clear or amplitude < _LEAST * stroke or abs(best - other) > 1:
        return _NONE
    return Ripple(amplitude, float(periods[best]))


def _sine(
    time: np.ndarray, way: np.ndarray, degree: int, least: float, periods: np.ndarray
) -> tuple[int, float, float, float]:
    """The best sine beside a polynomial: number of its period, its amplitude where the motion is
    fastest, and the sums of squares that the polynomial leaves without it and with it; all 0 where
    it leaves too little for a sine of a least amplitude.
    """
    scaled = 2.0 * (time - time[0]) / (time[-1] - time[0]) - 1.0
    smooth, _ = np.linalg.qr(np.polynomial.chebyshev.chebvander(scaled, degree))
    curve = smooth @ (smooth.T @ way)
    left, speed = way - curve, np.gradient(curve, time)
    speed = np.clip(speed / speed.max(), _SLOWEST, 1.0)
    if left @ left < _SEEN * time.size * least**2:
        return 0, 0.0, 0.0, 0.0
    phase = 2.0 * np.pi * time / periods[:, None]
    waves = speed * np.stack([np.cos(phase), np.sin(phase)], axis=1)  # (period, 2, time)
    waves -= waves @ smooth @ smooth.T
    squares, shares = waves @ waves.transpose(0, 2, 1), waves @ left
    sizes = np.linalg.solve(squares, shares[..., None])[..., 0]
    best = int((shares * sizes).sum(axis=1).argmax())
    rest = left - sizes[best] @ waves[best]
    return best, float(np.hypot(*sizes[best])), float(left @ left), float(rest @ rest)
