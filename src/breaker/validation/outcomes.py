"""What came out of a check of posteriors, in one line for the title of its figure.

Shapes: ``d`` draws, ``q`` outputs.
"""

from collections.abc import Sequence

import numpy as np

from breaker.mechanism import in_digits
from breaker.validation.comparison import percent
from breaker.validation.diagnostics import Recovery, Scores


def recovery_words(found: Recovery) -> str:
    """State how many of the true values intervals contain, over all outputs.

    >>> from breaker.validation.diagnostics import recovery
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
        scores: From :func:`breaker.validation.scores`.
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
