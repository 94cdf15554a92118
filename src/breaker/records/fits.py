"""Fits to evenly spaced samples: running statistics, local cubics and the rest after a motion.

Late in a motion one mode is left, ``y = e + a C(x) + b S(x)``, a damped swing or the sum of two
decays, of which the faster may be over. First its damping and stiffness follow from the integrals
of ``y'' + r y' + s (y - e) = 0``, which are linear in them and average the noise; then all numbers
are fitted by Gauss-Newton.
"""

from typing import NamedTuple

import numpy as np

_TOGETHER = 2**18  # samples in windows whose medians are computed at once: 2 MB
_BLOCKS = 64  # means of neighbouring samples that are fitted
_ROUNDS = 5
_FARTHEST = 5.0  # change of a rate in a round
_CONDITION = 1e3  # of a fit whose end is known


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
    """Cubic through the samples about a time.

    Args:
        near, half: The time and half of the width, ms.
        shares: Times of samples from ``near`` on, over ``half``, ``(w,)``.
        travel: Of these, ``(w,)``, mm.
        window: Their places, ``(w,)``.
        error: Error of the fit itself, mm.
    """

    def __init__(
        self,
        near: float,
        half: float,
        shares: np.ndarray,
        travel: np.ndarray,
        window: np.ndarray,
        error: float,
    ) -> None:
        self.near, self.half, self.window, self.error = float(near), half, window, error
        powers = shares[:, None] ** np.arange(4)
        self._inverse = np.linalg.solve(powers.T @ powers, powers.T)
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


class Settling(NamedTuple):
    """End of a curve, carried on.

    Attributes:
        rest: Where it comes to rest, mm.
        weights: Of the samples in that, ``(n,)``.
        time, travel: Means of neighbouring samples that are fitted, ``(m,)``, ms and mm.
        known: What is fitted to these, ``(m, p)``: the constant, the modes, and how these change
            with their rates.
        pull: Weights of these means in the rest, ``(m,)``.
    """

    rest: float
    weights: np.ndarray
    time: np.ndarray
    travel: np.ndarray
    known: np.ndarray
    pull: np.ndarray


def settling(time: np.ndarray, travel: np.ndarray, modes: int) -> Settling | None:
    """Fit the end of a curve; None where it does not show where it settles.

    Args:
        time: Times, ``(n,)``, ms, increasing.
        travel: Travel, ``(n,)``, mm; no sample missing.
        modes: 2; 1 for a slower decay alone; 0 for a mean.
    """
    every = max(1, time.size // _BLOCKS)
    skipped = time.size % every
    time, y = (each[skipped:].reshape(-1, every).mean(axis=1) for each in (time, travel))
    if y.size < 2:
        return None
    x = (time - time[0]) / (time[-1] - time[0])
    once = _integral(x, y)
    integrals = [once, _integral(x, once)][:modes]
    known = np.column_stack([x**i for i in range(modes + 1)] + [-each for each in integrals])
    rates = np.linalg.lstsq(known, y, rcond=None)[0][modes + 1 :]  # r, and s
    linear = None
    for _ in range(_ROUNDS):
        if not (rates > 0).all():
            return None
        basis, slopes = _solutions(x, rates)
        if linear is None:
            linear = np.linalg.lstsq(basis, y, rcond=None)[0]
        jacobian = np.column_stack([basis, *(each @ linear[1:] for each in slopes)])
        scale = np.linalg.norm(jacobian, axis=0)
        if not (scale > 0).all():
            return None
        root = np.linalg.svd(jacobian / scale, full_matrices=False)
        if not root.S[0] < _CONDITION * root.S[-1]:
            return None
        inverse = (root.Vh.T / root.S) @ root.U.T / scale[:, None]
        step = inverse @ (y - basis @ linear)
        linear = linear + step[: modes + 1]
        rates = rates + np.clip(step[modes + 1 :], -_FARTHEST, _FARTHEST)
    weights = np.append(np.zeros(skipped), np.repeat(inverse[0], every) / every)
    return Settling(float(linear[0]), weights, time, y, jacobian, inverse[0])


def hidden_mode(
    found: Settling, modes: np.ndarray, *, variance: float, size: float, share: float
) -> float:
    """Return the error of a fit's rest from a mode that it lacks, mm: what noise may hide.

    Each mode has the probability that travel gives it (evidence of a linear model), and with it
    an amplitude and its error. The root mean square of what these do to the rest is returned.

    Args:
        found: The fit.
        modes: One of them may be there, ``(c, m)``; they end at 0.
        variance: Of the noise of each mean, mm^2.
        size: Sd of the amplitude of a mode, before it is seen, mm.
        share: Probability that there is one, before it is seen.
    """
    basis, y = np.linalg.qr(found.known)[0], found.travel
    left, others = y - basis @ (basis.T @ y), modes - (modes @ basis) @ basis.T
    precision = (others**2).sum(axis=1) / variance + size**-2.0
    sizes = others @ left / variance / precision
    evidence = 0.5 * (sizes**2 * precision - np.log(size**2 * precision))
    evidence = np.append(evidence + np.log(share / len(modes)), np.log1p(-share))
    each = np.exp(evidence - evidence.max())
    moves = (modes @ found.pull) ** 2 * (sizes**2 + 1.0 / precision)
    return float(np.sqrt(each[:-1] @ moves / each.sum()))


def _integral(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integral of samples from the first on, by trapezia, ``(n,)``."""
    return np.append(0.0, np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))


def _solutions(x: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Constant and the solutions of ``y'' + r y' + s y = 0``, or of ``y' + r y = 0``.

    Returns:
        Constant and solutions, ``(n, order + 1)``; and derivatives of these by each rate,
        ``(n, order)``.
    """
    if not rates.size:
        return np.ones((x.size, 1)), []
    if rates.size == 1:
        decay = np.exp(-rates[0] * x)
        return np.column_stack([np.ones(x.size), decay]), [-(x * decay)[:, None]]
    r, s = rates
    square = s - r**2 / 4.0
    square = square if abs(square) > 1e-6 else 1e-6
    frequency = np.sqrt(complex(square))
    decay = np.exp(-0.5 * r * x)
    cosine = decay * np.cos(frequency * x).real
    sine = decay * (np.sin(frequency * x) / frequency).real
    both = np.column_stack([cosine, sine])
    by_s = np.column_stack([-0.5 * x * sine, (x * cosine - sine) / (2.0 * square)])
    by_r = -0.5 * x[:, None] * both - 0.5 * r * by_s
    return np.column_stack([np.ones(x.size), both]), [by_r, by_s]
