"""Damage a record by faults between the moving contact and the numbers of a file.

Each kind is a function of a good record and a generator, ``(time, travel, rng) -> (time, travel)``,
both ``(t,)``, ms and mm; a sample without a reading is NaN. The severity of the damage is drawn
over orders of magnitude, from below the noise to the loss of the entire record.
``studies.faults.files`` damages the text of a file.
"""

from collections.abc import Callable

import numpy as np

Record = tuple[np.ndarray, np.ndarray]
PHYSICAL: dict[str, Callable[[np.ndarray, np.ndarray, np.random.Generator], Record]] = {}
"""Kinds of damage by name."""


def kind(damage: Callable) -> Callable:
    """Register a kind of damage by the name of its function."""
    PHYSICAL[damage.__name__.replace("_", " ")] = damage
    return damage


def size(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a size between two, uniform in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _signed(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.choice([-1.0, 1.0])) * size(rng, low, high)


def _part(rng: np.random.Generator, total: int, shortest: float) -> slice:
    """Return a stretch of samples of random length, at least ``shortest``."""
    length = round(size(rng, shortest, total))
    first = int(rng.integers(0, total - length + 1))
    return slice(first, first + length)


def _stretch(time: np.ndarray, low: float, high: float, rng: np.random.Generator) -> slice:
    """Return a stretch of samples that lasts between ``low`` and ``high``, ms."""
    length = round(size(rng, low, high) / float(np.median(np.diff(time))))
    first = int(rng.integers(0, max(1, time.size - length)))
    return slice(first, first + length)


@kind
def clipped(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The range of the channel ends inside the stroke: 0.1 to 100 % of it are cut off."""
    low, high = travel.min(), travel.max()
    cut = size(rng, 0.001, 1.0) * (high - low)
    return time, np.clip(travel, *((low, high - cut) if rng.random() < 0.5 else (low + cut, high)))


@kind
def offset(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The zero is wrong by 0.01 to 30 mm."""
    return time, travel + _signed(rng, 0.01, 30.0)


@kind
def slipped(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The mount of the sensor slips once, by 0.05 to 10 mm."""
    return time, travel + _signed(rng, 0.05, 10.0) * (time > rng.uniform(time[0], time[-1]))


@kind
def gain(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The scale is wrong by 0.1 to 100 %, up or down."""
    return time, travel * np.exp(_signed(rng, 0.001, 1.0))


@kind
def stuck(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The reading stays constant for 0.2 ms up to the entire record, then continues correctly."""
    part, travel = _part(rng, time.size, 2), travel.copy()
    travel[part] = travel[part.start]
    return time, travel


@kind
def blocks_swapped(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """Two neighbouring blocks of a buffer, of 1 to 200 samples, are swapped."""
    length = min(round(size(rng, 1, 200)), time.size // 2)
    i = int(rng.integers(0, time.size - 2 * length + 1))
    order = np.arange(time.size)
    order[i : i + 2 * length] = np.roll(order[i : i + 2 * length], length)
    return time, travel[order]


@kind
def gap(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """A stretch from one sample up to nearly the entire record has no reading."""
    travel = travel.copy()
    travel[_part(rng, time.size, 1)] = np.nan
    return time, travel


@kind
def rows_lost(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """A stretch, or single samples, are lost together with their times."""
    keep = np.ones(time.size, dtype=bool)
    if rng.random() < 0.5:
        keep[_part(rng, time.size - 2, 1)] = False
    else:
        keep = rng.random(time.size) >= size(rng, 0.001, 0.9)
        keep[:2] = True
    return time[keep], travel[keep]


@kind
def samples_lost(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """A stretch of samples is lost, but the times continue without a gap: a buffer overran."""
    part = _part(rng, time.size - 2, 1)
    left = np.delete(travel, np.r_[part])
    return time[: left.size], left


@kind
def time_scaled(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The clock, and so all times, are wrong by 0.01 to 100 %."""
    return time * np.exp(_signed(rng, 1e-4, 1.0)), travel


@kind
def time_jumps(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The clock jumps once, by 1 µs to 1 s, forward or back."""
    return time + _signed(rng, 1e-3, 1e3) * (time > rng.uniform(time[0], time[-1])), travel


@kind
def spikes(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """Single samples, 1 to 30, are wrong by 0.05 to 100 mm."""
    travel, count = travel.copy(), round(size(rng, 1, 30))
    height = size(rng, 0.05, 100.0)
    where = rng.choice(time.size, count, replace=False)
    travel[where] += height * rng.choice([-1.0, 1.0], count)
    return time, travel


@kind
def burst(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """Noise of 0.1 to 30 mm is added for 0.2 to 20 ms."""
    part, travel = _stretch(time, 0.2, 20.0, rng), travel.copy()
    travel[part] += size(rng, 0.1, 30.0) * rng.standard_normal(travel[part].size)
    return time, travel


@kind
def excursion(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """One smooth excursion of 0.1 to 30 mm and back, in 0.5 to 50 ms."""
    part, travel = _stretch(time, 0.5, 50.0, rng), travel.copy()
    travel[part] += _signed(rng, 0.1, 30.0) * np.hanning(travel[part].size + 2)[1:-1]
    return time, travel


@kind
def quantised(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The reading has steps of 0.01 to 5 mm."""
    step = size(rng, 0.01, 5.0)
    return time, step * np.rint(travel / step)


@kind
def noisy(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """White noise of 0.01 to 3 mm is added."""
    return time, travel + size(rng, 0.01, 3.0) * rng.standard_normal(time.size)


@kind
def hum(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """Mains hum of 50 or 60 Hz and 0.01 to 5 mm is added."""
    phase = 2 * np.pi * (rng.choice([0.05, 0.06]) * time + rng.random())
    return time, travel + size(rng, 0.01, 5.0) * np.sin(phase)


@kind
def smoothed(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """A filter averages over 2 to 100 neighbours."""
    width = round(size(rng, 2, 100))
    ends = np.pad(travel, (width // 2, (width - 1) // 2), mode="edge")
    return time, np.convolve(ends, np.full(width, 1.0 / width), mode="valid")


@kind
def begins_late(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The first 0.1 to 99 % of the record are missing."""
    first = round(size(rng, 0.001, 0.99) * time.size)
    return time[first:], travel[first:]


@kind
def ends_early(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """The last 0.1 to 99 % of the record are missing."""
    last = time.size - round(size(rng, 0.001, 0.99) * time.size)
    return time[:last], travel[:last]


@kind
def nothing(time: np.ndarray, travel: np.ndarray, rng: np.random.Generator) -> Record:
    """Nothing is wrong, which shows how often a good record is rejected or has a remark."""
    return time, travel
