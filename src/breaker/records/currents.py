"""Currents of coil and motor: what a recorder of a breaker's control circuits shows of a motion.

A coil's current rises slowly, dips as the armature moves and arrives, rises to its end and is
broken by the auxiliary contact. A motor that charges a spring draws an inrush, then its running
current, until the limit switch. All is read from the record's own samples, and nothing is told of a
channel whose unit is no current.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from statistics import NormalDist
from typing import NamedTuple, Self

import numpy as np

from breaker.records.fits import filled, running_mean
from breaker.records.rejections import NotShownError

_SMOOTH = 0.5  # ms, over which a coil's current is averaged
_PERIOD = 20.0  # ms, over which a motor's is squared and averaged: of 50 Hz, and of 60 Hz nearly
_FLOWS = 0.2  # of the largest, from which on a current flows
_BREAKS = 0.9  # of its level before, below which a coil's current is broken
_CLEAR = 6.0  # sd of the noise of a mean, from which on something is seen
_DIP = 0.02  # of the largest, least depth of a dip
_FEWEST = 8  # samples of a current
_INRUSH = 0.25  # of the time that a motor runs, in which its inrush is
_RUNS = 100.0  # ms, for which a motor runs at least
_TINY = 1e-12  # A


class Channel(NamedTuple):
    """A channel of a record.

    Attributes:
        values: At the times of the record, ``(n,)``, in its unit; nan where a sample is missing.
        amperes: One of its unit, A; nan where that is no current.
    """

    values: np.ndarray
    amperes: float


@dataclass(eq=False)
class Currents:
    """Currents of a record beside one motion; each method returns a value and its sd, or raises
    NotShownError.

    Attributes:
        time: Times of the whole record, ``(n,)``, ms.
        channels: Those of ``word_meanings.BESIDE`` that the record has: "trigger" is the coil's.
        inside: The samples of the motion.
        moves: Its first motion, ms.
        trigger, trigger_sd: When the coil was energised, and the sd of that, ms.
    """

    time: np.ndarray
    channels: Mapping[str, Channel] = field(default_factory=dict)
    inside: slice = field(default_factory=lambda: slice(None))
    moves: float = np.nan
    trigger: float = np.nan
    trigger_sd: float = 0.0

    def coil_current(self) -> tuple[float, float]:
        """Largest current of the coil above its rest, A."""
        top, sd = float(self._coil.own.max()), self._coil.noise_of_mean
        # The largest of many means is above the level that all of them have.
        many = (self._coil.own > top - 2.0 * sd).sum() * self._coil.step / _SMOOTH
        above = sd * NormalDist().inv_cdf(many / (many + 1.0)) if many > 1.0 else 0.0
        return top - above, float(np.hypot(sd, 0.5 * above))

    def coil_dip_time(self) -> tuple[float, float]:
        """Time from the trigger to the dip that the armature makes as it arrives, ms."""
        return self._since_trigger(self._coil.dip())

    def coil_off_time(self) -> tuple[float, float]:
        """Time from the trigger until the current is broken, ms."""
        return self._since_trigger(self._coil.broken())

    def motor_inrush(self) -> tuple[float, float]:
        """Largest root mean square current of the motor as it starts, A."""
        own = self._motor.own
        return float(own[: max(int(_INRUSH * own.size), 1)].max()), self._motor.noise_of_mean

    def motor_current(self) -> tuple[float, float]:
        """Median root mean square current of the motor behind its inrush, A."""
        level = self._motor.own[int(_INRUSH * self._motor.own.size) :]
        middle = float(np.median(level))
        many = max(level.size * self._motor.step / _PERIOD, 1.0)
        spread = 1.4826 * float(np.median(np.abs(level - middle))) / np.sqrt(many)
        return middle, float(np.hypot(spread, self._motor.noise_of_mean))

    def charging_time(self) -> tuple[float, float]:
        """Time for which the motor runs, s."""
        begins, ends = self._motor.ends()
        sd = np.hypot(_PERIOD / 4.0, self._motor.step) / np.sqrt(6.0)  # of two edges
        return 1e-3 * (ends - begins), 1e-3 * float(sd)

    @cached_property
    def _coil(self) -> "_Pulse":
        """The coil's pulse, the first from the trigger on."""
        values = self._amperes("trigger", "coil", self.inside)
        if not np.isfinite(self.trigger):
            raise NotShownError("no trigger: when the coil was energised is not known")
        time = self.time[self.inside]
        before = time < self.trigger
        current = values - _rest(values, before)
        current *= np.sign(current[int(np.nanargmax(np.abs(current)))])
        return _Pulse.of(time, current, running_mean, _SMOOTH, ~before)

    @cached_property
    def _motor(self) -> "_Pulse":
        """The motor's run, the longest after the first motion: a drive is charged behind it."""
        values = self._amperes("motor", "motor", slice(None))
        later = self.time >= self.moves
        current = values - _rest(values, ~later)
        found = _Pulse.of(self.time, current, _running_rms, _PERIOD, later)
        if found.own.size * found.step < _RUNS:
            raise NotShownError(f"the motor does not run for {_RUNS:g} ms")
        return found

    def _amperes(self, kind: str, what: str, part: slice) -> np.ndarray:
        """Values of a part of a channel, A."""
        if kind not in self.channels:
            raise NotShownError(f"no channel of the {what}'s current")
        values, amperes = self.channels[kind]
        if np.isnan(amperes):
            raise NotShownError(
                f"the column of the {what} states no unit of a current, as '{what} current [A]' "
                "does"
            )
        values = values[part] * amperes
        if (~np.isnan(values)).sum() < _FEWEST:
            raise NotShownError(f"the {what}'s current has hardly a sample")
        return values

    def _since_trigger(self, found: tuple[float, float]) -> tuple[float, float]:
        at, sd = found
        return at - self.trigger, float(np.hypot(sd, self.trigger_sd))


