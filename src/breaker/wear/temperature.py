"""Friction that depends on the temperature, so that a season is not taken for wear.

Grease is stiffer in the cold. Where temperatures of operations are given, the log of ``gamma_a`` is
its line plus ``b (T - T0)``. T0 is the mean temperature of the reference, whose operations are
about as warm; where temperatures come later, it is the first of them. b is a constant of the drive,
unknown but for its prior: one more number in the state of every hypothesis, after levels and
slopes, which segments pass on. All that is told is of T0.

An operation without a temperature may have had that of any other: its mean is taken, and what its
records say of the friction counts for less by the spread of temperatures.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from breaker.mechanism import NAMES
from breaker.wear.hypotheses import Hypotheses

__all__ = ["FRICTION", "Felt", "Warmth", "coefficient", "feel", "lines"]

FRICTION = NAMES.index("gamma_a")
_PLACE = 2 * len(NAMES)  # of the coefficient in a state
_UNIT = 10.0  # K, of the coefficient


@dataclass(frozen=True)
class Warmth:
    """Temperatures so far.

    Attributes:
        reference: T0, °C.
        count, total, square: Number, sum and sum of squares of temperatures above T0, 10 K. One
            that is as far off as the unit is counted before there is any.
    """

    reference: float
    count: float = 1.0
    total: float = 0.0
    square: float = 1.0

    @classmethod
    def begin(cls, temperatures: np.ndarray) -> "Warmth | None":
        """Return what is known before any, with the mean of temperatures ``(n,)`` as T0."""
        known = temperatures[np.isfinite(temperatures)]
        return cls(float(known.mean())) if known.size else None

    def apart(self, temperature: float) -> tuple[float, float]:
        """Return mean and variance of a temperature above T0, 10 K, nan if it is not known."""
        if np.isfinite(temperature):
            return (float(temperature) - self.reference) / _UNIT, 0.0
        mean = self.total / self.count
        return mean, self.square / self.count - mean**2

    def learn(self, temperature: float) -> "Warmth":
        """Add a temperature, if it is known."""
        if not np.isfinite(temperature):
            return self
        apart, _ = self.apart(temperature)
        sums = self.count + 1.0, self.total + apart, self.square + apart**2
        return Warmth(self.reference, *sums)


@dataclass(frozen=True)
class Felt:
    """What the temperature of an operation does to its friction, standardised.

    Attributes:
        apart: Its temperature above T0, 10 K, as far as it is known.
        coefficient: Mean of b, for 10 K.
        variance: Variance of the friction by an unknown temperature.
    """

    apart: float = 0.0
    coefficient: float = 0.0
    variance: float = 0.0

    def at_it(self, hypotheses: Hypotheses) -> Hypotheses:
        """Return hypotheses of which the level is that at this temperature."""
        return _moved(hypotheses, self.apart)

    def at_reference(self, hypotheses: Hypotheses) -> Hypotheses:
        """Return what ``at_it`` was given, or what has been learnt since."""
        return _moved(hypotheses, -self.apart)

    def blurred(self, matrix: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return information ``(p, p)`` and ``(p,)`` with an unknown temperature integrated out."""
        if not self.variance:
            return matrix, slope
        told = matrix[:, FRICTION]
        share = self.variance / (1.0 + self.variance * told[FRICTION])
        return matrix - share * np.outer(told, told), slope - share * slope[FRICTION] * told

    def moved(self, centre: np.ndarray) -> np.ndarray:
        """Return standardised parameters ``(p,)`` of T0 as they are at this temperature."""
        if not (change := self.apart * self.coefficient):
            return centre
        centre = centre.copy()
        centre[FRICTION] += change
        return centre


def feel(
    hypotheses: Hypotheses,
    warmth: Warmth | None,
    temperature: float,
    settings: Mapping,
    log_sds: np.ndarray,
) -> tuple[Hypotheses, Warmth | None, Felt]:
    """Return hypotheses with a coefficient, where temperatures are known, and what one does.

    Args:
        hypotheses: They predict an operation.
        warmth: Temperatures before it; None before there was one.
        temperature: Its temperature, °C, nan if not known.
        settings: The section ``wear_model`` of the configuration.
        log_sds: Prior sds of the log parameters, ``(p,)``.
    """
    prior = np.array(settings["friction_by_temperature"]) / (100.0 * log_sds[FRICTION])
    warmth = warmth or Warmth.begin(np.array([temperature]))
    if not prior.any() or warmth is None:
        return hypotheses, warmth, Felt()
    apart, spread = warmth.apart(temperature)
    hypotheses = _with_coefficient(hypotheses, *prior)
    mean, cov = hypotheses.level()
    effect = np.square(mean[_PLACE]) + cov[_PLACE, _PLACE]
    felt = Felt(apart, float(mean[_PLACE]), float(spread * effect))
    return hypotheses, warmth.learn(temperature), felt


def lines(hypotheses: Hypotheses) -> Hypotheses:
    """Return the same about levels and slopes alone."""
    if hypotheses.mean.shape[1] == _PLACE:
        return hypotheses
    mean, cov = hypotheses.mean[:, :_PLACE], hypotheses.cov[:, :_PLACE, :_PLACE]
    return replace(hypotheses, mean=mean, cov=cov)


def coefficient(hypotheses: Hypotheses, log_sds: np.ndarray) -> tuple[float, float]:
    """Return mean and standard deviation of b, percent for 10 K; nan where there is none."""
    mean, cov = hypotheses.level()
    if mean.size <= _PLACE:
        return np.nan, np.nan
    per_cent = 100.0 * log_sds[FRICTION]
    return per_cent * mean[_PLACE], per_cent * np.sqrt(cov[_PLACE, _PLACE])


def _with_coefficient(old: Hypotheses, mean: float, sd: float) -> Hypotheses:
    """Return hypotheses with the prior of the coefficient, if they lack it."""
    h, n = old.mean.shape
    if n > _PLACE:
        return old
    cov = np.zeros((h, n + 1, n + 1))
    cov[:, :n, :n] = old.cov
    cov[:, n, n] = np.square(sd)
    return replace(old, mean=np.column_stack([old.mean, np.full(h, mean)]), cov=cov)


def _moved(old: Hypotheses, apart: float) -> Hypotheses:
    """Return hypotheses whose friction is that at another temperature, 10 K above theirs."""
    if not apart:
        return old
    mean, cov = old.mean.copy(), old.cov.copy()
    mean[:, FRICTION] += apart * mean[:, _PLACE]
    cov[:, FRICTION] += apart * cov[:, _PLACE]
    cov[:, :, FRICTION] += apart * cov[:, :, _PLACE]
    return replace(old, mean=mean, cov=cov)
