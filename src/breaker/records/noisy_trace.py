"""Measure values in a noisy curve, with errors that are propagated to first order.

Every value has its derivative by each sample of the curve and by each further error, so that the
uncertainty of values from overlapping windows includes their correlation.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count, pairwise

import numpy as np

from breaker.records.noise import filled, running_mean
from breaker.records.rejections import NotShownError

FEW = 6
"""Fewest samples of a local fit, two more than its coefficients, and of the mean of a rest."""

_WIDTH = 11.0  # of a local fit, so that the error of the cubic is a third of the error by noise
_MEMORY = 1e-4  # correlation of samples that counts as none
_SLIP = 0.7  # sd of the error of a slip, as a share of its size: any part of it may be travel
_NUMBERS = count()  # numbers of errors
_BLOCKS = 40  # means of neighbouring samples to which settling is fitted; more give the same


@dataclass(eq=False)
class LocalCubic:
    """Cubic through the samples about a time."""

    near: float  # the time, ms
    half: float  # half of the width, ms
    shares: np.ndarray  # times of the samples relative to near, divided by half, (w,)
    travel: np.ndarray  # travel of the samples, (w,), mm
    window: np.ndarray  # places of the samples, (w,)
    error: float  # error by rounding, mm

    def __post_init__(self) -> None:
        powers = self.shares[:, None] ** np.arange(4)
        self._inverse = np.linalg.solve(powers.T @ powers, powers.T)

    def weights(self, time: float, order: int = 0) -> np.ndarray:
        """Return the weights of the samples in the value or a derivative at a time, ``(w,)``."""
        u = (time - self.near) / self.half
        rows = (1.0, u, u * u, u**3), (0.0, 1.0, 2.0 * u, 3.0 * u * u), (0.0, 0.0, 2.0, 6.0 * u)
        return np.array(rows[order]) / self.half**order @ self._inverse

    def value(self, time: float, order: int = 0) -> float:
        """Return the value or a derivative, mm/ms^order."""
        return float(self.weights(time, order) @ self.travel)

    def solve(self, time: float, value: float, order: int = 0) -> float:
        """Return the time in the window, near ``time``, at which the fit has a value."""
        for _ in range(6):  # steps of Newton's method, which doubles the correct digits
            slope = self.value(time, order + 1)
            step = (self.value(time, order) - value) / slope if slope else 0.0
            time = min(max(time - step, self.near - self.half), self.near + self.half)
        return time


def settling(travel: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Return the position at which travel ``(n,)`` at even times comes to rest, mm, and its weights
    of the travel, ``(n,)``; None if it does not settle.

    Late in a motion, ``y'' + r y' + s (y - e) = 0``: a damped swing, or the sum of two decays,
    about the rest e. Summed twice, the equation is linear in r, s and s e, and the noise averages.
    """
    n = travel.size
    sums, x = np.tri(n) / n, np.arange(n) / n
    once = sums @ travel
    inverse = np.linalg.pinv(np.column_stack([np.ones(n), x, x**2, -once, -sums @ once]))
    _, _, square, r, s = inverse @ travel
    if not (r > 0.0 and s > 0.0):
        return None
    rest = 2.0 * square / s
    slopes = np.array([0.0, 0.0, 2.0 / s, 0.0, -rest / s]) @ inverse
    return float(rest), slopes + (r * slopes + s * slopes @ sums) @ sums


@dataclass(frozen=True, eq=False)
class Uncertain:
    """A value with its derivatives."""

    value: float  # the value
    slope: np.ndarray | float  # derivative by each sample of the curve, (n,)
    # derivative by each further error, in its standard deviations, by the number of the error
    errors: Mapping[int, float] = field(default_factory=dict)

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


def error_of(value: float, sd: float) -> Uncertain:
    """Return a value with an independent error."""
    return Uncertain(value, 0.0, {next(_NUMBERS): sd})


