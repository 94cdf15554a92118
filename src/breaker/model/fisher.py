r"""The information in a record: what it adds to the prior, and the posterior modes it leads to.

Near standardised outputs ``z0`` the likelihood of a record is the Gaussian

``exp(g . (z - z0) - (z - z0)' J (z - z0) / 2)``,

with ``J`` the Fisher information and ``g`` the slope of the log likelihood at ``z0``. Both follow
from the curve's Jacobian, whitened by the covariance of a record with the zero integrated.

- The posterior that is normal with precision ``J + 1`` is the best that a network can reach: the
  *limit* of contraction, ``1 - var(posterior) / var(prior)``.
- A trend through the posteriors of many operations would contain the prior once per operation. So
  trends use the likelihoods of the parameters (``information``); the onset of each record is
  integrated by Laplace's method. ``J`` is singular in directions that a record does not determine,
  so it is never inverted.
- Gauss-Newton steps with both lead to the mode of a posterior: of each operation under a normal
  prediction (``climb``), or of one set of parameters for all records (``pool``).

The choice of ``z0`` matters. The likelihood of one record is wide and skewed, so a Gaussian at its
own mode is biased by a part of its width, always to the same side. Over hundreds of operations the
error of a mean shrinks, but this bias remains. So all operations of a trend share one ``z0``, the
trend itself; the error of the approximation then shrinks with that of the trend.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES, sensitivity
from breaker.model.joint import Model

__all__ = [
    "Information",
    "climb",
    "contraction_limit",
    "information",
    "limit_over_prior",
    "linearise",
    "pool",
]

_ROUNDS = 20  # of the pooled fit
_REACHED = 1e-4  # prior sd: a step that ends it


def linearise(
    model: Model, z: np.ndarray, by: slice = slice(None), records: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Simulate standardised outputs with the derivatives of their curves.

    Args:
        z: Standardised outputs, ``(n, q)``.
        by: Which derivatives; by all outputs unless given.
        records: Records ``(n, t)`` to leave out the samples of that are missing, NaN: derivatives
            are 0 there.

    Returns:
        Curves ``(n, t)``, mm, and whitened derivatives by standardised outputs, ``(n, q, t)``: in
        units of the sensor's errors per prior sd.
    """
    p, sensor = len(NAMES), model.sensor
    values = model.destandardise(z)
    onset = values[:, p] if sensor.infers_onset else 0.0
    by = slice(*by.indices(z.shape[1]))
    motion, slopes = sensitivity(values[:, :p], sensor.times, model.motion, onset=onset, by=by)
    slopes *= np.append(model.prior.log_sds, sensor.onset_sd)[by]
    curves = motion.travel
    if sensor.discrepancy is not None:
        left_out = sensor.discrepancy
        curves += left_out.shift(z[:, :p])
        known = np.pad(left_out.slopes, ((0, max(z.shape[1] - p, 0)), (0, 0)))
        slopes += known[by].T
    if records is not None:
        slopes[np.isnan(records)] = np.nan
    return curves, sensor.whiten(np.moveaxis(slopes, -1, -2))


# ---- limit -----------------------------------------------------------------------------------


def contraction_limit(model: Model, values: np.ndarray) -> np.ndarray:
    """Return the contraction of the exact posterior, linearised at outputs, ``(n, q) -> (n, q)``.

    Args:
        values: Outputs in physical units, ``(n, q)``.
    """
    _, slopes = linearise(model, model.standardise(values))
    precision = slopes @ slopes.swapaxes(1, 2) + np.eye(slopes.shape[1])
    return 1.0 - np.linalg.inv(precision).diagonal(axis1=-2, axis2=-1)


def limit_over_prior(model: Model, n: int, rng: np.random.Generator) -> xr.Dataset:
    """Return the limit at ``n`` draws from the prior: ``contraction (curve, output)``.

    Example:
        >>> from breaker.model import Model, Prior, Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.3, zero_sd=0.1)
        >>> limit = limit_over_prior(Model(prior, sensor, "closing"), 50, np.random.default_rng(1))
        >>> limit.contraction.median("curve").round(1).values
        array([0.1, 0.7, 0.4, 0.9, 0.4, 0.9, 0.8, 1. ])
    """
    theta = model.prior.sample(n, rng)
    onset = model.sensor.onset_sd * rng.standard_normal(n)
    values = np.column_stack([theta, onset])[:, : len(model.names)]
    return xr.Dataset(
        {"contraction": (("curve", "output"), contraction_limit(model, values))},
        coords={"output": ("output", model.names)},
        attrs={"motion": model.motion},
    )


# ---- likelihoods of the parameters -----------------------------------------------------------


@dataclass(frozen=True)
class Information:
    """Gaussian likelihoods of records about given parameters, in standardised units.

    Attributes:
        matrix: Information ``J``, ``(n, p, p)``.
        slope: Slope ``g`` of the log likelihood at the given parameters, ``(n, p)``.
        onset: Most probable onset there, standardised, ``(n,)``.
    """

    matrix: np.ndarray
    slope: np.ndarray
    onset: np.ndarray


