"""Change points by another method: offline, with ruptures, on the posterior medians.

Truong et al. (2020), "Selective review of offline change point detection methods". Least-squares
lines are fitted to stretches of the medians of single operations, standardised by their own
scatter, with a penalty for each break. It sees all operations at once and knows neither prior nor
posterior widths: not a judge, a second opinion.
"""

import numpy as np
from ruptures import BottomUp
from ruptures.base import BaseCost

__all__ = ["bends"]

_BINS = 120  # means of operations that are looked at
_FEWEST = 20  # operations
_PENALTY = 3.0  # times the parameters and the log of the bins, for each break


class _Lines(BaseCost):
    """Squares that the least-squares line of a stretch leaves; the first column is the time."""

    model = "lines"
    min_size = 3

    def fit(self, signal: np.ndarray) -> "_Lines":
        """Prepare the sums of which all lines follow, from ``(n, 1 + p)``."""
        self.signal = signal
        t, values = signal[:, :1], signal[:, 1:]
        parts = np.ones_like(t), t, t * t, values, values * t, values**2
        self.sums = [np.vstack([np.zeros((1, each.shape[1])), each.cumsum(0)]) for each in parts]
        return self

    def error(self, start: int, end: int) -> float:
        """Return the squares left of samples from ``start`` to before ``end``."""
        n, t, tt, y, ty, yy = (each[end] - each[start] for each in self.sums)
        return float((yy - y**2 / n - (ty - t * y / n) ** 2 / (tt - t * t / n)).sum())


def bends(operations: np.ndarray, medians: np.ndarray) -> np.ndarray:
    """Return the operations at which the series bend together, rising, float.

    Args:
        operations: Numbers of the operations, ``(o,)``.
        medians: Posterior medians of log parameters, ``(o, p)``; nan where there is none.
    """
    there = np.isfinite(medians).all(axis=1)
    operations, medians = operations[there].astype(float), medians[there]
    if len(operations) < _FEWEST:
        return np.array([])
    # What is left of second differences: free of lines, six times the variance of the noise.
    noise = np.sqrt(np.square(np.diff(medians, n=2, axis=0)).mean(axis=0) / 6.0)
    if not np.all(noise > 1e-12 * np.abs(medians).max(axis=0)):
        return np.array([])
    size = -(-len(operations) // _BINS)
    bins = len(operations) // size
    first = len(operations) - bins * size  # the few operations that fill no bin
    series = (medians[first:] / noise * np.sqrt(size)).reshape(bins, size, -1).mean(axis=1)
    numbers = operations[first:].reshape(bins, size)
    # Centred, for the sums lose digits otherwise.
    signal = np.column_stack([numbers.mean(axis=1) - operations.mean(), series - series.mean(0)])
    found = BottomUp(custom_cost=_Lines(), min_size=3, jump=1).fit(signal)
    places = found.predict(pen=_PENALTY * medians.shape[1] * np.log(bins))[:-1]
    return numbers[np.array(places, dtype=int) - 1, -1]
