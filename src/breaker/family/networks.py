"""Trained networks read as arrays: features of an input, and draws given these. Needs no torch.

The same numbers as ``blocks.ResidualMLP`` and ``mixture.AutoregressiveMixture`` give, as a test
shows.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from breaker.common.tensor_file import ModelFileError
from breaker.family.inputs import Basis, NormalisedRecords, change_inputs, state_inputs
from breaker.family.membership import Match, Membership
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size, powers

EFFECTS = {
    "contact_preload": "preload of the contact spring, share of the closing force",
    "sliding_contact": "way to the touch of a contact that slides, share of the stroke",
    "build_up": "time in which the closing force builds up or is gone",
    "dry_friction": "dry friction, share of the closing force",
    "opening_preload": "preload of the opening spring, share of the closing force",
    "force_fall": "share of the closing force that is gone at the end of the way",
    "drag": "drag at the mean speed of a closing, share of the closing force",
    "train_mass": "mass that moves along in closing alone, share of the drive's",
    "closing_damper": "damper at the closed end at that speed, share of the closing force",
    "opening_damper": "damper at the open end at that speed, share of the closing force",
}
"""What the size of each mechanism is; that of ``build_up`` is in ms."""

CHANGE_OF = "the closing force (build_up: of the duration)"
"""What changes of mechanisms are shares of."""

WEARING = tuple(name for name in EFFECTS if name not in ("sliding_contact", "train_mass"))
"""Mechanisms that wear, whose change networks of changes tell."""


def effect_outputs(sizes: Mapping[str, np.ndarray], duration: np.ndarray) -> np.ndarray:
    """Return what networks infer of sizes of mechanisms or their changes, ``(n,)`` each, before
    their scale, ``(n, m)``; ``duration`` is that of the first motion that is there, ms,
    ``(n,)``.
    """
    units = {"build_up": duration}
    return np.arcsinh(np.column_stack([each / units.get(n, 1.0) for n, each in sizes.items()]))


def effect_draws(
    outputs: np.ndarray, names: Iterable[str], duration: float
) -> dict[str, np.ndarray]:
    """Return sizes of mechanisms, or their changes, by name, of draws ``(d, m)`` of outputs."""
    units = {"build_up": duration}
    return {n: units.get(n, 1.0) * np.sinh(each) for n, each in zip(names, outputs.T, strict=True)}


_CLIP, _WIDEST = 5.0, 7.0  # as of ``AutoregressiveMixture``
_AT_ONCE = 2_000  # draws whose arrays stay in a processor's cache


class Network:
    """Residual network and autoregressive mixture on top of it.

    Args:
        arrays: Weights by their names in ``training.FamilyNetwork``.
        atoms: Which outputs may be exactly 0, ``(q,)`` of bool.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], atoms: Sequence[bool]) -> None:
        self.arrays = arrays
        self.blocks = sum(name.startswith("summary.inner.") for name in arrays) // 2
        self.dims, self.width, outputs = arrays["inference.leave"].shape
        self.components = (outputs - 1) // 3
        self.atoms = tuple(atoms)

    def features(self, x: np.ndarray) -> np.ndarray:
        """Map inputs ``(n, i)`` to features ``(n, s)``."""
        h = self._layer("enter", x)
        for k in range(self.blocks):
            h = h + self._layer(f"outer.{k}", _silu(self._layer(f"inner.{k}", _silu(h))))
        return self._layer("leave", _silu(h))

    def _layer(self, name: str, x: np.ndarray, part: str = "summary") -> np.ndarray:
        weight, bias = (self.arrays[f"{part}.{name}.{kind}"] for kind in ("weight", "bias"))
        return x @ weight.T + bias

    def sample(
        self, features: np.ndarray, there: np.ndarray, draws: int, rng: np.random.Generator
    ) -> np.ndarray:
        """Draw outputs for inputs, the same random numbers for each.

        Args:
            features: ``(n, s)``.
            there: Which outputs the inputs can tell, ``(q,)`` of bool.
            draws: Number of draws d.

        Returns:
            ``(n, d, q)``; 0 where an output is not told.
        """
        n, q = len(features), self.dims
        head = self._layer("head", features, "inference")
        place, scale, below = np.split(head, [q, 2 * q], axis=1)
        weights = np.zeros((n, q, q), dtype=head.dtype)
        weights[:, *np.tril_indices(q, -1)] = below
        scale = np.exp(np.clip(scale, -_WIDEST, _WIDEST))
        shift = self._layer("project", features, "inference").reshape(n, q, -1, 1)
        # What is linear in an output: place, scale, weights of the outputs before, half the shift.
        linear = place[..., None], scale[..., None], weights[:, :, None], 0.5 * shift
        uniform, normal = rng.random((draws, q, 2)), rng.standard_normal((draws, q))
        theta = np.zeros((n, q, draws))
        inputs = max(1, _AT_ONCE // draws)
        for some in (slice(k, k + inputs) for k in range(0, n, inputs)):
            for few in (slice(k, k + _AT_ONCE) for k in range(0, draws, _AT_ONCE)):
                chance = uniform[few].T, normal[few].T
                own = [each[some] for each in linear]
                self._fill(theta[some, :, few], own, there, *chance)
        return theta.transpose(0, 2, 1)

    def _fill(
        self,
        theta: np.ndarray,
        linear: Sequence[np.ndarray],
        there: np.ndarray,
        uniform: np.ndarray,
        normal: np.ndarray,
    ) -> None:
        """Draw outputs ``(n, q, d)`` by random numbers ``(2, q, d)`` and ``(q, d)``, in place."""
        place, scale, weights, half_shift = linear
        (n, q, draws), dtype = theta.shape, place.dtype
        enter, leave, bias = (self.arrays[f"inference.{k}"] for k in ("enter", "leave", "bias"))
        # What an output sees of each one before it, residual and atom, side by side; halved.
        halves = 0.5 * enter.reshape(q, 2, q, -1).transpose(0, 3, 2, 1).reshape(q, -1, 2 * q)
        seen, sums = np.zeros((n, 2 * q, draws), dtype), np.tri(self.components, dtype=dtype)
        rows, columns = np.arange(n)[:, None], np.arange(draws)
        for i in np.flatnonzero(there):
            half = halves[i, :, : 2 * i] @ seen[:, : 2 * i]
            half += half_shift[:, i]
            hidden = _silu_of_half(half)
            numbers = leave[i].T @ hidden + bias[i, :, None]
            logits = numbers[:, : self.components]
            share = sums @ np.exp(logits - logits.max(axis=1, keepdims=True))
            chosen = (share < uniform[0, i] * share[:, -1:]).sum(axis=1)
            mean, width = (numbers[rows, k * self.components + chosen, columns] for k in (1, 2))
            residual = mean + np.exp(width.clip(-_WIDEST, _WIDEST)) * normal[i]
            free = uniform[1, i] >= _logistic(numbers[:, -1]) if self.atoms[i] else True
            value = place[:, i] + (weights[:, i, :, :i] @ theta[:, :i])[:, 0]
            theta[:, i] = np.where(free, value + scale[:, i] * residual, 0.0)
            seen[:, 2 * i] = np.where(free, residual.clip(-_CLIP, _CLIP), 0.0)
            seen[:, 2 * i + 1] = np.logical_not(free)


def _silu(x: np.ndarray) -> np.ndarray:
    return _silu_of_half(0.5 * x)


def _silu_of_half(half: np.ndarray) -> np.ndarray:
    """Of a half of x, which takes the fewest passes: ``x / (1 + e^-x)``."""
    y = np.tanh(half)  # without overflow
    y += 1.0
    y *= half
    return y


def _logistic(x: np.ndarray) -> np.ndarray:
    y = np.tanh(0.5 * x)  # without overflow
    y *= 0.5
    y += 0.5
    return y


_LARGEST = 100.0  # logarithms of sizes, and times over durations, by far more than of any drive
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
class StateDraws:
    """Draws of the state of a drive.

    Attributes:
        theta: Parameters, ``(d, p)``, physical units.
        release: Of each motion that is there, ``(d,)``, ms after 10 % of its way.
        switching: The same of touch or separation of the drive's own contact.
        effects: Size of each of ``EFFECTS``, ``(d,)``; exactly 0 where it is absent.
    """

    theta: np.ndarray
    release: Mapping[str, np.ndarray]
    switching: Mapping[str, np.ndarray]
    effects: Mapping[str, np.ndarray] = field(default_factory=dict)

    def of(self, chosen: np.ndarray) -> "StateDraws":
        """Return some of the draws, by their numbers ``(k,)``."""
        named = (
            {name: each[chosen] for name, each in by.items()}
            for by in (self.release, self.switching, self.effects)
        )
        return StateDraws(self.theta[chosen], *named)

    def joined(self, more: "StateDraws") -> "StateDraws":
        """Return these draws and others of the same posterior."""
        named = (
            {name: np.append(each, getattr(more, of)[name]) for name, each in by.items()}
            for of, by in vars(self).items()
            if of != "theta"
        )
        return StateDraws(np.concatenate([self.theta, more.theta]), *named)


@dataclass(frozen=True, eq=False)
class StateNetwork:
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
        np.repeat([False, True], [len(NAMES) + len(EVENTS), len(EFFECTS)]).tolist()
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
    ) -> StateDraws:
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
        x = state_inputs(at_one, told, self.bases, self.usual)
        there = outputs_there([m in records for m in MOTIONS])
        found = self.network.sample(self.network.features(x), there, draws, rng)[0]
        y = self.centre + self.scale * found
        beyond = ~(np.abs(y) < _LARGEST).all(axis=1)
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
        effects = effect_draws(sizes, EFFECTS, float(first.duration[0]))
        theta = np.exp(y[:, : len(NAMES)]) * scale.factors
        return StateDraws(theta, release, switching, effects)

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
        np.ones((*motions.shape[:-1], n), dtype=bool) for n in (len(NAMES), len(EFFECTS))
    )
    return np.concatenate([known, np.repeat(motions, 2, axis=-1), more], axis=-1)


