"""The joint probability model of one motion: prior, drive and sensor (paper, Sec. 3 and 5).

The unknowns of the model, its *outputs*, are the parameters and, if the sensor has one, the onset.
Only this module scales them. Networks, maps and samplers work in standardised outputs: logarithms
of parameters in prior standard deviations, and the onset in its standard deviation. The joint
density is exact, because the curve of the paper's drive is exact and the noise is Gaussian.

Your own prior or simulator replaces the paper's if the section ``model`` of the configuration names
it. With your own simulator, or a prior without ``log_prob``, everything that needs only draws
works; functions that need the exact density raise an error.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from breaker.common.named_functions import load
from breaker.common.randomness import generator
from breaker.model.curves import sensitivity, too_fast, travel
from breaker.model.equations import PRESSED, pressed
from breaker.model.parameters import MOTIONS, NAMES, ONSET, PARAMETERS, Parameter
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor

_FARTHEST = 20.0  # prior sd; omits a probability of 1e-88
_SCALING_DRAWS = 10_000  # sets the error of a parameter's sd to 1 %


class OwnPrior:
    """Your own prior (see ``model.prior``), with the interface of the paper's prior.

    Parameters are standardised by mean and sd of 10,000 seeded draws, in logarithms if all draws
    are positive.
    """

    def __init__(self, prior: object) -> None:
        self.prior, self.names = prior, tuple(prior.names)
        if hasattr(prior, "log_prob"):
            self.log_prob = prior.log_prob
        draws = self.sample(_SCALING_DRAWS, generator(0, "scale of a prior"))
        self.logarithmic = (draws > 0).all(axis=0)
        scaled = self._log(draws)
        self.centre, self.sds = scaled.mean(axis=0), scaled.std(axis=0)
        if not (self.sds > 0).all():
            fixed = ", ".join(np.array(self.names)[~(self.sds > 0)])
            raise ValueError(f"draws of {fixed} do not vary. Let the prior vary each parameter")

    def _log(self, theta: np.ndarray) -> np.ndarray:
        return np.where(self.logarithmic, np.log(np.where(self.logarithmic, theta, 1.0)), theta)

    def sample(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Draw parameters, ``(n, p)``; raise a ValueError if their shape or a value is wrong."""
        theta = np.asarray(self.prior.sample(n, rng), dtype=np.float64)
        if theta.shape != (n, len(self.names)) or not np.isfinite(theta).all():
            raise ValueError(
                f"sample({n}, rng) of the prior must return {n} rows of {len(self.names)} finite "
                f"parameters, as it has names, not an array of shape {theta.shape}"
            )
        return theta

    def standardise(self, theta: np.ndarray) -> np.ndarray:
        """Map parameters ``(..., p)`` to standardised ones."""
        return (self._log(theta) - self.centre) / self.sds

    def destandardise(self, z: np.ndarray) -> np.ndarray:
        """Map standardised parameters ``(..., p)`` to physical units."""
        scaled = self.centre + self.sds * z
        return np.where(self.logarithmic, np.exp(np.where(self.logarithmic, scaled, 0.0)), scaled)

    def supported(self, theta: np.ndarray) -> np.ndarray:
        """Return where the density is positive, ``(..., p) -> (...)``; needs ``log_prob``."""
        rows = theta.reshape(-1, theta.shape[-1])
        return (np.asarray(self.log_prob(rows)) > -np.inf).reshape(theta.shape[:-1])


