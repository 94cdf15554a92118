"""Detectors of a change in series of values, without a model of the drive.

Values wear as well, so what is watched over the operations, online, is the residual of each from
the line fitted to all before it (recursive residuals, Brown, Durbin & Evans 1975). Of normal noise
around a line they are independent, of the covariance of the noise. A statistic is made of them, one
a value; ``watching`` raises the alarms. Of one series (``chart``):

- ``threshold``: the size of the residual in its sd (Shewhart);
- ``cusum``: the larger of the sums ``S = max(0, S ± residual - 0.5)`` (Page 1954);
- ``ewma``: the size of ``Z = 0.8 Z + 0.2 residual`` over its own sd (Roberts 1959).

Of several together: ``mewma`` (Lowry, Woodall, Champ & Rigdon 1992), and ``slope_test``, whether
the lines bend: the likelihood ratio of a bend, largest over when and in which series.

The first values are a warm-up, from which a line and a covariance are learnt.

Shapes: ``n`` values, ``q`` series.
"""

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter

__all__ = ["KINDS", "chart", "directed", "mewma", "slope_test"]

KINDS = ("threshold", "cusum", "ewma")
_SLACK = 0.5  # of the cusum, sd
_WEIGHT = 0.2  # of the newest residual in the ewma
_ROUND_OFF = 1e-12  # of a value: scatter below it is none
_OWN = 10  # residuals beyond the number of series that a covariance takes


def chart(position: np.ndarray, values: np.ndarray, *, kind: str, warm_up: int) -> np.ndarray:
    """Return the statistic of a control chart of one series, ``(n,)``.

    Args:
        position: Positions of the values, rising, ``(n,)``.
        values: One series, ``(n, 1)``.
        kind: One of ``KINDS``.
        warm_up: Values before the first residual, at least 3. The warm-up goes on for as long as
            the values do not scatter.
    """
    residual, variance, known = _learnt(position, values, warm_up)
    statistic = np.full(len(values), np.nan)
    statistic[known] = _charted(residual[known, 0] / np.sqrt(variance[known, 0, 0]), kind)
    return statistic


def _charted(residual: np.ndarray, kind: str) -> np.ndarray:
    """Statistic of residuals in their sd, ``(n,)``."""
    if kind == "threshold":
        return np.abs(residual)
    if kind == "cusum":
        sums = np.cumsum([residual - _SLACK, -residual - _SLACK], axis=1)
        least = np.minimum(np.minimum.accumulate(sums, axis=1), 0.0)
        return np.max(sums - least, axis=0)
    if kind == "ewma":
        return np.abs(_smooth(residual[:, None], _WEIGHT)[:, 0])
    raise ValueError(f"a chart is one of {', '.join(KINDS)}, not {kind}")


def mewma(position: np.ndarray, values: np.ndarray, *, weight: float, warm_up: int) -> np.ndarray:
    """Return the statistic of a multivariate EWMA of the residuals, ``(n,)``.

    The squared size of ``Z = (1 - weight) Z + weight residual`` in its exact covariance, that of
    the residuals before; as that is an estimate, relative to its mean over the one it has where the
    covariance is known.

    Args:
        position, warm_up: As of ``chart``.
        values: Series, ``(n, q)``, of which none is a combination of the others.
        weight: Of the newest residual, above 0, up to 1.
    """
    residual, covariance, known = _learnt(position, values, warm_up)
    statistic = np.full(len(values), np.nan)
    smooth, q = _smooth(residual[known], weight), values.shape[1]
    size = np.einsum("ni,ni->n", smooth, _solved(covariance[known], smooth))
    degrees = np.flatnonzero(known) - 2
    statistic[known] = size * (degrees - q - 1) / degrees
    return statistic


