"""Noise of a record: its size, colour and drift at rest, and a ripple while the drive moves.

The likelihood takes noise of ``noise_sd`` that is independent from sample to sample. A record in
which there is more, or in which neighbouring samples of the grid err alike, knows less about the
drive than is inferred from it; one that was smoothed shows another motion.

A transducer on an elastic linkage swings about the drive's own way. During the motion such a
reading is a smooth curve and a sine, as large as the motion is fast. The drive does not move so:
what the sine adds is no mechanism, and for times, speeds and networks it is an error of the reading
that no mean of neighbouring samples takes away.
"""

from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.rejections import Remark

_FEWEST = 10  # samples at rest, for an estimate
_FALSE = 1e-4  # probability of a remark on noise of the right size
_NORMAL = 3.7  # sd that normal noise exceeds with that probability
_LESS = 0.5  # factor on noise_sd below which noise is another sensor's, or filtered away
_MORE = 1.15  # factor on noise_sd from which more noise matters
_ALIKE = 0.2  # correlation from which it matters
_LONG = 1.25  # steps of the grid, memory from which it matters
_DRIFT = 3.0  # noise_sd, drift over the grid from which it matters
_COLOURED, _LOST = 0.95, 0.75  # most correlation, and share of a variance that was not seen
_STEADY = 30  # samples at rest, from which a drift is told from noise

_PART = 0.05, 0.95  # of the way, in which a ripple is looked for
_FEWEST_MOVING, _MOST_MOVING = 25, 400  # samples there; of more, means of neighbours
# Of polynomials that stand for the drive's own way. What either leaves of a bump swings, too, but
# the faster the higher its degree; a sine is the same beside both.
_DEGREES = 8, 11
_SLOWEST = 0.1  # speed over the largest, at which a ripple is as large as at lower ones
_SHORTEST_PERIOD = 4  # samples
_LONGEST_PERIOD = 0.25  # of the time of that part
_PERIODS = 60  # tried in between
_SHARE, _CLEAR = 0.7, 50.0  # of what the polynomial leaves, and over what is left (F statistic)
_LEFT = 0.1  # of the square of the least amplitude, as what it leaves of each sample at least
_LEAST_RIPPLE = 0.004  # of the stroke: where elastic parts swing by less, networks know it


class Noise(NamedTuple):
    """Noise of a record; nan where there is too little rest to see it.

    Attributes:
        sd: Standard deviation of a sample about the drift, mm.
        colour: Correlation of samples that are a step of the model's grid apart.
        next: Correlation of neighbouring samples of the file.
        drift: Slope of the travel at rest, mm/ms.
        samples: Number of samples at rest.
    """

    sd: float
    colour: float
    next: float
    drift: float
    samples: int

    @property
    def process(self) -> tuple[float, float]:
        """Standard deviation of a sample, mm, and its correlation with the next, of all noise.

        Both are seen too small at a short rest of coloured noise, which takes part of it for a
        drift.
        """
        if not np.isfinite(self.next):
            return self.sd, 0.0
        colour = self.next + (2.0 + 4.0 * self.next) / self.samples
        colour = float(np.clip(colour, 0.0, _COLOURED))
        lost = 2.0 * (1.0 + colour) / (1.0 - colour) / self.samples
        return self.sd / float(np.sqrt(1.0 - min(lost, _LOST))), colour


def noise_at_rest(rest: np.ndarray, step: float, grid_step: float, quantum: float) -> Noise:
    """Estimate the noise of a record.

    Args:
        rest: Travel before the motion, ``(r,)``, mm; NaN where a sample is missing.
        step: Time between two samples, ms.
        grid_step: Time between two samples of the model's grid, ms.
        quantum: Step to which readings are rounded, mm; its error, ``quantum / sqrt(12)``, is
            there also where rest is too steady to show it.
    """
    every = max(1, round(grid_step / step))
    there = ~np.isnan(rest)
    count = int(there.sum())
    if count < max(_FEWEST, every + 2):
        return Noise(np.nan, np.nan, np.nan, np.nan, count)
    at = step * (np.arange(rest.size) - np.flatnonzero(there).mean())
    centred = np.where(there, rest - rest[there].mean(), 0.0)
    drift = float(centred @ at / (at[there] @ at[there]))
    left = np.where(there, centred - drift * at, 0.0)
    square, rounding = float(left @ left), quantum / np.sqrt(12.0)
    sd = np.sqrt(square / (count - 2))
    if sd <= max(rounding, 1e-9):
        return Noise(float(rounding), np.nan, np.nan, drift, count)

    def alike(lag: int) -> float:
        pairs = max((there[lag:] & there[:-lag]).sum(), 1)
        return float(left[lag:] @ left[:-lag] / pairs / (square / count))

    return Noise(float(sd), alike(every), alike(1), drift, count)


