"""Slips of a transducer that noise hides from a look at single samples.

A drive that slows down moves smoothly. Beside a cubic through the samples about a place, a slip is
a step there, as large in twice the time; a bend of the curve makes one that grows with the time.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from breaker.reading.records.error_propagation import Trace
from breaker.reading.records.motion_search import white_noise
from breaker.reading.records.running_statistics import filled

_DEGREE = 3
_FEWEST, _LONGEST = 4, 0.05  # samples on either side; of the time of the motion, at most
_CLEAR = 6.0  # sd of a step by noise, from which it is seen; of the thousands that are tried
_LEAST = 0.003  # strokes, step that counts
_RIPPLES = 2.0  # times the root mean square of a ripple, which makes steps, too
_ALIKE = 0.7, 4 / 3  # of a step, that of twice the time


def hidden_slip(trace: Trace, arrival: float) -> tuple[int, float] | None:
    """Return the clearest slip after a motion's arrival that is not among the trace's own.

    Args:
        arrival: Time from which the drive slows down, ms.

    Returns:
        The sample from which on the travel is elsewhere, and by how much, mm; None without one.

    Example:
        >>> time = np.arange(0.0, 100.0, 0.1)
        >>> way = 150.0 * np.sin(0.5 * np.pi * np.clip(time / 50.0, 0.0, 1.0))
        >>> way += 0.1 * np.random.default_rng(1).standard_normal(time.size)
        >>> trace = Trace(time, way + 1.2 * (time > 45.0), 0.1, 0.0, 0.0, 35.0, 150.0)
        >>> sample, size = hidden_slip(trace, 35.0)
        >>> bool(abs(time[sample] - 45.0) < 0.5 and abs(size - 1.2) < 0.3)
        True
        >>> hidden_slip(Trace(time, way, 0.1, 0.0, 0.0, 35.0, 150.0), 35.0) is None
        True
    """
    tried = list(_steps(trace))
    least = max(_LEAST * trace.stroke, _RIPPLES * trace.ripple)
    best, found = _CLEAR, None
    for (count, steps, sd), (_, longer, _) in pairwise(tried):
        low, high = np.sort([share * steps for share in _ALIKE], axis=0)
        size = np.where((longer > low) & (longer < high), np.abs(steps), 0.0)
        size[: np.searchsorted(trace.time, arrival)] = 0.0
        for place, _ in trace.slips:
            size[max(place - 2 * count, 0) : place + 2 * count] = 0.0
        place = int(size.argmax())
        if size[place] > max(least, best * sd):
            best, found = size[place] / sd, (place, float(steps[place]))
    return found


def _steps(trace: Trace) -> Iterator[tuple[int, np.ndarray, float]]:
    """Samples on either side, the step before each sample beside a cubic through these, ``(n,)``,
    mm, and its sd by noise; of more and more samples, twice as many as the longest at last.
    """
    travel, count = filled(trace.travel), _FEWEST
    if not trace.noise:
        return  # it hides nothing
    noise = max(trace.noise, white_noise(travel)) * float(np.sqrt(trace.alike))
    longest = max(_LONGEST * trace.duration / trace.step, _FEWEST)
    while count <= 2.0 * longest and travel.size > 2 * count:
        at = (np.arange(2 * count) + 0.5) / count - 1.0
        shapes = np.column_stack([np.vander(at, _DEGREE + 1), 0.5 * np.sign(at)])
        weights = np.linalg.pinv(shapes)[-1]
        steps = np.zeros(travel.size)
        steps[count : travel.size - count + 1] = np.convolve(travel, weights[::-1], "valid")
        yield count, steps, noise * float(np.linalg.norm(weights))
        count *= 2
