"""The state of a drive from one record or both motions of an operation, by a network of the family.

The network was trained on rich drives, whose seven parameters are the truth, and whose elements are
drawn afresh for every drive. It sees shapes (``records.normalised_shape``), and infers in the units
of stroke and duration of the first motion. So the answer follows a drive's size exactly. Where the
size is given, stroke and duration themselves are told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from breaker.common.tensor_file import ModelFileError
from breaker.family.mechanisms import MECHANISMS, mechanism_draws
from breaker.family.membership import Match, Membership
from breaker.family.network_inputs import Basis, NormalisedRecords, level_inputs
from breaker.family.trained_network import Network
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size, powers

_MOST = 100.0  # logarithms of sizes, and times over durations, by far more than of any drive
_BEYOND = 1e-3  # share of draws beyond these; the tails of a sound network reach there in 1e-6
_APART = 0.25
"""Share of the variance added by factors of widening that outputs do not have in common.

Errors for foreign drives are not along the posterior. If they were (0), a recorded contact would
narrow L too much: 76 % of 95 % intervals hold it for drives with all mechanisms, 89 % by this share
(``studies.mechanisms all --contact 0.1 --wipe 0.05``).
"""

EVENTS = tuple(f"{event} {motion}" for motion in MOTIONS for event in ("release", "switching"))
"""Outputs beside the parameters: when each motion begins, and the contact touches or parts."""


@dataclass(frozen=True)
class LevelDraws:
    """Draws of the state of a drive.

    Attributes:
        theta: Parameters, ``(d, p)``, physical units.
        release: Of each motion that is there, ``(d,)``, ms after 10 % of its way.
        switching: The same of touch or separation of the drive's own contact.
        mechanisms: Size of each of ``MECHANISMS``, ``(d,)``; exactly 0 where it is absent.
    """

    theta: np.ndarray
    release: Mapping[str, np.ndarray]
    switching: Mapping[str, np.ndarray]
    mechanisms: Mapping[str, np.ndarray] = field(default_factory=dict)

    def of(self, chosen: np.ndarray) -> "LevelDraws":
        """Return some of the draws, by their numbers ``(k,)``."""
        named = (
            {name: each[chosen] for name, each in by.items()}
            for by in (self.release, self.switching, self.mechanisms)
        )
        return LevelDraws(self.theta[chosen], *named)

    def joined(self, more: "LevelDraws") -> "LevelDraws":
        """Return these draws and others of the same posterior."""
        named = (
            {name: np.append(each, getattr(more, of)[name]) for name, each in by.items()}
            for of, by in vars(self).items()
            if of != "theta"
        )
        return LevelDraws(np.concatenate([self.theta, more.theta]), *named)


@dataclass(frozen=True, eq=False)
class Levels:
    """A trained network of levels.

    Attributes:
        settings: How it was made; ``family``, its name, and ``prior`` among them.
        network: Its weights.
        bases: Components of the shapes of each motion.
        usual: Mean and sd of the logarithms of stroke and duration, ``(2, 2)``.
        centre, scale: Of the outputs, ``(q,)``.
        members: What drives of the family look like, by motion.
        widening: Factors on the distances of draws from their median, ``(p + 4,)``, by the number
            of motions that tell a drive: 1 where none is given.
    """

    atoms: ClassVar[tuple[bool, ...]] = tuple(
        np.repeat([False, True], [len(NAMES) + len(EVENTS), len(MECHANISMS)]).tolist()
    )
    """Which outputs may be exactly 0."""

    settings: Mapping
    network: Network
    bases: Mapping[str, Basis]
    usual: np.ndarray
    centre: np.ndarray
    scale: np.ndarray
    members: Mapping[str, Membership]
    widening: Mapping[int, np.ndarray] = field(default_factory=dict)

    def draw(
        self,
        records: Mapping[str, NormalisedRecords],
        draws: int,
        rng: np.random.Generator,
        *,
        size: Size | None = None,
    ) -> LevelDraws:
        """Draw from the posterior of one operation.

        Args:
            records: One record of each motion at hand, physical units.
            size: Size of the drive beside the family's, if it is given.

        Raises:
            ModelFileError: If more than one answer in a thousand is no number, or beyond all
                drives.
        """
        motions = [motion for motion in MOTIONS if motion in records]
        seen = {m: records.get(m, NormalisedRecords.nothing(1)) for m in MOTIONS}
        told, unit = np.array([size is not None]), size or UNIT
        at_one = {
            m: each._replace(stroke=each.stroke / unit.lengths, duration=each.duration / unit.times)
            for m, each in seen.items()
        }
        x = level_inputs(at_one, told, self.bases, self.usual)
        there = outputs_there([m in records for m in MOTIONS])
        found = self.network.sample(self.network.features(x), there, draws, rng)[0]
        y = self.centre + self.scale * found
        beyond = ~(np.abs(y) < _MOST).all(axis=1)
        if beyond.all() or beyond.sum() > 1 + _BEYOND * draws:
            why = "train it anew"
            if size is not None:
                why = "the size that is given is far from what the record shows: check it"
            raise ModelFileError(f"a network answers no sizes of a drive: {why}")
        y[beyond] = y[~beyond][: beyond.sum()]
        if (factors := self.widening.get(len(motions))) is not None:
            y[:, : len(factors)] = _widened(y[:, : len(factors)], factors, rng)
        first = seen[motions[0]]
        scale = Size(float(first.stroke[0]), float(first.duration[0]))
        events = {
            name: float(seen[name.split()[1]].duration[0]) * y[:, len(NAMES) + k]
            for k, name in enumerate(EVENTS)
        }
        release, switching = (
            {m: events[f"{event} {m}"] for m in motions} for event in ("release", "switching")
        )
        sizes = y[:, len(NAMES) + len(EVENTS) :]
        mechanisms = mechanism_draws(sizes, MECHANISMS, float(first.duration[0]))
        theta = np.exp(y[:, : len(NAMES)]) * scale.factors
        return LevelDraws(theta, release, switching, mechanisms)

    def match(self, motion: str, record: NormalisedRecords) -> Match:
        """Say whether one record may be of a drive of the family."""
        return self.members[motion].match(record, self.bases[motion])


def _widened(y: np.ndarray, factors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return draws ``(d, k)`` with factors ``(k,)`` times their sds, about their medians."""
    apart, added = y - np.median(y, axis=0), np.square(factors) - 1.0
    own = np.sqrt(_APART * added) * rng.permuted(apart, axis=0)
    return y + (np.sqrt(1.0 + (1.0 - _APART) * added) - 1.0) * apart + own


def outputs_there(motions: Sequence[bool]) -> np.ndarray:
    """Return which outputs records of motions tell, ``(q,)`` of bool; or ``(n, ...) -> (n, q)``."""
    motions = np.asarray(motions)
    known, more = (
        np.ones((*motions.shape[:-1], n), dtype=bool) for n in (len(NAMES), len(MECHANISMS))
    )
    return np.concatenate([known, np.repeat(motions, 2, axis=-1), more], axis=-1)


def level_outputs(
    theta: np.ndarray, events: np.ndarray, stroke: np.ndarray, duration: np.ndarray
) -> np.ndarray:
    """Return parameters and events as a network of levels infers them, before its scale, ``(n, p +
    4)``.

    Args:
        theta: Parameters, ``(n, p)``.
        events: ``EVENTS``, after 10 % of the way of their motion, in its durations, ``(n, 4)``.
        stroke, duration: As records show them of the first motion that is there, ``(n,)``.
    """
    length, time = powers()
    units = np.log(stroke)[:, None] * length + np.log(duration)[:, None] * time
    return np.hstack([np.log(theta) - units, events])
