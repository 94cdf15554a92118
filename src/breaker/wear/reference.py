r"""The reference: where a trend starts, what it leaves out, and whether both motions agree.

The first operations are too few for a trend, so their records are pooled: one set of parameters and
one difference from the model fit all of them best, under the prior of the parameters and what was
learned of differences. All that follows is linear near them. How much of the reference is
difference, phase by phase, says how far the model can be trusted on this drive.

Whether closing and opening have the same parameters is asked once, of these operations. A trend of
both pools as many records, so it needs agreement to the accuracy of all of them, and of what was
learned.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag
from scipy.special import chdtrc  # scipy.stats takes most of a second to load

from breaker.mechanism import NAMES
from breaker.model import Model, information, pool
from breaker.wear.difference import Apparent, split_off
from breaker.wear.learned import Learned

__all__ = ["Reference", "agreement", "find_reference", "onset_of", "pooled"]

_ROUNDS = 30  # of the fit of parameters and difference
_REACHED = 1e-4  # prior sd: a step that ends it
_RESEMBLES = 1.4  # factor between informations of operations that are compared
_RIDGE = 1e-9  # of an information, for directions that no record determines


@dataclass(frozen=True)
class Reference:
    """Where a trend starts.

    Attributes:
        centre: Standardised parameters that the first operations agree on best, ``(p,)``.
        agreement: p-value of the difference between the motions' parameters: see ``agreement``.
        difference: Amplitudes of the difference that they share, ``(n,)``; none where the model
            is held to be right.
        matrix: Information of one of them about parameters and difference, ``(p + n, p + n)``.
        records: Their number.
    """

    centre: np.ndarray
    agreement: float
    difference: np.ndarray
    matrix: np.ndarray
    records: int

    @cached_property
    def root(self) -> np.ndarray:
        """Cholesky root of the information, in which what an operation says has unit noise."""
        ridge = _RIDGE * np.trace(self.matrix) / len(self.matrix)
        return np.linalg.cholesky(self.matrix + ridge * np.eye(len(self.matrix)))

    def resembles(self, matrix: np.ndarray) -> bool:
        """Say whether an operation whose records lack samples can be compared with the others.

        Its records say less of all that is not as the reference, which would seem to be a step.

        Args:
            matrix: Its information about parameters and difference, ``(p + n, p + n)``.
        """
        share = np.trace(matrix) / np.trace(self.matrix)
        return bool(1.0 / _RESEMBLES <= share <= _RESEMBLES)


def find_reference(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
    learned: Learned | None = None,
) -> Reference:
    """Pool the first operations, and ask whether motions agree.

    Args:
        records: Records of each, of the same operations, ``(n, t)``, mm.
        outputs: Means of the posteriors of each, standardised, ``(n, q)``, to start from.
        learned: What was learned of differences; None where the model is held to be right.
    """
    if learned is not None:
        return _with_difference(models, records, outputs, learned)
    centre, p = pooled(models, records, outputs), len(NAMES)
    agree = agreement(models, records, outputs, centre)
    count = len(next(iter(records.values())))
    return Reference(centre, agree, np.zeros(0), np.zeros((p, p)), count)


def _with_difference(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
    learned: Learned,
) -> Reference:
    """The mode of parameters and shared difference, by Gauss-Newton with limited steps."""
    p, n = len(NAMES), len(learned.new)
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    prior = block_diag(np.eye(p), np.linalg.inv(learned.new))
    state = np.append(_mean_of(outputs), np.zeros(n))
    for _ in range(_ROUNDS):
        places = np.tile(state[:p], (len(next(iter(records.values()))), 1))
        known = learned.models(models, state[p:])
        matrix, slope, onsets = learned.information(known, records, places, onsets, steps=2)
        # A finer error than the components is the same in all records: more of them add little.
        counts = 1.0 / (1.0 + len(places) * learned.rough)
        matrix, slope = counts * matrix.sum(axis=0), counts * slope.sum(axis=0)
        step = np.linalg.solve(prior + matrix, slope - prior @ state)
        # No step farther than half a prior sd: far from the mode the curve bends.
        share = min(1.0, 0.5 / np.abs(step[:p]).max())
        state = state + share * step
        if np.abs(step[:p]).max() < _REACHED:
            break
    else:
        logging.getLogger("breaker").warning(
            "%s: no parameters and difference that fit all records were found in %d steps",
            *(" and ".join(records), _ROUNDS),
        )
    agree = 1.0
    if len(models) > 1:
        alone = [
            learned.information(known, {m: records[m]}, places, onsets, steps=1) for m in models
        ]
        sums = [(counts * each[0].sum(axis=0), counts * each[1].sum(axis=0)) for each in alone]
        agree = _agreement_with_difference(learned, state[p:], *(split_off(*each) for each in sums))
    one_record = matrix / (counts * len(places))
    return Reference(state[:p], agree, state[p:], one_record, len(places))


def _agreement_with_difference(
    learned: Learned, known: np.ndarray, one: Apparent, other: Apparent
) -> float:
    """p-value of the same parameters in both motions, given what was learned of differences.

    Each motion has apparent parameters of its own. They differ by what its difference passes for:
    normal, with the covariance that was learned, narrowed by what no parameters explain.
    """
    prior = np.linalg.inv(learned.new)
    cov = np.linalg.inv(prior + one.rest + other.rest)
    mean = cov @ (one.left + other.left - prior @ known)
    gain = one.gain - other.gain
    apart = one.mean - other.mean - gain @ mean
    within = np.linalg.inv(one.held) + np.linalg.inv(other.held) + gain @ cov @ gain.T
    return float(chdtrc(len(apart), apart @ np.linalg.solve(within, apart)))


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
        >>> from breaker.model import Prior, Sensor
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
    onsets = {motion: onset_of(outputs[motion]) for motion in models}
    return pool(models, records, _mean_of(outputs), onsets, warn=True)


def _mean_of(outputs: Mapping[str, np.ndarray]) -> np.ndarray:
    """Mean of outputs of all motions and records, the parameters alone, ``(p,)``."""
    p = len(NAMES)
    return np.mean([each[:, :p].mean(axis=0) for each in outputs.values()], axis=0)


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
