"""Values read from a noisy curve, with errors that are propagated to first order.

Every value has its slope by each sample of the curve and by each further error, so that values
from windows that overlap have the right uncertainty together.
"""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count

import numpy as np

from breaker.records.fits import LocalCubic, filled, level, running_mean
from breaker.records.rejections import NotShownError

_FEWEST = 6  # samples of a local fit or of part of a rest: two more than numbers of a cubic
# Half the width of a local fit: so that the error of the cubic, this share of the stroke for a fit
# as long as the motion, is a third of the noise's; at most this share of the motion.
_WIDTH, _BEND, _WIDEST = 11.0, 0.02, 0.2
_MEMORY = 1e-4  # correlation of samples that counts as none
_BLOCKS = 64  # means of neighbouring samples of a rest
_EXACT = 1e-10  # strokes^2, the least variance of noise that a rest is read with
SEEN = 3.0
"""Standard deviations from which a distance is seen: noise alone makes one in 370."""
_NUMBERS = count()  # of errors
_NO_REST = "too little rest before or after the motion"


@dataclass(frozen=True, eq=False)
class Uncertain:
    """A value with its slopes.

    Attributes:
        value: The value.
        slope: By each sample of the curve, ``(n,)``.
        errors: By each further error, in its standard deviations, by name or number.
    """

    value: float
    slope: np.ndarray | float
    errors: Mapping[Hashable, float] = field(default_factory=dict)

    def __add__(self, other: "Uncertain | float") -> "Uncertain":
        if not isinstance(other, Uncertain):
            return Uncertain(self.value + other, self.slope, self.errors)
        both = self.errors.keys() | other.errors.keys()
        errors = {k: self.errors.get(k, 0.0) + other.errors.get(k, 0.0) for k in both}
        return Uncertain(self.value + other.value, self.slope + other.slope, errors)

    def __mul__(self, factor: float) -> "Uncertain":
        errors = {k: factor * error for k, error in self.errors.items()}
        return Uncertain(self.value * factor, self.slope * factor, errors)

    def __sub__(self, other: "Uncertain") -> "Uncertain":
        return self + other * -1.0

    def __truediv__(self, other: "Uncertain") -> "Uncertain":
        value = self.value / other.value
        slopes = (self - other * value) * (1.0 / other.value)
        return Uncertain(value, slopes.slope, slopes.errors)


def error_of(value: float, sd: float, name: str = "") -> Uncertain:
    """Return a value with an error; values of one name share it."""
    return Uncertain(value, 0.0, {name or next(_NUMBERS): sd})


