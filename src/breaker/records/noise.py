"""Estimate the noise of a record: its sd and colour at rest, and a ripple while the drive moves.

The likelihood assumes noise of ``noise_sd`` that is independent from sample to sample. A record
with more noise, or with correlated noise, is less informative; smoothing changes the motion.
"""

from typing import NamedTuple

import numpy as np

from breaker.common.numerals import in_digits
from breaker.records.rejections import FEWEST, MATTERS, Remark, normal_sds

_BLOCK = 2**18  # samples in windows whose medians are computed at once: 2 MB
_RATIOS = 0.5, 1.15  # noise over noise_sd, limits beyond which parameters and their sds are wrong
_CORRELATED = 0.2  # correlation at a step of the grid from which a remark is made
_COLOURED = 0.95  # largest correlation of neighbours that a short rest can show
# Degrees of polynomials that model the drive's travel from 5 to 95 %. The residual of a bump swings
# too, but its frequency rises with the degree; a ripple has the same frequency for both degrees.
_DEGREES = 8, 11
_SHARE = 0.7  # least share of the polynomial's residual that a sine explains

REST = (50.0, 1.0)
"""Rest in which the noise is estimated, ms before the first motion: the start may be gradual, and
an earlier motion may still swing long before it."""

OF_SECOND = 1.0 / (0.6745 * 6.0**0.5)
"""Sd of white noise as a share of the median absolute second difference, to which steady motion
contributes nothing."""


class Noise(NamedTuple):
    """Noise of a record; nan if the rest is too short to estimate it."""

    sd: float  # standard deviation of a sample about the drift, mm
    colour: float  # correlation of neighbouring samples
    samples: int  # number of samples at rest

    @property
    def process(self) -> tuple[float, float]:
        """Sd of a sample, mm, and correlation with the next, corrected for a short rest."""
        if not np.isfinite(self.colour):
            return self.sd, 0.0
        colour = self.colour + (2.0 + 4.0 * self.colour) / self.samples
        colour = float(np.clip(colour, 0.0, _COLOURED))
        seen = 1.0 - 2.0 * (1.0 + colour) / (1.0 - colour) / self.samples
        return self.sd / float(np.sqrt(max(seen, 0.25))), colour


def noise_at_rest(rest: np.ndarray, quantum: float) -> Noise:
    """Estimate the noise of a record.

    Args:
        rest: Travel before the motion, ``(r,)``, mm, evenly spaced; NaN where a sample is missing.
        quantum: Step to which readings are rounded, mm; the sd is at least that of rounding,
            ``quantum / sqrt(12)``.
    """
    there = ~np.isnan(rest)
    count = int(there.sum())
    if count < FEWEST:
        return Noise(np.nan, np.nan, count)
    place = np.arange(rest.size)
    drift, level = np.polyfit(place[there], rest[there], 1)
    left = np.where(there, rest - level - drift * place, 0.0)
    sd, rounding = np.sqrt(left @ left / (count - 2)), quantum / np.sqrt(12.0)
    if sd <= max(rounding, 1e-9):
        return Noise(float(rounding), np.nan, count)
    pairs = max((there[1:] & there[:-1]).sum(), 1)
    return Noise(float(sd), float(left[1:] @ left[:-1] / pairs / (left @ left / count)), count)


def noise_remarks(noise: Noise, noise_sd: float, every: float) -> list[Remark]:
    """Return remarks where noise differs from the noise that a model assumes.

    Args:
        noise: Noise of the record.
        noise_sd: Sd that the model assumes, mm.
        every: Step of the model's grid in steps of the record.
    """
    if np.isnan(noise.sd):
        return [Remark("few-at-rest")]
    near = float(np.clip(np.nan_to_num(noise.colour), 0.0, _COLOURED))
    sds, remarks = normal_sds(1), []
    size = {"noise": in_digits(noise.sd, 2), "noise_sd": noise_sd}
    # Degrees of freedom of a first-order process: correlation makes samples less informative.
    free = max(noise.samples * (1.0 - near**2) / (1.0 + near**2) - 1.0, 1.0)
    chance = sds / np.sqrt(2.0 * free)  # largest random error of the logarithm of an sd
    if noise.sd > noise_sd * max(_RATIOS[1], np.exp(chance)):
        remarks.append(Remark("noisier", **size))
    if 0.0 < noise.sd < noise_sd * min(_RATIOS[0], 1.0 - chance):
        remarks.append(Remark("calmer", **size))
    colour = near ** max(every, 1.0)  # of a first-order process, at a step of the grid
    if colour > _CORRELATED and near > sds / np.sqrt(noise.samples):
        remarks.append(Remark("coloured", colour=colour))
    return remarks


