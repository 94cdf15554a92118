"""The reference: where a trend starts, and whether the model fits the drive.

The first operations are pooled, as too few for a trend. If the model fits them, to within what
noise leaves of their mean, the trend starts from the parameters that they agree on, and all that
follows is exact.

If it does not, as at the end of a stroke with a damper, pooling drives the parameters far off. The
misfit is the same in every operation and does not average out, so that hundreds of operations trade
it against whatever they know least. What can be followed then are the *effective* values: what the
posterior of a single operation, prior included, would be about without noise. They are stable, and
pulled to the prior where an operation says little. An operation then is a measurement of them by
the mode of its posterior, with the covariance that the modes have in the baseline.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from breaker.mechanism import NAMES
from breaker.model import Model, Sensor, climb, information, pool

__all__ = ["Reference", "find_reference", "modes", "onset_of"]

_MOVES = 3  # Gauss-Newton steps to a mode, from the network's mean
_FINEST = 0.01  # prior sd, to which a mode is known at best
_MISFIT = 1e-6  # p-value of the mean record below which the model does not fit


@dataclass(frozen=True)
class Reference:
    """Where a trend starts.

    Attributes:
        centre: Standardised parameters that the first operations agree on best, ``(p,)``.
        p_values: Of the mean record of each motion: small where the model does not fit it.
        spread: Covariance of the modes of single operations about their line, ``(p, p)``; used
            where the model does not fit.
    """

    centre: np.ndarray
    p_values: dict[str, float]
    spread: np.ndarray

    @property
    def fits(self) -> bool:
        """Whether the model fits the baseline, in every motion."""
        return all(value >= _MISFIT for value in self.p_values.values())


def find_reference(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
) -> Reference:
    """Pool the first operations, and see whether the model fits them.

    Args:
        models: Joint model of each motion.
        records: Records of each, of the same operations, ``(n, t)``, mm.
        outputs: Means of the posteriors of each, standardised, ``(n, q)``, to start from.
    """
    p = len(NAMES)
    start = np.mean([each[:, :p].mean(axis=0) for each in outputs.values()], axis=0)
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    centre = pool(models, records, start, onsets, warn=True)
    p_values = {}
    for motion, model in models.items():
        residuals = _residuals(model, records[motion], centre, onsets[motion])
        p_values[motion] = _common_curve(model.sensor, residuals)
    return Reference(centre, p_values, _spread(*modes(models, records, outputs)))


def _spread(found: np.ndarray, within: np.ndarray) -> np.ndarray:
    """Covariance of modes ``(n, p)`` about a line, and what posteriors say of it where n is small.

    A Gaussian likelihood of precision ``J`` and one prior make modes of covariance ``S - S^2``,
    with ``S = (1 + J)^-1``. It counts as much as two operations a parameter.
    """
    n, p = found.shape
    design = np.column_stack([np.ones(n), np.arange(n) - (n - 1) / 2])[:, : min(2, n)]
    left = found - design @ np.linalg.lstsq(design, found, rcond=None)[0]
    posterior = np.linalg.inv(np.eye(p) + within.mean(axis=0))
    expected = posterior - posterior @ posterior + np.square(_FINEST) * np.eye(p)
    free = max(n - 2, 0)
    return (left.T @ left + 2 * p * expected) / (free + 2 * p)


def modes(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mode of the posterior of every operation, from all of its motions.

    Args:
        models: Joint model of each motion.
        records: Records of each, ``(n, t)``, mm.
        outputs: Means of the posteriors of each, standardised, ``(n, q)``, to start from.

    Returns:
        Standardised parameters ``(n, p)`` and the information of the records there, ``(n, p, p)``.
    """
    p = len(NAMES)
    centre = np.mean([each[:, :p] for each in outputs.values()], axis=0)
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    prior = np.zeros(p), np.eye(p)
    centre, matrix, _ = climb(models, records, centre, onsets, *prior, moves=_MOVES)
    return centre, matrix


def onset_of(outputs: np.ndarray) -> np.ndarray:
    """Onsets of outputs ``(n, q)``, 0 where there is none."""
    p = len(NAMES)
    return outputs[:, p] if outputs.shape[1] > p else np.zeros(len(outputs))


def _residuals(
    model: Model, records: np.ndarray, centre: np.ndarray, onset: np.ndarray
) -> np.ndarray:
    """What the model leaves of each record, with the record's own onset, ``(n, t)``, mm."""
    places = np.tile(centre, (len(records), 1))
    onset = information(model, records, places, onset).onset
    outputs = np.column_stack([places, onset])[:, : len(model.names)]
    return records - model.curves(model.destandardise(outputs))


def _common_curve(sensor: Sensor, residuals: np.ndarray) -> float:
    """p-value of residuals ``(n, t)`` that have no curve in common, NaN where a sample is missing.

    The curve by generalised least squares follows a chi-square; of whole records it is their mean.
    """
    there = ~np.isnan(residuals)
    if there.all():
        mean = residuals.mean(axis=0)
        statistic = len(residuals) * sensor.chi_square(mean, np.zeros_like(mean))
        return float(chi2.sf(statistic, df=mean.size))
    seen = there.any(axis=0)
    weights, values = there[:, seen].astype(float), np.where(there, residuals, 0.0)[:, seen]
    noise, zero = sensor.noise_sd**2, sensor.zero_sd**2
    shared = zero / (noise + weights.sum(axis=1) * zero)
    precision = np.diag(weights.sum(axis=0)) - (weights.T * shared) @ weights
    total = values.sum(axis=0) - (shared * values.sum(axis=1)) @ weights
    statistic = total @ np.linalg.solve(precision, total) / noise
    return float(chi2.sf(statistic, df=seen.sum()))
