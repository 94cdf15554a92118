r"""What a record says of the parameters, the prior left out: a pseudo-observation.

A posterior counts the prior. A trend through the posteriors of many operations would count it once
an operation, and be pulled to it; so it is made of posteriors divided by the prior. That is the
likelihood, which is exact here. Near parameters ``z0`` (standardised) it is the Gaussian

``exp(g . (z - z0) - (z - z0)' J (z - z0) / 2)``,

``J`` the information of the record and ``g`` the slope of the log likelihood at ``z0``, where the
zero is integrated as always and the onset, an unknown of this record alone, by Laplace's method.
``J`` is singular where the record says nothing: no inverse is ever taken of it.

Where ``z0`` is matters. The likelihood of one record is wide and bent, and a Gaussian about its own
mode is off by a part of its width, always to the same side: over hundreds of operations the error
of the mean shrinks and this bias stays. So ``z0`` is a value that all operations share, that of
the trend: what is then left out shrinks with the error of the trend itself.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import NAMES, sensitivity
from breaker.model.joint import Model

__all__ = ["Information", "climb", "information", "pool"]

_ROUNDS = 20  # of the pooled fit


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
) -> Information:
    """Return what records say near given parameters.

    Args:
        model: Joint model of the motion.
        records: Records, ``(n, t)``, mm.
        centre: Standardised parameters, ``(n, p)``.
        onset: Standardised onsets to start from, ``(n,)``; ignored where there is none.
        steps: Gauss-Newton steps of the onset; one does where it is known from a place nearby.
    """
    p = len(NAMES)
    if not model.sensor.infers_onset:
        jacobian, residual = _whitened(model, records, centre, np.zeros(len(centre)))
        jacobian = jacobian[..., :p]
        matrix = np.einsum("nti,ntj->nij", jacobian, jacobian)
        return Information(
            matrix, np.einsum("nti,nt->ni", jacobian, residual), np.zeros(len(centre))
        )
    onset = np.array(onset, dtype=np.float64)
    for _ in range(steps):
        by_onset, residual = _whitened(model, records, centre, onset, by=slice(p, None))
        by_onset = by_onset[..., 0]
        curvature = np.einsum("nt,nt->n", by_onset, by_onset) + 1.0
        step = (np.einsum("nt,nt->n", by_onset, residual) - onset) / curvature
        onset += np.clip(step, -1.0, 1.0)
    jacobian, residual = _whitened(model, records, centre, onset)
    matrix = np.einsum("nti,ntj->nij", jacobian, jacobian)
    slope = np.einsum("nti,nt->ni", jacobian, residual)
    # The onset has a prior of its own in every record; it is integrated.
    matrix[:, p, p] += 1.0
    slope[:, p] -= onset
    share = matrix[:, :p, p] / matrix[:, p, p, None]
    return Information(
        matrix[:, :p, :p] - share[:, :, None] * matrix[:, None, :p, p],
        slope[:, :p] - share * slope[:, p, None],
        onset,
    )


def _whitened(
    model: Model,
    records: np.ndarray,
    centre: np.ndarray,
    onset: np.ndarray,
    by: slice = slice(None),
) -> tuple[np.ndarray, np.ndarray]:
    """Slopes ``(n, t, p + 1)`` and residuals ``(n, t)``, in units of the sensor's errors."""
    sensor, prior = model.sensor, model.prior
    theta = prior.destandardise(centre)
    motion, slopes = sensitivity(
        theta, sensor.times, model.motion, onset=sensor.onset_sd * onset, by=by
    )
    slopes *= np.append(prior.log_sds, sensor.onset_sd)[by]
    whitened = np.moveaxis(sensor.whiten(np.moveaxis(slopes, -1, -2)), -1, -2)
    return whitened, sensor.whiten(records - motion.travel)


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
    """Go towards the mode of each operation under a normal, and return what it says there.

    Args:
        models: Joint model of each motion.
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
    onsets = dict(onsets)
    for move in range(moves + 1):
        matrix, slope = np.zeros((*centre.shape, mean.size)), np.zeros(centre.shape)
        for motion, each in records.items():
            steps = later_steps if move else 2
            found = information(models[motion], each, centre, onsets[motion], steps=steps)
            onsets[motion] = found.onset
            matrix, slope = matrix + found.matrix, slope + found.slope
        if move < moves:
            right = slope + np.einsum("nij,nj->ni", matrix, centre - mean)
            mode = mean + np.linalg.solve(precision + matrix, right[..., None])[..., 0]
            centre = centre + np.clip(mode - centre, -1.0, 1.0)
    return centre, matrix, slope


def pool(
    models: list[Model],
    records: list[np.ndarray],
    centre: np.ndarray,
    onsets: list[np.ndarray],
    *,
    warn: bool = False,
) -> np.ndarray:
    """Return the parameters that all records of a stretch without wear agree on best.

    The mode of prior times all likelihoods, by Gauss-Newton with limited steps, over one or both
    motions. Where it is not reached, the model hardly fits.

    Args:
        models: Joint models, one a motion.
        records: Records of each, ``(n, t)``, mm.
        centre: Standardised parameters to start from, ``(p,)``.
        onsets: Standardised onsets of each to start from, ``(n,)``.
        warn: Tell in the log if the mode was not reached.
    """
    centre = np.array(centre, dtype=np.float64)
    for _ in range(_ROUNDS):
        matrix, slope = np.eye(centre.size), -centre
        for model, record, onset in zip(models, records, onsets, strict=True):
            found = information(model, record, np.tile(centre, (len(record), 1)), onset)
            matrix = matrix + found.matrix.sum(axis=0)
            slope = slope + found.slope.sum(axis=0)
        step = np.linalg.solve(matrix, slope)
        # No step farther than half a prior sd: far from the mode the curve bends.
        centre += step * min(1.0, 0.5 / np.abs(step).max())
        if np.abs(step).max() < 1e-4:
            return centre
    if warn:
        logging.getLogger("breaker").warning(
            "%s: no parameters that all records agree on were found in %d steps",
            *(" and ".join(model.motion for model in models), _ROUNDS),
        )
    return centre