def white_noise(travel: np.ndarray) -> float:
    """Return the sd of the noise of a record, mm, if its samples are independent."""
    second = np.diff(travel[~np.isnan(travel)], n=2)
    return float(OF_SECOND * np.median(np.abs(second))) if second.size else 0.0


def ripple_of(done: np.ndarray) -> float:
    """Return the rms of a reading's ripple during a motion, strokes; 0 if none is clear.

    A transducer on an elastic linkage swings around the travel of the drive, in proportion to its
    speed. No mean of samples removes this error: without it, 2 of 3,000 values of
    ``studies.exports`` more are false (60 sheets, seed 78).

    Args:
        done: Travel as a share of the stroke, ``(n,)``, evenly spaced; NaN where one is missing.
    """
    end = int((done >= 0.95).argmax())
    begin = end - int((done[end::-1] <= 0.05).argmax())
    there = np.flatnonzero(~np.isnan(done[begin:end]))
    if there.size < 2 * _DEGREES[1]:
        return 0.0
    done, share = done[begin:end][there], there / (end - begin)
    # Periods from a quarter of this part down to four samples.
    cycles, ripple = np.geomspace(4.0, max(0.25 * done.size, 4.0), 60), []
    for degree in _DEGREES:
        smooth, _ = np.linalg.qr(np.polynomial.chebyshev.chebvander(2.0 * share - 1.0, degree))
        curve = smooth @ (smooth.T @ done)
        left, speed = done - curve, np.gradient(curve, share)
        speed = np.clip(speed / speed.max(), 0.1, 1.0)
        waves = np.exp(2j * np.pi * cycles[:, None] * share) * speed
        waves -= waves @ smooth @ smooth.T
        fits, power = np.abs(waves @ left), 0.5 * np.square(np.abs(waves)).sum(axis=1)
        best = int((fits**2 / power).argmax())
        amplitude = float(fits[best] / power[best])
        if fits[best] * amplitude < _SHARE * (left @ left) or amplitude < MATTERS:
            return 0.0
        ripple.append((best, amplitude))
    (first, amplitude), (second, _) = ripple
    return amplitude / np.sqrt(2.0) if abs(first - second) <= 2 else 0.0


def filled(travel: np.ndarray) -> np.ndarray:
    """Return samples ``(n,)`` with missing ones interpolated linearly."""
    there = np.flatnonzero(~np.isnan(travel))
    return np.interp(np.arange(travel.size), there, travel[there])


def slope(travel: np.ndarray, half: int, step: float) -> np.ndarray:
    """Return the slope of a line through ``half`` samples before and after each sample, ``(n,)``,
    mm/ms; nan where a sample is missing, or the line would reach beyond the ends.
    """
    known = np.isfinite(travel)
    if travel.size <= 2 * half or not known.any():
        return np.full(travel.size, np.nan)
    places = np.arange(-half, half + 1)
    slopes = np.convolve(filled(travel), -places / (step * np.square(places).sum()), "same")
    slopes[:half] = slopes[-half:] = np.nan
    return np.where(known, slopes, np.nan)


def smoothed(travel: np.ndarray, half: int) -> np.ndarray:
    """Return the running median over ``half`` samples before and after each sample, ``(n,)``.

    Missing samples are interpolated. The first and the last full window also give the ends.
    """
    smooth = running_median(filled(travel), 2 * half + 1)
    if smooth.size > 2 * half:
        smooth[:half], smooth[-half:] = smooth[half], smooth[-half - 1]
    return smooth


def running_median(values: np.ndarray, window: int) -> np.ndarray:
    """Return medians of an odd number of samples around each sample, ``(n,)``, without NaN.

    ``scipy.ndimage`` also has this filter, but its import takes a quarter of a first answer.
    """
    half, medians = window // 2, np.empty(values.size)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, half, mode="edge"), window)
    rows = max(1, _BLOCK // window)
    for begin in range(0, values.size, rows):
        block = np.partition(windows[begin : begin + rows], half, axis=1)
        medians[begin : begin + rows] = block[:, half]
    return medians


def running_mean(values: np.ndarray, window: int) -> np.ndarray:
    """Return means of an odd number of samples around each sample, ``(n,)``.

    Example:
        >>> running_mean(np.array([0.0, 3.0, 6.0, 9.0]), 3)
        array([1., 3., 6., 8.])
    """
    half = window // 2
    total = np.cumsum(np.pad(values - values[0], (half + 1, half), mode="edge"))
    return values[0] + (total[window:] - total[:-window]) / window
