"""Leaps: where travel goes on elsewhere from one sample to the next, by more than noise can do.

Lost or repeated samples, a sensor that slips and a reading that sticks for a moment all leave one.
They may be far too small for a speed to rule them out, but two straight lines that do not meet fit
the samples around them better than any two that do. Where a contact touches or a damper stops the
drive, lines meet: the travel of a mass is continuous, whatever hits it.
"""

from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

__all__ = ["leap_remark"]

_STEP = 0.1  # ms, to which samples of fast records are averaged
_SIDE = 1.5  # ms, of each line
_FEWEST = 4  # samples of a line
_SLOWEST = 0.41  # ms between samples, above which motions curve within a line
# Gain of lines that do not meet, in variances of the noise: beyond it is less than one white record
# in 10,000. And in strokes squared: less than it is the curvature of a motion.
_GAIN = 32.0
_CURVED = 2e-4


def leap_remark(
    time: np.ndarray, travel: np.ndarray, noise: float, quantum: float, stroke: float
) -> str:
    """Say where a record leaps, "" if it does nowhere.

    Args:
        time: Times, ``(t,)``, ms, evenly spaced.
        travel: Travel, ``(t,)``, mm; NaN where a sample is missing.
        noise: Standard deviation of a sample's noise, mm.
        quantum: Step to which readings are rounded, mm; 0 if they are not.
        stroke: Way between the rest positions, mm.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    block = max(1, round(_STEP / step))
    blocks = len(travel) // block
    mean = travel[: blocks * block].reshape(blocks, block).mean(axis=1)
    side = max(_FEWEST, round(_SIDE / (block * step)))
    if step > _SLOWEST or blocks < 2 * side:
        return ""
    gain, leap = _gain(mean, side)
    # Neighbouring samples are rounded alike.
    gain -= _GAIN * max(noise**2 / block, quantum**2 / 8.0) + _CURVED * stroke**2
    if not (gain > 0.0).any():
        return ""
    place = int(np.nanargmax(gain))
    at = time[0] + (place + side) * block * step
    return (
        f"the travel leaps by {leap[place]:.2g} mm at {at:.4g} ms: were samples lost or repeated, "
        "or did the sensor slip or stick?"
    )


def _gain(travel: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """How much better two lines that do not meet fit, mm^2, and the leap between them, mm.

    Both are ``(t - 2 side + 1,)``: for a leap after the first ``side`` samples of each window.
    """
    apart, meeting, leap = _lines(side)
    windows = sliding_window_view(travel, 2 * side)
    windows = windows - windows[:, :1]
    # A sum of squares that is explained is that of the products with an orthonormal basis.
    explained = ((windows @ meeting) ** 2).reshape(len(windows), -1, 3).sum(axis=2).max(axis=1)
    return ((windows @ apart) ** 2).sum(axis=1) - explained, windows @ leap


@lru_cache
def _lines(side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Orthonormal bases of two lines that do not meet, ``(2 side, 4)``, and of those that meet on
    any other sample, three columns each; and what gives the leap between the former, ``(2 side,)``.
    """
    t = np.arange(2 * side) - (side - 0.5)
    right = (t > 0).astype(float)
    columns = np.column_stack([1.0 - right, (1.0 - right) * t, right, right * t])
    knots = t[1 : -1 : max(1, side // 6)]
    meeting = [
        np.linalg.qr(np.column_stack([np.ones_like(t), t, np.maximum(t - knot, 0.0)]))[0]
        for knot in knots
    ]
    fit = np.linalg.pinv(columns)
    return np.linalg.qr(columns)[0], np.hstack(meeting), fit[2] - fit[0]