def slope_test(
    position: np.ndarray,
    values: np.ndarray,
    *,
    groups: Sequence[Sequence[int]],
    ages: Sequence[int],
    warm_up: int,
) -> np.ndarray:
    r"""Return the log likelihood ratio of a bend of the lines, ``(n,)``.

    Of a bend in one group of series, whose size is unknown in each, at one age, against none: the
    largest over groups and ages. With :math:`c` the least-squares estimate of the bend in all
    series over its sd, :math:`T^2` its squared size in the covariance of the :math:`m + 2` values
    before the bend, and :math:`T_0^2` what is left of that where the group bends and the others do
    not, it is :math:`\frac{m - q + 1}{2} \log \frac{m + T^2}{m + T_0^2}` (Rao 1948). Without a
    change its tail for one age and a group of two is :math:`e^{-x}`, exactly.

    Args:
        position, values, warm_up: As of ``mewma``.
        groups: Numbers of the series that may bend together.
        ages: Values since the bend, from 1.
    """
    residual, covariance, known = _learnt(position, values, warm_up)
    bends = _recursive(position, np.maximum(position[:, None] - position, 0.0)).T  # (bend, n)
    n, q = values.shape
    statistic = np.full(n, np.nan)
    statistic[known] = 0.0
    before = np.arange(n) >= q + _OWN  # of those a covariance is taken
    precision = np.zeros_like(covariance)
    precision[before] = np.linalg.inv(covariance[before])
    for age in ages:
        now = np.flatnonzero(known)
        now = now[(now >= age) & before[now - age + 1]]
        since = now - age
        window = np.where(np.arange(n) <= now[:, None], bends[since], 0.0)
        size = np.sqrt(np.square(window).sum(axis=1, keepdims=True))
        ratio = _ratio(window @ residual / size, precision[since + 1], since - 1.0, groups)
        statistic[now] = np.maximum(statistic[now], ratio)
    return statistic


def _ratio(
    bend: np.ndarray, precision: np.ndarray, degrees: np.ndarray, groups: Sequence[Sequence[int]]
) -> np.ndarray:
    """Log likelihood ratio of bends ``(n, q)`` in their sd, largest over groups, ``(n,)``."""
    pull = np.einsum("nij,nj->ni", precision, bend)
    total = np.einsum("ni,ni->n", bend, pull)
    parts = []
    for group in groups:
        own, block = pull[:, group], precision[:, group][:, :, group]
        parts.append(np.einsum("ni,ni->n", own, _solved(block, own)))
    left = np.maximum(total - np.max(parts, axis=0), 0.0)
    return 0.5 * (degrees - bend.shape[1] + 1) * np.log((degrees + total) / (degrees + left))


def directed(position: np.ndarray, values: np.ndarray, *, warm_up: int) -> np.ndarray:
    """Return the residual of each series given all others of that value, in its sd, ``(n, q)``.

    What is left of the noise of one series where the others share it: the form in which a change
    of that series alone shows best to a detector that watches one series. NaN in the warm-up.

    Args:
        position, values, warm_up: As of ``mewma``.
    """
    residual, covariance, known = _learnt(position, values, warm_up)
    result = np.full(values.shape, np.nan)
    precision = np.linalg.inv(covariance[known])
    sd = np.sqrt(np.einsum("nii->ni", precision))
    result[known] = np.einsum("nij,nj->ni", precision, residual[known]) / sd
    return result


def _learnt(
    position: np.ndarray, values: np.ndarray, warm_up: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Residuals ``(n, q)``, covariance of those before each ``(n, q, q)``, and which count."""
    if not warm_up >= 3:
        raise ValueError("warm_up must be at least 3")
    n, q = values.shape
    residual = _recursive(position, values)
    products = residual[:, :, None] * residual[:, None]
    count = np.arange(n)
    covariance = (np.cumsum(products, axis=0) - products) / np.maximum(count - 2, 1)[:, None, None]
    sd = np.sqrt(np.maximum(np.einsum("nii->ni", covariance), 0.0))
    scatters = (sd > _ROUND_OFF * np.abs(values)).all(axis=1)
    least = max(warm_up, q + _OWN if q > 1 else 0)
    return residual, covariance, scatters & (count >= least)


def _recursive(position: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Residual of each value from the line through those before, ``(n, q)``, 0 of the first two.

    In the sd of its prediction over that of the noise, so of the variance of the noise.
    """
    n = len(position)
    count = np.maximum(np.arange(n), 1)[:, None]
    t = (position - position.mean())[:, None] if n else position[:, None]
    y = values - values[:1]

    def before(each: np.ndarray) -> np.ndarray:
        return np.cumsum(each, axis=0) - each

    middle, mean = before(t) / count, before(y) / count
    square = before(t * t) - count * middle**2
    square[:2] = 1.0
    slope = (before(t * y) - count * middle * mean) / square
    away = t - middle
    result = (y - mean - slope * away) / np.sqrt(1 + 1 / count + away**2 / square)
    result[:2] = 0.0
    return result


def _smooth(residual: np.ndarray, weight: float) -> np.ndarray:
    """Exponentially weighted means of residuals ``(n, q)``, over their exact share of the sd."""
    smooth = lfilter([weight], [1.0, weight - 1.0], residual, axis=0)
    left = 1 - (1 - weight) ** (2.0 * np.arange(1, len(residual) + 1))
    return smooth / np.sqrt(weight / (2 - weight) * left)[:, None]


def _solved(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return np.linalg.solve(matrix, vector[..., None])[..., 0]
