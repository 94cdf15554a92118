"""Remaining life: when the level of the drive is first beyond a limit.

Lines are drawn from all hypotheses about the current segment: its beginning and its kind. The level
along a line has no scatter, as nothing that is predicted has: a line that is beyond the limit now
has no operation left. Future changes of the wear are left out: a life is that of the trend as it is
now.

Quantities such as touch times are not linear in the parameters, so they are simulated along each
line. Beyond five prior standard deviations in any parameter the model is not trusted: lines end
there, and what they would reach later counts as never.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from breaker.mechanism import NAMES, Limit, evaluate
from breaker.model import Prior
from breaker.wear.changepoint import PER
from breaker.wear.hypotheses import Hypotheses

__all__ = ["Horizon", "Remaining", "draw_lines", "lives_of", "quantiles_of", "remaining_life"]

_FARTHEST = 5.0  # prior sd, as far as lines are followed
_NODES = np.array([0.0, 1 / 16, 1 / 4, 1.0])  # of a line, where it is simulated first,
_CLOSER = 2  # and how often nearer to where it meets a limit


@dataclass(frozen=True, eq=False)
class Horizon:
    """The range in which a remaining life is sought, and the draws that make lines.

    Attributes:
        operations: Farthest future operation.
        normals: Standard normal draws that make lines, ``(d, 2 p)``: the same for every operation,
            so that a series of predictions is smooth.
        widening: Factor on the widths of trends, for what linear likelihoods leave out.
    """

    operations: int
    normals: np.ndarray
    widening: float = 1.0


@dataclass(frozen=True)
class Remaining:
    """Remaining lives, one for each limit, in draws.

    Attributes:
        lives: Operations until the level is first beyond the limit, ``(limit, d)``: 0 where it is,
            inf where that is not within the horizon.
        toward: Probability that the trend leads to the limit, ``(limit,)``.
        now: Quantities of all parts of all limits by the trend now, ``(d, part)``.
    """

    lives: np.ndarray
    toward: np.ndarray
    now: np.ndarray

    @property
    def beyond(self) -> np.ndarray:
        """Probability that the level is beyond the limit now, ``(limit,)``: of no life left."""
        return np.where(np.isnan(self.lives), np.nan, self.lives == 0).mean(axis=1)

    def quantiles(self, shares: Sequence[float]) -> np.ndarray:
        """Return quantiles of the remaining lives, ``(limit, q)``.

        The least number of operations by which the level is beyond the limit in a share of the
        draws; inf where it is not within the horizon.

        >>> left = Remaining(np.array([[0.0, 30.0, 20.0, np.inf]]), np.ones(1), np.zeros((4, 1)))
        >>> left.quantiles([0.25, 0.5, 0.95]).tolist()
        [[0.0, 20.0, inf]]
        """
        return quantiles_of(self.lives, shares)

    def unknown(self) -> "Remaining":
        """Return the same without any knowledge: nan everywhere."""
        return Remaining(*(np.full_like(getattr(self, each.name), np.nan) for each in fields(self)))


def quantiles_of(draws: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Return the least of draws ``(..., d)`` up to which a share of them lies, ``(..., q)``."""
    d = draws.shape[-1]
    place = np.ceil(np.round(np.asarray(shares) * d, 6)).astype(int) - 1
    return np.sort(draws, axis=-1)[..., place]


def remaining_life(
    hypotheses: Hypotheses, limits: Sequence[Limit], prior: Prior, horizon: Horizon
) -> Remaining:
    """Predict when limits are first exceeded, from the hypotheses after an operation.

    Args:
        hypotheses: Hypotheses about the current segment.
        prior: Prior that standardises the parameters.
        horizon: Future operations and draws.

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> mean = np.zeros((1, 14))
        >>> mean[0, 12] = -0.5  # f falls by 5 percent per 1,000 operations, as known exactly,
        >>> line = np.zeros(1), mean, np.zeros((1, 14, 14))
        >>> first = np.zeros(1), *np.zeros((2, 1), dtype=int), np.zeros(1)
        >>> weak = Limit("weak", "closing", (("f", 0.74, False),))
        >>> horizon = Horizon(1000, np.zeros((2, 14)))
        >>> left = remaining_life(Hypotheses(1, *line, *first), [weak], prior, horizon)
        >>> left.quantiles([0.5])[0].round(-1).tolist()  # 1.3 percent from 0.75
        [270.0]
    """
    return lives_of(draw_lines(hypotheses, horizon), limits, prior, horizon.operations)