@dataclass(eq=False)
class Trace:
    """Curve of one motion, whose travel increases."""

    time: np.ndarray  # times, (n,), ms, evenly spaced
    # travel in the direction of the motion, (n,), mm; NaN where a sample is missing
    travel: np.ndarray
    noise: float  # standard deviation of the noise of a sample, rounding included, mm
    colour: float  # correlation of the noise of neighbouring samples
    quantum: float  # step of the reading, mm; 0 where the step is below the noise
    duration: float  # approximate duration of the motion, ms
    stroke: float  # approximate distance between the rests, mm
    ripple: float = 0.0  # root mean square of a ripple of the reading while the drive moves, mm
    # slips: samples from which on the reading is wrong by an unknown share of a size, mm
    slips: Sequence[tuple[int, float]] = ()

    def __post_init__(self) -> None:
        self._there = ~np.isnan(self.travel)
        self.known = self.time[self._there]
        self.step = float(self.time[1] - self.time[0])
        # Factor by which coloured noise increases the variance of a mean of many samples.
        self.inflation = (1.0 + self.colour) / (1.0 - self.colour)

    @cached_property
    def half(self) -> float:
        """Half the width of local fits, ms."""
        noise = self.noise * math.sqrt(0.5 * self.inflation * self.step / self.duration)
        share = (_WIDTH * noise / self.stroke) ** 0.4
        return max(share * self.duration, 0.5 * (FEW - 1) * self.step)

    @cached_property
    def smooth(self) -> np.ndarray:
        """Running mean over the width of a local fit, ``(n,)``, to find where to fit."""
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
                square += (_SLIP * size * float(result.slope[place:].sum())) ** 2
        return math.sqrt(square)

    def rest(self, begin: float, end: float) -> Uncertain:
        """Return the mean travel between two times, at rest.

        Raises:
            NotShownError: If there are no samples between the times.
        """
        window = self._window(begin, end)
        if not window.size:
            raise NotShownError("too little rest before or after the motion")
        mean = self._of(float(self.travel[window].mean()), window, 1.0 / window.size)
        return mean + error_of(0.0, self._rounding())

    def parts(self, begin: float, end: float, count: int) -> list[Uncertain]:
        """Return the means of equal parts of a rest; an empty list if a part has few samples."""
        marks = np.linspace(begin, end, count + 1)
        if min(self._window(*part).size for part in pairwise(marks)) < FEW:
            return []
        return [self.rest(*part) for part in pairwise(marks)]

    def settles(self, begin: float, end: float) -> Uncertain | None:
        """Return the position at which travel between two times settles, None if unknown."""
        window = self._window(begin, end)
        every = max(1, window.size // _BLOCKS)
        window = window[window.size % every :]
        result = settling(self.travel[window].reshape(-1, every).mean(axis=1))
        if result is None:
            return None
        rest = self._of(result[0], window, np.repeat(result[1], every) / every)
        return rest + error_of(0.0, self._rounding())

    def at(self, time: Uncertain) -> Uncertain:
        """Return the travel at a time."""
        fit = self._fit(time.value)
        travel = self._value(fit, time.value, self.ripple)
        return travel + (time + -time.value) * fit.value(time.value, 1)

    def at_corner(self, time: Uncertain, lost: float, sd: float) -> Uncertain:
        """Return the travel at a time at which the drive loses a share of its speed at once.

        A local cubic rounds this corner by 3/32 of the change of slope times half its width.
        """
        fit = self._fit(time.value)
        change = 3.0 / 32.0 * fit.value(time.value, 1) * fit.half
        return self.at(time) + error_of(change * lost, change * sd)

    def reaches(
        self, level: Uncertain, after: float = -math.inf, *, before: float | None = None
    ) -> Uncertain:
        """Return the first time after ``after`` at which the travel reaches a level.

        Args:
            level, after: Level, mm, and time, ms.
            before: Return the last time before this time instead, ms, if given.

        Raises:
            NotShownError: If the travel never reaches the level.
        """
        if before is None:
            places = np.flatnonzero((self.smooth >= level.value) & (self.time > after))
            place = places[0] if places.size else 0
        else:
            places = np.flatnonzero((self.smooth <= level.value) & (self.time < before))
            place = places[-1] if places.size else 0
        if place == 0:
            raise NotShownError("the record does not pass the point")
        fit = self._fit(self.time[place])
        time = fit.solve(self.time[place], level.value)
        speed = fit.value(time, 1)
        if not speed > 0.0:
            raise NotShownError("the drive hardly moves at the point")
        return (level - self._value(fit, time, self.ripple)) * (1.0 / speed) + time

    def top(self, begin: float, end: float) -> Uncertain:
        """Return the largest travel between two times, as the top of a local fit."""
        stop = min(end, float(self.known[-2]))  # a fit needs samples on both sides
        later = self._window(min(begin, stop), stop)
        fit = self._fit(float(self.time[later[int(self.smooth[later].argmax())]]))
        time = min(fit.solve(fit.near, 0.0, 1), float(self.known[-1]))
        # Noise raises the top by half the variance of the slope over the second derivative:
        # without this correction, over-travels are 0.3 sds too large.
        slope = self.sd(self._of(0.0, fit.window, fit.weights(time, 1)))
        bend = max(-fit.value(time, 2), slope / fit.half)
        return self._value(fit, time) + (-0.5 * slope**2 / bend if bend > 0.0 else 0.0)

    def _value(self, fit: LocalCubic, time: float, ripple: float = 0.0) -> Uncertain:
        """Return the value of a local fit, mm, with its error and that of a ripple."""
        travel = self._of(fit.value(time), fit.window, fit.weights(time))
        return travel + error_of(0.0, math.hypot(fit.error, ripple))

    def _window(self, begin: float, end: float) -> np.ndarray:
        """Return the places of the samples between two times that are not missing."""
        return np.flatnonzero((self.time >= begin) & (self.time <= end) & self._there)

    def _of(self, value: float, window: np.ndarray, weights: np.ndarray | float) -> Uncertain:
        """Return a value whose derivatives by the samples in a window are ``weights``."""
        slope = np.zeros(self.time.size)
        slope[window] = weights
        return Uncertain(value, slope)

    def _rounding(self, spread: float = 0.0) -> float:
        """Return the sd of the rounding error, mm, of a mean of readings with a spread, mm.

        Noise and motion across several steps of the reading average the rounding error.
        """
        if not self.quantum:
            return 0.0
        single = self.quantum / math.sqrt(12.0)
        noise = max(self.noise**2 - single**2, 0.0) / self.quantum**2
        return single * math.exp(-2.0 * math.pi**2 * noise) / (1.0 + spread / single)

    def _fit(self, near: float) -> LocalCubic:
        """Return the cubic fitted to the samples around the sample nearest to a time."""
        centre = round((near - float(self.time[0])) / self.step)
        for half in (self.half, 2.0 * self.half):  # wider where samples are missing
            reach = int(half / self.step + 1e-6)
            first = max(centre - reach, 0)
            window = first + np.flatnonzero(self._there[first : centre + reach + 1])
            if window.size >= FEW - 1 and window[0] < centre < window[-1]:
                break
        else:
            raise NotShownError("samples are missing at the point")
        travel, shares = self.travel[window], (window - centre) * self.step / half
        error = self._rounding(float(np.std(travel)))
        return LocalCubic(float(self.time[centre]), half, shares, travel, window, error)