@dataclass(eq=False)
class _Pulse:
    """A current that flows for a while.

    Attributes:
        time, current, smooth: ``(n,)``, ms and A, above the rest, without gaps.
        noise, noise_of_mean: Standard deviations of a sample and of a smooth value, A.
        first, last: First and last sample of the flow.
    """

    time: np.ndarray
    current: np.ndarray
    smooth: np.ndarray
    noise: float
    noise_of_mean: float
    first: int
    last: int

    @classmethod
    def of(
        cls,
        time: np.ndarray,
        current: np.ndarray,
        smoothing: Callable[[np.ndarray, int], np.ndarray],
        width: float,
        may: np.ndarray,
    ) -> Self:
        """Return the longest flow among the samples ``(n,)`` that may be of it.

        Args:
            smoothing: Of samples over an odd number of them, for as long as the width, ms.
        """
        current = filled(current)
        count = 2 * round(0.5 * width / float(np.median(np.diff(time)))) + 1
        noise = 1.4826 * float(np.median(np.abs(np.diff(current, n=3)))) / np.sqrt(20.0)
        of_mean = max(noise / float(np.sqrt(count)), _TINY)
        smooth = smoothing(current, count)
        flows = may & (smooth > max(_FLOWS * smooth[may].max(initial=0.0), _CLEAR * of_mean))
        edges = np.flatnonzero(np.diff(np.concatenate([[0], flows.astype(int), [0]])))
        if not edges.size:
            raise NotShownError("no current flows")
        runs = edges.reshape(-1, 2)
        first, behind = runs[int(np.ptp(runs, axis=1).argmax())]
        return cls(time, current, smooth, noise, of_mean, int(first), int(behind) - 1)

    @property
    def step(self) -> float:
        """Time between two samples, ms."""
        return float(self.time[1] - self.time[0])

    @property
    def own(self) -> np.ndarray:
        """Smooth current while it flows."""
        return self.smooth[self.first : self.last + 1]

    def ends(self) -> tuple[float, float]:
        """Times at which half of the power next to them is reached and left, ms."""
        count = max(round(_PERIOD / self.step), 1)
        if self.first < count or self.last >= self.time.size - count:
            raise NotShownError("the current flows when the record begins or ends")
        levels = np.median(self.own[:count]), np.median(self.own[-count:])
        half = [np.flatnonzero(self.own >= level / np.sqrt(2.0)) for level in levels]
        return tuple(float(self.time[self.first + k]) for k in (half[0][0], half[1][-1]))

    def broken(self) -> tuple[float, float]:
        """When a current is broken for good, and the sd of that, ms."""
        if self.last == self.time.size - 1:
            raise NotShownError("the current still flows when the record ends")
        count = max(round(_SMOOTH / self.step), 1)
        before = self.own[-16 * count : -4 * count]
        level = float(np.median(before if before.size else self.own))
        above = self.current[: self.last + 1] >= _BREAKS * level - 3.0 * self.noise
        at = int(np.flatnonzero(above)[-1]) if above.any() else self.last
        return float(self.time[at]) + 0.5 * self.step, max(0.5 * _SMOOTH, self.step) / np.sqrt(3.0)

    def dip(self) -> tuple[float, float]:
        """When the deepest dip between two larger currents is, and the sd of that, ms."""
        from scipy.signal import find_peaks  # here, as most records have no current

        least = max(_CLEAR * np.sqrt(2.0) * self.noise_of_mean, _DIP * float(self.own.max()))
        found, about = find_peaks(-self.own, prominence=least)
        if not found.size:
            raise NotShownError("the coil's current shows no dip of the armature")
        k = int(about["prominences"].argmax())
        low = self.own <= self.own[found[k]] + 2.0 * self.noise_of_mean
        near = np.flatnonzero(low[about["left_bases"][k] : about["right_bases"][k]])
        half = 0.5 * max(np.ptp(near) * self.step, _SMOOTH)
        return float(self.time[self.first + found[k]]), float(half / np.sqrt(3.0))


def _running_rms(current: np.ndarray, count: int) -> np.ndarray:
    """Root mean squares of an odd number of samples about each of ``(n,)``."""
    return np.sqrt(np.maximum(running_mean(np.square(current), count), 0.0))


def _rest(values: np.ndarray, before: np.ndarray) -> float:
    """Level of a current at rest: before it flows, or else that of the ends which is nearer 0, as
    a recorder that starts with the trigger shows no rest before.
    """
    there = ~np.isnan(values)
    if (before & there).sum() >= _FEWEST:
        return float(np.median(values[before & there]))
    ends = [float(np.median(each)) for each in (values[there][:_FEWEST], values[there][-_FEWEST:])]
    return min(ends, key=abs)
