"""Is a posterior unbiased, and how much does it know? Arrays in, arrays out.

z-score and contraction, recovery of the truth, and summaries of curves (paper, Sec. 5 and 6). Its
calibration by ranks is in ``calibration``.

Shapes: ``n`` simulations, ``d`` draws, ``q`` outputs, ``t`` samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from breaker.common.numerals import in_digits
from breaker.paper.posterior.posterior_tables import quantiles, share_inside
from breaker.paper.validation.amortised_against_exact import percent
from breaker.paper.validation.calibration import checked_draws, coverage, ranks

REGIONS = (0.9, 0.5)
"""Shares of the draws that the regions of :func:`regions` hold, the widest first."""

_GRID, _ON_A_LINE = 48, 1e-9  # values of a density, and how far a correlation is below 1


@dataclass(frozen=True)
class Scores:
    """Bias, width and information of posteriors, per curve and summarised.

    Attributes:
        z: (posterior mean - truth) / posterior sd, ``(n, q)``.
        contraction: 1 - posterior variance / prior variance, ``(n, q)``. Never clipped: negative
            where a posterior is wider than the prior.
        z_mean: Mean z-score, ``(q,)``; 0 for an exact posterior.
        z_sd: Standard deviation of the z-score, ``(q,)``; 1 for an exact posterior on average
            over the prior (exactly for a Gaussian one), with standard error 1/sqrt(2 n).
        mean_contraction: Mean contraction, ``(q,)``.
    """

    z: np.ndarray
    contraction: np.ndarray
    z_mean: np.ndarray
    z_sd: np.ndarray
    mean_contraction: np.ndarray


def scores(
    draws: ArrayLike, truth: ArrayLike, *, prior_sd: ArrayLike | None, log: ArrayLike
) -> Scores:
    """Return z-score and contraction of each curve (paper, Sec. 6, Fig. 5).

    Both are taken in log parameters where ``log`` says so, in plain units elsewhere (the onset).

    Args:
        draws: Posterior draws, ``(n, d, q)``, physical units.
        truth: Values that made the data, ``(n, q)``.
        prior_sd: Prior standard deviation ``(q,)`` in the same scale as the score: the log-sd of
            a parameter, the sd in ms of the onset. Conditioning the prior on a positive wipe
            lowers the log-sds by less than half a percent at the default and is left out. That
            of the truths if None.
        log: Which outputs are taken in logarithms, ``(q,)`` of bool.

    Raises:
        ValueError: If shapes do not fit, a value is not finite, a value to take the logarithm
            of is not positive, or a posterior has no width.
    """
    draws, truth = checked_draws(draws, truth)
    spread = _scaled(truth, log).std(axis=0, ddof=1) if prior_sd is None else prior_sd
    known = contraction(draws, prior_sd=spread, log=log)
    draws, truth = _scaled(draws, log), _scaled(truth, log)
    z = (draws.mean(axis=1) - truth) / draws.std(axis=1, ddof=1)
    return Scores(z, known, z.mean(axis=0), z.std(axis=0, ddof=1), known.mean(axis=0))


def contraction(draws: np.ndarray, *, prior_sd: ArrayLike, log: ArrayLike) -> np.ndarray:
    """Return 1 - posterior variance / prior variance of draws ``(n, d, q)``, ``(n, q)``.

    Args and errors are those of :func:`scores`.
    """
    sd = _scaled(draws, log).std(axis=1, ddof=1)
    if none := np.count_nonzero(np.ptp(draws, axis=1) == 0.0):  # rounding leaves them an sd
        raise ValueError(f"{none} posteriors have no width")
    return 1.0 - (sd / np.asarray(prior_sd, dtype=np.float64)) ** 2


@dataclass(frozen=True)
class Recovery:
    """Posterior summaries beside the truth, in physical units.

    Attributes:
        truth: Values that made the data, ``(n, q)``.
        median: Posterior median, ``(n, q)``.
        interval_50: Central 50 % interval, ``(n, q, 2)``.
        interval_95: Central 95 % interval, ``(n, q, 2)``.
        covered_50, covered_95: Share of the true values inside these intervals, ``(q,)``, by ranks.
        correlation: Pearson correlation of the medians with the truth, ``(q,)``.
    """

    truth: np.ndarray
    median: np.ndarray
    interval_50: np.ndarray
    interval_95: np.ndarray
    covered_50: np.ndarray
    covered_95: np.ndarray
    correlation: np.ndarray


def recovery(draws: ArrayLike, truth: ArrayLike) -> Recovery:
    """Summarise draws ``(n, d, q)`` beside their truth ``(n, q)`` (paper, Sec. 6, Fig. 6).

    Raises:
        ValueError: If shapes do not fit or a value is not finite.
    """
    draws, truth = checked_draws(draws, truth)
    found = quantiles(draws, axis=1)
    columns = zip(found["median"].T, truth.T, strict=True)
    pearson = np.array([np.corrcoef(guess, actual)[0, 1] for guess, actual in columns])
    half, most = coverage(ranks(draws, truth), draws.shape[1], levels=(0.5, 0.95))
    return Recovery(truth, **found, covered_50=half, covered_95=most, correlation=pearson)


def correlation(draws: ArrayLike, *, log: ArrayLike) -> np.ndarray:
    """Return the correlation ``(q, q)`` of draws ``(d, q)``, of logarithms by ``log (q,)``."""
    return np.corrcoef(_scaled(np.asarray(draws, dtype=np.float64), log), rowvar=False)


def regions(draws: ArrayLike) -> dict[tuple[int, int], tuple[np.ndarray, ...]]:
    """Return where the density of draws is highest, of each pair of outputs.

    A Gaussian kernel estimates the density. A pair whose draws lie on a line has none.

    Args:
        draws: Draws, ``(d, q)``, physical units.

    Returns:
        By the columns ``(i, j)`` of a pair, ``i < j``: values of both, ``(g,)`` each, the density
        there, ``(g of j, g of i)``, and the levels above which 90 % and 50 % of the draws lie,
        ``(2,)``, rising.
    """
    from scipy.stats import gaussian_kde  # which takes long to import

    draws = np.asarray(draws, dtype=np.float64)
    low, high = draws.min(axis=0), draws.max(axis=0)
    room = 0.1 * (high - low)
    grids = np.linspace(low - room, high + room, _GRID)
    found = {}
    for i, j in zip(*np.triu_indices(draws.shape[1], 1), strict=True):
        pair = draws[:, [i, j]].T
        if not np.ptp(pair, axis=1).all() or abs(np.corrcoef(pair)[0, 1]) > 1.0 - _ON_A_LINE:
            continue
        kernel = gaussian_kde(pair)
        x, y = np.meshgrid(grids[:, i], grids[:, j])
        density = kernel([x.ravel(), y.ravel()]).reshape(x.shape)
        levels = np.quantile(kernel(pair), 1.0 - np.array(REGIONS))
        found[int(i), int(j)] = grids[:, i], grids[:, j], density, levels
    return found


@dataclass(frozen=True)
class PriorCheck:
    """Comparison of measured curves with curves of the prior.

    Attributes:
        median, lower, upper: Pointwise 95 % band of the prior's curves, ``(t,)``.
        inside: Share of the samples of each measured curve inside the band, ``(o,)``.
        least: Share inside that 95 % of the prior's own curves reach. Samples of one curve
            leave the band together, so that this share is well below 0.95.
    """

    median: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    inside: np.ndarray
    least: float


def prior_check(curves: ArrayLike, measured: ArrayLike) -> PriorCheck:
    """Hold measured curves ``(o, t)`` against curves ``(n, t)`` of the prior (paper, Fig. 3).

    Missing samples of measured curves, NaN, do not count.
    """
    median, lower, upper = np.quantile(curves, [0.5, 0.025, 0.975], axis=0)
    least = float(np.quantile(share_inside(curves, lower, upper), 0.05))
    return PriorCheck(median, lower, upper, share_inside(measured, lower, upper), least)


def _scaled(values: np.ndarray, log: ArrayLike) -> np.ndarray:
    """Take the logarithm of the columns (last axis) that ``log`` names."""
    log = np.asarray(log, dtype=bool)
    if not np.all(values[..., log] > 0):
        raise ValueError("values to take the logarithm of must be positive")
    scaled = values.copy()
    scaled[..., log] = np.log(values[..., log])
    return scaled


# ---- what came out, in one line for the title of its figure --------------------------------------


def recovery_words(found: Recovery) -> str:
    """State how many of the true values intervals contain, over all outputs.

    >>> draws = [[[1], [2], [3], [4], [5]], [[2], [4], [6], [8], [10]]]
    >>> recovery_words(recovery(draws, [[3.1], [8.1]]))
    '95 % intervals contain 100 % of the true values, 50 % intervals 100 %'
    """
    ends = (_from_to(found.covered_95), _from_to(found.covered_50))
    return "95 % intervals contain {} of the true values, 50 % intervals {}".format(*ends)


def _from_to(shares: np.ndarray) -> str:
    low, high = percent(shares.min()), percent(shares.max())
    return high if low == high else f"{low.removesuffix(' %')} to {high}"


def contraction_words(
    scores: Scores, symbols: Sequence[str], limit: np.ndarray | None = None
) -> str:
    """State what is known best and least, how far from the limit, and the z-scores.

    Args:
        scores: From ``diagnostics.scores``.
        symbols: Names of the ``q`` outputs.
        limit: Mean contraction of the exact posterior, linearised, ``(q,)``, if known.
    """
    mean = scores.mean_contraction
    best, least = mean.argmax(), mean.argmin()
    told = f"best known: {symbols[best]} ({mean[best]:.2f})"
    if least != best:
        told += f", least: {symbols[least]} ({mean[least]:.2f})"
    if limit is not None:
        short = (np.asarray(limit) - mean).max()
        told += f"; {f'at most {in_digits(short, 1)}' if short > 0 else 'not'} below the limit"
    return f"{told}; z-score sd {scores.z_sd.min():.2f} to {scores.z_sd.max():.2f}"


def pairs_words(
    draws: np.ndarray, truth: np.ndarray, correlation: np.ndarray, symbols: Sequence[str]
) -> str:
    """State for one record how many true values intervals contain, and what is known as a pair.

    >>> import numpy as np
    >>> draws = np.linspace([0.0, 1.0], [1.0, 0.0], 101)
    >>> pairs_words(draws, np.array([0.5, 2.0]), np.corrcoef(draws, rowvar=False), ["a", "b"])
    '95 % intervals contain 1 of 2 true values; closest pair: a and b (−1.00)'

    Args:
        draws: Draws of the posterior, ``(d, q)``.
        truth: Values that made the record, ``(q,)``.
        correlation: Of the draws, ``(q, q)``.
        symbols: Names of the ``q`` outputs.
    """
    low, high = np.quantile(draws, [0.025, 0.975], axis=0)
    inside = int(((truth >= low) & (truth <= high)).sum())
    told = f"95 % intervals contain {inside} of {len(truth)} true values"
    if len(truth) < 2:
        return told
    i, j = np.unravel_index(np.argmax(np.abs(np.triu(correlation, 1))), correlation.shape)
    value = f"{correlation[i, j]:+.2f}".replace("-", "−")
    return f"{told}; closest pair: {symbols[i]} and {symbols[j]} ({value})"
