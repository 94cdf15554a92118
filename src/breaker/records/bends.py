"""Speed along a record, and where a closing touches: to look at, not to infer from."""

import numpy as np
from scipy.signal import savgol_filter

__all__ = ["seen_touch", "speed_along"]

_WINDOW = 0.12  # of the duration of a motion, over which its speed is one
_SHARES = (0.5, 0.85)  # of the way, between which contacts touch
_NEAR = 0.08  # of the way from the touch
_SLOWER = 0.05  # share of the greatest speed by which it falls, at least, that soon after a touch
_CLEAR = 5.0  # sd of the speed at rest by which it falls at least


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
    there = np.flatnonzero(~np.isnan(travel))
    filled = np.interp(np.arange(travel.size), there, travel[there])
    window = 2 * max(2, round(0.5 * _WINDOW * duration / step)) + 1
    if window > travel.size:
        return np.full(travel.size, np.nan)
    return savgol_filter(filled, window, polyorder=2, deriv=1, delta=step)


def seen_touch(travel: np.ndarray, speed: np.ndarray, noise: float) -> int | None:
    """Return the sample at which a closing touches, if the speed has a clear bend there.

    Args:
        travel: Travel from before the first motion to the rest, ``(t,)``, mm, from rest to rest.
        speed: Its speed, ``(t,)``, mm/ms.
        noise: Standard deviation of the speed at rest, mm/ms.
    """
    way = np.nanmax(travel) - travel[0]
    done = np.where(np.isnan(travel), -1.0, (travel - travel[0]) / way)
    inside = np.flatnonzero((done > _SHARES[0]) & (done < _SHARES[1]))
    if inside.size < 3:
        return None
    touch = inside[0] + int(speed[inside[0] : inside[-1] + 1].argmax())
    after = np.flatnonzero(done[touch:] > done[touch] + _NEAR)
    if touch in (inside[0], inside[-1]) or after.size == 0:
        return None
    falls = speed[touch] - speed[touch + after[0]]
    return touch if falls > max(_SLOWER * speed[touch], _CLEAR * noise) else None
