r"""The information in a record: what it adds to the prior.

With ``J`` the Fisher information of a record, from the curve's Jacobian, whitened by the covariance
of a record with the zero integrated, the posterior that is normal with precision ``J + 1`` in
standardised outputs is the best that a network can reach: the *limit* of contraction,
``1 - var(posterior) / var(prior)``.
"""

import numpy as np
import xarray as xr

from breaker.mechanism.curves import sensitivity
from breaker.paper.model.joint_model import Model
from breaker.quantities.parameters import NAMES


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
