"""Forecast when a drive exceeds a limit: draws of its path, continued at a rate that may change.

The rate may change abruptly, with an equal probability for equal relative ageing (``Future``).
Shapes: ``n`` operations of forecasts, ``d`` draws, ``m`` nodes ahead, ``k`` coordinates.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from breaker.common.randomness import generator
from breaker.model.limits import Limit
from breaker.prognosis.readout import Readout
from breaker.prognosis.trend import Path

QUANTILES = (0.05, 0.5, 0.95)
_NODES, _NEAREST = 12, 10.0  # nodes ahead, and operations until the first


class Future(NamedTuple):
    """Distribution of future wear; its values were estimated from simulated lives.

    Attributes:
        horizon: Largest number of operations ahead.
        changes: Expected changes of the rate while a drive becomes e times as old.
        faster, spread: Median of the factor on the rate, and sd of its logarithm.
        noticed: Operations until records show a change of the rate, as a share of the age.
    """

    horizon: int = 10000
    changes: float = 1.0
    faster: float = 6.0
    spread: float = 0.4
    noticed: float = 0.25

    def turns(self, past: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Return operations until the rate changes, ``(n, count)``, and factors on the rate, from
        the same stratified random numbers after each number of operations ``past (n,)``.
        """
        rng = generator(seed, "future of wear")
        when, how = (rng.permutation((np.arange(count) + 0.5) / count) for _ in range(2))
        turns = past[:, None] * (when ** (-1.0 / self.changes) - 1.0)
        return turns, self.faster * np.exp(self.spread * ndtri(how))


class Onward:
    """The continuation of a path from some operations: draws of the drive at nodes ahead of each.

    Uncertainty of the drive's present state enters the network as noise of its records. Uncertainty
    of the rate moves the path, in proportion to the operations ahead.

    Args:
        path, readout: Path of the drive, and its readout as new.
        where, past: Indices of the operations, and operations since new, ``(n,)``.

    Attributes:
        now: Readout of the drive at these operations.
        turns: First result of ``Future.turns``.
    """

    def __init__(
        self, path: Path, readout: Readout, where: np.ndarray, past: np.ndarray, future: Future
    ) -> None:
        self._seed = readout.seed
        self._nodes = np.append(0.0, np.geomspace(_NEAREST, future.horizon, _NODES - 1))
        self.turns, self._faster = future.turns(past, readout.draws, readout.seed)
        change, variance = path.change[where], np.maximum(path.variance[where], 1e-12)
        ahead = self._nodes[:, None, None]
        onward = change + ahead * path.rate[where]
        more = 2.0 * ahead * path.covariance[where] + ahead**2 * path.rate_variance[where]
        aside = np.sqrt(np.maximum(more, 0.0))
        self._new, self.now = readout, readout.at(change, variance)
        self._measured = readout.at(onward, variance + more)
        self._ways = [part.at(onward + way * aside, variance) for part, way in readout.ways()]

    def forecast(self, limit: Limit) -> dict[str, tuple]:
        """Forecast a limit.

        Returns:
            Dimensions and arrays: ``p_exceeded``, the probability that the limit is exceeded now;
            ``p_nearer``, that the drive is nearer to it than as new; ``lives``, operations left of
            each draw: 0 if exceeded, inf beyond the horizon; ``remaining``, their 5, 50 and 95 %
            quantiles; quantities now, ``value``, and as ``new``; unknown numbers are nan. Also
            ``limit``, ``words``, ``of``, and ``part_limit`` to ``part_unit`` of its bounds.
        """
        now, new = limit.read(self.now), limit.read(self._new)[0]
        excess = limit.excess(_continued(self._along(limit), self._nodes))
        known = np.isfinite(now).any(axis=(1, 2))
        lives = np.full(now.shape[:2], np.nan)
        for k in np.flatnonzero(known):
            lives[k] = _crossings(excess[:, k], self._nodes)
        faster = self.turns + (lives - self.turns) / self._faster
        lives = np.where(lives > self.turns, faster, lives)
        nearer = (limit.excess(now) > limit.excess(new)).all(axis=-1).mean(axis=1)
        left = np.quantile(lives, QUANTILES, axis=1, method="inverted_cdf").T
        exceeded, dims = limit.exceeded(now).mean(axis=1), ("limit", "asked")
        quantity, bound, upper = zip(*limit.parts, strict=True)
        parts = {"limit": [limit.name] * len(bound), "unit": limit.units, "quantity": quantity}
        parts |= {"bound": bound, "upper": upper}
        return {
            "p_exceeded": (dims, np.where(known, exceeded, np.nan)[None]),
            "p_nearer": (dims, np.where(known, nearer, np.nan)[None]),
            "remaining": ((*dims, "quantile"), left[None]),
            "lives": ((*dims, "draw"), lives.astype(np.float32)[None]),
            "value": (("part", "asked", "quantile"), np.quantile(now, QUANTILES, axis=1).T),
            "new": ("part", np.median(new, axis=0)),
            **{f"part_{name}": ("part", np.array(values)) for name, values in parts.items()},
            **{name: ("limit", np.array([getattr(limit, name)])) for name in ("words", "of")},
            "limit": ("limit", np.array([limit.name])),
        }

    def _along(self, limit: Limit) -> np.ndarray:
        """Return draws of the quantities along the path, ``(m, n, d, parts)``: normal deviations
        between draws, with the sd of the few directions, as these have no tails.
        """
        if limit.of == "record":
            values = limit.read(self._measured)
            return values.reshape(_NODES, -1, *values.shape[1:])
        every = [limit.read(way) for way in self._ways]
        middles = np.stack([np.median(draws, axis=1, keepdims=True) for draws in every])
        with np.errstate(invalid="ignore"):
            within = np.concatenate([e - m for e, m in zip(every, middles, strict=True)], axis=1)
            normal = ndtri((np.arange(within.shape[1]) + 0.5) / within.shape[1])
            normal = generator(self._seed, "ways of a path").permutation(normal)[:, None]
            values = middles.mean(axis=0) + within + middles.std(axis=0) * normal
        return values.reshape(_NODES, -1, *values.shape[1:])


def _continued(draws: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return draws along paths, ``(m, n, d, parts)``; missing values are extrapolated linearly."""
    steps = draws.copy()
    for k in range(2, len(nodes)):
        share = (nodes[k] - nodes[k - 1]) / (nodes[k - 1] - nodes[k - 2])
        with np.errstate(invalid="ignore"):
            straight = steps[k - 1] + share * (steps[k - 1] - steps[k - 2])
        steps[k] = np.where(np.isnan(steps[k]), straight, steps[k])
    return steps


def _crossings(excess: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return operations until each draw exceeds all parts of a limit, ``(d,)``; inf if it does not.

    ``excess`` is the distance of each part beyond its bound at the nodes, ``(m, d, parts)``.
    """
    over = (excess > 0.0).all(axis=-1)
    first = over.argmax(axis=0)
    crossings = np.where(over.any(axis=0), 0.0, np.inf)
    coming = np.flatnonzero(first > 0)
    before, after = excess[first[coming] - 1, coming], excess[first[coming], coming]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(before > 0.0, 0.0, before / (before - after))
    share = np.nan_to_num(share, nan=1.0).max(axis=-1)
    crossings[coming] = nodes[first[coming] - 1] + share * np.diff(nodes)[first[coming] - 1]
    return crossings
