"""One posterior from both motions of an operation, where they know the same parameters.

Closing and opening are two records of one drive. If its parameters are the same in both, what is
known of them is the product of both likelihoods and one prior; only the onsets are their own. The
product is exact: a Gaussian about the mode of both is corrected by importance sampling against
both likelihoods, as the posterior of one motion is.

Whether the parameters *are* the same is asked of every operation. The Bayes factor compares one set
of parameters for both records with one for each; it is the evidence of both together over the
product of their evidences. A drive whose closing moves masses that its opening does not has two
sets of effective parameters, and fusing them would be wrong.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import NAMES
from breaker.model import Model, information, pool
from breaker.posterior import Corrected, correct

__all__ = ["APART", "Fused", "Pair", "fuse"]

_DIFFERENT = "the motions have different parameters"
_HOPELESS = 120.0  # squared distance of the posteriors from which no common mode is looked for
APART = 60.0  # of chi-square: e^-30 to one, whatever the Occam factors of seven parameters


@dataclass(frozen=True, eq=False)
class Pair:
    """Joint model of the records of both motions, with the parameters in common.

    Unknowns: the seven parameters, then the onset of each motion where the sensor has one. Offers
    what ``correction.correct`` asks of a model.

    Attributes:
        models: Joint model of each motion, with the same prior.
    """

    models: Mapping[str, Model]

    def _parts(self, values: np.ndarray) -> dict[str, np.ndarray]:
        """Split unknowns ``(..., q)`` into those of each motion."""
        p = len(NAMES)
        own = (values.shape[-1] - p) // len(self.models)
        parts = {}
        for i, motion in enumerate(self.models):
            onset = values[..., p + i * own : p + (i + 1) * own]
            parts[motion] = np.concatenate([values[..., :p], onset], axis=-1)
        return parts

    def _joined(self, parts: Mapping[str, np.ndarray]) -> np.ndarray:
        p = len(NAMES)
        first = next(iter(parts.values()))[..., :p]
        return np.concatenate([first, *(part[..., p:] for part in parts.values())], axis=-1)

    def standardise(self, values: np.ndarray) -> np.ndarray:
        """Map unknowns ``(..., q)`` in physical units to standardised ones."""
        parts = self._parts(values)
        return self._joined({name: self.models[name].standardise(v) for name, v in parts.items()})

    def destandardise(self, z: np.ndarray) -> np.ndarray:
        """Map standardised unknowns ``(..., q)`` to physical units."""
        parts = self._parts(z)
        return self._joined({name: self.models[name].destandardise(v) for name, v in parts.items()})

    def log_joint(self, z: np.ndarray, records: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return ``log p(z, records)``, ``(n, q) -> (n,)``; the prior counts once."""
        total, parts, p = np.zeros(len(z)), self._parts(z), len(NAMES)
        for i, (motion, model) in enumerate(self.models.items()):
            total = total + model.log_joint(parts[motion], records[motion])
            if i:  # the parameters' prior is in the first already
                prior = model.log_prior(parts[motion])
                onset = parts[motion][:, p:]
                own = -0.5 * (np.square(onset) + np.log(2 * np.pi)).sum(axis=-1)
                inside = np.isfinite(prior)
                total[inside] += (own - prior)[inside]
        return total


@dataclass(frozen=True)
class Fused:
    """What both motions of an operation say together.

    Attributes:
        draws: Equally weighted draws of the seven parameters, ``(d, p)``, physical units; nan
            where the motions are too far apart to be fused, or the posterior was not resolved.
        log_agreement: Log of the Bayes factor of one set of parameters against two; nan where it
            was not worked out.
        apart: By how much chi-square rises if both motions have the same parameters.
        reason: Why there are no draws; empty if there are.
    """

    draws: np.ndarray
    log_agreement: float
    apart: float
    reason: str


def fuse(
    pair: Pair,
    records: Mapping[str, np.ndarray],
    draws: Mapping[str, np.ndarray],
    log_evidence: float,
    settings: Mapping,
    rng: np.random.Generator,
) -> Fused:
    """Fuse the posteriors of both motions of an operation.

    Args:
        pair: Joint model of both.
        records: Record of each motion, ``(t,)``, mm.
        draws: Draws of each motion's posterior, ``(d, q)``, physical units.
        log_evidence: Sum of the log evidences of both records, each by itself.
        settings: The section ``correction`` of the configuration.
        rng: Generator of all draws.
    """
    p = len(NAMES)
    z = {motion: model.standardise(draws[motion]) for motion, model in pair.models.items()}
    d = len(next(iter(z.values())))
    nothing = np.full((d, p), np.nan)
    if (apart := _distance([each[:, :p] for each in z.values()])) > _HOPELESS:
        return Fused(nothing, np.nan, apart, _DIFFERENT)
    lone = {motion: records[motion][None] for motion in pair.models}
    onsets = {
        m: each[:, p:].mean(axis=0) if each.shape[1] > p else np.zeros(1) for m, each in z.items()
    }
    start = np.mean([each[:, :p].mean(axis=0) for each in z.values()], axis=0)
    mode = pool(pair.models, lone, start, onsets)
    precision, apart, columns = np.eye(p), 0.0, []
    for motion, model in pair.models.items():
        found = information(model, lone[motion], mode[None], onsets[motion])
        precision = precision + found.matrix[0]
        unknowns = np.append(mode, found.onset)[None, : z[motion].shape[1]]
        together = model.sensor.chi_square(
            records[motion], model.curves(model.destandardise(unknowns))
        )[0]
        alone = model.sensor.chi_square(records[motion], model.curves(draws[motion]))
        apart += together - alone.min()
        spread = z[motion][:, p:].std(axis=0)
        columns.append(found.onset + spread * rng.standard_normal((d, spread.size)))
    if not apart < APART:
        return Fused(nothing, np.nan, apart, _DIFFERENT)
    root = np.linalg.cholesky(np.linalg.inv(precision))
    begin = np.concatenate([mode + rng.standard_normal((d, p)) @ root.T, *columns], axis=1)
    found = correct(pair, records, pair.destandardise(begin), settings, rng)
    return _fused(found, p, apart, log_evidence)


def _distance(draws: list[np.ndarray]) -> float:
    """Squared distance of two posteriors' means over their covariances, from draws ``(d, p)``.

    For linear models the least by which chi-square rises, and it takes no search for a mode.
    """
    first, second = draws
    apart = first.mean(axis=0) - second.mean(axis=0)
    return float(apart @ np.linalg.solve(np.cov(first.T) + np.cov(second.T), apart))


def _fused(found: Corrected, p: int, apart: float, log_evidence: float) -> Fused:
    if not found.resolved:
        return Fused(np.full_like(found.draws[:, :p], np.nan), np.nan, apart, found.reason)
    agreement = found.importance.log_evidence - log_evidence
    return Fused(found.draws[:, :p], float(agreement), apart, "")
