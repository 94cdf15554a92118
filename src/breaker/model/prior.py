"""Log-normal prior of the seven parameters, conditioned on a pressed contact.

Paper, Sec. 5: independent log-normals, as all parameters are positive. An opening needs a contact
that is pressed in the closed rest position, so the prior is conditioned on ``f > k_a L`` (positive
spring compression, Eq. 7). With ``z = (log theta - log median) / log_sd`` standard normal, the
condition is a half-space ``a . z + b > 0``. The normal distribution function gives its probability
(0.9968 for the defaults).

**Sources of the default medians and widths.** The paper takes location and spread from fits to
travel curves of real breakers, but publishes neither values nor curves. So all defaults are
assumptions of this project:

========= ======= ======= ==========================================================================
parameter median  log-sd  source
========= ======= ======= ==========================================================================
L         10      0.05    catalogues of 12 kV vacuum breakers: 8 to 12 mm
f         0.75    0.10    chosen with k_a and k_b so that three quantities match the catalogues
k_a       0.045   0.15    as f
k_b       0.040   0.20    as f; values from catalogued forces and masses (above 0.15) do not match
mu        2.0     0.20    assumed, no source
gamma_a   0.30    0.20    assumed, no source
gamma_b   0.12    0.40    assumed, no source; the least known parameter has the largest width
========= ======= ======= ==========================================================================

The three quantities (median and 95 % interval of prior curves; catalogues): spring compression
3.5 mm (1.0 to 6.7; 2.5 to 4.5), closing speed over the last 6 mm before the touch 1.23 m/s (0.84 to
1.72; 0.6 to 1.5), opening speed over the first 6 mm 1.07 m/s (0.78 to 1.44; 0.8 to 1.6).

**Your own prior** is any object with ``names``, ``sample`` and, for exact correction,
``log_prob``:

- ``names``: names of its ``p`` parameters;
- ``sample(n, rng) -> (n, p)``: draws, from a ``numpy.random.Generator``;
- ``log_prob(theta) -> (n,)``: log density at parameters ``(n, p)``, -inf where it is zero.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breaker.model.equations import pressed
from breaker.model.parameters import NAMES, Size, powers

_SIGNS = {"f": 1.0, "k_a": -1.0, "L": -1.0}  # pressed contact: log f - log k_a - log L > 0


@dataclass(frozen=True, eq=False)
class Prior:
    """Prior of the parameters of the drive.

    Attributes:
        medians: Medians of the log-normals before conditioning, ``(p,)``, units of the parameters.
        log_sds: Standard deviations of the natural logarithms, ``(p,)``.

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> prior.standardise(prior.medians * np.exp(0.1))  # one sd above every median
        array([1., 1., 1., 1., 1., 1., 1.])
        >>> prior.supported(prior.sample(3, np.random.default_rng(1)))
        array([ True,  True,  True])
    """

    medians: np.ndarray
    log_sds: np.ndarray
    names = NAMES
    logarithmic = np.ones(len(NAMES), dtype=bool)  # all are standardised by their logarithm

    def __post_init__(self) -> None:
        for name in ("medians", "log_sds"):
            values = np.asarray(getattr(self, name), dtype=np.float64)
            if values.shape != (len(NAMES),) or not np.all(np.isfinite(values) & (values > 0)):
                raise ValueError(f"{name} of the prior must be {len(NAMES)} positive numbers")
            object.__setattr__(self, name, values)

    @classmethod
    def from_settings(cls, settings: Mapping[str, Mapping[str, float]]) -> "Prior":
        """Build the prior from ``{name: {"median": ..., "log_sd": ...}}``."""
        return cls(
            medians=np.array([settings[name]["median"] for name in NAMES]),
            log_sds=np.array([settings[name]["log_sd"] for name in NAMES]),
        )

    @property
    def sds(self) -> np.ndarray:
        """Scale of standardised parameters, ``(p,)``."""
        return self.log_sds

    def sized(self, size: Size) -> "Prior":
        """Return the prior of drives of a size relative to the drives of this prior."""
        return replace(self, medians=self.medians * size.factors)

    @cached_property
    def condition(self) -> tuple[np.ndarray, float]:
        """Coefficients ``a``, ``b`` of ``a . z + b > 0`` on standardised parameters."""
        signs = [_SIGNS.get(name, 0.0) for name in NAMES]
        logs = (s * math.log(median) for s, median in zip(signs, self.medians, strict=True))
        return signs * self.log_sds, sum(logs)

    @property
    def size_axes(self) -> np.ndarray:
        """Orthonormal axes along which a size moves standardised parameters, ``(p, 2)``."""
        return np.linalg.qr((powers() / self.log_sds).T)[0]

    @cached_property
    def log_support(self) -> float:
        """Log of the probability of ``f > k_a L`` before conditioning."""
        slope, offset = self.condition
        from scipy.special import log_ndtr  # imported here: shipped networks do not need it

        return float(log_ndtr(offset / np.linalg.norm(slope)))

    def standardise(self, theta: np.ndarray) -> np.ndarray:
        """Map parameters ``(..., p)`` to standardised log space ``(..., p)``."""
        return (np.log(theta) - np.log(self.medians)) / self.log_sds

    def destandardise(self, z: np.ndarray) -> np.ndarray:
        """Map standardised log space ``(..., p)`` to parameters ``(..., p)``."""
        return np.exp(np.log(self.medians) + self.log_sds * z)

    @staticmethod
    def supported(theta: np.ndarray) -> np.ndarray:
        """Return which parameters ``(..., p)`` lie in the prior's support, ``(...)`` of bool."""
        return pressed(theta)

    def sample(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Draw parameters, ``(n, p)``, exactly from the conditioned prior.

        Along the normal of the half-space the coordinate follows a truncated normal.
        """
        from scipy.special import ndtr, ndtri  # scipy.stats takes most of a second to load

        slope, offset = self.condition
        length = np.linalg.norm(slope)
        direction = slope / length
        z = rng.standard_normal((n, len(NAMES)))
        # With v = direction . z, the condition is -v < offset / length. Working with -v keeps
        # full precision in the common case, where nearly everything is accepted.
        upper = ndtr(offset / length)
        along = -ndtri(upper * (1.0 - rng.random(n)))
        z += (along - z @ direction)[:, None] * direction
        return self.destandardise(z)

    def log_prob(self, theta: np.ndarray) -> np.ndarray:
        """Return the log density, ``(..., p) -> (...)``; ``-inf`` outside the support."""
        theta = np.asarray(theta, dtype=np.float64)
        inside = np.all(theta > 0, axis=-1) & self.supported(theta)
        safe = np.where(inside[..., None], theta, self.medians)
        normal = -(self.standardise(safe) ** 2) / 2 - np.log(np.sqrt(2 * np.pi))
        log_density = normal - np.log(self.log_sds) - np.log(safe)
        return np.where(inside, log_density.sum(axis=-1) - self.log_support, -np.inf)
