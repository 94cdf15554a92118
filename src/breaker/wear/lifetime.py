"""Remaining life: when the trend of the current segment first takes the drive beyond a limit.

Lines are drawn from all hypotheses about the current segment: its beginning, kind and scatter.
Along a line, every operation may exceed the limit by its own scatter, so the probability not to
have exceeded it is a product over operations. Future changes of the wear are left out: a life is
that of the trend as it is now.

Quantities such as touch times are not linear in the parameters, so they are simulated along each
line. Beyond five prior standard deviations in any parameter the model is not trusted: nothing is
predicted from there on, and the distribution of the remaining life ends below one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy.special import log_ndtr

from breaker.mechanism import NAMES, Limit, evaluate
from breaker.model import Prior
from breaker.wear.changepoint import PER, Hypotheses, Tracker

__all__ = ["Horizon", "Remaining", "horizon_grid", "reached", "remaining_life"]

_FARTHEST = 5.0  # prior sd, as far as lines are followed
_NODES = np.array([0.0, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0])  # of a line, where it is simulated
_NO_VALUE = 40.0  # excess, in sds of the scatter, of a quantity that does not exist
_LEAST = 1e-9  # least spread of a quantity
_STEP = 1e-3  # of standardised parameters, for slopes of quantities


def horizon_grid(horizon: int) -> np.ndarray:
    """Return the numbers of future operations at which lines are judged: every one, then wider."""
    wide = np.geomspace(100, horizon, 160) if horizon > 100 else np.array([horizon])
    return np.unique(np.concatenate([np.arange(1, min(horizon, 100) + 1), wide.round()])).astype(
        int
    )


@dataclass(frozen=True, eq=False)
class Horizon:
    """The range and resolution in which a remaining life is sought.

    Attributes:
        operations: Farthest future operation.
        normals: Standard normal draws that make lines, ``(d, 2 p)``: the same for every operation,
            so that a series of predictions is smooth.
        widening: Factor on the widths of trends, for what linear likelihoods leave out.
    """

    operations: int
    normals: np.ndarray
    widening: float = 1.0

    @cached_property
    def grid(self) -> np.ndarray:
        """Future operations, ``(g,)``."""
        return horizon_grid(self.operations)


@dataclass(frozen=True)
class Remaining:
    """Remaining lives, one for each limit.

    Attributes:
        cdf: Probability to be beyond the limit by a future operation of the grid, ``(limit, g)``.
        toward: Probability that the trend leads to the limit, ``(limit,)``.
        beyond: Probability that the trend is beyond it now, ``(limit,)``.
        now: Quantities of all parts of all limits by the trend now, ``(d, part)``.
    """

    cdf: np.ndarray
    toward: np.ndarray
    beyond: np.ndarray
    now: np.ndarray

    def unknown(self) -> "Remaining":
        """Return the same without any knowledge: nan everywhere."""
        return Remaining(*(np.full_like(getattr(self, each.name), np.nan) for each in fields(self)))


def reached(grid: np.ndarray, cdf: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Return the future operations by which a probability is reached, inf where it is not.

    >>> reached(np.array([1, 2, 3]), np.array([0.1, 0.5, 0.9]), [0.3, 0.95]).tolist()
    [1.5, inf]

    Args:
        grid: Future operations, ``(g,)``.
        cdf: Probability to be beyond a limit by then, ``(g,)``; without knowledge nan, and then
            the result is nan, too.
        shares: Probabilities, ``(q,)``.
    """
    if np.isnan(cdf).any():
        return np.full(len(shares), np.nan)
    return np.array(
        [np.interp(share, cdf, grid) if cdf[-1] >= share else np.inf for share in shares]
    )


