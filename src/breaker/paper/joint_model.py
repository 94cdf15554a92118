"""The joint probability model of one motion: prior, mechanism and sensor.

Its unknowns, the *outputs*, are the seven parameters and, where the sensor has one, the onset. Only
this module scales them. Networks, maps and samplers work in standardised outputs: logarithms of
parameters in prior standard deviations, and the onset in its own. The joint density is exact,
because the curve is exact and the noise Gaussian.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from breaker.model.curves import sensitivity, too_fast, travel
from breaker.model.parameters import MOTIONS, NAMES, Parameter, Size, outputs
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor

_FARTHEST = 20.0  # prior sd; beyond lies a probability of 1e-88


@dataclass(frozen=True, eq=False)
class Model:
    """Joint model of the unknowns of one motion and its record.

    Attributes:
        prior: Prior of the parameters.
        sensor: Time grid and errors of the records.
        motion: "closing" or "opening".

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> model = Model(prior, sensor, "closing")
        >>> record = model.curves(np.append(prior.medians, 0.0)[None])[0]
        >>> z = np.array([[0.0] * 8, [1.0] * 8])  # the truth, and a prior sd off
        >>> model.log_joint(z, record).round(1)
        array([ 199.1, -203.8])
    """

    prior: Prior
    sensor: Sensor
    motion: str

    def __post_init__(self) -> None:
        if self.motion not in MOTIONS:
            raise ValueError(f"unknown motion {self.motion!r}; known: {', '.join(MOTIONS)}")

    @classmethod
    def from_settings(cls, settings: Mapping) -> "Model":
        """Build from ``{"prior", "sensor", "motion"}``, as in the configuration."""
        sensor = Sensor.from_settings(settings["sensor"])
        return cls(Prior.from_settings(settings["prior"]), sensor, settings["motion"])

    def sized(self, size: Size) -> "Model":
        """Return the model of drives of another size, if this is that of size 1.

        Exact, for the mechanism does not tell sizes apart. Times and errors, the noise among them,
        are scaled along.
        """
        return replace(self, prior=self.prior.sized(size), sensor=self.sensor.sized(size))

    @property
    def outputs(self) -> tuple[Parameter, ...]:
        """What is inferred, in order."""
        return outputs(self.sensor.infers_onset)

    @property
    def names(self) -> list[str]:
        """Names of the outputs."""
        return [output.name for output in self.outputs]

    def standardise(self, values: np.ndarray) -> np.ndarray:
        """Map outputs ``(..., q)`` in physical units to standardised ones."""
        p = len(NAMES)
        z = np.array(values, dtype=np.float64)
        z[..., :p] = self.prior.standardise(z[..., :p])
        z[..., p:] /= self.sensor.onset_sd or 1.0
        return z

    def destandardise(self, z: np.ndarray) -> np.ndarray:
        """Map standardised outputs ``(..., q)`` to physical units."""
        p = len(NAMES)
        values = np.array(z, dtype=np.float64)
        values[..., :p] = self.prior.destandardise(values[..., :p])
        values[..., p:] *= self.sensor.onset_sd
        return values

    def log_scaling(self, values: np.ndarray) -> np.ndarray:
        """Return the log of ``|d z / d values|``, ``(..., q) -> (...)``."""
        p = len(NAMES)
        log_slope = -(np.log(self.prior.log_sds) + np.log(values[..., :p])).sum(-1)
        if self.sensor.infers_onset:
            log_slope = log_slope - np.log(self.sensor.onset_sd)
        return log_slope

    def curves(self, values: np.ndarray) -> np.ndarray:
        """Return the exact curves of outputs ``(n, q)``, ``(n, t)``, mm."""
        p = len(NAMES)
        onset = values[:, p] if self.sensor.infers_onset else 0.0
        return travel(values[:, :p], self.sensor.times, self.motion, onset=onset).travel

    def log_prior(self, z: np.ndarray) -> np.ndarray:
        """Return the normalised log density of standardised outputs, ``(..., q) -> (...)``.

        It is ``-inf`` outside the prior's support, beyond 20 prior standard deviations of any
        output, and for drives too fast to be simulated; nan stays nan.
        """
        p = len(NAMES)
        near = np.all(np.abs(z) <= _FARTHEST, axis=-1)
        values = self.destandardise(np.where(near[..., None], z, 0.0))
        theta, onset = values[..., :p], values[..., p:].sum(axis=-1)  # 0 where it is no output
        inside = near & self.prior.supported(theta) & ~too_fast(theta, self.sensor.times, onset)
        safe = np.where(inside[..., None], z, 0.0)
        normal = -0.5 * (np.square(safe).sum(-1) + z.shape[-1] * np.log(2 * np.pi))
        result = np.where(inside, normal - self.prior.log_support, -np.inf)
        return np.where(np.isnan(z).any(axis=-1), np.nan, result)

    def log_joint(self, z: np.ndarray, record: np.ndarray) -> np.ndarray:
        """Return ``log p(z, record)`` of standardised outputs ``(n, q)`` and a record ``(t,)``.

        Exact: the zero is integrated, the onset is one of the outputs, and samples that are nan
        are missing. ``(n,)``, per unit of ``z``; ``-inf`` where the prior is zero and nothing is
        simulated.
        """
        result = self.log_prior(z)
        inside = np.isfinite(result)
        curves = self.curves(self.destandardise(z[inside]))
        result[inside] += self.sensor.log_likelihood(record, curves)
        return result


# ---- fisher information ----


def linearise(model: Model, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Simulate standardised outputs with the derivatives of their curves.

    Args:
        z: Standardised outputs, ``(n, q)``.

    Returns:
        Curves ``(n, t)``, mm, and whitened derivatives by standardised outputs, ``(n, q, t)``: in
        units of the sensor's errors per prior sd.
    """
    p, q, sensor = len(NAMES), z.shape[1], model.sensor
    values = model.destandardise(z)
    onset = values[:, p] if sensor.infers_onset else 0.0
    by = slice(0, q)
    motion, slopes = sensitivity(values[:, :p], sensor.times, model.motion, onset=onset, by=by)
    slopes *= np.append(model.prior.log_sds, sensor.onset_sd)[by]
    return motion.travel, sensor.whiten(np.moveaxis(slopes, -1, -2))


def contraction_limit(model: Model, values: np.ndarray) -> np.ndarray:
    """Return the contraction of the exact posterior, linearised at outputs, ``(n, q) -> (n, q)``.

    Args:
        values: Outputs in physical units, ``(n, q)``.
    """
    _, slopes = linearise(model, model.standardise(values))
    precision = slopes @ slopes.swapaxes(1, 2) + np.eye(slopes.shape[1])
    return 1.0 - np.linalg.inv(precision).diagonal(axis1=-2, axis2=-1)


def limit_over_prior(model: Model, n: int, rng: np.random.Generator) -> xr.Dataset:
    """Return the limit at ``n`` draws from the prior: ``contraction (curve, output)``."""
    theta = model.prior.sample(n, rng)
    onset = model.sensor.onset_sd * rng.standard_normal(n)
    values = np.column_stack([theta, onset])[:, : len(model.names)]
    return xr.Dataset(
        {"contraction": (("curve", "output"), contraction_limit(model, values))},
        coords={"output": ("output", model.names)},
        attrs={"motion": model.motion},
    )
