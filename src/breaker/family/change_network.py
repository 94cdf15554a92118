"""What has changed in a drive between two conditions, by a network of its family.

The network sees the drive's curves as they were and their change, and how noisy both are. That a
parameter has not changed at all is an answer of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from breaker.family.mechanisms import WEARING, mechanism_draws
from breaker.family.network_inputs import Basis, NormalisedRecords, change_inputs
from breaker.family.trained_network import Network
from breaker.model.parameters import MOTIONS, NAMES

LEAST_AGREEMENT = 0.01
"""Agreement of a parameter below which closing and opening contradict each other."""

_SURE = 0.95  # share of draws
_MOST = np.log(2.0)  # of the logarithm of a parameter; no wear of a family is half as large


@dataclass(frozen=True)
class ChangeDraws:
    """Draws of a change.

    Attributes:
        ratios: Parameters over what they were, ``(d, p)``; 1 where they have not changed.
        later: By how much touch or separation of each motion at hand comes later after the release,
            ``(d,)``, ms.
        mechanisms: By how much the size of each of ``WEARING`` has changed, ``(d,)``; that of
            ``build_up`` as a share of the duration.
    """

    ratios: np.ndarray
    later: Mapping[str, np.ndarray]
    mechanisms: Mapping[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Changes:
    """A trained network of changes; attributes as of ``Levels``."""

    atoms: ClassVar[tuple[bool, ...]] = (True,) * (len(NAMES) + len(MOTIONS) + len(WEARING))

    settings: Mapping
    network: Network
    bases: Mapping[str, Basis]
    change_bases: Mapping[str, Basis]
    usual: np.ndarray
    centre: np.ndarray
    scale: np.ndarray

    def draw(
        self,
        references: Mapping[str, NormalisedRecords],
        changes: Mapping[str, NormalisedRecords],
        draws: int,
        rng: np.random.Generator,
    ) -> ChangeDraws:
        """Draw from the posterior of the change of one drive.

        Args:
            references: Of each motion at hand, physical units.
            changes: Of the same motions, what ``without_onset`` leaves, in the units of the
                references; its noise is that of both.
        """
        motions = [motion for motion in MOTIONS if motion in references]
        y = self.draws(references, changes, draws, rng, mechanisms=True)[0]
        later = {
            m: float(references[m].duration[0]) * y[:, len(NAMES) + MOTIONS.index(m)]
            for m in motions
        }
        mechanisms = mechanism_draws(y[:, len(NAMES) + len(MOTIONS) :], WEARING, 1.0)
        return ChangeDraws(np.exp(y[:, : len(NAMES)]), later, mechanisms)

    def draws(
        self,
        references: Mapping[str, NormalisedRecords],
        changes: Mapping[str, NormalisedRecords],
        draws: int,
        rng: np.random.Generator,
        *,
        mechanisms: bool = False,
    ) -> np.ndarray:
        """Draw from the posteriors of several changes, the same random numbers for each.

        Returns:
            Logarithms of the parameters over what they were, by how much touch and separation come
            later, in durations, and outputs of the mechanisms that wear, ``(n, d, q)``; these are 0
            unless ``mechanisms``.
        """
        n = len(next(iter(references.values())).way)
        known, changed = (
            {m: each.get(m, NormalisedRecords.nothing(n)) for m in MOTIONS}
            for each in (references, changes)
        )
        x = change_inputs(known, changed, self.bases, self.change_bases, self.usual)
        told = [m in references for m in MOTIONS]
        there = np.array([True] * len(NAMES) + told + [mechanisms] * len(WEARING))
        found = self.network.sample(self.network.features(x), there, draws, rng)
        return self.centre + self.scale * found


def change_outputs(before: np.ndarray, after: np.ndarray, later: np.ndarray) -> np.ndarray:
    """Return parameters and times as a network of changes infers them, before its scale, ``(n, p +
    2)``.

    Args:
        before, after: Parameters, ``(n, p)``.
        later: By how much touch and separation come later, ``(n, 2)``, in durations.
    """
    ratios = np.where(after == before, 1.0, after / before)
    return np.hstack([np.log(ratios), later])


def plausible_wear(draws: np.ndarray) -> np.ndarray:
    """Say whether wear may be what draws tell, ``(...)``: whether 95 % of each are below a factor
    of 2, as no network knows of larger changes than its family has.

    Args:
        draws: Logarithms of the parameters over what they were, ``(..., d, p)``.
    """
    return ((np.abs(draws) < _MOST).mean(axis=-2) > _SURE).all(axis=-1)


def agreement_of(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """How probable it is that draws ``(d, p)`` and others are as far apart, ``(p,)``.

    Twice the share of pairs in which that of the larger draws is the smaller one.
    """
    found = np.empty(one.shape[1])
    for k, (a, b) in enumerate(zip(one.T, np.sort(other, axis=0).T, strict=True)):
        sides = [np.searchsorted(b, a, side).mean() / len(b) for side in ("left", "right")]
        below = np.mean(sides)
        found[k] = 2.0 * min(below, 1.0 - below)
    return found
