"""How long a drive may go on: when its path is beyond a limit, if the wear goes on as it does.

The rate drifts with each draw of the path (``drift``), and may become another one at once. How
likely that is, and by how much, was learned from lives (``Future``): as likely each time
that the drive has become a tenth older. The probability to be beyond a limit after so many
operations is that of the path so much further on, over all the changes that there may be. A change
that is noticed ends in a service; draws are then followed until then.
"""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np
from scipy.special import ndtri

from breaker.model.limits import Limit
from breaker.prognosis.drift import Drift
from breaker.prognosis.path_fit import Path
from breaker.prognosis.readout import Condition, Readout

_NODES, _NEAREST, _FARTHEST = 12, 10.0, 8.0  # along the path, operations, horizons
_AHEAD = 160  # operations ahead at which a distribution is computed
_FINE = 1500  # and lengths of a path at which the share of draws that is beyond is tabled
_WHEN, _HOW = 48, 3  # nodes of when the next change comes, and of its size
_BLOCK = 32  # rows at once
_SHARES = (0.05, 0.5, 0.95)


class Future(NamedTuple):
    """What may become of the wear.

    Attributes:
        horizon: Operations, the farthest that is looked for.
        changes: Changes of the rate to expect while a drive becomes e times as old.
        faster: Median of the factor on the rate,
        spread: and sd of its logarithm.
        noticed: Records after which a change of the rate is noticed.
        drift: Standard deviation of the drift of the rate, where the path does not show it,
        drifting: and of that to come, about that so far.
    """

    horizon: int = 10000
    changes: float = 1.0
    faster: float = 6.0
    spread: float = 0.4
    noticed: float = 50.0
    drift: float = 1.0
    drifting: float = 0.4

    @classmethod
    def from_settings(cls, settings: Mapping) -> Self:
        """Build from the section ``trend`` of the configuration."""
        return cls(settings["horizon"])

    def ahead(self) -> np.ndarray:
        """Return operations ahead at which it is asked, ``(h,)``; the first is 0."""
        return np.append(0.0, np.geomspace(1.0, self.horizon, _AHEAD - 1))

    def ways(self, lag: np.ndarray | float = np.inf) -> np.ndarray:
        """Return how far the path has come, in operations at its rate so far, ``(..., h, w)``.

        One for each of ``ahead`` and each change that may come, the first none.

        Args:
            lag: Operations from a change until it is noticed, from where on the path is not
                followed, ``(...)``.
        """
        ahead, lag = (
            self.ahead()[:, None, None],
            np.asarray(lag, dtype=float)[..., None, None, None],
        )
        when = np.minimum(self._when()[:, None], ahead)
        until = np.minimum(ahead, when + lag)
        factor = self.faster * np.exp(self.spread * ndtri((np.arange(_HOW) + 0.5) / _HOW))
        way = when + factor * (until - when)
        way = way.reshape(*way.shape[:-2], -1)
        none = np.broadcast_to(self.ahead()[:, None], (*way.shape[:-1], 1))
        return np.concatenate([none, way], axis=-1)

    def shares(self, past: np.ndarray | float) -> np.ndarray:
        """Return how probable each change of ``ways`` is, ``(..., w)``.

        Args:
            past: Operations so far, ``(...)``.
        """
        past, when = np.asarray(past, dtype=float)[..., None], self._when()
        ends = np.concatenate([[0.0], np.sqrt(when[1:] * when[:-1]), [self.horizon]])
        stays = (1.0 + ends / past) ** -self.changes
        each = (stays[..., :-1] - stays[..., 1:]) / _HOW
        return np.concatenate([stays[..., -1:], np.repeat(each, _HOW, axis=-1)], axis=-1)

    def _when(self) -> np.ndarray:
        return np.geomspace(1.0, self.horizon, _WHEN)

    def fails(
        self, lives: np.ndarray, past: np.ndarray, lag: np.ndarray | float = np.inf
    ) -> np.ndarray:
        """Return the probability to be beyond a limit, by each of ``ahead``, ``(n, h)``.

        Args:
            lives: Operations that are left to each draw at the rate so far, ``(n, d)``, sorted; inf
                where it never is beyond, nan where nothing is known.
            past: Operations so far, ``(n,)``.
            lag: As of ``ways``, ``(n,)``; inf where nobody looks.
        """
        fine = np.append(0.0, np.geomspace(0.5, _FARTHEST * self.horizon, _FINE))
        lag, found = np.broadcast_to(lag, past.shape), np.full((len(past), _AHEAD), np.nan)
        shares = self.shares(past)
        known = np.flatnonzero(~np.isnan(lives[:, 0]))
        for lags in np.unique(lag[known]):
            places = np.searchsorted(0.5 * (fine[1:] + fine[:-1]), self.ways(lags))
            rows = known[lag[known] == lags]
            for some in np.split(rows, range(_BLOCK, len(rows), _BLOCK)):
                over = [np.searchsorted(each, fine, side="right") for each in lives[some]]
                over = np.array(over, dtype=np.float32).reshape(-1, fine.size) / lives.shape[1]
                found[some] = np.einsum("nhw,nw->nh", over[:, places], shares[some])
        return np.maximum.accumulate(found, axis=1)

    def quantiles(self, fails: np.ndarray) -> np.ndarray:
        """Return operations ahead by which 5, 50 and 95 % are beyond, ``(n, 3)``; inf if never."""
        ahead, found = self.ahead(), np.full((len(fails), len(_SHARES)), np.nan)
        rows = np.flatnonzero(~np.isnan(fails[:, 0]))
        for j, share in enumerate(_SHARES):
            k = (fails[rows] < share).sum(axis=1)
            low, high = np.maximum(k - 1, 0), np.minimum(k, _AHEAD - 1)
            before, after = fails[rows, low], fails[rows, high]
            part = (share - before) / np.where(after > before, after - before, 1.0)
            between = ahead[low] + part * (ahead[high] - ahead[low])
            found[rows, j] = np.where(k == 0, 0.0, np.where(k == _AHEAD, np.inf, between))
        return found


