"""Motions of many drives, laid onto records as a transducer reads them: compiled, so that other
threads need not wait.
"""

import numpy as np

from breaker.common.compiling import compiled
from breaker.drive.simulation.integrator import closed_rest, follow
from breaker.drive.simulation.paths import curve, passing, sampled
from breaker.drive.simulation.rich_drive import CONTACTS, ELEMENTS
from breaker.quantities.parameters import GAP, NAMES

TOLERANCE = 1e-4
"""mm and mm/ms, error of a step of a drive of size 1: the reading is right to some micrometres."""

_GAP = NAMES.index(GAP.name)
_LINKAGE = len(NAMES) + ELEMENTS.index("linkage")
_CONTACT = len(NAMES) + ELEMENTS.index("contact")
_SLIDING = CONTACTS.index("sliding")
_FOLLOWED = 400.0  # ms, of a drive of size 1, until which half of the way is made


@compiled()
def closed_travel(numbers, touch):
    """Travel of a drive that is closed, mm; nan where it does not work.

    Args:
        numbers: Of a drive of size 1.
        touch: Way to the touch of a contact that slides, least and most, share of the stroke.
    """
    rest = closed_rest(numbers)
    if not np.isfinite(rest):
        return np.nan
    steps, _ = follow(numbers, rest, False, 1e-9, np.inf, TOLERANCE)
    if not len(steps):
        return np.nan
    share = numbers[_GAP] / steps[0, 2]
    slides = numbers[_CONTACT] == _SLIDING
    return np.nan if slides and not touch[0] <= share <= touch[1] else steps[0, 2]


@compiled(nogil=True)
def closed_travels(numbers, touch):
    """``closed_travel`` of drives ``(n, p + e)``, ``(n,)``."""
    found = np.empty(len(numbers))
    for i in range(len(numbers)):
        found[i] = closed_travel(numbers[i], touch)
    return found


@compiled(nogil=True)
def landmarks(numbers, touch, closing):
    """Strokes, mm, and when 10 and 50 % of the way are made, ms after the release, ``(n, 3)``.

    Args:
        numbers: Of drives of size 1, ``(n, p + e)``.
        touch: As of ``closed_travel``.
        closing: Whether they close.

    Returns:
        nan of drives that do not work, or do not move.
    """
    found = np.full((len(numbers), 3), np.nan)
    for i in range(len(numbers)):
        stroke = closed_travel(numbers[i], touch)
        if np.isfinite(stroke):
            rest = closed_rest(numbers[i])
            steps, _ = follow(numbers[i], rest, closing, _FOLLOWED, 1.0, TOLERANCE)
            if len(steps):
                pieces = curve(steps, numbers[i, _LINKAGE])
                found[i, 0] = stroke
                for k, share in enumerate((0.1, 0.5)):
                    level = stroke * (share if closing else 1.0 - share)
                    found[i, 1 + k] = passing(pieces, level)
    return found


@compiled(nogil=True)
def readings(numbers, closing, times, begins, units):
    """Read the motions of drives that work.

    Args:
        numbers: Of drives of size 1, ``(n, p + e)``.
        closing: Whether they close.
        times: Of the samples, ms, ``(t,)``.
        begins: When each is released, ms, ``(n,)``; nan of one that is left out.
        units: Size of each, lengths and times, ``(n, 2)``.

    Returns:
        Travel ``(n, t)``, mm; and the time of touch or parting, ms, ``(n,)``. Both are nan of a
        drive that is left out or whose curve is not finite.
    """
    travel, switching = np.full((len(numbers), times.size), np.nan), np.full(len(numbers), np.nan)
    for i in range(len(numbers)):
        if np.isfinite(begins[i]):
            at = (times - begins[i]) / units[i, 1]
            rest, end = closed_rest(numbers[i]), max(at[-1], 1e-9)
            steps, switches = follow(numbers[i], rest, closing, end, np.inf, TOLERANCE)
            if len(steps):
                travel[i] = units[i, 0] * sampled(curve(steps, numbers[i, _LINKAGE]), at)
                switching[i] = begins[i] + units[i, 1] * switches
    return travel, switching
