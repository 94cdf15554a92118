"""What drives of breakers are: ranges of stroke, speed and acceleration, far beyond which a record
is in another unit or at another rate.

From vacuum drives of 6 mm to those of 300 mm; an opening may be braked from early on.
"""

import numpy as np

from breaker.common.numerals import in_digits

STROKES = (2.0, 300.0)
"""Ways of drives, mm."""

SPEEDS = {"closing": (0.2, 8.0), "opening": (0.12, 14.0)}
"""Mean speeds of drives from 10 to 90 % of the way, m/s."""

TIMES = (0.5, 150.0)
"""Times that they take for that, ms."""

_GAINED = 3.0  # mm/ms^2, largest square of that speed over the stroke
_SHARES = 0.1, 0.9


def of_no_drive(motion: str, time: np.ndarray, done: np.ndarray, stroke: float) -> str:
    """Say why a motion is none of a breaker's drive; "" if it may be one.

    Args:
        motion: "closing" or "opening".
        time: Times, ``(t,)``, ms.
        done: Shares of the way that are done, ``(t,)``; nan where a sample is missing.
        stroke: Way between the rests, mm.
    """
    past = np.flatnonzero(done >= _SHARES[1])
    if not past.size:
        return ""
    low = np.flatnonzero(done[: past[0]] <= _SHARES[0])
    if not low.size:
        return ""
    lasts = max(float(time[past[0]] - time[low[-1]]), float(time[1] - time[0]))
    speed = (_SHARES[1] - _SHARES[0]) * stroke / lasts
    least, most = SPEEDS[motion]
    usual = least <= speed <= most and TIMES[0] <= lasts <= TIMES[1]
    if usual and speed**2 <= _GAINED * stroke:
        return ""
    return (
        f"{in_digits(stroke, 3)} mm in {in_digits(lasts, 3)} ms, {in_digits(speed, 3)} m/s, is no "
        f"{motion} of a breaker's drive: check the rate or unit of the time, and the unit or ratio "
        "of the travel"
    )
