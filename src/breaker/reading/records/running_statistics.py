"""Running medians and means of evenly spaced samples; beyond the ends, those at the ends stand.

``scipy.ndimage`` has both, and takes a quarter of a first answer to load.
"""

import numpy as np

from breaker.common.compiling import compiled

_fast = compiled(late=True)


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