def lives_of(lines: np.ndarray, limits: Sequence[Limit], prior: Prior, farthest: int) -> Remaining:
    """Follow lines ``(d, 2 p)`` until the level is beyond each limit, or to the horizon."""
    p = len(NAMES)
    level, slope = lines[:, :p], lines[:, p:] / PER

    def along(at: np.ndarray, which: np.ndarray) -> np.ndarray:
        """Parameters ``(..., p)`` of chosen lines ``(d,)`` after operations ``(d, ...)``."""
        shape = (len(at), *(1,) * (at.ndim - 1), p)
        z = level[which].reshape(shape) + at[..., None] * slope[which].reshape(shape)
        return prior.destandardise(np.clip(z, -_FARTHEST - 1.0, _FARTHEST + 1.0))

    every = np.arange(len(lines))
    nodes = _ends(level, slope, farthest)[:, None] * _NODES  # (d, k)
    known = _simulated(limits, along(nodes, every).reshape(-1, p))
    lives, toward = np.zeros((len(limits), len(lines))), np.zeros(len(limits))
    now = [np.zeros((len(lines), 0))]
    for i, limit in enumerate(limits):
        of = known[limit.motion, limit.speeds]
        values = np.stack([of[name] for name in limit.quantities], axis=-1)
        values = values.reshape(*nodes.shape, -1)
        excess = _excess(limit, values)
        nearer = excess[:, 1] > np.minimum(excess[:, 0], 0.0)  # or holds, and goes on to
        toward[i] = nearer.all(axis=-1).mean()
        lives[i] = _first_beyond(limit, along, nodes, excess)
        now.append(values[:, 0])
    return Remaining(lives, toward, np.concatenate(now, axis=1))


def _ends(level: np.ndarray, slope: np.ndarray, farthest: int) -> np.ndarray:
    """Future operation at which lines ``(d, p)`` leave what the prior holds possible, ``(d,)``."""
    with np.errstate(divide="ignore"):
        ends = np.where(slope > 0, _FARTHEST - level, -_FARTHEST - level) / slope
    ends[slope == 0] = np.inf
    return np.minimum(np.maximum(ends.min(axis=1), 1.0), farthest)


def draw_lines(hypotheses: Hypotheses, horizon: Horizon) -> np.ndarray:
    """Draw lines ``(d, 2 p)``, as many of a hypothesis as its share."""
    d = len(horizon.normals)
    ladder = np.cumsum(hypotheses.weight) / hypotheses.weight.sum()
    chosen = np.minimum(np.searchsorted(ladder, (np.arange(d) + 0.5) / d), ladder.size - 1)
    used, place = np.unique(chosen, return_inverse=True)
    values, vectors = np.linalg.eigh(hypotheses.cov[used])
    # The symmetric root, for the eigenvectors' signs jump from one operation to the next.
    roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None] @ np.swapaxes(vectors, 1, 2)
    moved = np.einsum("dij,dj->di", roots[place], horizon.widening * horizon.normals)
    return hypotheses.mean[chosen] + moved


def _simulated(limits: Sequence[Limit], theta: np.ndarray) -> Mapping[tuple, dict]:
    """Quantities of limits ``(n,)`` at parameters ``(n, p)``, by motion and speeds, by name."""
    known, places = {}, [(limit.motion, limit.speeds) for limit in limits]
    for place in set(places):
        there = [limit for limit, each in zip(limits, places, strict=True) if each == place]
        names = sorted({name for limit in there for name in limit.quantities})
        known[place] = dict(zip(names, evaluate(names, theta, *place).T, strict=True))
    return known


def _first_beyond(
    limit: Limit, along: Callable, nodes: np.ndarray, excess: np.ndarray
) -> np.ndarray:
    """Return the first whole operation at which all parts of a limit hold, ``(d,)``, or inf.

    Args:
        along: Parameters ``(n, p)`` of chosen lines at operations ``(n,)``.
        nodes: Future operations along each line, ``(d, k)``, the first of them 0.
        excess: How far each part is beyond its limit there, ``(d, k, parts)``.
    """
    holds = (excess > 0).all(axis=-1)
    lives = np.where(holds[:, 0], 0.0, np.inf)
    coming = np.flatnonzero(holds.any(axis=1) & ~holds[:, 0])
    if not coming.size:
        return lives
    first = holds[coming].argmax(axis=1)
    sides = np.stack([first - 1, first])  # the last node before, the first beyond
    ends, there = nodes[coming, sides], excess[coming, sides]
    for _ in range(_CLOSER):
        at = _crossing(ends, there)
        closer = _excess(limit, limit.evaluate(along(at, coming)))
        place = (closer > 0).all(axis=-1).astype(int), np.arange(coming.size)
        ends[place], there[place] = at, closer
    lives[coming] = np.floor(_crossing(ends, there)) + 1.0
    return lives


def _excess(limit: Limit, values: np.ndarray) -> np.ndarray:
    """How far values are beyond a limit, inf where a quantity does not exist any more."""
    return np.nan_to_num(limit.excess(values), nan=np.inf)


def _crossing(ends: np.ndarray, excess: np.ndarray) -> np.ndarray:
    """Return when all parts of a limit first hold, if they change linearly, ``(d,)``.

    Args:
        ends: Operations before and after that, ``(2, d)``.
        excess: How far each part is beyond its limit there, ``(2, d, parts)``.
    """
    before, after = excess
    with np.errstate(invalid="ignore"):
        share = np.where(before > 0, 0.0, before / (before - after))
    share = np.where(np.isinf(after) & (before <= 0), 0.5, share).max(axis=-1)
    return ends[0] + share * (ends[1] - ends[0])
