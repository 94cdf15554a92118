"""Posteriors of records of which samples are missing at random, beside those of whole records."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.paper.posterior.amortised import sample_records
from breaker.paper.posterior.estimator import Posterior
from breaker.quantities.parameters import is_logarithmic

__all__ = ["over_curves", "remove", "validate_missing", "widening"]


def validate_missing(posterior: Posterior, whole: xr.Dataset, share: float) -> xr.Dataset:
    """Infer the records of a validation again, each without a share of its samples.

    Args:
        posterior: The model.
        whole: What ``amortised.validate`` returned of it.
        share: Share of the samples of each record that are taken away at random.

    Returns:
        What ``amortised.validate`` returns; the seed of the draws is the same.
    """
    seed = int(whole.attrs["seed"])
    rng = generator(seed, "missing samples", posterior.motion)
    measured = remove(whole.measured.values, share, rng)
    return sample_records(posterior, measured, whole.truth.values, whole.sizes["draw"], seed)


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


def over_curves(ratios: np.ndarray) -> np.ndarray:
    """Return 5 %, 50 % and 95 % of ratios ``(n, q)`` over curves, and their number, ``(4, q)``.

    Curves without a ratio (nan) are left out.
    """
    known = ratios[np.isfinite(ratios).all(axis=1)]
    if not len(known):
        return np.stack([*np.full((3, ratios.shape[1]), np.nan), np.zeros(ratios.shape[1])])
    count = np.full((1, ratios.shape[1]), float(len(known)))
    return np.concatenate([np.quantile(known, [0.05, 0.5, 0.95], axis=0), count])
