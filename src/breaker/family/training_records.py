"""Records of a bank's curves for training, every batch by other sensors.

Beginning, end, rate, noise and its colour, steps and gaps are drawn for each record, which is then
normalised by the code that reads measured ones.
"""

import numpy as np

from breaker.common.compiling import compiled
from breaker.family.bank import GRID, GRID_STEP
from breaker.family.inputs import FINEST_STEP, NormalisedRecords
from breaker.family.shape import BEGIN, END, SHAPE_TIMES, effective_noise, normalise

_fast = compiled()

_LONGEST = 600  # samples: above 504, the longest record in the finest steps
_TRIES = 20  # records of a curve, before it counts as without a motion
_NOTHING = (0.0, 1.0, 1.0, 1.0, 0.0, 1.0)  # numbers about a record that is not there
_ERROR = 0.1  # of estimated noise: of its logarithm, and of its colour
_SAMPLING = (FINEST_STEP, 0.15)  # durations between samples
_BEGINS, _ENDS = (BEGIN, -0.5), (2.5, END)  # durations after 10 % of the travel
_WHOLE, _WHITE, _SMOOTH, _GAPLESS = 0.5, 0.6, 0.5, 0.9  # shares of records
_COLOUR = 0.8  # largest correlation of neighbouring samples
_QUANTUM = (0.1, 4.0)  # of the noise
_GAP = (0.1, 1.5)  # durations


def record_shapes(
    curves: np.ndarray,
    rng: np.random.Generator,
    noise: tuple[float, float],
    *,
    like: tuple[np.ndarray, np.ndarray] | None = None,
    wanted: np.ndarray | None = None,
) -> tuple[NormalisedRecords, np.ndarray]:
    """Record curves of one motion, and normalise the records.

    Args:
        curves: Travel over the stroke, ``(n, u)``, at the times of a bank.
        noise: Range of the noise of a sample, share of the stroke, log-uniform.
        like: Stroke and duration of other records, ``(n,)`` each, in which these are measured; in
            strokes and durations of these curves.
        wanted: Which curves are recorded, ``(n,)`` of bool; all if None. Others are not there.

    Returns:
        The records, in strokes and durations of their curves, and the times of 10 % of the travel
        as they show it, ``(n,)``. A curve of which no record shows a motion is not there.
    """
    n = len(curves)
    way, present = np.empty((n, SHAPE_TIMES.size)), np.empty((n, SHAPE_TIMES.size), dtype=np.bool_)
    about = np.empty((n, 6))
    units = np.array(like) if like else np.zeros((2, n))
    limits = np.log(np.array([*noise, *_SAMPLING, *_QUANTUM]))
    there = np.ones(n, dtype=np.bool_) if wanted is None else wanted.copy()
    _record(curves, rng, limits, units, way, present, about, there)
    origin, stroke, duration, sd, colour, step = about.T
    sd = np.exp(_ERROR * rng.standard_normal(n)) * sd
    colour = np.clip(colour + _ERROR * rng.standard_normal(n), 0.0, 0.95)
    return NormalisedRecords(there, way, present, stroke, duration, sd, colour, step), origin


@_fast
def _record(curves, rng, limits, units, way, present, about, there):
    """Record and normalise the curves that are to be there; ``there`` is then which ones are.

    ``about`` is origin, stroke, duration, noise, colour and step of each, ``(n, 6)``.
    """
    strokes, durations = units[0], units[1]
    out = np.empty(_LONGEST)
    for r in range(len(curves)):
        wanted, there[r] = there[r], False
        for _ in range(_TRIES if wanted else 0):
            begin = rng.uniform(*_BEGINS)
            end = END if rng.random() < _WHOLE else rng.uniform(*_ENDS)
            noise = np.exp(rng.uniform(limits[0], limits[1]))
            step = np.exp(rng.uniform(limits[2], limits[3]))
            colour = 0.0 if rng.random() < _WHITE else rng.uniform(0.0, _COLOUR)
            fine = rng.random() < _SMOOTH
            quantum = 0.0 if fine else noise * np.exp(rng.uniform(limits[4], limits[5]))
            n = min(_LONGEST, int((end - begin) / step) + 1)
            _samples(curves[r], rng, begin, step, noise, colour, quantum, out[:n])
            if rng.random() > _GAPLESS:
                first = rng.integers(0, n)
                out[first : min(n, first + int(rng.uniform(*_GAP) / step))] = np.nan
            like = strokes[r], durations[r]
            _, stroke, origin, duration = normalise(out[:n], step, like, way[r], present[r])
            there[r] = 0.2 < duration < 5.0 and stroke > 0.3
            if there[r]:
                break
        if not there[r]:
            way[r], present[r] = 0.0, False
            _put(about, r, _NOTHING)
            continue
        sd = np.sqrt(noise * noise + quantum * quantum / 12.0)
        length = strokes[r] if strokes[r] > 0.0 else stroke
        unit = durations[r] if durations[r] > 0.0 else duration
        sd = effective_noise(sd / length, colour, step / unit)
        _put(about, r, (begin + origin, stroke, duration, sd, colour, step / duration))


@_fast
def _put(about, r, numbers):
    """Set a row; numba takes 3 s to compile an assignment of several numbers."""
    for i in range(6):
        about[r, i] = numbers[i]


@_fast
def _samples(curve, rng, begin, step, noise, colour, quantum, out):
    """Sample a curve, with noise of a first-order process, rounded."""
    root, error = np.sqrt(1.0 - colour * colour), rng.standard_normal()
    for i in range(out.size):
        value = _at(curve, (begin + i * step - GRID[0]) / GRID_STEP) + noise * error
        error = colour * error + root * rng.standard_normal()
        out[i] = quantum * np.round(value / quantum) if quantum > 0.0 else value


@_fast
def _at(curve, place):
    """A curve between its points, by the cubic of Catmull and Rom."""
    i = min(max(int(np.floor(place)), 1), curve.size - 3)
    x = min(max(place, 0.0), curve.size - 1.0) - i
    a, b, c, d = curve[i - 1], curve[i], curve[i + 1], curve[i + 2]
    return b + 0.5 * x * (c - a + x * (2 * a - 5 * b + 4 * c - d + x * (3 * (b - c) + d - a)))
