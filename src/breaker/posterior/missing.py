"""Records with missing samples: which of them a network accepts, and how posteriors widen.

A missing sample is NaN. A network accepts only records of the kind that it was trained on. Its
posterior from fewer samples must stay calibrated and widen as the exact posterior does.
"""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import is_logarithmic

__all__ = ["check", "remove", "widening"]


def check(measured: np.ndarray, samples: int, *, missing: float, motion: str) -> None:
    """Raise an error for records that a network does not accept.

    Args:
        measured: Records, ``(o, t)``, mm.
        samples: Samples of the sensor's grid.
        missing: Largest share of missing samples that the network was trained with; 0 if it takes
            none.
        motion: Its motion, for the message.

    Raises:
        ValueError: If the shape is another, a sample is infinite, or too many are missing; the
            message has the remedy.
    """
    if measured.ndim != 2 or measured.shape[1] != samples:
        raise ValueError(f"records must have the shape (o, {samples}), not {measured.shape}")
    infinite = np.isinf(measured).any(axis=1)
    if infinite.any():
        raise ValueError(f"{infinite.sum()} of {len(measured)} records have infinite samples")
    most = np.isnan(measured).sum(axis=1).max(initial=0)
    allowed = math.floor(round(missing * samples, 6))
    if most > allowed:
        summary = f"network.{motion}.summary"
        remedy = f"a larger {summary}.deep_set.missing" if missing else f"{summary}.kind: deep_set"
        raise ValueError(
            f"{most} of {samples} samples are missing, and the network of {motion} takes at most "
            f"{allowed}; train it with {remedy}"
        )


def remove(measured: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Return records with a share of the samples missing at random, nan, ``(n, t) -> (n, t)``.

    Each record loses the same number of samples, each set of samples being as likely.
    """
    n, t = measured.shape
    lost = rng.permuted(np.tile(np.arange(t) < round(share * t), (n, 1)), axis=1)
    return np.where(lost, np.nan, measured)


def widening(whole: xr.Dataset, missing: xr.Dataset, names: Sequence[str]) -> np.ndarray:
    """Return how much wider posteriors are without the missing samples, ``(n, q)``.

    The ratio of standard deviations, of log parameters and of the onset, curve by curve. It is nan
    where either of the two is not ``resolved``, since its draws are not those of the posterior.

    Args:
        whole, missing: ``draws (curve, draw, output)`` of the same curves, and ``resolved (curve)``
            if they were corrected.
        names: Names of the outputs.
    """
    log = is_logarithmic(names)
    sds = []
    for data in (missing, whole):
        draws = data.draws.values.astype(np.float64)
        draws[..., log] = np.log(draws[..., log])
        sd = draws.std(axis=1, ddof=1)
        if "resolved" in data:
            sd[~data.resolved.values] = np.nan
        sds.append(sd)
    return sds[0] / sds[1]
