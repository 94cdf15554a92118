"""How long a drive may go on: when its path is beyond a limit, if the wear goes on as it does.

Or changes: the rate may become another one. How likely that is, and by how much, was learned from
lives (``wear_model.future``): in each tenth of the life that a drive would have without as likely,
whether these are ten operations or a thousand. The probability to be beyond after so many
operations is that of the path so much further on, over all the changes that there may be.

A service is planned by the path as it is: a change is noticed when it comes, and moves the plan.
What lives cost in which it comes too late for that is in the margin (``docs/lives.csv``).
"""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np
from scipy.special import ndtri

from breaker.drive.life.path import Path
from breaker.drive.life.readout import Readout
from breaker.mechanism.limits import Limit

_NODES, _NEAREST, _FARTHEST = 12, 10.0, 8.0  # along the path, operations, horizons
_AHEAD = 160  # operations ahead at which a distribution is computed
_WHEN, _HOW = 5, 3  # nodes of when the next change comes, and of its size
_SHARES = (0.05, 0.5, 0.95)


class Future(NamedTuple):
    """What may become of the wear.

    Attributes:
        horizon: Operations, the farthest that is looked for.
        changes: Changes of the rate to expect in a life as long as at the rate so far.
        faster: Median of the factor on the rate,
        spread: and sd of its logarithm.
        widening: Factor on the intervals of changes along a path: a network errs alike all along.
        margin: Share of the life that is left for almost sure, after which to service.
    """

    horizon: int = 10000
    changes: float = 2.0
    faster: float = 6.0
    spread: float = 0.4
    widening: float = 1.8
    margin: float = 0.8

    @classmethod
    def from_settings(cls, settings: Mapping) -> Self:
        """Build from the section ``wear_model`` of the configuration."""
        return cls(settings["horizon"], **settings["future"])

    def ahead(self) -> np.ndarray:
        """Return operations ahead at which it is asked, ``(h,)``; the first is 0."""
        return np.append(0.0, np.geomspace(1.0, self.horizon, _AHEAD - 1))

    def ways(self, life: float) -> tuple[np.ndarray, np.ndarray]:
        """Return how far the path may have come, in operations at its rate, and how probably.

        Args:
            life: Operations from new to the limit, if the wear goes on as it does.

        Returns:
            For each of ``ahead``, ``(h, w)`` each.
        """
        ahead, often = self.ahead()[:, None, None], max(self.changes / life, 1e-12)
        goes_on = np.exp(-often * ahead)
        when = (np.arange(_WHEN) + 0.5)[:, None] / _WHEN  # quantiles, given that a change comes
        before = np.minimum(-np.log1p(-when * (1.0 - goes_on)) / often, ahead)
        factor = self.faster * np.exp(self.spread * ndtri((np.arange(_HOW) + 0.5) / _HOW))
        way = (before + factor * (ahead - before)).reshape(len(ahead), -1)
        share = np.repeat((1.0 - goes_on[:, 0]) / way.shape[1], way.shape[1], axis=1)
        return np.hstack([ahead[:, 0], way]), np.hstack([goes_on[:, 0], share])


class Onward:
    """A path, as it goes on from some operations: draws of the drive at nodes ahead of each.

    Args:
        path, readout: Of the drive.
        where: Indices of the operations, ``(n,)``.
        horizon: Operations, the farthest that is looked for.
        since: What a change is since, ``"new"`` or ``"event"``.

    Attributes:
        nodes: Operations ahead, ``(m,)``; the first is 0.
    """

    def __init__(
        self, path: Path, readout: Readout, where: np.ndarray, horizon: float, since: str
    ) -> None:
        self.shape = _NODES, len(where)
        self.nodes = np.append(0.0, np.geomspace(_NEAREST, _FARTHEST * horizon, _NODES - 1))
        ahead = self.nodes[:, None, None]
        now = (path.change, path.variance, path.covariance)
        if since == "event":
            now = (path.since, path.since_variance, path.covariance)
        change, variance, both = (each[where] for each in now)
        spread = variance + 2.0 * ahead * both + ahead**2 * path.rate_variance[where]
        onward = (change + ahead * path.rate[where]).reshape(-1, readout.size)
        spread = np.maximum(spread, 1e-12).reshape(-1, readout.size)
        self._condition = readout.condition(onward, spread)

    def values(self, limit: Limit) -> np.ndarray:
        """Return draws of the quantities of a limit, ``(m, n, d, parts)``; nan where not known."""
        found = limit.read(self._condition)
        return found.reshape(*self.shape, *found.shape[1:])


