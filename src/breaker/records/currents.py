"""Measure the current of the coil, and the resistance of the contact, during a motion.

The current of a coil rises slowly, dips as the armature arrives, and is interrupted by the
auxiliary contact. A resistance counts while its test current flows. A channel without a unit of
current or resistance has no values.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from breaker.records.contacts import CLEAR, FEWEST, LEAST, RESOLVED, SETTLED, ContactTimes
from breaker.records.conversion import seen_quantum
from breaker.records.noise import filled, running_mean
from breaker.records.rejections import NotShownError

_PARTS = 8  # parts of a resistance whose medians show its error, since its ripple is slow
_FLOWS = 0.2  # share of the largest current that counts as flow


class _Flow(NamedTuple):
    """Longest flow of a current."""

    time: np.ndarray  # times, (n,), ms
    amperes: np.ndarray  # means, (n,), A
    sd: float  # standard deviation of a mean, A
    step: float  # time between two samples, ms
    complete: bool  # whether the flow ends within the record


@dataclass(eq=False)
class Currents:
    """Currents and resistance of a record; each method with the name of a quantity returns its
    value and sd, or raises NotShownError.
    """

    time: np.ndarray  # times of the entire record, (n,), ms
    # channels by kind, (n,), as in the file; NaN where missing; "trigger" is the coil
    channels: Mapping[str, np.ndarray] = field(default_factory=dict)
    # A (µΩ for the contact) of one unit of a channel; NaN for other units
    sizes: Mapping[str, float] = field(default_factory=dict)
    motion: str = "closing"
    inside: slice = field(default_factory=lambda: slice(None))  # the samples of the motion
    moves: float = np.nan  # time of the first motion, ms
    contact: ContactTimes = field(default_factory=ContactTimes)

    def channel(self, kind: str) -> np.ndarray:
        """Return a channel, ``(n,)``, in A, or µΩ for the contact; NaN where it has no values."""
        if kind not in self.channels:
            return np.full(self.time.shape, np.nan)
        return self.sizes[kind] * self.channels[kind]

    def coil_current(self) -> tuple[float, float]:
        """Return the largest current of the coil, A."""
        current, sd = self._coil.amperes, self._coil.sd
        top = float(np.median(current[current > current.max() - 2.0 * sd]))  # less biased than max
        return top, float(np.hypot(sd, 0.5 * (current.max() - top)))

    def coil_dip_time(self) -> tuple[float, float]:
        """Return the time from the trigger to the dip as the armature arrives, ms."""
        current, sd = self._coil.amperes, self._coil.sd
        from scipy.signal import find_peaks  # imported here, as most records have no current

        least = max(CLEAR * np.sqrt(2.0) * sd, LEAST * float(current.max()))
        dips, shape = find_peaks(-current, prominence=least)
        if not dips.size:
            raise NotShownError("the coil's current shows no dip of the armature")
        k = int(shape["prominences"].argmax())
        near = current[shape["left_bases"][k] : shape["right_bases"][k]]
        low = np.flatnonzero(near <= current[dips[k]] + 2.0 * sd)
        return self._since_trigger(dips[k], 0.5 * max(np.ptp(low) * self._coil.step, RESOLVED))

    def coil_off_time(self) -> tuple[float, float]:
        """Return the time from the trigger until the current is interrupted, ms."""
        if not self._coil.complete:
            raise NotShownError("the current still flows when the record ends")
        last = np.flatnonzero(self._coil.amperes >= 0.5 * np.median(self._coil.amperes))[-1]
        return self._since_trigger(last, max(RESOLVED, self._coil.step))

    def static_resistance(self) -> tuple[float, float]:
        """Return the resistance of the contact at rest: before an opening, after a closing, µΩ."""
        if np.isnan(self.contact.main) and self.contact.why:  # it may not be closed
            raise NotShownError(self.contact.why)
        end = float(self.time[self.inside][-1:].sum())
        if self.motion == "closing":
            return self._resistance(self.moves + SETTLED * (end - self.moves), np.inf)
        return self._resistance(-np.inf, self.moves - RESOLVED)

    def arcing_resistance(self) -> tuple[float, float]:
        """Return the resistance while the arcing contact alone is closed, µΩ."""
        ends = self.contact.main, self.contact.arcing
        if np.isnan(ends).any():
            reason = "no resistance that shows the arcing contact apart from the main contact"
            raise NotShownError(self.contact.why or reason)
        return self._resistance(min(ends), max(ends))

    def _resistance(self, begin: float, end: float) -> tuple[float, float]:
        """Return median and sd of the resistance between two times, ms, while current flows."""
        values, time = self.channel("contact")[self.inside], self.time[self.inside]
        if np.isnan(values).all():
            reason = "no resistance of the contact, or its column states no unit, such as [µΩ]"
            raise NotShownError(reason)
        there = (time > begin) & (time < end) & ~np.isnan(values)
        if "current" in self.channels:
            flows = np.nan_to_num(np.abs(self.channels["current"][self.inside]))
            there &= flows > 0.5 * flows.max()
        samples = values[there]
        if samples.size < _PARTS:
            raise NotShownError(f"fewer than {_PARTS} samples of the resistance there")
        middle = float(np.median(samples))
        if not 0.0 < middle < (1.0 - LEAST) * np.nanmax(values):
            raise NotShownError("the resistance is beyond its range there")
        off = [abs(np.median(part) - middle) for part in np.array_split(samples, _PARTS)]
        spread = float(np.median(off)) / (0.6745 * np.sqrt(_PARTS))  # ignores a rise at its end
        return middle, float(np.hypot(spread, seen_quantum(samples) / np.sqrt(12.0)))

    @cached_property
    def _coil(self) -> _Flow:
        """Longest flow of the coil's current from the trigger on, as means over ``RESOLVED``."""
        if not np.isfinite(self.contact.trigger):
            raise NotShownError("no trigger: when the coil was energised is not known")
        time, values = self.time[self.inside], self.channel("trigger")[self.inside]
        there, later = ~np.isnan(values), time >= self.contact.trigger
        if there.sum() < FEWEST:
            raise NotShownError("no current, or its column states no unit, such as [A]")
        before = values[there & ~later]
        rest = before if before.size >= FEWEST else values[there][-FEWEST:]  # no rest at the begin
        current, step = filled(values) - np.median(rest), float(np.median(np.diff(time)))
        count = 2 * round(0.5 * RESOLVED / step) + 1
        noise = 1.4826 * float(np.median(np.abs(np.diff(current, n=3)))) / np.sqrt(20.0)
        sd = max(noise / np.sqrt(count), 1e-12)
        smooth = running_mean(current * np.sign(current[int(np.abs(current).argmax())]), count)
        flows = later & (smooth > max(_FLOWS * smooth[later].max(initial=0.0), CLEAR * sd))
        runs = np.flatnonzero(np.diff(flows, prepend=False, append=False)).reshape(-1, 2)
        if not runs.size:
            raise NotShownError("no current flows")
        first, end = runs[int(np.ptp(runs, axis=1).argmax())]
        complete = bool(end <= time.size - count)
        return _Flow(time[first:end], smooth[first:end], float(sd), step, complete)

    def _since_trigger(self, place: int, half: float) -> tuple[float, float]:
        after = float(self._coil.time[place]) - self.contact.trigger
        return after, float(np.hypot(half / np.sqrt(3.0), self.contact.trigger_sd))