def remaining_life(
    tracker: Tracker,
    hypotheses: Hypotheses,
    limits: Sequence[Limit],
    prior: Prior,
    horizon: Horizon,
) -> Remaining:
    """Predict when limits are first exceeded, from the hypotheses after an operation.

    Args:
        tracker: The model of wear.
        hypotheses: Hypotheses about the current segment.
        limits: Limits, in any motion.
        prior: Prior that standardises the parameters.
        horizon: Future operations and draws.

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> tracker = Tracker(np.full(7, 0.1), 1e-3, 2.0, 0.05, np.array([0.001]), 0.0, 0.2)
        >>> mean = np.zeros((1, 14))
        >>> mean[0, 12] = -0.5  # f falls by 5 percent per 1,000 operations, as known exactly,
        >>> line = np.zeros(1), mean, np.zeros((1, 14, 14))
        >>> first = *np.zeros((2, 1), dtype=int), np.zeros(1, dtype=int)
        >>> weak = Limit("weak", "closing", (("f", 0.74, False),))
        >>> horizon = Horizon(1000, np.zeros((2, 14)))
        >>> left = remaining_life(tracker, Hypotheses(1, *line, *first), [weak], prior, horizon)
        >>> float(reached(horizon.grid, left.cdf[0], [0.5])[0].round(-1))  # 1.3 percent from 0.75
        240.0
    """
    grid, p = horizon.grid, len(NAMES)
    lines, scatter = _lines(hypotheses, horizon.widening * horizon.normals, tracker.scatters)
    level, slope = lines[:, :p], lines[:, p:] / PER
    end = _ends(level, slope, horizon.operations)
    nodes = end[:, None] * _NODES  # (d, k)
    along = level[:, None] + nodes[..., None] * slope[:, None]
    along = np.clip(along, -_FARTHEST - 1.0, _FARTHEST + 1.0)
    steps = np.diff(grid, prepend=0)
    cdf, now = np.zeros((len(limits), grid.size)), [np.zeros((len(lines), 0))]
    toward, beyond = np.zeros((2, len(limits)))
    simulated = _simulated(limits, prior, along.reshape(-1, p), hypotheses.level()[0][:p])
    for i, (limit, (values, spread)) in enumerate(zip(limits, simulated, strict=True)):
        values = values.reshape(*nodes.shape, -1)
        scale = scatter[:, None, None] * np.maximum(np.nan_to_num(spread), _LEAST)
        excess = limit.excess(values)
        ratio = np.where(np.isnan(excess), _NO_VALUE, excess / scale).min(axis=-1)  # (d, k)
        toward[i], beyond[i] = np.mean(ratio[:, 1] > ratio[:, 0]), np.mean(ratio[:, 0] > 0)
        log_below = log_ndtr(-_interpolate(nodes, ratio, grid))  # of an operation, (d, g)
        log_below[grid > end[:, None]] = 0.0
        cdf[i] = -np.expm1((log_below * steps).cumsum(axis=1)).mean(axis=0)
        now.append(values[:, 0])
    return Remaining(cdf, toward, beyond, np.concatenate(now, axis=1))


def _ends(level: np.ndarray, slope: np.ndarray, farthest: int) -> np.ndarray:
    """Future operation at which lines ``(d, p)`` leave what the prior holds possible, ``(d,)``."""
    with np.errstate(divide="ignore"):
        ends = np.where(slope > 0, _FARTHEST - level, -_FARTHEST - level) / slope
    ends[slope == 0] = np.inf
    return np.minimum(np.maximum(ends.min(axis=1), 1.0), farthest)


def _lines(
    hypotheses: Hypotheses, normals: np.ndarray, scatters: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Draw lines ``(d, 2 p)`` and their scatters ``(d,)``, as many of a hypothesis as its share."""
    d = len(normals)
    ladder = np.cumsum(hypotheses.weight) / hypotheses.weight.sum()
    chosen = np.minimum(np.searchsorted(ladder, (np.arange(d) + 0.5) / d), ladder.size - 1)
    used, place = np.unique(chosen, return_inverse=True)
    values, vectors = np.linalg.eigh(hypotheses.cov[used])
    # The symmetric root, for the eigenvectors' signs jump from one operation to the next.
    roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None] @ np.swapaxes(vectors, 1, 2)
    moved = np.einsum("dij,dj->di", roots[place], normals)
    return hypotheses.mean[chosen] + moved, scatters[hypotheses.scatter[chosen]]


def _simulated(
    limits: Sequence[Limit], prior: Prior, points: np.ndarray, centre: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield, limit by limit, quantities ``(n, parts)`` at points and their spread, ``(parts,)``.

    The spread is the sd of a quantity at ``centre`` for a scatter of one in every log parameter.
    """
    p = len(NAMES)
    around = np.concatenate([points, centre + _STEP * np.vstack([np.zeros(p), np.eye(p)])])
    theta = prior.destandardise(around)
    known, places = {}, [(limit.motion, limit.speeds) for limit in limits]
    for place in set(places):
        there = [limit for limit, each in zip(limits, places, strict=True) if each == place]
        names = sorted({name for limit in there for name in limit.quantities})
        known[place] = dict(zip(names, evaluate(names, theta, *place).T, strict=True))
    for limit, place in zip(limits, places, strict=True):
        values = np.stack([known[place][name] for name in limit.quantities], axis=-1)
        slopes = (values[-p:] - values[-p - 1]) / (_STEP * prior.log_sds[:, None])
        yield values[: len(points)], np.sqrt(np.square(slopes).sum(axis=0))


def _interpolate(nodes: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Interpolate values ``(d, k)`` at nodes ``(d, k)`` linearly on a grid, ``(d, g)``."""
    share = np.minimum(grid / nodes[:, -1:], 1.0)  # the nodes of all lines are the same shares
    right = np.clip(np.searchsorted(_NODES, share), 1, _NODES.size - 1)
    low, high = _NODES[right - 1], _NODES[right]
    rows = np.arange(len(values))[:, None]
    weight = (share - low) / (high - low)
    return (1.0 - weight) * values[rows, right - 1] + weight * values[rows, right]
