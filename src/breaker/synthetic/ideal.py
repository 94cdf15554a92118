r"""What could be known at best of the remaining life of a simulated drive: an ideal observer.

The observer sees the same operations, each record as what it says of the parameters: their values
with the noise of its information. It knows how the lives are drawn: the drive's scatter, when the
wear may change, of which kinds, by how much; and that they are lines with one bend. What it does
not know is whether, when and in what the wear of this life has changed: of that it has the exact
posterior, a sum over all changes, each of them a Gaussian line. One that is *told* knows also when
and in which parameter the wear changed, but not by how much.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import NAMES
from breaker.model import Model, Prior
from breaker.synthetic.lives import KINDS, Life, bend_error, record_information, record_weight
from breaker.wear import lives_of

__all__ = ["Observer"]

_NODES, _REACH = 40, 5.0  # of the ratio, and sds to either side of where it is likeliest
_PER = 1000.0  # operations in the unit of slopes


@dataclass(frozen=True, eq=False)
class Observer:
    """An ideal observer of a life.

    Attributes:
        life: The life.
        prior: Prior of its parameters.
        settings: The section ``lives`` of the configuration.
        operations: Numbers of the records, ``(o,)``.
        seen: Standardised parameters of each as its record says, ``(o, p)``.
        weight: Information of each about the trend, ``(p, p)``.
    """

    life: Life
    prior: Prior
    settings: Mapping
    operations: np.ndarray
    seen: np.ndarray
    weight: np.ndarray

    @classmethod
    def of(
        cls, models: Mapping[str, Model], life: Life, settings: Mapping, rng: np.random.Generator
    ) -> "Observer":
        """Let the records of a life be seen, with the information that they have at its change."""
        prior = next(iter(models.values())).prior
        matrix = record_information(models, life.trend[life.change - 1])
        chosen = life.operations % settings["every"] == 0
        truth = prior.standardise(life.theta[chosen])
        noise = np.linalg.solve(np.linalg.cholesky(matrix).T, rng.standard_normal(truth.T.shape))
        weight = record_weight(matrix, life.scatter / prior.log_sds)
        seen = truth + noise.T
        return cls(life, prior, settings, life.operations[chosen], seen, weight)

    def lives(
        self, now: int, normals: np.ndarray, farthest: int, *, told: bool = False
    ) -> np.ndarray:
        """Return draws of the remaining life after an operation, ``(d,)``, inf where not in sight.

        Args:
            normals: Standard normal draws, ``(d, 2 p)``.
            told: Whether the observer knows when and in what the wear changed.
        """
        known = self.operations <= now
        s, seen = (self.operations[known] - now) / _PER, self.seen[known]
        q, r = np.linalg.qr(np.column_stack([np.ones(s.size), s]))
        changes, kinds, _ = possible = self._changes(now, told)
        bends = np.maximum(s[:, None] - (changes - now) / _PER, 0.0)  # (o, c)
        apart = bends - q @ (q.T @ bends)  # what no line explains
        chosen, which, turn = self._draw(seen, apart, possible, now, len(normals))
        turns = np.zeros((len(normals), len(NAMES)))
        turns[np.arange(len(normals)), kinds[which]] = turn
        line, part = np.linalg.solve(r, q.T @ seen), np.linalg.solve(r, q.T @ bends)  # at now
        since = np.stack([(now - changes) / _PER, np.ones(len(changes))])
        mean = line[None] + (since - part).T[chosen][..., None] * turns[:, None]
        cov = np.kron(np.linalg.inv(r.T @ r), np.linalg.inv(self.weight))
        lines = _with_prior(mean.reshape(len(normals), -1), cov, normals)
        limits = [self.life.limit]
        return lives_of(lines, limits, self.prior, farthest).lives[0]

    def _changes(self, now: int, told: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Operations ``(c,)`` and parameters ``(k,)`` of possible changes, size at a ratio of 1."""
        every, n = self.settings["every"], self.settings["operations"]
        first, last = (round(n * share) for share in self.settings["change"])
        changes = np.arange(first, max(first, min(last, now - every)) + 1, every)
        changes = np.array([self.life.change]) if told else changes
        names = [self.life.changed] if told else list(KINDS)
        kinds, signs = np.array([NAMES.index(name) for name in names]), [KINDS[n] for n in names]
        errors = np.array([bend_error(int(change), self.settings) for change in changes])
        scale = np.array(signs) / np.sqrt(self.weight.diagonal()[kinds])
        return changes, kinds, scale[:, None] * errors

    def _draw(
        self,
        seen: np.ndarray,
        apart: np.ndarray,
        possible: tuple[np.ndarray, np.ndarray, np.ndarray],
        now: int,
        count: int,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Draw changes from their posterior: which operation and kind, and its size, 0 for none."""
        changes, kinds, scales = possible
        precision = self.weight.diagonal()[kinds][:, None] * np.square(apart).sum(axis=0)  # (k, c)
        precision = np.maximum(precision * np.square(scales), 1e-12)  # of the ratio
        slope = ((seen @ self.weight).T @ apart)[kinds] * scales
        lowest, highest = self.settings["ratio"]
        middle, reach = np.clip(slope / precision, lowest, highest), _REACH / np.sqrt(precision)
        low, high = np.maximum(middle - reach, lowest), np.minimum(middle + reach, highest)
        ratio = low[..., None] + (high - low)[..., None] * (np.arange(_NODES) + 0.5) / _NODES
        log_weight = slope[..., None] * ratio - precision[..., None] * np.square(ratio) / 2
        log_weight += np.log((high - low) / _NODES / np.log(highest / lowest))[..., None]
        log_weight -= np.log(ratio) + np.log(len(kinds))
        n, (first, last) = self.settings["operations"], self.settings["change"]
        log_weight += np.log(self.settings["every"] / (n * (last - first)))
        passed = np.clip((now / n - first) / (last - first), 0.0, 1.0 - 1e-9)
        none = -np.inf if changes.size == 1 else np.log1p(-passed)
        every = np.append(log_weight.ravel(), none)
        ladder = np.cumsum(np.exp(every - every.max()))
        at = np.searchsorted(ladder / ladder[-1], (np.arange(count) + 0.5) / count)
        kind, change, node = np.unravel_index(np.minimum(at, every.size - 2), ratio.shape)
        size = ratio[kind, change, node] * scales[kind, change]
        return change, kind, np.where(at < every.size - 1, size, 0.0)


def _with_prior(mean: np.ndarray, cov: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Draw lines ``(d, 2 p)`` of given means and one covariance, levels known by the prior, too."""
    p = len(NAMES)
    gain = np.linalg.solve(cov[:p, :p] + np.eye(p), cov[:p]).T
    root = np.linalg.cholesky(cov - gain @ cov[:p] + 1e-12 * np.eye(2 * p))
    return mean - mean[:, :p] @ gain.T + normals @ root.T
