"""Values read from a noisy curve, with errors that are propagated to first order.

Every value has its slope by each sample of the curve and by each further error, so that values
from windows that overlap have the right uncertainty together.
"""

import math
import sys
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count

import numpy as np

from breaker.records.fits import LocalCubic, filled, level, running_mean, settlings
from breaker.records.rejections import NotShownError

_FEWEST = 6  # samples of a local fit or of part of a rest: two more than numbers of a cubic
# Half the width of a local fit: so that the error of the cubic, this share of the stroke for a fit
# as long as the motion, is a third of the noise's; at most this share of the motion.
_WIDTH, _BEND, _WIDEST = 11.0, 0.02, 0.2
_MEMORY = 1e-4  # correlation of samples that counts as none
_BLOCKS = 64  # means of neighbouring samples of a rest
TAILS = (0.8, 0.55, 0.4)
"""Shares of the time after the arrival: the longest that ways to settle explain shows the rest."""
SEEN = 3.0
"""Standard deviations from which a distance is seen: noise alone makes one in 370."""
_NUMBERS = count()  # of errors


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
            raise NotShownError("too little rest before the motion")
        return self._mean(window)

    def settled(self, arrival: float, begun: float) -> Uncertain:
        """Return the travel at which the drive rests or will rest.

        Args:
            arrival, begun: When the drive arrived, and when the motion began, ms.
        """
        end = float(self.known[-1])
        for share in TAILS:
            rest, misfit = self._settled(arrival, end - share * (end - arrival), begun)
            if not misfit:
                break
        return rest + error_of(0.0, math.hypot(misfit, self._rounding(0.0)))

    def _settled(self, arrival: float, begin: float, begun: float) -> tuple[Uncertain, float]:
        """The same of the samples from a time on, and what no way to settle explains, mm."""
        window = self._window(begin, math.inf)
        every = max(1, window.size // _BLOCKS)
        window = window[window.size % every :]
        time, travel = (
            each[window].reshape(-1, every).mean(axis=1) for each in (self.time, self.travel)
        )
        late, begun = (time - arrival) / self.duration, (begun - arrival) / self.duration
        functions, ways, chances = settlings(late, begun)
        # Of a curve without noise, so that the digits suffice.
        least = math.sqrt(sys.float_info.epsilon) * self.stroke**2
        noise = max(self.alike * self.noise**2 / every, least)
        found = level(travel, self.stroke * functions, ways, chances, noise)
        value, weights, hidden, misfit = found
        rest = self._of(value, window, np.repeat(weights, every) / every)
        return rest + error_of(0.0, hidden), misfit

    def unrest(self, begin: float, end: float) -> float:
        """Return by how much means of four parts of a rest differ beyond noise, mm.

        Of a low rate the rest is longer, so that a part has samples enough.
        """
        count = max(self._window(begin, end).size, 4 * _FEWEST)
        parts = np.array_split(self._window(-math.inf, end)[-count:], 4)
        means = [self._mean(part) for part in parts if part.size]
        way = float(np.ptp([mean.value for mean in means]))
        return max(0.0, way - SEEN * self.sd(means[-1] - means[0]))

    def drift(self, begin: float, end: float) -> float:
        """Return the pace of a rest that goes on one way, seen over each of its thirds, mm/ms."""
        window = self._window(begin, end)
        if window.size < 3 * _FEWEST:
            return 0.0
        first, second, third = (self._mean(part) for part in np.array_split(window, 3))
        ways = (second - first).value, (third - second).value
        least = min(ways, key=abs)
        seen = ways[0] * ways[1] > 0.0 and abs(least) > SEEN * self.sd(second - first)
        return 3.0 * abs(least) / (end - begin) if seen else 0.0

    def at(self, time: Uncertain) -> Uncertain:
        """Return the travel at a time."""
        fit, window, error = self._fit(time.value)
        travel = self._of(fit.value(time.value), window, fit.weights(time.value))
        moved = (time + -time.value) * fit.value(time.value, 1)
        return travel + moved + error_of(0.0, error)

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
        fit, window, _ = self._fit(float(self.time[later[int(self.smooth[later].argmax())]]))
        time = min(fit.solve(fit.near, 0.0, 1), float(self.known[-1]))
        travel = self._of(fit.value(time), window, fit.weights(time))
        # The top of a noisy curve is higher than that of its mean, by half the variance of its
        # slope over its bend.
        slope = self.sd(self._of(0.0, window, fit.weights(time, 1)))
        bend = max(-fit.value(time, 2), slope / fit.half)
        return travel + (-0.5 * slope**2 / bend if bend > 0.0 else 0.0)

    def _window(self, begin: float, end: float) -> np.ndarray:
        """Samples between two times that are there."""
        return np.flatnonzero((self.time >= begin) & (self.time <= end) & self._there)

    def _passes(self, level: Uncertain, near: float) -> Uncertain:
        """Time near another one at which the travel is at a level."""
        fit, window, error = self._fit(near)
        time = fit.solve(near, level.value)
        speed = fit.value(time, 1)
        if not speed > 0.0:
            raise NotShownError("the drive hardly moves at the point")
        travel = self._of(level.value, window, fit.weights(time)) + error_of(0.0, error)
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

    def _fit(self, near: float) -> tuple[LocalCubic, np.ndarray, float]:
        """Cubic about the sample next to a time, its samples, and the error of its value, mm."""
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
        error = math.hypot(self._rounding(float(np.std(travel))), bend, self.ripple)
        shares = (window - centre) * self.step / half
        return LocalCubic(float(self.time[centre]), half, travel, shares), window, error
