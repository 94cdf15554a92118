"""Smooth curves through evenly spaced samples: running medians and means, cubics about a time.

Beyond the ends of running statistics, samples at the ends stand. ``scipy.ndimage`` has these, and
takes a quarter of a first answer to load.
"""

import operator
from dataclasses import dataclass

import numpy as np

from breaker.common.compiling import compiled

_fast = compiled(late=True)
_DEGREE = 3  # of local fits
_STEPS = 6  # in search of a time


def filled(travel: np.ndarray) -> np.ndarray:
    """Return samples with straight lines where some are missing, ``(n,)``."""
    there = np.flatnonzero(~np.isnan(travel))
    return np.interp(np.arange(travel.size), there, travel[there])


def smoothed(travel: np.ndarray, half: int) -> np.ndarray:
    """Return the running median over so many samples before and after each, ``(n,)``.

    Where samples are missing, straight lines count. Near the ends it goes on as it is there:
    mirrored, a burst at the end would fill the window.
    """
    smooth = running_median(filled(travel), 2 * half + 1)
    if smooth.size > 2 * half:
        smooth[:half], smooth[-half:] = smooth[half], smooth[-half - 1]
    return smooth


@_fast
def running_median(values, window):
    """Medians of an odd number of samples about each of ``(n,)``, without nan.

    Example:
        >>> running_median(np.array([0.0, 9.0, 1.0, 2.0, 3.0]), 3)
        array([0., 1., 2., 2., 3.])
    """
    n, half = values.size, window // 2
    ordered = np.sort(np.array([values[min(max(i, 0), n - 1)] for i in range(-half, half + 1)]))
    found = np.empty(n)
    for i in range(n):
        found[i] = ordered[half]
        leaves, enters = values[max(i - half, 0)], values[min(i + half + 1, n - 1)]
        k = np.searchsorted(ordered, leaves)
        while k < window - 1 and ordered[k + 1] < enters:
            ordered[k] = ordered[k + 1]
            k += 1
        while k > 0 and ordered[k - 1] > enters:
            ordered[k] = ordered[k - 1]
            k -= 1
        ordered[k] = enters
    return found


def running_mean(values: np.ndarray, window: int) -> np.ndarray:
    """Return means of an odd number of samples about each of ``(n,)``.

    Example:
        >>> running_mean(np.array([0.0, 3.0, 6.0, 9.0]), 3)
        array([1., 3., 6., 8.])
    """
    half = window // 2
    total = np.cumsum(np.pad(values - values[0], (half + 1, half), mode="edge"))
    return values[0] + (total[window:] - total[:-window]) / window


def weights_of(shares: np.ndarray) -> np.ndarray:
    """Coefficients of a polynomial by the samples at shares ``(w,)``, ``(degree + 1, w)``."""
    powers = shares[:, None] ** np.arange(_DEGREE + 1)
    return np.linalg.solve(powers.T @ powers, powers.T)


@dataclass(frozen=True, eq=False)
class LocalCubic:
    """Polynomial through samples about a time, in halves of its width from there."""

    near: float
    half: float
    coefficients: list[float]  # of degree + 1
    window: np.ndarray  # samples, (w,)
    inverse: np.ndarray  # each coefficient's weights of these samples, (degree + 1, w)
    error: float

    def value(self, time: float, order: int = 0) -> float:
        """Value, or a derivative of an order, mm/ms^order."""
        return sum(map(operator.mul, self._powers(time, order), self.coefficients))

    def weights(self, time: float, order: int = 0) -> np.ndarray:
        """Weights of the samples in that, ``(w,)``."""
        return np.array(self._powers(time, order)) @ self.inverse

    def solve(self, time: float, value: float, order: int = 0) -> float:
        """Time within the fit, near another, at which its value or a derivative is one given."""
        for _ in range(_STEPS):
            slope = self.value(time, order + 1)
            step = (self.value(time, order) - value) / slope if slope else 0.0
            time = min(max(time - step, self.near - self.half), self.near + self.half)
            if abs(step) < 1e-9 * self.half:
                break
        return time

    def _powers(self, time: float, order: int) -> tuple[float, ...]:
        """Factors on the coefficients that make the value, or a derivative."""
        u = (time - self.near) / self.half
        if order == 0:
            return 1.0, u, u * u, u * u * u
        if order == 1:
            return 0.0, 1.0 / self.half, 2.0 * u / self.half, 3.0 * u * u / self.half
        return 0.0, 0.0, 2.0 / self.half**2, 6.0 * u / self.half**2