class Onward:
    """A path, as it goes on from some operations: draws of the drive at nodes ahead of each.

    Uncertainty of the drive's present state enters the network as noise of its records. That of the
    rate leads elsewhere, the farther the more, in the directions in which it is not known.

    Args:
        path, readout: Of the drive.
        where: Indices of the operations, ``(n,)``.
        horizon: Operations, the farthest that is looked for.
        since: What a change is since, ``"new"`` or ``"event"``.

    Attributes:
        nodes: Operations ahead, at the rate of now, ``(m,)``; the first is 0.
    """

    def __init__(
        self, path: Path, readout: Readout, where: np.ndarray, horizon: float, since: str
    ) -> None:
        self.nodes = np.append(0.0, np.geomspace(_NEAREST, _FARTHEST * horizon, _NODES - 1))
        ahead = self.nodes[:, None, None]
        now = (path.change, path.variance, path.covariance)
        if since == "event":
            now = (path.since, path.since_variance, path.covariance)
        change, variance, both = (each[where] for each in now)
        onward = change + ahead * path.rate[where]
        more = 2.0 * ahead * both + ahead**2 * path.rate_variance[where]
        self.shape, every = onward.shape[:2], np.tile(where, _NODES)
        self._seed = readout.seed

        def condition(of: Readout, change: np.ndarray, variance: np.ndarray) -> Condition:
            flat = (each.reshape(-1, of.size) for each in (change, np.maximum(variance, 1e-12)))
            return of.condition(*flat, every)

        self._now = readout.condition(change, np.maximum(variance, 1e-12), where)
        self._measured = condition(readout, onward, variance + more)
        aside, still = np.sqrt(np.maximum(more, 0.0)), np.broadcast_to(variance, onward.shape)
        self._ways = [condition(of, onward + way * aside, still) for of, way in readout.ways()]

    def now(self, limit: Limit) -> np.ndarray:
        """Return draws of the quantities of a limit, ``(n, d, parts)``; nan where not known."""
        return limit.read(self._now)

    def values(self, limit: Limit) -> np.ndarray:
        """Return draws of the quantities along the path, ``(m, n, d, parts)``.

        The few ways have no tails; their spread says how far draws are apart.
        """
        if limit.of == "record":
            found = limit.read(self._measured)
            return found.reshape(*self.shape, *found.shape[1:])
        each = [limit.read(condition) for condition in self._ways]
        middles = np.stack([np.median(draws, axis=1, keepdims=True) for draws in each])
        with np.errstate(invalid="ignore"):
            within = [draws - middle for draws, middle in zip(each, middles, strict=True)]
            within = np.concatenate(within, axis=1)
            count = within.shape[1]
            normal = ndtri((np.arange(count) + 0.5) / count)
            normal = np.random.default_rng(self._seed).permutation(normal)[:, None]
            found = middles.mean(axis=0) + within + middles.std(axis=0) * normal
        return found.reshape(*self.shape, *found.shape[1:])


class Forecast(NamedTuple):
    """What is known of one limit after some operations.

    Attributes:
        beyond: Probability to be beyond the limit now, ``(n,)``.
        value: Quantities of the limit now, ``(n, parts, 3)``, at 5, 50 and 95 %.
        remaining: Operations left, ``(n, 3)``, at 5, 50 and 95 %; 0 where the limit is exceeded,
            inf beyond the horizon.
        lives: Operations left to each draw if the wear drifts as it does, ``(n, d)``, sorted.
    """

    beyond: np.ndarray
    value: np.ndarray
    remaining: np.ndarray
    lives: np.ndarray

    @classmethod
    def of(
        cls, limit: Limit, onward: Onward, drift: Drift, past: np.ndarray, future: Future
    ) -> Self:
        """Return the forecast of a limit after ``past`` operations, ``(n,)``."""
        now, along = onward.now(limit), _continued(onward.values(limit), onward.nodes)
        excess, lives = limit.excess(along), np.full(now.shape[:2], np.nan)
        known = np.isfinite(now).any(axis=(1, 2))
        for k in np.flatnonzero(known):
            lives[k] = _crossings(excess[:, k], onward.nodes)
        lives = np.sort(drift.operations(lives), axis=1)
        remaining = future.quantiles(future.fails(lives, past))
        beyond = np.where(known, limit.exceeded(now).mean(axis=1), np.nan)
        value = np.moveaxis(np.quantile(now, _SHARES, axis=1), 0, -1)
        return cls(beyond, value, remaining, lives)


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

    ``excess`` is how far each part is beyond at the nodes, ``(nodes, d, parts)``.
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