def state_outputs(
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


LEAST_AGREEMENT = 0.01
"""Agreement of a parameter below which closing and opening contradict each other."""

_SURE = 0.95  # share of draws
_LARGEST_WEAR = np.log(2.0)  # of the logarithm of a parameter; no wear of a family is half as large


@dataclass(frozen=True)
class ChangeDraws:
    """Draws of a change.

    Attributes:
        ratios: Parameters over what they were, ``(d, p)``; 1 where they have not changed.
        later: By how much touch or separation of each motion at hand comes later after the release,
            ``(d,)``, ms.
        effects: By how much the size of each of ``WEARING`` has changed, ``(d,)``; that of
            ``build_up`` as a share of the duration.
    """

    ratios: np.ndarray
    later: Mapping[str, np.ndarray]
    effects: Mapping[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ChangeNetwork:
    """A trained network of changes; attributes as of ``StateNetwork``."""

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
        y = self.draws(references, changes, draws, rng, effects=True)[0]
        later = {
            m: float(references[m].duration[0]) * y[:, len(NAMES) + MOTIONS.index(m)]
            for m in motions
        }
        effects = effect_draws(y[:, len(NAMES) + len(MOTIONS) :], WEARING, 1.0)
        return ChangeDraws(np.exp(y[:, : len(NAMES)]), later, effects)

    def draws(
        self,
        references: Mapping[str, NormalisedRecords],
        changes: Mapping[str, NormalisedRecords],
        draws: int,
        rng: np.random.Generator,
        *,
        effects: bool = False,
    ) -> np.ndarray:
        """Draw from the posteriors of several changes, the same random numbers for each.

        Returns:
            Logarithms of the parameters over what they were, by how much touch and separation come
            later, in durations, and outputs of the effects that wear, ``(n, d, q)``; these are 0
            unless ``effects``.
        """
        n = len(next(iter(references.values())).way)
        known, changed = (
            {m: each.get(m, NormalisedRecords.nothing(n)) for m in MOTIONS}
            for each in (references, changes)
        )
        x = change_inputs(known, changed, self.bases, self.change_bases, self.usual)
        told = [m in references for m in MOTIONS]
        there = np.array([True] * len(NAMES) + told + [effects] * len(WEARING))
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
    return ((np.abs(draws) < _LARGEST_WEAR).mean(axis=-2) > _SURE).all(axis=-1)


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
