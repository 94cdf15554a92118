"""Training records of a bank's curves, each by another sensor, normalised as measured records."""

import numpy as np

from breaker.common.compiling import compiled
from breaker.family.bank import GRID
from breaker.family.inputs import NormalisedRecords, Sensors
from breaker.family.shape import average, effective_noise, motion_of

_fast = compiled()
_motion_of, _average, _effective_noise = map(_fast, (motion_of, average, effective_noise))

_TRIES = 20  # records of a curve without a motion, after which the curve is absent


def record_shapes(
    curves: np.ndarray,
    rng: np.random.Generator,
    sensors: Sensors,
    *,
    like: tuple[np.ndarray, np.ndarray] | None = None,
    wanted: np.ndarray | None = None,
) -> tuple[NormalisedRecords, np.ndarray]:
    """Record curves of one motion, and normalise the records.

    Args:
        curves: Travel over the stroke, ``(n, u)``, at the times of a bank.
        sensors: Ranges of their sensors.
        like: Stroke and duration of other records as units, relative to the curves, ``(n,)`` each.
        wanted: Which curves are recorded, ``(n,)`` of bool; all if None. Others are absent.

    Returns:
        Records, in strokes and durations of their curves, and their times of 10 % of the travel,
        ``(n,)``. A curve is absent if no record of it shows a motion.
    """
    n = len(curves)
    seen, origin, units = NormalisedRecords.nothing(n), np.zeros(n), np.zeros((2, n))
    units[:] = like or 0.0
    logs = {name: tuple(np.log(getattr(sensors, name))) for name in ("noise", "step", "quantum")}
    there = np.ones(n, dtype=np.bool_) if wanted is None else wanted.copy()
    _record(curves, rng, sensors._replace(**logs), *units, there, origin, *seen[1:])
    sd = np.exp(sensors.error * rng.standard_normal(n)) * seen.noise
    colour = np.clip(seen.colour + sensors.error * rng.standard_normal(n), 0.0, 0.95)
    return seen._replace(there=there, noise=sd, colour=colour), origin


@_fast
def _record(curves, rng, sensors, strokes, durations, there, origins, ways, presents, *about):
    """Record the curves that are ``there``, and write to it which have a motion. Log-uniform ranges
    of sensors are logarithms; ``about`` is stroke, duration, noise, colour and step, ``(n,)`` each.
    """
    longest = int((sensors.ends[1] - sensors.begins[0]) / np.exp(sensors.step[0])) + 2
    out = np.empty(longest)
    for r in range(len(curves)):
        wanted, there[r] = there[r], False
        for _ in range(_TRIES if wanted else 0):
            begin = rng.uniform(*sensors.begins)
            end = sensors.ends[1] if rng.random() < sensors.entire else rng.uniform(*sensors.ends)
            noise = np.exp(rng.uniform(*sensors.noise))
            step = np.exp(rng.uniform(*sensors.step))
            colour = 0.0 if rng.random() < sensors.white else rng.uniform(0.0, sensors.colour)
            fine = rng.random() < sensors.smooth
            quantum = 0.0 if fine else noise * np.exp(rng.uniform(*sensors.quantum))
            n = min(longest, int((end - begin) / step) + 1)
            _samples(curves[r], rng, begin, step, noise, colour, quantum, out[:n])
            if rng.random() > sensors.gapless:
                first = rng.integers(0, n)
                out[first : min(n, first + int(rng.uniform(*sensors.gap) / step))] = np.nan
            motion = _motion_of(out[:n], step)
            _, stroke, origin, duration, _, _ = motion
            there[r] = 0.2 < duration < 5.0 and stroke > 0.3
            if there[r]:
                break
        if there[r]:
            length = strokes[r] if strokes[r] > 0.0 else stroke
            unit = durations[r] if durations[r] > 0.0 else duration
            _average(out[:n], step, motion, (length, unit), ways[r], presents[r])
            sd = np.sqrt(noise * noise + quantum * quantum / 12.0)
            sd = _effective_noise(sd / length, colour, step / unit)
            origins[r] = begin + origin
            for k, number in enumerate((stroke, duration, sd, colour, step / duration)):
                about[k][r] = number
        else:
            ways[r], presents[r] = 0.0, False


@_fast
def _samples(curve, rng, begin, step, noise, colour, quantum, out):
    """Sample a curve, with noise of a first-order process, rounded."""
    root, error = np.sqrt(1.0 - colour * colour), rng.standard_normal()
    for i in range(out.size):
        value = _at(curve, begin + i * step) + noise * error
        error = colour * error + root * rng.standard_normal()
        out[i] = quantum * np.round(value / quantum) if quantum > 0.0 else value


@_fast
def _at(curve, time):
    """Return a curve between its points, by the cubic of Catmull and Rom."""
    place = (time - GRID[0]) / (GRID[1] - GRID[0])
    i = min(max(int(np.floor(place)), 1), curve.size - 3)
    x = min(max(place, 0.0), curve.size - 1.0) - i
    a, b, c, d = curve[i - 1], curve[i], curve[i + 1], curve[i + 2]
    return b + 0.5 * x * (c - a + x * (2 * a - 5 * b + 4 * c - d + x * (3 * (b - c) + d - a)))
