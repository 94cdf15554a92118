"""Records with missing samples: taken away at random, and what that costs.

A posterior from fewer samples must stay calibrated and become wider, as much as the exact one
does and where it does.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.mechanism import is_logarithmic

__all__ = ["remove", "widening"]


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
    where either of the two says that it is not ``resolved``: its draws are not the posterior's.

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
