"""Noise of a record: its size, colour and drift at rest, and a ripple while the drive moves.

The likelihood takes noise of ``noise_sd`` that is independent from sample to sample. A record in
which there is more, or in which neighbouring samples of the grid err alike, knows less about the
drive than is inferred from it; one that was smoothed shows another motion.

A transducer on an elastic linkage swings about the drive's own way, by as much as the motion is
fast. What such a ripple adds is an error of the reading that no mean of samples takes away.
"""

from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.rejections import FALSE, FEWEST, MATTERS, Remark, normal_sds

_RATIOS = 0.5, 1.15  # of the noise to noise_sd, beyond which parameters and their sds are wrong
_ALIKE = 0.2  # correlation from which it matters
_DRIFT = 3.0  # noise_sd, drift over the grid from which it matters
_HUM = 0.2  # mm, rms of a hum that makes a time of 1 mm/ms wrong by more than timing_sd
_COLOURED = 0.95  # most correlation of neighbours that a short rest lets one see
_PART = 0.05, 0.95  # of the way, in which a ripple is looked for
# Of polynomials for the drive's own way. What either leaves of a bump swings, too, but the faster
# the higher its degree; a sine is the same beside both.
_DEGREES = 8, 11
_SHARE = 0.7  # of what the polynomial leaves, a sine's at least


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
        seen = 1.0 - 2.0 * (1.0 + colour) / (1.0 - colour) / self.samples
        return self.sd / float(np.sqrt(max(seen, 0.25))), colour


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
    if count < max(FEWEST, every + 2):
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


def noise_remarks(
    noise: Noise, noise_sd: float | None, step: float, times: np.ndarray
) -> list[Remark]:
    """Say where noise is not what a model takes for granted; without one, whether it is a hum.

    Args:
        noise: Of the record.
        noise_sd: The model's, mm; None compares nothing.
        step: Time between two samples of the record, ms.
        times: The model's grid, ``(t,)``, ms.

    Example:
        >>> times = np.linspace(-2.0, 58.0, 151)
        >>> [each.code for each in noise_remarks(Noise(0.21, 0.0, 0.0, 0.0, 80), 0.1, 0.1, times)]
        ['noisier']
        >>> noise_remarks(Noise(0.11, 0.0, 0.0, 0.0, 80), 0.1, 0.1, times)
        []
    """
    if np.isnan(noise.sd):
        return [Remark("few-at-rest")] if noise_sd is not None else []
    near = min(max(noise.next, 0.0), 0.99) if np.isfinite(noise.next) else 0.0
    sds, memory = normal_sds(1), in_digits(step / (1.0 - near), 2)
    if noise_sd is None:
        hums = noise.sd > _HUM and near > sds / np.sqrt(noise.samples)
        return [Remark("hums", noise=in_digits(noise.sd, 2), memory=memory)] if hums else []
    remarks, size = [], {"noise": in_digits(noise.sd, 2), "noise_sd": noise_sd}
    # Of a first-order process: where neighbours are alike, as many samples know less.
    free = max(noise.samples * (1.0 - near**2) / (1.0 + near**2) - 1.0, 1.0)
    # Quantiles of chi over the root of its degrees of freedom (Wilson and Hilferty).
    off = NormalDist().inv_cdf(1.0 - FALSE) * np.sqrt(2.0 / (9.0 * free))
    least, most = (max(1.0 - 2.0 / (9.0 * free) + sign * off, 0.0) ** 1.5 for sign in (-1, 1))
    if noise.sd > noise_sd * max(_RATIOS[1], most):
        remarks.append(Remark("noisier", **size))
    if 0.0 < noise.sd < noise_sd * min(_RATIOS[0], least):
        remarks.append(Remark("calmer", **size))
    # A mean over the memory makes neighbouring samples as alike as they are.
    smooth = step / (1.0 - near) > times[1] - times[0] and near > sds / np.sqrt(noise.samples)
    if (smooth and near > 1.0 - _ALIKE) or noise.colour > max(_ALIKE, sds / np.sqrt(free)):
        remarks.append(Remark("coloured", memory=memory, colour=noise.colour))
    way = abs(noise.drift) * float(times[-1] - times[0])
    error = noise.sd * np.sqrt(12.0 / free) / (step * noise.samples)
    if way > _DRIFT * noise_sd and abs(noise.drift) > sds * error:
        remarks.append(Remark("drifts", drift=in_digits(noise.drift, 2), way=in_digits(way, 2)))
    return remarks


class Ripple(NamedTuple):
    """A ripple of a reading: its amplitude where the motion is fastest, mm, and period, ms."""

    amplitude: float
    period: float

    @property
    def rms(self) -> float:
        """Root mean square of what it adds, mm."""
        return self.amplitude / float(np.sqrt(2.0))


def ripple_of(time: np.ndarray, way: np.ndarray, stroke: float) -> Ripple:
    """Return the ripple of a motion, of amplitude 0 where none is clear.

    Args:
        time: Times, ``(n,)``, ms.
        way: Way from the rest before, in the direction of the motion, ``(n,)``, mm; NaN where a
            sample is missing.
        stroke: From there to the rest after it, mm.
    """
    none = Ripple(0.0, np.nan)
    there = np.flatnonzero(~np.isnan(way))
    ends = there[way[there] >= _PART[1] * stroke]
    rests = there[: np.searchsorted(there, ends[0])] if ends.size else there[:0]
    rests = rests[way[rests] <= _PART[0] * stroke]
    own = there[(there > rests[-1]) & (there < ends[0])] if rests.size else there[:0]
    if own.size < 2 * _DEGREES[1]:
        return none
    time, way = time[own], way[own]
    # From 4 samples to a quarter of that part, each a little longer than the one before.
    span = time[-1] - time[0]
    periods = np.geomspace(min(4.0 / own.size, 0.25) * span, 0.25 * span, 60)
    best, other = (_sine(time, way, degree, MATTERS * stroke, periods) for degree in _DEGREES)
    if best is None or other is None or abs(best[0] - other[0]) > 1:
        return none
    return Ripple(best[1], float(periods[best[0]]))


def _sine(
    time: np.ndarray, way: np.ndarray, degree: int, least: float, periods: np.ndarray
) -> tuple[int, float] | None:
    """Number of the period, and amplitude, of the sine that is most of what a polynomial leaves."""
    scaled = 2.0 * (time - time[0]) / (time[-1] - time[0]) - 1.0
    smooth, _ = np.linalg.qr(np.polynomial.chebyshev.chebvander(scaled, degree))
    curve = smooth @ (smooth.T @ way)
    left, speed = way - curve, np.gradient(curve, time)
    if left @ left < 0.1 * time.size * least**2:  # a sine of that amplitude leaves more
        return None
    phase = 2.0 * np.pi * time / periods[:, None]
    waves = np.stack([np.cos(phase), np.sin(phase)], 1) * np.clip(speed / speed.max(), 0.1, 1.0)
    waves -= waves @ smooth @ smooth.T  # (period, 2, time)
    shares = waves @ left
    sizes = np.linalg.solve(waves @ waves.transpose(0, 2, 1), shares[..., None])[..., 0]
    best = int((shares * sizes).sum(axis=1).argmax())
    explained, amplitude = float(shares[best] @ sizes[best]), float(np.hypot(*sizes[best]))
    return (best, amplitude) if explained > _SHARE * (left @ left) and amplitude > least else None
