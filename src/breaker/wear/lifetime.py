"""Remaining life: when the trend of the current segment first takes the drive beyond a limit.

Lines are drawn from all that is held about the current segment, run length, kind of change and
scatter included. Along each of them an operation is beyond a limit by its own scatter, so what is
left is a product of the probabilities not to be beyond it, operation after operation. Future
changes of the wear are left out: a life is that of the trend as it is now.

What an engineer measures of a drive is not linear in its parameters, so it is simulated along each
line. Where a line leaves what the prior holds possible (five standard deviations in any parameter)
the model has no say any more: from there on nothing is predicted, and the distribution of the
remaining life ends below one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy.special import log_ndtr

from breaker.mechanism import NAMES, Limit, evaluate
from breaker.model import Prior
from breaker.wear.changepoint import Hypotheses, Tracker

__all__ = ["Horizon", "Remaining", "horizon_grid", "remaining_life"]

_FARTHEST = 5.0  # prior sd, as far as lines are followed
_NODES = np.array([0.0, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0])  # of a line, where it is simulated
_PER = 1000.0  # operations in the unit of slopes
_BEYOND, _LEAST = 40.0, 1e-9  # sds of scatter of what does not exist; least of its spread
_STEP = 1e-3  # of standardised parameters, for slopes of quantities


def horizon_grid(horizon: int) -> np.ndarray:
    """Return the numbers of future operations at which lines are judged: every one, then wider."""
    wide = np.geomspace(100, horizon, 160) if horizon > 100 else np.array([horizon])
    return np.unique(np.concatenate([np.arange(1, min(horizon, 100) + 1), wide.round()])).astype(
        int
    )


@dataclass(frozen=True, eq=False)
class Horizon:
    """How far and how finely a remaining life is looked for.

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
        """Return the same without any knowledge."""
        return Remaining(*(np.full_like(getattr(self, each.name), np.nan) for each in fields(self)))


def remaining_life(
    tracker: Tracker,
    hypotheses: Hypotheses,
    limits: Sequence[Limit],
    prior: Prior,
    horizon: Horizon,
) -> Remaining:
    """Predict when limits are first exceeded, from what is held after an operation.

    Args:
        tracker: The model of wear.
        hypotheses: Hypotheses about the current segment.
        limits: Limits, in any motion.
        prior: Prior that standardises the parameters.
        horizon: Future operations and draws.
    """
    grid, p = horizon.grid, len(NAMES)
    if not limits:
        none = np.zeros(0)
        return Remaining(np.zeros((0, grid.size)), none, none, np.zeros((len(horizon.normals), 0)))
    lines, scatter = _lines(hypotheses, horizon.widening * horizon.normals, tracker.scatters)
    level, slope = lines[:, :p], lines[:, p:] / _PER
    with np.errstate(divide="ignore"):
        ends = np.where(slope > 0, _FARTHEST - level, -_FARTHEST - level) / slope
    ends[slope == 0] = np.inf
    end = np.minimum(np.maximum(ends.min(axis=1), 1.0), horizon.operations)  # (d,)
    nodes = end[:, None] * _NODES  # (d, k)
    along = level[:, None] + nodes[..., None] * slope[:, None]
    along = np.clip(along, -_FARTHEST - 1.0, _FARTHEST + 1.0)
    steps = np.diff(grid, prepend=0)
    cdf, toward, beyond, now = [], [], [], []
    sampled = _sampled(limits, prior, along.reshape(-1, p), hypotheses.level()[0][:p])
    for limit, (values, spread) in zip(limits, sampled, strict=True):  # (d * k, parts), (parts,)
        values = values.reshape(*nodes.shape, -1)
        now.append(values[:, 0])
        # How many sds of its scatter an operation is beyond the limit in its farthest part; what
        # does not exist, for the motion comes to nothing, is beyond any.
        excess = limit.excess(values)
        scale = scatter[:, None, None] * np.maximum(np.nan_to_num(spread), _LEAST)
        ratio = np.where(np.isnan(excess), _BEYOND, excess / scale).min(axis=-1)
        toward.append(np.mean(ratio[:, 1] > ratio[:, 0]))
        beyond.append(np.mean(ratio[:, 0] > 0))
        left = log_ndtr(-_interpolate(nodes, ratio, grid))
        left[grid > end[:, None]] = 0.0
        cdf.append(-np.expm1((left * steps).cumsum(axis=1)).mean(axis=0))
    return Remaining(np.array(cdf), np.array(toward), np.array(beyond), np.concatenate(now, axis=1))


def _lines(
    hypotheses: Hypotheses, normals: np.ndarray, scatters: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Draw lines ``(d, 2 p)`` and their scatters ``(d,)``, each hypothesis by its share."""
    d = len(normals)
    ladder = np.cumsum(hypotheses.weight) / hypotheses.weight.sum()
    chosen = np.minimum(np.searchsorted(ladder, (np.arange(d) + 0.5) / d), ladder.size - 1)
    used, place = np.unique(chosen, return_inverse=True)
    values, vectors = np.linalg.eigh(hypotheses.cov[used])
    # The symmetric root, for the eigenvectors' signs jump from one operation to the next.
    roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None] @ np.swapaxes(vectors, 1, 2)
    moved = np.einsum("dij,dj->di", roots[place], normals)
    return hypotheses.mean[chosen] + moved, scatters[hypotheses.scatter[chosen]]


def _sampled(limits: Sequence[Limit], prior: Prior, points: np.ndarray, centre: np.ndarray):
    """Yield, limit by limit, quantities ``(n, parts)`` at points and their spread, ``(parts,)``.

    The spread is the sd of a quantity at ``centre`` for a scatter of one in every log parameter.
    """
    p = len(NAMES)
    around = np.concatenate([points, centre + _STEP * np.vstack([np.zeros(p), np.eye(p)])])
    theta = prior.destandardise(around)
    known = {}
    for motion in {limit.motion for limit in limits}:
        names = sorted(
            {part[0] for limit in limits if limit.motion == motion for part in limit.parts}
        )
        known[motion] = dict(zip(names, evaluate(names, theta, motion).T, strict=True))
    for limit in limits:
        values = np.stack([known[limit.motion][part[0]] for part in limit.parts], axis=-1)
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
