"""Records of operations, and what each of them says of a trend."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from breaker.mechanism import NAMES
from breaker.model import Model, climb
from breaker.wear.reference import Reference, modes, onset_of

__all__ = ["Series", "likelihood", "series_of"]

_ROOM = 0.02  # share of a parameter that an operation may be off what is predicted
_MOVES = 2  # of the place where an operation's likelihood is taken


@dataclass(frozen=True)
class Series:
    """Records of some operations, in one or both motions.

    Attributes:
        operations: Their numbers, rising, ``(o,)``.
        records: Of each motion, ``(o, t)``, mm; NaN where a sample is missing, or there is no
            record that can be used.
        outputs: Mean of each motion's own posterior, standardised, ``(o, q)``: where to start
            from; nan where there is none.
    """

    operations: np.ndarray
    records: Mapping[str, np.ndarray]
    outputs: Mapping[str, np.ndarray]

    def usable(self, motion: str) -> np.ndarray:
        """Say which operations have a record and a posterior of a motion, ``(o,)``."""
        return np.isfinite(self.records[motion]).any(1) & np.isfinite(self.outputs[motion]).all(1)


def series_of(
    models: Mapping[str, Model], data: Mapping[str, xr.Dataset], usable: Mapping[str, np.ndarray]
) -> Series:
    """Return the series of measured operations.

    Args:
        models: Joint model of each motion.
        data: What ``condition.align`` returns of each motion, for the same operations.
        usable: Which of them have a posterior, ``(o,)``.
    """
    records, outputs = {}, {}
    for motion, model in models.items():
        there = usable[motion]
        records[motion] = np.where(there[:, None], data[motion].travel.values, np.nan)
        outputs[motion] = np.full((len(there), len(model.names)), np.nan)
        draws = data[motion].draws.values[there].astype(np.float64)
        outputs[motion][there] = model.standardise(draws).mean(axis=1)
    return Series(next(iter(data.values())).operation.values, records, outputs)


def likelihood(
    models: Mapping[str, Model],
    series: Series,
    i: int,
    reference: Reference | None,
    predicted: tuple[np.ndarray, np.ndarray] | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what the records of an operation say, about where; zeros without a record.

    The place is the mode of the operation's likelihood under what is predicted of it, with some
    room for scatter and for a change not noticed yet. So it goes where the records leave no
    doubt, and stays at the trend where they say little.

    Where the model does not fit, the operation is a measurement of its effective value by the
    mode of its own posterior.

    Args:
        models: Joint model of each motion that has a usable record.
        series: Records.
        i: Which operation of them.
        reference: Where the trend started; None before there is one.
        predicted: Mean ``(p,)`` and covariance ``(p, p)`` of the standardised parameters, as
            predicted; None in the baseline.

    Returns:
        Information ``(p, p)`` and slope ``(p,)`` at a place, ``(p,)``, standardised.
    """
    p, one = len(NAMES), slice(i, i + 1)
    nothing = np.zeros((p, p)), np.zeros(p), np.zeros(p)
    if not models or reference is None:
        return nothing
    records = {motion: series.records[motion][one] for motion in models}
    outputs = {motion: series.outputs[motion][one] for motion in models}
    if not reference.fits:
        if models.keys() != reference.p_values.keys():
            return nothing  # the mode of one motion is pulled to the prior in another way
        centre, _ = modes(models, records, outputs)
        return np.linalg.inv(reference.spread), np.zeros(p), centre[0]
    room = np.diag(np.square(_ROOM / next(iter(models.values())).prior.log_sds))
    mean, spread = (reference.centre, np.zeros((p, p))) if predicted is None else predicted
    onsets = {motion: onset_of(each) for motion, each in outputs.items()}
    expected = mean, np.linalg.inv(spread + room)
    centre, matrix, slope = climb(
        models, records, mean[None], onsets, *expected, moves=_MOVES, later_steps=1
    )
    return matrix[0], slope[0], centre[0]
