"""The baseline: where a trend starts, and what the model cannot do.

The first operations are pooled, as too few for a trend. If the model fits them, to within what
noise leaves of their mean, the trend starts from the parameters that they agree on, and all is
exact.

If it does not, as at the end of a stroke with a damper, pooling would drive the parameters far off:
the misfit is the same in every operation, does not average out, and hundreds of operations would
trade it against whatever they know least. Then the trend starts from the *effective* values, the
mode of the average log likelihood and one prior, and goes on from there:

- the mean residual of the baseline is taken off every later record: changes count, not the misfit;
- samples at which it exceeds the noise are left out, for there the misfit will change, too;
- directions in which one operation says less than the prior stay at the effective values.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from breaker.information import information, pool
from breaker.model import Model
from breaker.parameters import NAMES

__all__ = ["Baseline", "find_baseline"]

_MISFIT = 1e-6  # p-value of the mean record from which the model does not fit
_LARGEST = 1.0  # noise sd, mean residual of a sample that is used where it does not fit
_INFORMED = 1.0  # least information of a direction that is used then, in units of the prior's


@dataclass(frozen=True)
class Baseline:
    """Where a trend starts.

    Attributes:
        centre: Standardised parameters, ``(p,)``.
        p_value: Of the mean record, by motion: small where the model does not fit.
        offset: What is taken off the records of each motion, ``(t,)``, mm.
        used: Samples of each motion that count, ``(t,)``.
        projector: Onto the directions that count, ``(p, p)``.
    """

    centre: np.ndarray
    p_value: dict[str, float]
    offset: dict[str, np.ndarray]
    used: dict[str, np.ndarray]
    projector: np.ndarray

    @property
    def fits(self) -> bool:
        """Whether the model fits the baseline, in every motion."""
        return all(value >= _MISFIT for value in self.p_value.values())


def find_baseline(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    outputs: Mapping[str, np.ndarray],
) -> Baseline:
    """Pool the first operations, and see whether the model fits them.

    Args:
        models: Joint model of each motion.
        records: Records of each, ``(n, t)``, mm.
        outputs: Means of the posteriors of each, standardised, ``(n, q)``, to start from.
    """
    p = len(NAMES)
    start = np.mean([each[:, :p].mean(axis=0) for each in outputs.values()], axis=0)
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    ordered = [models[m] for m in records], list(records.values()), start, list(onsets.values())
    centre = pool(*ordered)
    p_value = {}
    for motion, model in models.items():
        mean, n = (
            _mean_residual(model, records[motion], centre, onsets[motion]),
            len(records[motion]),
        )
        statistic = n * model.sensor.chi_square(mean, np.zeros_like(mean))
        p_value[motion] = float(chi2.sf(statistic, df=mean.size))
    nothing = {motion: np.zeros(each.shape[1]) for motion, each in records.items()}
    every = {motion: np.ones(each.shape[1], dtype=bool) for motion, each in records.items()}
    exact = Baseline(centre, p_value, nothing, every, np.eye(p))
    return exact if exact.fits else _effective(models, records, onsets, ordered, p_value)


def _effective(
    models: Mapping[str, Model],
    records: Mapping[str, np.ndarray],
    onsets: Mapping[str, np.ndarray],
    ordered: tuple,
    p_value: dict[str, float],
) -> Baseline:
    p = len(NAMES)
    centre = pool(*ordered, single=True)
    offset, used, matrix = {}, {}, np.zeros((p, p))
    for motion, model in models.items():
        offset[motion] = _mean_residual(model, records[motion], centre, onsets[motion])
        used[motion] = np.abs(offset[motion]) <= _LARGEST * model.sensor.noise_sd
        places = np.tile(centre, (len(records[motion]), 1))
        left = records[motion] - offset[motion]
        found = information(model, left, places, onsets[motion], used=used[motion])
        matrix += found.matrix.mean(axis=0)
    values, vectors = np.linalg.eigh(matrix)
    kept = vectors[:, values >= _INFORMED]
    return Baseline(centre, p_value, offset, used, kept @ kept.T)


def onset_of(outputs: np.ndarray) -> np.ndarray:
    """Onsets of outputs ``(n, q)``, 0 where there is none."""
    p = len(NAMES)
    return outputs[:, p] if outputs.shape[1] > p else np.zeros(len(outputs))


def _mean_residual(
    model: Model, records: np.ndarray, centre: np.ndarray, onset: np.ndarray
) -> np.ndarray:
    """Mean over records of what the model leaves of them, each with its own onset, ``(t,)``, mm."""
    places = np.tile(centre, (len(records), 1))
    onset = information(model, records, places, onset).onset
    outputs = np.column_stack([places, onset])[:, : len(model.names)]
    return (records - model.curves(model.destandardise(outputs))).mean(axis=0)
