"""How much an exact posterior can know: the limit that a network is held against.

Linearised at the truth, the posterior of ``z`` (standardised log parameters, and the onset in
units of its prior sd where it is on) is normal with precision ``J^T C^-1 J + 1``: ``J`` the
Jacobian of the curve, ``C`` the covariance of a record with the zero integrated. Its diagonal
gives the contraction ``1 - var(posterior) / var(prior)`` of each output.
"""

import numpy as np
import xarray as xr

from breaker.mechanism import outputs, sensitivity
from breaker.model.prior import Prior
from breaker.model.sensor import Sensor

__all__ = ["contraction_limit", "jacobian", "limit_over_prior"]


def jacobian(
    prior: Prior, sensor: Sensor, motion: str, theta: np.ndarray, onset: np.ndarray
) -> np.ndarray:
    """Return the derivative of curves with respect to standardised outputs.

    Args:
        theta: Parameters, ``(n, p)``.
        onset: Onsets, ``(n,)``, ms.

    Returns:
        ``(n, t, q)``, mm per prior sd, exact; the onset comes last, where the sensor has one.
    """
    _, slopes = sensitivity(theta, sensor.times, motion, onset=onset)
    slopes *= np.append(prior.log_sds, sensor.onset_sd)
    return slopes if sensor.infers_onset else slopes[..., :-1]


def contraction_limit(
    prior: Prior, sensor: Sensor, motion: str, theta: np.ndarray, onset: np.ndarray
) -> np.ndarray:
    """Return the contraction that the exact posterior reaches, curve by curve, ``(n, q)``."""
    slopes = jacobian(prior, sensor, motion, theta, onset)
    whitened = np.moveaxis(sensor.whiten(np.moveaxis(slopes, -1, -2)), -1, -2)
    precision = np.einsum("ntq,ntr->nqr", whitened, whitened) + np.eye(slopes.shape[-1])
    return 1.0 - np.linalg.inv(precision).diagonal(axis1=-2, axis2=-1)


def limit_over_prior(
    prior: Prior, sensor: Sensor, motion: str, n: int, rng: np.random.Generator
) -> xr.Dataset:
    """Return the limit at ``n`` draws from the prior: ``contraction (curve, output)``."""
    theta = prior.sample(n, rng)
    onset = sensor.onset_sd * rng.standard_normal(n)
    limit = contraction_limit(prior, sensor, motion, theta, onset)
    names = [output.name for output in outputs(sensor.infers_onset)]
    return xr.Dataset(
        {"contraction": (("curve", "output"), limit)},
        coords={"output": ("output", names)},
        attrs={"motion": motion},
    )