@dataclass(frozen=True, eq=False)
class Model:
    """Joint model of the unknowns of one motion and its record.

    Attributes:
        prior: Prior of the parameters.
        sensor: Time grid and errors of the records.
        motion: "closing" or "opening".
        simulator: ``simulate(theta (n, p), times (t,), motion, rng) -> travel (n, t)``, mm; the
            drive of the paper if None.

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> model = Model(prior, sensor, "closing")
        >>> record = model.curves(np.append(prior.medians, 0.0)[None])[0]
        >>> z = np.array([[0.0] * 8, [1.0] * 8])  # the truth, and one prior sd from it
        >>> model.log_joint(z, record).round(1)
        array([ 199.1, -203.8])
    """

    prior: Prior | OwnPrior
    sensor: Sensor
    motion: str
    simulator: Callable | None = None

    def __post_init__(self) -> None:
        if self.motion not in MOTIONS:
            raise ValueError(f"unknown motion {self.motion!r}; known: {', '.join(MOTIONS)}")
        if self.simulator and self.sensor.infers_onset:
            raise ValueError(
                "sensor.onset_sd must be 0 with a simulator of your own, whose curves nothing "
                "shifts; make the start of the motion one of its parameters"
            )
        if not self.simulator and self.parameters != NAMES:
            raise ValueError(
                f"the drive of the paper has the parameters {', '.join(NAMES)}, and the prior "
                f"{', '.join(self.parameters)}; name a simulator of your own in model.simulator"
            )

    @classmethod
    def from_settings(cls, settings: Mapping) -> "Model":
        """Build from ``{"model", "prior", "sensor", "motion"}``, as in the configuration.

        A ``model`` of null is the paper's model. Your own functions are tried out; a ValueError is
        raised if one does not exist or does not fit.
        """
        own = settings.get("model") or {}
        named = {name: load(own[name]) for name in ("prior", "simulator") if own.get(name)}
        own_prior = OwnPrior(named["prior"]()) if "prior" in named else None
        prior = own_prior or Prior.from_settings(settings["prior"])
        sensor = Sensor(**settings["sensor"])
        model = cls(prior, sensor, settings["motion"], named.get("simulator"))
        if named:
            model._try_out()
        return model

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters: all outputs except the onset."""
        return tuple(self.prior.names)

    @cached_property
    def outputs(self) -> tuple[Parameter, ...]:
        """Inferred quantities, in order."""
        known = {parameter.name: parameter for parameter in PARAMETERS}
        own = [
            known.get(name) or Parameter(name=name, symbol=name, unit="1", meaning=name)
            for name in self.parameters
        ]
        return (*own, ONSET) if self.sensor.infers_onset else tuple(own)

    @property
    def names(self) -> list[str]:
        """Names of the outputs."""
        return [output.name for output in self.outputs]

    @cached_property
    def logarithmic(self) -> np.ndarray:
        """Which outputs are standardised by their logarithm, ``(q,)`` of bool."""
        return np.append(self.prior.logarithmic, [False] * self.sensor.infers_onset).astype(bool)

    @cached_property
    def sds(self) -> np.ndarray:
        """Prior sd of each output, ``(q,)``: of its logarithm where ``logarithmic``."""
        return np.append(self.prior.sds, [self.sensor.onset_sd] * self.sensor.infers_onset)

    def sample(self, n: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Draw parameters ``(n, p)`` and onsets ``(n,)`` from the prior."""
        return self.prior.sample(n, rng), self.sensor.onset_sd * rng.standard_normal(n)

    def simulate(
        self, theta: np.ndarray, onset: np.ndarray | float, rng: np.random.Generator | None = None
    ) -> np.ndarray:
        """Return curves ``(n, t)``, mm, of parameters ``(n, p)`` and onsets ``(n,)`` without noise;
        ``rng`` is for your own simulator if its curves are random.
        """
        times = self.sensor.times
        if not self.simulator:
            return travel(theta, times, self.motion, onset=onset).travel
        rng = rng if rng is not None else generator(0, "simulator")
        curves = np.asarray(self.simulator(theta, times, self.motion, rng), dtype=np.float64)
        if curves.shape != (len(theta), times.size):
            raise ValueError(
                f"the simulator must return a row for each row of theta and a column for each "
                f"time, {(len(theta), times.size)}, not an array of shape {curves.shape}"
            )
        return curves

    def _try_out(self) -> None:
        """Raise a ValueError if your own functions return wrong shapes, values that are not finite,
        or parameters of the paper's drive with which the contact never closes.
        """
        rng = generator(0, "trial")
        if not self.simulator:
            loose = np.count_nonzero(~pressed(self.sample(_SCALING_DRAWS, rng)[0]))
            if loose:
                raise ValueError(
                    f"{loose} of {_SCALING_DRAWS} draws do not fulfil {PRESSED}, so their contact "
                    "never closes. Leave them out, as docs/examples/own_prior.py does"
                )
        theta, onset = self.sample(5, rng)
        if not np.isfinite(self.simulate(theta, onset, rng)).all():
            raise ValueError("the simulator must return finite curves")
        log_prob = getattr(getattr(self.prior, "prior", None), "log_prob", None)
        density = log_prob(theta) if log_prob else np.zeros(5)
        if np.shape(density) != (5,) or not np.isfinite(density).all():
            text = f"log_prob(theta) of 5 draws must return 5 finite numbers, not {density}"
            raise ValueError(text)

    def curves(self, values: np.ndarray, rng: np.random.Generator | None = None) -> np.ndarray:
        """Return the curves of outputs ``(n, q)``, ``(n, t)``, mm, without noise."""
        p = len(self.parameters)
        onset = values[:, p] if self.sensor.infers_onset else 0.0
        return self.simulate(values[:, :p], onset, rng)

    def standardise(self, values: np.ndarray) -> np.ndarray:
        """Map outputs ``(..., q)`` in physical units to standardised ones."""
        p = len(self.parameters)
        z = np.array(values, dtype=np.float64)
        z[..., :p] = self.prior.standardise(z[..., :p])
        z[..., p:] /= self.sensor.onset_sd or 1.0
        return z

    def destandardise(self, z: np.ndarray) -> np.ndarray:
        """Map standardised outputs ``(..., q)`` to physical units."""
        p = len(self.parameters)
        values = np.array(z, dtype=np.float64)
        values[..., :p] = self.prior.destandardise(values[..., :p])
        values[..., p:] *= self.sensor.onset_sd
        return values

    def log_scaling(self, values: np.ndarray) -> np.ndarray:
        """Return the log of ``|d z / d values|``, ``(..., q) -> (...)``."""
        p = len(self.parameters)
        logs = self.logarithmic[:p]
        log_values = np.log(np.where(logs, values[..., :p], 1.0))
        log_slope = -(np.log(self.sds[:p]) + log_values).sum(-1)
        if self.sensor.infers_onset:
            log_slope = log_slope - np.log(self.sensor.onset_sd)
        return log_slope

    # The exact density.

    def check_exact(self) -> None:
        """Raise a ValueError if the model has no known density."""
        if self.simulator or not hasattr(self.prior, "log_prob"):
            raise ValueError(
                "the exact density of the posterior is known only for the drive of the paper with "
                "a prior that has log_prob; leave out model.simulator, and give the prior log_prob"
            )

    def log_prior(self, z: np.ndarray) -> np.ndarray:
        """Return the normalised log density of standardised outputs, ``(..., q) -> (...)``.

        It is ``-inf`` outside the prior's support, beyond 20 prior standard deviations of any
        output, and for drives too fast to simulate; nan stays nan.
        """
        self.check_exact()
        p = len(NAMES)
        near = np.all(np.abs(z) <= _FARTHEST, axis=-1)
        values = self.destandardise(np.where(near[..., None], z, 0.0))
        theta, onset = values[..., :p], values[..., p:].sum(axis=-1)  # onset 0 if not an output
        inside = near & self.prior.supported(theta) & ~too_fast(theta, self.sensor.times, onset)
        result = np.where(inside, self._log_density(np.where(inside[..., None], z, 0.0)), -np.inf)
        return np.where(np.isnan(z).any(axis=-1), np.nan, result)

    def _log_density(self, z: np.ndarray) -> np.ndarray:
        """Return the log density of standardised outputs inside the support."""
        if isinstance(self.prior, Prior):
            normal = -0.5 * (np.square(z).sum(-1) + z.shape[-1] * np.log(2 * np.pi))
            return normal - self.prior.log_support
        # The onset is normal; the density of the parameters, from the prior, is per unit of z.
        values, p = self.destandardise(z), len(NAMES)
        density = np.asarray(self.prior.log_prob(values[..., :p].reshape(-1, p)))
        in_z = density.reshape(z.shape[:-1]) - self.log_scaling(values)
        onset = -0.5 * (np.square(z[..., p:]) + np.log(2 * np.pi)).sum(-1)
        return in_z + onset - np.log(self.sensor.onset_sd or 1.0)

    def log_joint(self, z: np.ndarray, record: np.ndarray) -> np.ndarray:
        """Return ``log p(z, record)`` of standardised outputs ``(n, q)`` and a record ``(t,)``.

        The density ``(n,)``, per unit of ``z``, is exact: the zero is integrated, the onset is an
        output, and samples of nan are missing. It is ``-inf`` where the prior is zero, where no
        curve is simulated.
        """
        result = self.log_prior(z)
        inside = np.isfinite(result)
        curves = self.curves(self.destandardise(z[inside]))
        result[inside] += self.sensor.log_likelihood(record, curves)
        return result


