"""The samples of a record as a likelihood sees them: its motion, in steps that lose nothing."""

from dataclasses import dataclass

import numpy as np

from breaker.reading.records.raw_record import Raw

_FINEST = 0.04  # durations between samples; finer ones are averaged, which no motion notices
_BEFORE, _BEHIND = 3.0, 9.7  # durations around 10 % of the way, as in the records of training
_THERE = 0.5  # of the samples of a mean, least share
_KNOWN = 1e9  # degrees of freedom of noise that is known
_LEAST = 5e-5  # noise over the stroke, below which no network was trained


@dataclass(frozen=True, eq=False)
class RecordSamples:
    """Samples of one motion, whose zero is unknown.

    Attributes:
        times: ms after 10 % of the way, ``(t,)``.
        travel: mm towards closed, ``(t,)``.
        sd, colour: Noise of a sample, mm, and the correlation of those that are neighbours.
        joined: Whether the sample before is a neighbour, ``(t,)``.
        rest: By how many independent samples at rest the noise is known, less those that its drift
            takes; inf where it is that of the rounding, or no rest shows it.

    Example:
        >>> times = np.arange(200.0)
        >>> noise = 0.1 * np.random.default_rng(1).standard_normal(200)
        >>> samples = RecordSamples(times, 5.0 + noise, 0.1, 0.0, times > 0.0)
        >>> bool(150.0 < np.square(samples.residuals(np.zeros((1, 200)))).sum() < 250.0)
        True
    """

    times: np.ndarray
    travel: np.ndarray
    sd: float
    colour: float
    joined: np.ndarray
    rest: float = np.inf

    @classmethod
    def of(cls, raw: Raw, tenth: float, stroke: float, duration: float) -> "RecordSamples":
        """Take the samples of a record.

        Args:
            tenth: Time of 10 % of its way, ms of the file.
            stroke, duration: Its own, mm and ms.
        """
        times, left = raw.time[raw.inside] - tenth, raw.left
        near = (times >= -_BEFORE * duration) & (times <= _BEHIND * duration)
        times, left = times[near], left[near]
        every = max(1, int(_FINEST * duration / raw.step))
        n = len(times) // every * every
        parts = left[:n].reshape(-1, every)
        whole = np.isfinite(parts).mean(axis=1) >= _THERE
        sd, colour = raw.process
        at_rest = raw.noise_at(raw.step)
        rest = (at_rest.samples - 2) * (1.0 - colour**2) / (1.0 + colour**2)
        sd = max(np.hypot(sd, raw.ripple.rms), _LEAST * stroke)
        sd, colour = mean_noise(sd, colour, every)
        joined = np.append(False, np.diff(np.flatnonzero(whole)) == 1)
        means = np.nanmean(parts[whole], axis=1)
        times = times[:n].reshape(-1, every).mean(axis=1)[whole]
        return cls(times, means, sd, colour, joined, rest if np.isfinite(at_rest.next) else np.inf)

    def residuals(self, travel: np.ndarray) -> np.ndarray:
        """Residuals of curves ``(n, t)`` as independent standard normal numbers, ``(n, t)``.

        The noise is a first-order process, begun anew behind a gap. The zero is the one that fits
        best: its prior is flat, and what it moves is taken out.
        """
        off, ones = self._white(self.travel - travel), self._white(np.ones((1, self.times.size)))
        ones = ones[0] / np.sqrt(np.square(ones).sum())
        return off - np.outer(off @ ones, ones)

    @property
    def free(self) -> int:
        """Degrees of freedom of the square of ``residuals`` at the true curve."""
        return self.times.size - 1

    def p_values(self, squares: np.ndarray) -> np.ndarray:
        """Share of records of a drive that lie farther from it than this one, ``(n,)``.

        The noise is no better known than its rest shows it: sums of squares over it follow an F
        distribution.

        Args:
            squares: Of the residuals of drives, ``(n,)``.
        """
        from scipy.special import fdtrc

        return fdtrc(self.free, min(self.rest, _KNOWN), squares / self.free)

    def _white(self, residual: np.ndarray) -> np.ndarray:
        """Residuals ``(n, t)`` as independent standard normal numbers."""
        before = np.where(self.joined, self.colour * np.roll(residual, 1, axis=1), 0.0)
        left = np.where(self.joined, np.sqrt(1.0 - self.colour**2), 1.0)
        return (residual - before) / (self.sd * left)


def mean_noise(sd: float, colour: float, every: int) -> tuple[float, float]:
    """Standard deviation and correlation of neighbours of means of so many samples.

    Args:
        sd, colour: Of a sample: a first-order process.

    Example:
        >>> [round(each, 3) for each in mean_noise(1.0, 0.0, 4)]
        [0.5, 0.0]
    """
    lags = np.arange(1, every)
    within = every + 2.0 * ((every - lags) * colour**lags).sum()
    # Pairs of one mean and the next are 1 to 2 every - 1 samples apart.
    lags = np.arange(1, 2 * every)
    across = ((every - np.abs(lags - every)) * colour**lags).sum()
    return float(sd * np.sqrt(within) / every), float(across / within)