@dataclass(eq=False)
class Trace:
    """A curve of one motion, in its direction.

    Attributes:
        time: Times, ``(n,)``, ms, evenly spaced.
        travel: Travel in the direction of the motion, ``(n,)``, mm; NaN where a sample is missing.
        noise: Standard deviation of the noise of a sample, rounding included, mm.
        colour: Correlation of the noise of neighbouring samples.
        quantum: Step of the reading, mm; 0 where it is fine.
        duration: About how long the motion takes, ms.
        stroke: About its distance, mm.
        ripple: Root mean square of a ripple of the reading while the drive moves, mm.
        slips: Samples from which on the reading is off by an unknown part of so many mm.
    """

    time: np.ndarray
    travel: np.ndarray
    noise: float
    colour: float
    quantum: float
    duration: float
    stroke: float
    ripple: float = 0.0
    slips: Sequence[tuple[int, float]] = ()

    def __post_init__(self) -> None:
        self._there = ~np.isnan(self.travel)
        self.known = self.time[self._there]
        self.step = float(self.time[-1] - self.time[0]) / (self.time.size - 1)
        # Factor by which colour makes the variance of a mean of many samples larger.
        self.alike = (1.0 + self.colour) / (1.0 - self.colour)

    @cached_property
    def half(self) -> float:
        """Half the width of local fits, ms."""
        noise = self.noise * math.sqrt(0.5 * self.alike * self.step / self.duration)
        share = (_WIDTH * noise / self.stroke) ** 0.4
        return max(min(share, _WIDEST) * self.duration, 0.5 * (_FEWEST - 1) * self.step)

    @cached_property
    def smooth(self) -> np.ndarray:
        """Running mean over the width of a local fit, ``(n,)``, to look for places."""
        return running_mean(filled(self.travel), 2 * round(0.5 * self.half / self.step) + 1)

    def sd(self, result: Uncertain) -> float:
        """Return the standard deviation of a value."""
        square = sum(error * error for error in result.errors.values())
        if np.ndim(result.slope):
            slope = np.trim_zeros(result.slope)
            memory = math.ceil(math.log(_MEMORY) / math.log(max(self.colour, _MEMORY)))
            along = np.convolve(slope, self.colour ** np.arange(memory))[: slope.size]
            square += self.noise**2 * max(float(2.0 * slope @ along - slope @ slope), 0.0)
            for place, size in self.slips:
                square += (size * float(result.slope[place:].sum())) ** 2 / 3.0  # any part of it
        return math.sqrt(square)

    def rest(self, begin: float, end: float) -> Uncertain:
        """Return the mean travel between two times, at rest.

        Raises:
            NotShownError: If there is no sample.
        """
        window = self._window(begin, end)
        if not window.size:
            raise NotShownError(_NO_REST)
        return self._mean(window)

    def settled(
        self, begin: float, end: float, ways: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    ) -> Uncertain:
        """Return the travel at rest, where the reading may still move between two times.

        Args:
            begin, end: Those times, ms.
            ways: How it may move at some times, ms, in strokes, and how probable each way is.

        Raises:
            NotShownError: If there is no sample.
        """
        window = self._window(begin, end)
        if not window.size:
            raise NotShownError(_NO_REST)
        every = max(1, window.size // _BLOCKS)
        window = window[window.size % every :]
        time, travel = (each[window].reshape(-1, every) for each in (self.time, self.travel))
        moves, chances = ways(time.mean(axis=1))
        noise = max(self.alike * self.noise**2 / every, _EXACT * self.stroke**2)
        value, weights, hidden = level(travel.mean(axis=1), self.stroke * moves, chances, noise)
        rest = self._of(value, window, np.repeat(weights, every) / every)
        return rest + error_of(0.0, math.hypot(hidden, self._rounding(0.0)))

    def unrest(self, lasts: float) -> float:
        """Return by how much the means of four parts of the last time differ beyond noise, mm.

        Args:
            lasts: That time, ms; of a low rate longer, so that a part has samples enough.
        """
        count = max(round(lasts / self.step), 4 * _FEWEST)
        last = np.flatnonzero(self._there)[-count:]
        parts = [self._mean(part) for part in np.array_split(last, 4)]
        way = float(np.ptp([part.value for part in parts]))
        return max(0.0, way - SEEN * self.sd(parts[-1] - parts[0]))

    def at(self, time: Uncertain) -> Uncertain:
        """Return the travel at a time."""
        fit = self._fit(time.value)
        travel = self._of(fit.value(time.value), fit.window, fit.weights(time.value))
        moved = (time + -time.value) * fit.value(time.value, 1)
        return travel + moved + error_of(0.0, math.hypot(fit.error, self.ripple))

    def reaches(self, level: Uncertain, after: float = -math.inf) -> Uncertain:
        """Return the first time after another one at which the travel reaches a level.

        Raises:
            NotShownError: If it does not reach it.
        """
        above = (self.smooth >= level.value) & (self.time > after)
        first = int(above.argmax())
        if not above[first] or first == 0:
            raise NotShownError("the record does not pass the point")
        return self._passes(level, self.time[first])

    def left(self, level: Uncertain, before: float) -> Uncertain:
        """Return the last time before another one at which the travel is at a level.

        Raises:
            NotShownError: If it never is.
        """
        below = np.flatnonzero((self.smooth <= level.value) & (self.time < before))
        if not below.size:
            raise NotShownError("the drive does not travel as far")
        return self._passes(level, self.time[below[-1]])

    def top(self, begin: float, end: float) -> Uncertain:
        """Return the largest travel between two times, as the top of a local fit."""
        stop = min(end, float(self.known[-2]))  # a fit has samples on both sides
        later = self._window(min(begin, stop), stop)
        fit = self._fit(float(self.time[later[int(self.smooth[later].argmax())]]))
        time = min(fit.solve(fit.near, 0.0, 1), float(self.known[-1]))
        travel = self._of(fit.value(time), fit.window, fit.weights(time))
        # The top of a noisy curve is higher than that of its mean, by half the variance of its
        # slope over its bend.
        slope = self.sd(self._of(0.0, fit.window, fit.weights(time, 1)))
        bend = max(-fit.value(time, 2), slope / fit.half)
        return travel + (-0.5 * slope**2 / bend if bend > 0.0 else 0.0)

    def _window(self, begin: float, end: float) -> np.ndarray:
        """Samples between two times that are there."""
        return np.flatnonzero((self.time >= begin) & (self.time <= end) & self._there)

    def _passes(self, level: Uncertain, near: float) -> Uncertain:
        """Time near another one at which the travel is at a level."""
        fit = self._fit(near)
        time = fit.solve(near, level.value)
        speed = fit.value(time, 1)
        if not speed > 0.0:
            raise NotShownError("the drive hardly moves at the point")
        travel = self._of(level.value, fit.window, fit.weights(time))
        travel += error_of(0.0, math.hypot(fit.error, self.ripple))
        return (level - travel) * (1.0 / speed) + time

    def _of(self, value: float, window: np.ndarray, weights: np.ndarray | float) -> Uncertain:
        """Value that is a weighted sum of the samples in a window."""
        slope = np.zeros(self.time.size)
        slope[window] = weights
        return Uncertain(value, slope)

    def _mean(self, window: np.ndarray) -> Uncertain:
        mean = self._of(float(self.travel[window].mean()), window, 1.0 / window.size)
        return mean + error_of(0.0, self._rounding(0.0))

    def _rounding(self, spread: float) -> float:
        """Error of rounding, mm, of a mean of readings of travel that spreads by an sd.

        Noise and motion across several steps even it out.
        """
        alone = self.quantum / math.sqrt(12.0)
        return alone / (1.0 + max(self.noise - alone, spread) / alone) if alone else 0.0

    def _fit(self, near: float) -> LocalCubic:
        """Cubic through the samples about the sample next to a time."""
        centre = round((near - float(self.time[0])) / self.step)
        centre = min(max(centre, 0), self.time.size - 1)
        for half in (self.half, 2.0 * self.half):  # wider where samples are missing
            reach = int(half / self.step + 1e-6)
            first = max(centre - reach, 0)
            window = first + np.flatnonzero(self._there[first : centre + reach + 1])
            if window.size >= _FEWEST - 1 and window[0] < centre < window[-1]:
                break
        else:
            raise NotShownError("samples are missing at the point")
        travel = self.travel[window]
        bend = _BEND * self.stroke * (half / self.duration) ** 2
        error = math.hypot(self._rounding(float(np.std(travel))), bend)
        shares = (window - centre) * self.step / half
        return LocalCubic(float(self.time[centre]), half, travel, window, shares, error)
