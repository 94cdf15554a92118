"""Fits to evenly spaced samples: running statistics, local cubics, and levels of rest.

A drive that has arrived may still swing, creep or seem to drift. Which of these it does is not
known, so its rest is the mean over all of them, each as probable as the travel makes it.
"""

import numpy as np

_TOGETHER = 2**18  # samples in windows whose medians are computed at once: 2 MB
# After the arrival, in durations of the motion: angular frequencies of swings (0 is two decays),
# times in which they fade, and times in which creeps do.
_SWINGS = np.array([0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 5.5, 7.5])
_FADES = np.geomspace(0.25, 2.0, 6)
_CREEPS = np.array([1.0, 2.0, 4.0])
# Of swings and creeps at the arrival, in strokes, and of drifts, in strokes per duration: sd
# before they are seen. And how many drives do so, of the simulated ones and of field records.
_SIZES = 0.09, 0.03, 0.0045
_CHANCES = 0.3, 0.1, 0.03
_LEFT = 1.7  # noise variances, beyond what noise leaves of the 64 means of a rest (4 sds)


def filled(travel: np.ndarray) -> np.ndarray:
    """Return samples with straight lines where some are missing, ``(n,)``."""
    there = np.flatnonzero(~np.isnan(travel))
    return np.interp(np.arange(travel.size), there, travel[there])


def smoothed(travel: np.ndarray, half: int) -> np.ndarray:
    """Return the running median over so many samples before and after each, ``(n,)``.

    Straight lines replace missing samples. The first and last full window stand for the ends.
    """
    smooth = running_median(filled(travel), 2 * half + 1)
    if smooth.size > 2 * half:
        smooth[:half], smooth[-half:] = smooth[half], smooth[-half - 1]
    return smooth