def noise_remarks(noise: Noise, noise_sd: float, step: float, times: np.ndarray) -> list[str]:
    """Say where a record's noise is not what the model takes for granted: white, and no larger.

    Of records in which it is, fewer than one in 1,000 has a remark.

    Args:
        noise_sd: The model's, mm.
        step: Time between two samples of the record, ms.
        times: The model's grid, ``(t,)``, ms.

    Example:
        >>> times = np.linspace(-2.0, 58.0, 151)
        >>> noise_remarks(Noise(0.21, 0.0, 0.0, 0.0, 80), 0.1, 0.1, times)[0][:58]
        'the noise at rest is 0.21 mm, more than sensor.noise_sd, 0'
        >>> noise_remarks(Noise(0.11, 0.0, 0.0, 0.0, 80), 0.1, 0.1, times)
        []
    """
    from scipy.special import chdtri  # takes a quarter of a first answer to load, which needs none

    if np.isnan(noise.sd):
        return [Remark("few-at-rest")]
    remarks, size = [], {"noise": in_digits(noise.sd, 2), "noise_sd": noise_sd}
    near = min(max(noise.next, 0.0), 0.99) if np.isfinite(noise.next) else 0.0
    # Of a first-order process: where neighbours are alike, as many samples know less.
    free = max(noise.samples * (1.0 - near**2) / (1.0 + near**2) - 1.0, 1.0)
    if noise.sd > noise_sd * max(_MORE, float(np.sqrt(chdtri(free, _FALSE) / free))):
        remarks.append(Remark("noisier", **size))
    least = min(_LESS, float(np.sqrt(chdtri(free, 1.0 - _FALSE) / free)))
    if 0.0 < noise.sd < least * noise_sd:
        remarks.append(Remark("calmer", **size))
    grid_step = float(times[1] - times[0])
    # A mean over so long makes neighbouring samples as alike as they are.
    memory = step / (1.0 - near)
    smooth = memory > _LONG * grid_step and near > _NORMAL / np.sqrt(noise.samples)
    if smooth or noise.colour > max(_ALIKE, _NORMAL / np.sqrt(free)):
        remarks.append(Remark("coloured", memory=in_digits(memory, 2), colour=noise.colour))
    drifts = abs(noise.drift) * float(times[-1] - times[0])
    longest = step * noise.samples
    error = noise.sd * np.sqrt(12.0 / noise.samples * (1.0 + near) / (1.0 - near)) / longest
    certain = noise.samples >= _STEADY and abs(noise.drift) > (_NORMAL + 0.5) * error
    if certain and drifts > _DRIFT * noise_sd:
        remarks.append(Remark("drifts", drift=in_digits(noise.drift, 2), way=in_digits(drifts, 2)))
    return remarks


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
    every = max(1, own.size // _MOST_MOVING)
    own = own[: own.size // every * every]
    if own.size < _FEWEST_MOVING * every:
        return _NONE
    time, way = (each[own].reshape(-1, every).mean(axis=1) for each in (time, way))
    span = float(time[-1] - time[0])
    shortest = min(_SHORTEST_PERIOD * span / (time.size - 1), _LONGEST_PERIOD * span)
    periods = np.geomspace(shortest, _LONGEST_PERIOD * span, _PERIODS)
    (best, amplitude, total, rest), (other, *_) = (
        _sine(time, way, degree, _LEAST_RIPPLE * stroke, periods) for degree in _DEGREES
    )
    free = time.size - max(_DEGREES) - 4
    clear = 0.5 * (total - rest) * free > _CLEAR * rest and rest < (1.0 - _SHARE) * total
    if not clear or amplitude < _LEAST_RIPPLE * stroke or abs(best - other) > 1:
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
    if left @ left < _LEFT * time.size * least**2:
        return 0, 0.0, 0.0, 0.0
    phase = 2.0 * np.pi * time / periods[:, None]
    waves = speed * np.stack([np.cos(phase), np.sin(phase)], axis=1)  # (period, 2, time)
    waves -= waves @ smooth @ smooth.T
    squares, shares = waves @ waves.transpose(0, 2, 1), waves @ left
    sizes = np.linalg.solve(squares, shares[..., None])[..., 0]
    best = int((shares * sizes).sum(axis=1).argmax())
    rest = left - sizes[best] @ waves[best]
    return best, float(np.hypot(*sizes[best])), float(left @ left), float(rest @ rest)