# ---- contraction that a record allows, linearised ------------------------------------------------


def contraction_limit(model: Model, values: np.ndarray) -> np.ndarray:
    """Return the contraction of the exact posterior, linearised at outputs ``(n, q)``."""
    model.check_exact()
    p, q, sensor = len(NAMES), len(model.names), model.sensor
    theta, onset = values[:, :p], values[:, p] if sensor.infers_onset else 0.0
    _, slopes = sensitivity(theta, sensor.times, model.motion, onset=onset)
    slopes = slopes[..., :q]
    # Convert slopes by log parameters and onset to slopes by standardised outputs.
    steps = np.where(model.logarithmic[:p], model.sds[:p], model.sds[:p] / theta)
    slopes[..., :p] *= steps[:, None]
    slopes[..., p:] *= sensor.onset_sd
    whitened = sensor.whiten(np.moveaxis(slopes, -1, -2))
    precision = whitened @ whitened.swapaxes(1, 2) + np.eye(q)
    return 1.0 - np.linalg.inv(precision).diagonal(axis1=-2, axis2=-1)


def limit_over_prior(model: Model, n: int, rng: np.random.Generator) -> xr.Dataset:
    """Return the limit at ``n`` draws from the prior, as ``contraction (curve, output)``."""
    values = np.column_stack(model.sample(n, rng))[:, : len(model.names)]
    return xr.Dataset(
        {"contraction": (("curve", "output"), contraction_limit(model, values))},
        coords={"output": ("output", model.names)},
        attrs={"motion": model.motion},
    )