class Forecast(NamedTuple):
    """What is known of one limit after some operations.

    Attributes:
        beyond: Probability to be beyond the limit now, ``(n,)``.
        value: Quantities of the limit now, ``(n, parts, 3)``, at 5, 50 and 95 %.
        remaining: Operations left, ``(n, 3)``, at 5, 50 and 95 %; 0 where the limit is exceeded,
            inf beyond the horizon.
        steady: Operations left if the wear goes on as it does, ``(n, 3)``.
    """

    beyond: np.ndarray
    value: np.ndarray
    remaining: np.ndarray
    steady: np.ndarray

    @classmethod
    def of(cls, limit: Limit, onward: Onward, past: np.ndarray, future: Future) -> Self:
        """Return the forecast of a limit.

        Args:
            past: Operations so far, ``(n,)``.
        """
        draws = onward.values(limit)
        now, along = draws[0], _continued(draws, onward.nodes)
        if limit.source.inferred:
            middle = np.median(along, axis=2, keepdims=True)
            wide = middle + future.widening * (along - middle)
            along = np.where(np.isfinite(along), wide, along)
        excess = limit.excess(along)
        remaining, steady = np.full((2, len(past), 3), np.nan)
        ahead = future.ahead()
        for k in np.flatnonzero(np.isfinite(now).any(axis=(1, 2))):
            lives = np.sort(_crossings(excess[:, k], onward.nodes))
            steady[k] = np.quantile(lives, _SHARES, method="inverted_cdf")
            ways, shares = future.ways(past[k] + steady[k, 1])
            over = np.searchsorted(lives, ways, side="right") / lives.size
            remaining[k] = _quantiles(ahead, (over * shares).sum(axis=1))
        steady = np.where(steady > future.horizon, np.inf, steady)
        known = ~np.isnan(remaining[:, 0])
        beyond = np.where(known, limit.exceeded(now).mean(axis=1), np.nan)
        value = np.moveaxis(np.quantile(now, _SHARES, axis=1), 0, -1)
        return cls(beyond, value, remaining, steady)


def _continued(draws: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Draws along paths, ``(nodes, n, d, parts)``; what no network knows goes on straight."""
    found = draws.copy()
    for k in range(2, len(nodes)):
        share = (nodes[k] - nodes[k - 1]) / (nodes[k - 1] - nodes[k - 2])
        with np.errstate(invalid="ignore"):
            straight = found[k - 1] + share * (found[k - 1] - found[k - 2])
        found[k] = np.where(np.isnan(found[k]), straight, found[k])
    return found


def _crossings(excess: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """How far along its path each draw is beyond all parts of a limit, ``(d,)``; inf if it is not.

    Args:
        excess: How far each part is beyond, at the nodes, ``(nodes, d, parts)``; straight between.
    """
    holds = (excess > 0.0).all(axis=-1)
    first = holds.argmax(axis=0)
    found = np.where(holds.any(axis=0), 0.0, np.inf)
    coming = np.flatnonzero(first > 0)
    before, after = excess[first[coming] - 1, coming], excess[first[coming], coming]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(before > 0.0, 0.0, before / (before - after))
    share = np.nan_to_num(share, nan=1.0).max(axis=-1)
    found[coming] = nodes[first[coming] - 1] + share * np.diff(nodes)[first[coming] - 1]
    return found


def _quantiles(ahead: np.ndarray, beyond: np.ndarray) -> list[float]:
    """Operations ahead by which so much of a probability is there, inf if not by the last."""
    total, found = np.maximum.accumulate(beyond), []
    for share, k in zip(_SHARES, np.searchsorted(total, _SHARES), strict=True):
        if 0 < k < len(total):
            part = (share - total[k - 1]) / (total[k] - total[k - 1])
            found.append(float(ahead[k - 1] + part * (ahead[k] - ahead[k - 1])))
        else:
            found.append(np.inf if k else 0.0)
    return found