def running_median(values: np.ndarray, window: int) -> np.ndarray:
    """Return medians of an odd number of samples about each of ``(n,)``, without NaN.

    ``scipy.ndimage`` has one as well, which takes a quarter of a first answer to load.
    """
    half, medians = window // 2, np.empty(values.size)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, half, mode="edge"), window)
    rows = max(1, _TOGETHER // window)
    for begin in range(0, values.size, rows):
        block = np.partition(windows[begin : begin + rows], half, axis=1)
        medians[begin : begin + rows] = block[:, half]
    return medians


def running_mean(values: np.ndarray, window: int) -> np.ndarray:
    """Return means of an odd number of samples about each of ``(n,)``.

    Example:
        >>> running_mean(np.array([0.0, 3.0, 6.0, 9.0]), 3)
        array([1., 3., 6., 8.])
    """
    half = window // 2
    total = np.cumsum(np.pad(values - values[0], (half + 1, half), mode="edge"))
    return values[0] + (total[window:] - total[:-window]) / window


class LocalCubic:
    """Cubic through samples about a time.

    Args:
        near, half: The time and half of the width, ms.
        travel: The samples, ``(w,)``, mm.
        shares: Their times from ``near`` on, over ``half``, ``(w,)``.
    """

    def __init__(self, near: float, half: float, travel: np.ndarray, shares: np.ndarray) -> None:
        self.near, self.half = near, half
        self._inverse = np.linalg.pinv(shares[:, None] ** np.arange(4))
        self._coefficients = self._inverse @ travel

    def _basis(self, time: float, order: int) -> np.ndarray:
        u = (time - self.near) / self.half
        rows = (1.0, u, u * u, u**3), (0.0, 1.0, 2.0 * u, 3.0 * u * u), (0.0, 0.0, 2.0, 6.0 * u)
        return np.array(rows[order]) / self.half**order

    def value(self, time: float, order: int = 0) -> float:
        """Return the value or a derivative, mm/ms^order."""
        return float(self._basis(time, order) @ self._coefficients)

    def weights(self, time: float, order: int = 0) -> np.ndarray:
        """Return the weights of the samples in that value, ``(w,)``."""
        return self._basis(time, order) @ self._inverse

    def solve(self, time: float, value: float, order: int = 0) -> float:
        """Return the time in the window, near another, at which the fit has a value."""
        for _ in range(6):  # of Newton's method, which doubles the digits
            slope = self.value(time, order + 1)
            step = (self.value(time, order) - value) / slope if slope else 0.0
            time = min(max(time - step, self.near - self.half), self.near + self.half)
        return time


def settlings(late: np.ndarray, begun: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how a drive that has arrived may move on, and how probable each way is.

    Args:
        late: Times since the arrival, ``(n,)``, durations of the motion.
        begun: When the motion began, from which a drift counts.

    Returns:
        Functions, ``(f, n)``, strokes; which of them each way is a sum of, ``(m, 3)``; and the
        probabilities of the ways, ``(m,)``.
    """
    creeps = _SIZES[1] * np.exp(-late / _CREEPS[:, None])
    slow = np.vstack([np.zeros_like(late), creeps, _SIZES[2] * (late - begun)])
    turns = _SWINGS[:, None] * late
    sines = np.where(_SWINGS[:, None] > 0.0, np.sin(turns), late)
    fades = np.exp(-late / _FADES[:, None, None])
    swings = _SIZES[0] * np.vstack([fades * np.cos(turns), fades * sines]).reshape(-1, late.size)
    half = len(swings) // 2
    swung = len(slow) + np.arange(half)
    swung = np.vstack([[0, 0], np.column_stack([swung, swung + half])])  # 0 is none
    first, second = np.indices((len(slow), len(swung))).reshape(2, -1)
    swing, creep, drift = _CHANCES
    slowly = [1.0 - creep - drift, *np.full(_CREEPS.size, creep / _CREEPS.size), drift]
    chances = np.outer(slowly, [1.0 - swing, *np.full(half, swing / half)]).ravel()
    return np.vstack([slow, swings]), np.column_stack([first, swung[second]]), chances


def level(
    travel: np.ndarray,
    functions: np.ndarray,
    ways: np.ndarray,
    chances: np.ndarray,
    variance: float,
) -> tuple[float, np.ndarray, float, float]:
    """Return the level about which travel moves in one of some ways.

    Args:
        travel: Travel, ``(n,)``, mm.
        functions: Functions, ``(f, n)``; their amounts have an sd of 1 before they are seen.
        ways: Functions of each way to move, ``(m, k)``.
        chances: Probabilities of the ways before they are seen, ``(m,)``.
        variance: Of the noise of each sample, mm^2.

    Returns:
        The level, mm; the weights of the samples in it, ``(n,)``; the sd of its error from what
        the samples do not show, mm; and what the best way leaves, mm, 0 where noise leaves as much.
    """
    mean, n, k = float(travel.mean()), travel.size, ways.shape[1]
    off, means = travel - mean, functions.mean(axis=1)
    centred = functions - means[:, None]
    squares = (centred @ centred.T)[ways[:, :, None], ways[:, None, :]]
    shares, middles = (centred @ off)[ways][..., None], means[ways][..., None]

    def seen(noise: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        precisions = squares / noise + np.eye(k)
        covariances = np.linalg.inv(precisions)
        return precisions, covariances, covariances @ shares / noise

    _, _, amounts = seen(variance)
    left = off @ off + (amounts * (squares @ amounts - 2.0 * shares)).sum(axis=(1, 2)).min()
    left = float(left) / max(n - 1 - k, 1)
    noise = max(variance, left)  # what the best way leaves
    precisions, covariances, amounts = seen(noise)
    evidence = 0.5 * (amounts * shares).sum(axis=(1, 2)) / noise
    evidence += np.log(chances) - 0.5 * np.log(np.linalg.det(precisions))
    each = np.exp(evidence - evidence.max())
    each /= each.sum()
    offsets = (middles * amounts).sum(axis=(1, 2))
    turned = covariances @ middles
    gains = turned / noise
    hidden = (middles * turned - variance * gains * (squares @ gains)).sum(axis=(1, 2))
    offset = float(each @ offsets)
    square = float(each @ (np.maximum(hidden, 0.0) + (offsets - offset) ** 2))
    amounts = np.bincount(ways.ravel(), (each[:, None] * gains[..., 0]).ravel(), len(functions))
    misfit = left if left > _LEFT * variance else 0.0
    weights = 1.0 / n - amounts @ centred
    return mean - offset, weights, float(np.sqrt(square)), float(np.sqrt(misfit))