def information(
    model: Model,
    records: np.ndarray,
    centre: np.ndarray,
    onset: np.ndarray,
    *,
    steps: int = 3,
    basis: np.ndarray | None = None,
) -> Information:
    """Return the Gaussian likelihoods of records about given parameters.

    Args:
        records: Records, ``(n, t)``, mm; NaN where a sample is missing.
        centre: Standardised parameters, ``(n, p)``.
        onset: Standardised onsets to start from, ``(n,)``; ignored where there is none.
        steps: Gauss-Newton steps of the onset; one does where it is known from a place nearby.
        basis: Curves ``(c, t)``, mm, whose amplitudes in a record count as unknowns too, after the
            parameters and around 0: matrix and slope are then of size p + c.

    Example:
        >>> from breaker.model import Model, Prior, Sensor
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.0, zero_sd=0.1)
        >>> model = Model(prior, sensor, "closing")
        >>> record = model.curves(prior.medians[None])  # no noise: the likelihood peaks there
        >>> found = information(model, record, np.zeros((1, 7)), np.zeros(1))
        >>> bool(abs(found.slope).max() < 1e-9), found.matrix.shape
        (True, (1, 7, 7))
    """
    p = len(NAMES)
    if not model.sensor.infers_onset:
        matrix, slope = _normal_equations(model, centre, slice(None), records, basis)
        return Information(matrix, slope, np.zeros(len(centre)))
    z = np.column_stack([centre, onset])
    for _ in range(steps):
        known, slope = _normal_equations(model, z, slice(p, None), records)
        step = (slope[:, 0] - z[:, p]) / (known[:, 0, 0] + 1.0)
        z[:, p] += np.clip(step, -1.0, 1.0)
    matrix, slope = _normal_equations(model, z, slice(None), records, basis)
    # The onset has a prior of its own in every record; it is integrated.
    matrix[:, p, p] += 1.0
    slope[:, p] -= z[:, p]
    share = matrix[:, :, p] / matrix[:, p, p, None]
    matrix = matrix - share[:, :, None] * matrix[:, None, p]
    slope = slope - share * slope[:, p, None]
    matrix = np.delete(np.delete(matrix, p, axis=1), p, axis=2)
    return Information(matrix, np.delete(slope, p, axis=1), z[:, p])


def _normal_equations(
    model: Model,
    z: np.ndarray,
    by: slice,
    records: np.ndarray,
    basis: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """``J J'`` and ``J r`` of derivatives ``(n, q, t)`` and what curves leave of records."""
    curves, slopes = linearise(model, z, by, records)
    if basis is not None:
        present = np.where(np.isnan(records)[:, None], np.nan, basis)
        slopes = np.concatenate([slopes, model.sensor.whiten(present)], axis=1)
    residual = model.sensor.whiten(records - curves)
    return slopes @ slopes.swapaxes(1, 2), (slopes @ residual[..., None])[..., 0]


# ---- modes of posteriors ---------------------------------------------------------------------


def climb(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    centre: np.ndarray,
    onsets: Mapping[str, np.ndarray],
    mean: np.ndarray,
    precision: np.ndarray,
    *,
    moves: int,
    later_steps: int = 2,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the posterior mode of each operation under a normal prior, and the information there.

    Args:
        records: Records of each, ``(n, t)``, mm.
        centre: Standardised parameters to start from, ``(n, p)``.
        onsets: Standardised onsets of each to start from, ``(n,)``.
        mean, precision: Of the normal, ``(p,)`` and ``(p, p)``.
        moves: Gauss-Newton steps, none farther than a prior sd in any parameter.
        later_steps: Steps of the onset after the first place.

    Returns:
        Parameters ``(n, p)``, and the information ``(n, p, p)`` and slope ``(n, p)`` of all motions
        there.
    """
    matrix, slope, onsets = _together(models, records, centre, onsets, 2)
    for _ in range(moves):
        right = slope + np.einsum("nij,nj->ni", matrix, centre - mean)
        mode = mean + np.linalg.solve(precision + matrix, right[..., None])[..., 0]
        centre = centre + np.clip(mode - centre, -1.0, 1.0)
        matrix, slope, onsets = _together(models, records, centre, onsets, later_steps)
    return centre, matrix, slope


def pool(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    centre: np.ndarray,
    onsets: Mapping[str, np.ndarray],
    *,
    warn: bool = False,
) -> np.ndarray:
    """Find the parameters that fit all records of a stretch without wear best.

    The mode of the prior times all likelihoods of one or both motions, by Gauss-Newton with limited
    steps. If it is not reached, the model hardly fits.

    Args:
        records: Records of each, ``(n, t)``, mm, of the same operations.
        centre: Standardised parameters to start from, ``(p,)``.
        onsets: Standardised onsets of each to start from, ``(n,)``.
        warn: Log a warning if the mode was not reached.
    """
    n = len(next(iter(records.values())))
    centre = np.array(centre, dtype=np.float64)
    for _ in range(_ROUNDS):
        places = np.tile(centre, (n, 1))
        matrix, slope, _ = _together(models, records, places, onsets, 3)
        step = np.linalg.solve(np.eye(len(NAMES)) + matrix.sum(0), slope.sum(0) - centre)
        # No step farther than half a prior sd: far from the mode the curve bends.
        centre += step * min(1.0, 0.5 / np.abs(step).max())
        if np.abs(step).max() < _REACHED:
            return centre
    if warn:
        logging.getLogger("breaker").warning(
            "%s: no parameters that fit all records were found in %d steps",
            *(" and ".join(records), _ROUNDS),
        )
    return centre


def _together(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    centre: np.ndarray,
    onsets: Mapping[str, np.ndarray],
    steps: int,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Information ``(n, p, p)`` and slope ``(n, p)`` of all motions, and the onsets of each."""
    found = {
        motion: information(models[motion], each, centre, onsets[motion], steps=steps)
        for motion, each in records.items()
    }
    matrix = sum(each.matrix for each in found.values())
    slope = sum(each.slope for each in found.values())
    return matrix, slope, {motion: each.onset for motion, each in found.items()}
