"""Speed along a record, and where a closing touches: to look at, not to infer from."""

import numpy as np
from scipy.signal import savgol_filter

from breaker.reading.records.curve_fits import filled

_WINDOW = 0.12  # of the duration of a motion, over which its speed is one
_WAY = (0.3, 0.95)  # of the way, between which contacts touch and the travel is smooth otherwise
_INNER = np.linspace(0.15, 0.85, 71)  # of that time, where a bend is told from a curve
_CLEAR = 5.0  # standard errors, from which a bend is one
_FEWEST = 20  # samples of that time


def speed_along(time: np.ndarray, travel: np.ndarray, duration: float) -> np.ndarray:
    """Return the speed, ``(t,)``, mm/ms, by parabolas through an eighth of a motion.

    Args:
        time: Times, ``(t,)``, ms, evenly spaced.
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
        duration: Of the motion, ms.

    Example:
        >>> time = np.arange(0.0, 30.0, 0.1)
        >>> f"{speed_along(time, 1.5 * time, 20.0)[100]:.2f} mm/ms"
        '1.50 mm/ms'
    """
    step = (time[-1] - time[0]) / (len(time) - 1)
    window = 2 * max(2, round(0.5 * _WINDOW * duration / step)) + 1
    if window > travel.size:
        return np.full(travel.size, np.nan)
    return savgol_filter(filled(travel), window, polyorder=2, deriv=1, delta=step)


def seen_touch(time: np.ndarray, travel: np.ndarray) -> float | None:
    """Return about when a closing touches, ms, if that is seen; None where noise hides it.

    The contact spring slows the drive down from about the touch on, so the acceleration falls
    there: a cubic with such a bend is fitted to the way of the contact. In curves of the model the
    bend is at the touch to within half a millisecond; a lever or a preload may move it by more.

    Args:
        time: Times of a closing, from its first motion to its rest, ``(t,)``, ms.
        travel: Its travel towards closed, ``(t,)``, mm; NaN where a sample is missing.

    Example:
        >>> time = np.arange(0.0, 16.0, 0.1)
        >>> travel = time - 0.1 * np.maximum(time - 10.0, 0.0) ** 2
        >>> f"{seen_touch(time, travel):.0f} ms"
        '10 ms'
    """
    time, travel = (each[~np.isnan(travel)] for each in (time, travel))
    if travel.size < _FEWEST or np.ptp(travel) == 0.0:
        return None
    done = (travel - travel[0]) / np.ptp(travel)
    # From the last sample below the one share to the first above the other.
    begin = int(np.flatnonzero(done <= _WAY[0]).max(initial=0))
    end = begin + int((done[begin:] >= _WAY[1]).argmax())
    if end - begin < _FEWEST:
        return None
    time, travel = time[begin:end], travel[begin:end]
    u = (time - time[0]) / (time[-1] - time[0])
    smooth, _ = np.linalg.qr(np.vander(u, 4))
    left = travel - smooth @ (smooth.T @ travel)
    bends = np.maximum(u - _INNER[:, None], 0.0) ** 2
    bends -= bends @ smooth @ smooth.T
    along, squares = bends @ left, np.square(bends).sum(axis=1)
    gains = np.where(along < 0.0, along**2 / squares, 0.0)
    best = int(gains.argmax())
    # Intercept, slope, curvature, third power, size and place of the bend.
    noise = (left @ left - gains[best]) / (u.size - 6)
    if gains[best] <= _CLEAR**2 * noise:
        return None
    return float(time[0] + _INNER[best] * (time[-1] - time[0]))
