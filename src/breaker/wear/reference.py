"""The reference: where a trend starts, whether the model fits, and whether both motions agree.

The first operations are too few for a trend, so their records are pooled. If the model fits their
mean to within the noise, the trend starts from the parameters that fit all of them best, and all
that follows is exact.

If it does not, as at the end of a stroke with a damper, pooling drives the parameters far off: the
misfit is the same in every operation and does not average out, so the least known parameters absorb
it. Then the *effective* values are followed: where the posterior of a single operation, prior
included, would lie without noise. They are stable, and pulled to the prior in directions that a
record hardly determines. The mode of an operation's posterior measures them, with the covariance
that these modes have in the reference.

Whether closing and opening have the same parameters is asked once, of these operations. A trend of
both pools as many records, so it needs agreement to the accuracy of all of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc  # scipy.stats takes most of a second to load

from breaker.mechanism import NAMES
from breaker.model import Model, Sensor, climb, information, pool

__all__ = ["Reference", "agreement", "find_reference", "modes", "onset_of", "pooled"]

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
        agreement: p-value of the difference between the motions' parameters: see ``agreement``.
    """

    centre: np.ndarray
    p_values: dict[str, float]
    spread: np.ndarray
    agreement: float

    @property
    def fits(self) -> bool:
        """Whether the model fits the first operations, in every motion."""
        return all(value >= _MISFIT for value in self.p_values.values())


def find_reference(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
) -> Reference:
    """Pool the first operations; find whether the model fits them and whether motions agree.

    Args:
        models: Joint model of each motion.
        records: Records of each, of the same operations, ``(n, t)``, mm.
        outputs: Means of the posteriors of each, standardised, ``(n, q)``, to start from.
    """
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    centre = pooled(models, records, outputs)
    p_values = {}
    for motion, model in models.items():
        left, _ = _residuals(model, records[motion], centre, onsets[motion])
        p_values[motion] = _common_curve(model.sensor, left)
    spread = _spread(*modes(models, records, outputs))
    return Reference(centre, p_values, spread, agreement(models, records, outputs, centre))


def agreement(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
    centre: np.ndarray,
) -> float:
    """Return the p-value of the hypothesis that both motions have the same parameters.

    By the likelihood ratio: the misfit of all records at the parameters that both motions agree
    on, less that of each motion's records at its own, is chi-square with p degrees of freedom
    (Wilks). Wear that is common to both motions cancels. A model that does not fit makes the
    motions differ, too.

    Args:
        models, records, outputs: As of ``find_reference``.
        centre: Parameters that all records agree on best, standardised, ``(p,)``.

    Returns:
        The p-value, 1 for a single motion. It is uniform if the motions agree, and larger where
        records hardly inform about a parameter, so the level below which they are said to differ
        bounds the probability of a false alarm.

    Example:
        >>> from breaker.model import Prior
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> sensor = Sensor(-2.0, 58.0, 151, noise_sd=0.1, onset_sd=0.0, zero_sd=0.1)
        >>> models = {motion: Model(prior, sensor, motion) for motion in ("closing", "opening")}
        >>> z, rng = np.zeros((5, 7)), np.random.default_rng(1)
        >>> theta = prior.destandardise(z)
        >>> records = {m: sensor.corrupt(each.curves(theta), rng) for m, each in models.items()}
        >>> outputs = dict.fromkeys(models, z)
        >>> agreement(models, records, outputs, pooled(models, records, outputs)) > 0.001
        True
    """
    if len(models) < 2:
        return 1.0
    rise = 0.0
    for motion, model in models.items():
        record, onset = records[motion], onset_of(outputs[motion])
        own = pooled({motion: model}, {motion: record}, outputs)
        rise += _misfit(model, record, centre, onset) - _misfit(model, record, own, onset)
    return float(chdtrc(len(NAMES), rise))


def pooled(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
) -> np.ndarray:
    """Return the standardised parameters that all records agree on best, ``(p,)``."""
    p = len(NAMES)
    begin = np.mean([outputs[motion][:, :p].mean(axis=0) for motion in models], axis=0)
    onsets = {motion: onset_of(outputs[motion]) for motion in models}
    return pool(models, records, begin, onsets, warn=True)


def _spread(found: np.ndarray, within: np.ndarray) -> np.ndarray:
    """Covariance of modes ``(n, p)`` about a line, regularised by the one that is expected.

    A Gaussian likelihood of precision ``J`` and one prior make modes of covariance ``S - S^2``,
    with ``S = (1 + J)^-1``. This counts as much as two operations per parameter.
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
) -> tuple[np.ndarray, np.ndarray]:
    """What the model leaves of records ``(n, t)``, mm, and their best onsets ``(n,)``."""
    places = np.tile(centre, (len(records), 1))
    onset = information(model, records, places, onset).onset
    outputs = np.column_stack([places, onset])[:, : len(model.names)]
    return records - model.curves(model.destandardise(outputs)), onset


def _misfit(model: Model, records: np.ndarray, centre: np.ndarray, onset: np.ndarray) -> float:
    """Squares that the model leaves of records and their onsets, in units of the noise."""
    left, onset = _residuals(model, records, centre, onset)
    return float(model.sensor.chi_square(left, np.zeros_like(left)).sum() + np.square(onset).sum())


def _common_curve(sensor: Sensor, residuals: np.ndarray) -> float:
    """p-value of residuals ``(n, t)`` that have no curve in common, NaN where a sample is missing.

    The curve by generalised least squares follows a chi-square; of whole records it is their mean.
    """
    there = ~np.isnan(residuals)
    if there.all():
        mean = residuals.mean(axis=0)
        statistic = len(residuals) * sensor.chi_square(mean, np.zeros_like(mean))
        return float(chdtrc(mean.size, statistic))
    seen = there.any(axis=0)
    weights, values = there[:, seen].astype(float), np.where(there, residuals, 0.0)[:, seen]
    noise, zero = sensor.noise_sd**2, sensor.zero_sd**2
    shared = zero / (noise + weights.sum(axis=1) * zero)
    precision = np.diag(weights.sum(axis=0)) - (weights.T * shared) @ weights
    total = values.sum(axis=0) - (shared * values.sum(axis=1)) @ weights
    statistic = total @ np.linalg.solve(precision, total) / noise
    return float(chdtrc(seen.sum(), statistic))
