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

_RATIOS = 80  # nodes of the ratio
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
            now: The operation.
            normals: Standard normal draws, ``(d, 2 p)``.
            farthest: Farthest remaining life.
            told: Whether the observer knows when and in what the wear changed.
        """
        known = self.operations <= now
        s, seen = (self.operations[known] - now) / _PER, self.seen[known]
        q, r = np.linalg.qr(np.column_stack([np.ones(s.size), s]))
        changes, kinds, sizes = self._changes(now, told)
        bends = np.maximum(s[:, None] - (changes - now) / _PER, 0.0)  # (o, c)
        apart = bends - q @ (q.T @ bends)  # what no line explains
        chosen = self._draw(seen, apart, changes, kinds, sizes, now, len(normals), told)
        turns = np.zeros((len(normals), len(NAMES)))
        where = np.arange(len(normals)), kinds[chosen[0]]
        turns[where] = np.where(chosen[3], sizes[chosen[:3]], 0.0)
        line, part = np.linalg.solve(r, q.T @ seen), np.linalg.solve(r, q.T @ bends)  # at now
        since = np.stack([(now - changes) / _PER, np.ones(len(changes))])
        mean = line[None] + (since - part).T[chosen[1]][..., None] * turns[:, None]
        cov = np.kron(np.linalg.inv(r.T @ r), np.linalg.inv(self.weight))
        lines = _with_prior(mean.reshape(len(normals), -1), cov, normals)
        limits = [self.life.limit]
        return lives_of(lines, limits, self.prior, farthest).lives[0]

    def _changes(self, now: int, told: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Operations ``(c,)``, parameters ``(k,)`` and sizes ``(k, c, r)`` of possible changes."""
        every, n = self.settings["every"], self.settings["operations"]
        first, last = (round(n * share) for share in self.settings["change"])
        changes = np.arange(first, max(first, min(last, now - every)) + 1, every)
        names = [self.life.changed] if told else list(KINDS)
        changes = np.array([self.life.change]) if told else changes
        kinds, signs = np.array([NAMES.index(name) for name in names]), [KINDS[n] for n in names]
        ratios = np.geomspace(*self.settings["ratio"], _RATIOS)
        errors = np.array([bend_error(int(change), self.settings) for change in changes])
        scale = np.array(signs) / np.sqrt(self.weight.diagonal()[kinds])
        return changes, kinds, scale[:, None, None] * errors[:, None] * ratios

    def _draw(
        self,
        seen: np.ndarray,
        apart: np.ndarray,
        changes: np.ndarray,
        kinds: np.ndarray,
        sizes: np.ndarray,
        now: int,
        count: int,
        told: bool,
    ) -> tuple[np.ndarray, ...]:
        """Draw changes from their posterior: indices into sizes, and whether there is any."""
        n, (first, last) = self.settings["operations"], self.settings["change"]
        precision = self.weight.diagonal()[kinds][:, None, None] * np.square(apart).sum(0)[:, None]
        slope = ((seen @ self.weight).T @ apart)[kinds][..., None]
        log_weight = slope * sizes - precision * np.square(sizes) / 2
        each = self.settings["every"] / (n * (last - first)) / sizes.shape[0] / sizes.shape[2]
        passed = (now - n * first) / (n * (last - first))
        none = 0.0 if told else np.clip(1.0 - passed, 1e-12, 1.0)
        with np.errstate(divide="ignore"):
            every = np.append(log_weight.ravel() + np.log(each), np.log(none))
        ladder = np.cumsum(np.exp(every - every.max()))
        at = np.searchsorted(ladder / ladder[-1], (np.arange(count) + 0.5) / count)
        at = np.minimum(at, every.size - 1)
        inside = np.unravel_index(np.minimum(at, every.size - 2), sizes.shape)
        return *inside, at < every.size - 1


def _with_prior(mean: np.ndarray, cov: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Draw lines ``(d, 2 p)`` of given means and one covariance, levels known by the prior, too."""
    p = len(NAMES)
    gain = np.linalg.solve(cov[:p, :p] + np.eye(p), cov[:p]).T
    root = np.linalg.cholesky(cov - gain @ cov[:p] + 1e-12 * np.eye(2 * p))
    return mean - mean[:, :p] @ gain.T + normals @ root.T
