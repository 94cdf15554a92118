"""The networks of a family as arrays: the state of a drive, and its changes. Needs no torch.

They see shapes, and estimate in the units of stroke and duration of the first motion. So the
estimate follows the size of the drive exactly.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from breaker.common.tensor_file import ModelFileError, open_model
from breaker.family.inputs import Basis, NormalisedRecords, change_inputs, state_inputs
from breaker.family.membership import Match, Membership
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size
from breaker.model.prior import Prior
from breaker.networks import CLIP, WIDEST
from breaker.shipped import FAMILIES, KINDS, model_file, widening

EVENTS = tuple(f"{event} {motion}" for motion in MOTIONS for event in ("release", "switching"))
"""Outputs of a state network: start of each motion, and contact touch or separation."""

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
"""Additional effects by name: what the size of each is, as outputs of a state network.

Forces that depend on the speed count at the mean speed of a closing from 10 to 50 % of its travel.
``build_up`` is in ms. What is absent is exactly 0.
"""

# Effects that wear: outputs of a change network.
WEARING = tuple(name for name in EFFECTS if name not in ("sliding_contact", "train_mass"))
SURE = 0.95  # probability, or share of draws, from which a change, its cause or size is stated
LEAST_AGREEMENT = 0.01  # of a parameter, below which closing and opening contradict each other

_AT_ONCE = 8_000  # draws: half a million at once would take some GB
_LARGEST = 100.0  # logarithms of sizes, and times over durations, by far more than of any drive
# Share of the variance added by factors of widening that outputs do not have in common. Errors for
# drives of an independent simulator are not along the posterior. By 0, a recorded contact narrows L
# too much: 76 % of 95 % intervals contain it for drives with all effects, and 89 % by this share.
_APART = 0.25
_BEYOND = 1e-3  # share of draws beyond these; the tails of a sound network reach there in 1e-6
_LARGEST_WEAR = np.log(2.0)  # of the logarithm of a parameter; wear of a family is below half of it


class Network:
    """Residual network with an autoregressive mixture: features of an input, and draws given these.

    Same numbers as ``blocks.ResidualMLP`` and ``mixture.AutoregressiveMixture``, as a test shows,
    of weights by their names in ``training.FamilyNetwork``. Outputs with ``atoms`` may be 0.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], atoms: Sequence[bool]) -> None:
        self.arrays = arrays
        self.blocks = sum(name.startswith("summary.inner.") for name in arrays) // 2
        self.dims, _, outputs = arrays["inference.leave"].shape
        self.components = (outputs - 1) // 3
        self.atoms = tuple(atoms)

    def features(self, x: np.ndarray) -> np.ndarray:
        """Map inputs ``(n, i)`` to features ``(n, s)``."""
        h = self._layer("enter", x)
        for k in range(self.blocks):
            inner = self._layer(f"inner.{k}", _silu_of_half(0.5 * h))
            h = h + self._layer(f"outer.{k}", _silu_of_half(0.5 * inner))
        return self._layer("leave", _silu_of_half(0.5 * h))

    def _layer(self, name: str, x: np.ndarray, part: str = "summary") -> np.ndarray:
        weight, bias = (self.arrays[f"{part}.{name}.{kind}"] for kind in ("weight", "bias"))
        return x @ weight.T + bias

    def sample(
        self, features: np.ndarray, there: np.ndarray, draws: int, rng: np.random.Generator
    ) -> np.ndarray:
        """Draw outputs ``(n, d, q)`` by features ``(n, s)``, by the same random numbers for each; 0
        where the inputs do not determine an output, as ``there`` tells, ``(q,)`` of bool.
        """
        n, q = len(features), self.dims
        head = self._layer("head", features, "inference")
        place, scale, below = np.split(head, [q, 2 * q], axis=1)
        weights = np.zeros((n, q, q), dtype=head.dtype)
        weights[:, *np.tril_indices(q, -1)] = below
        scale = np.exp(np.clip(scale, -WIDEST, WIDEST))
        shift = self._layer("project", features, "inference").reshape(n, q, -1, 1)
        # What is linear in an output: place, scale, weights of the outputs before, half the shift.
        linear = place[..., None], scale[..., None], weights[:, :, None], 0.5 * shift
        uniform, normal = rng.random((draws, q, 2)), rng.standard_normal((draws, q))
        parts = [slice(k, k + _AT_ONCE) for k in range(0, draws, _AT_ONCE)]
        parts_drawn = [self._some(linear, there, uniform[few].T, normal[few].T) for few in parts]
        return np.concatenate(parts_drawn, axis=2).transpose(0, 2, 1)

    def _some(self, linear, there, uniform, normal):
        """Return outputs ``(n, q, d)`` by random numbers ``(2, q, d)`` and ``(q, d)``."""
        place, scale, weights, half_shift = linear
        (n, q), draws, dtype = place.shape[:2], normal.shape[1], place.dtype
        enter, leave, bias = (self.arrays[f"inference.{k}"] for k in ("enter", "leave", "bias"))
        # Residual and atom of each output before, which an output sees side by side; halved.
        halves = 0.5 * enter.reshape(q, 2, q, -1).transpose(0, 3, 2, 1).reshape(q, -1, 2 * q)
        theta, seen = np.zeros((n, q, draws)), np.zeros((n, 2 * q, draws), dtype)
        sums, rows, columns = np.tri(self.components, dtype=dtype), *np.ogrid[:n, :draws]
        for i in np.flatnonzero(there):
            half = halves[i, :, : 2 * i] @ seen[:, : 2 * i]
            half += half_shift[:, i]
            numbers = leave[i].T @ _silu_of_half(half) + bias[i, :, None]
            logits = numbers[:, : self.components]
            share = sums @ np.exp(logits - logits.max(axis=1, keepdims=True))
            chosen = (share < uniform[0, i] * share[:, -1:]).sum(axis=1)
            mean, width = (numbers[rows, k * self.components + chosen, columns] for k in (1, 2))
            residual = mean + np.exp(width.clip(-WIDEST, WIDEST)) * normal[i]
            absent = 0.5 * np.tanh(0.5 * numbers[:, -1]) + 0.5  # probability of the atom
            free = uniform[1, i] >= absent if self.atoms[i] else True
            value = place[:, i] + (weights[:, i, :, :i] @ theta[:, :i])[:, 0]
            theta[:, i] = np.where(free, value + scale[:, i] * residual, 0.0)
            seen[:, 2 * i] = np.where(free, residual.clip(-CLIP, CLIP), 0.0)
            seen[:, 2 * i + 1] = np.logical_not(free)
        return theta


def _silu_of_half(half: np.ndarray) -> np.ndarray:
    """Of a half of x, which takes the fewest passes: ``x / (1 + e^-x)``."""
    y = np.tanh(half)  # without overflow
    y += 1.0
    y *= half
    return y


@dataclass(frozen=True, eq=False)
class TrainedNetwork:
    """A network, and in what scales it sees and estimates.

    Attributes:
        outputs, atoms: Of its class: names of outputs, and which of them may be exactly 0.
        settings: How it was made; ``family``, its name, and ``prior`` among them.
        network: Its weights.
        bases: Components of the shapes of each motion.
        usual: Mean and sd of the logarithms of stroke and duration, ``(2, 2)``.
        centre, scale: Of the outputs, ``(q,)``.
    """

    settings: Mapping
    network: Network
    bases: Mapping[str, Basis]
    usual: np.ndarray
    centre: np.ndarray
    scale: np.ndarray

    @classmethod
    def there(cls, motions: np.ndarray) -> np.ndarray:
        """Return which outputs records of motions ``(n, m)`` determine, ``(n, q)`` of bool."""
        of, some = dict(zip(MOTIONS, motions.T, strict=True)), motions.any(axis=1)
        return np.column_stack([of.get(name.split()[-1], some) for name in cls.outputs])

    def sample(
        self, features: np.ndarray, there: np.ndarray, draws: int, rng: np.random.Generator
    ) -> np.ndarray:
        """Return ``Network.sample`` in the units of what is estimated."""
        return self.centre + self.scale * self.network.sample(features, there, draws, rng)


@dataclass(frozen=True)
class StateDraws:
    """Posterior draws of the state of a drive.

    Attributes:
        theta: Parameters, ``(d, p)``, physical units.
        release: Of each motion that is there, ``(d,)``, ms after 10 % of its travel.
        switching: The same of touch or separation of the drive's own contact.
        effects: Size of each of ``EFFECTS``, ``(d,)``.
    """

    theta: np.ndarray
    release: Mapping[str, np.ndarray]
    switching: Mapping[str, np.ndarray]
    effects: Mapping[str, np.ndarray] = field(default_factory=dict)

    def of(self, chosen: np.ndarray) -> "StateDraws":
        """Return some of the draws, by their numbers ``(k,)``."""
        named = (
            {name: values[chosen] for name, values in by.items()}
            for by in (self.release, self.switching, self.effects)
        )
        return StateDraws(self.theta[chosen], *named)


@dataclass(frozen=True, eq=False)
class StateNetwork(TrainedNetwork):
    """A trained network that estimates the state of a drive from records of one operation.

    It has the distances of drives of the family, by motion, and factors on the distances of draws
    from their median, ``(p + 4,)``, by the number of motions at hand: 1 where none is given.
    """

    kind, outputs = "levels", (*NAMES, *EVENTS, *EFFECTS)
    atoms = tuple(name in EFFECTS for name in outputs)

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
        """Draw from the posterior of one operation, with a record of each motion at hand, physical
        units, and the size of the drive relative to the family's, if it is known.

        Raises:
            ModelFileError: If many draws are not finite, or beyond all drives.
        """
        motions = [motion for motion in MOTIONS if motion in records]
        unit = size or UNIT
        seen = {
            m: one._replace(stroke=one.stroke / unit.lengths, duration=one.duration / unit.times)
            for m, one in records.items()
        }
        x = state_inputs(seen, np.array([size is not None]), self.bases, self.usual)
        there = self.there(np.array([[m in records for m in MOTIONS]]))[0]
        y = self.sample(self.network.features(x), there, draws, rng)[0]
        sound = (np.abs(y) < _LARGEST).all(axis=1)
        beyond = np.count_nonzero(~sound)
        if beyond == draws or beyond > 1 + _BEYOND * draws:
            remedy = "check the given size" if size else "train it again"
            raise ModelFileError(f"a network estimates sizes that no drive has: {remedy}")
        y[~sound] = y[sound][:beyond]
        if (factors := self.widening.get(len(motions))) is not None:
            y[:, : len(factors)] = _widened(y[:, : len(factors)], factors, rng)
        logs, events, effects = np.split(y, [len(NAMES), len(NAMES) + len(EVENTS)], axis=1)
        events = dict(zip(EVENTS, events.T, strict=True))
        release, switching = (
            {m: float(records[m].duration[0]) * events[f"{event} {m}"] for m in motions}
            for event in ("release", "switching")
        )
        first = records[motions[0]]
        stroke, duration = float(first.stroke[0]), float(first.duration[0])
        theta = np.exp(logs) * Size(stroke, duration).factors
        return StateDraws(theta, release, switching, effect_draws(effects, EFFECTS, duration))

    def match(self, motion: str, record: NormalisedRecords) -> Match:
        """Compare one record with the drives of the family."""
        return self.members[motion].match(record, self.bases[motion])


def _widened(y: np.ndarray, factors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return draws ``(d, k)`` with factors ``(k,)`` times their sds, about their medians."""
    apart, added = y - np.median(y, axis=0), np.square(factors) - 1.0
    own = np.sqrt(_APART * added) * rng.permuted(apart, axis=0)
    return y + (np.sqrt(1.0 + (1.0 - _APART) * added) - 1.0) * apart + own


def effect_outputs(sizes: Mapping[str, np.ndarray], duration: np.ndarray) -> np.ndarray:
    """Return what networks estimate of effects or their changes, ``(n,)`` by name, in units of a
    duration: about the size where that is small, and its logarithm where large.
    """
    units = {"build_up": duration}
    return np.arcsinh(np.column_stack([v / units.get(name, 1.0) for name, v in sizes.items()]))


def effect_draws(
    outputs: np.ndarray, names: Iterable[str], duration: float
) -> dict[str, np.ndarray]:
    """Return sizes of effects, or their changes, by name, of outputs ``(..., m)``."""
    units, values = {"build_up": duration}, np.moveaxis(outputs, -1, 0)
    return {n: units.get(n, 1.0) * np.sinh(v) for n, v in zip(names, values, strict=True)}


@dataclass(frozen=True, eq=False)
class ChangeNetwork(TrainedNetwork):
    """A trained network that estimates changes between two inspections.

    It sees the curves of the drive as they were and their change, by motion in components of
    ``change_bases``, and the noise of both. No change at all has a probability of its own.
    """

    kind, outputs = "changes", (*NAMES, *(f"later {motion}" for motion in MOTIONS), *WEARING)
    atoms = (True,) * len(outputs)

    change_bases: Mapping[str, Basis]

    def draw(
        self,
        references: Mapping[str, NormalisedRecords],
        changes: Mapping[str, NormalisedRecords],
        draws: int,
        rng: np.random.Generator,
        *,
        effects: bool = True,
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Draw from the posteriors of n changes, with effects or without, by the same random
        numbers for each.

        Args:
            references: Of each motion at hand, physical units.
            changes: Of the same motions, what ``without_onset`` leaves, in the units of the
                references; its noise is that of both.

        Returns:
            Logarithms of the parameters over what they were, ``(n, d, p)``, 0 where they have not
            changed; and by how much the size of each of ``WEARING`` has changed, ``(n, d)``, that
            of ``build_up`` as a share of the duration.
        """
        x = change_inputs(references, changes, self.bases, self.change_bases, self.usual)
        there = self.there(np.array([[m in references for m in MOTIONS]]))[0]
        there[len(NAMES) :] &= effects
        y = self.sample(self.network.features(x), there, draws, rng)
        return y[..., : len(NAMES)], effect_draws(y[..., -len(WEARING) :], WEARING, 1.0)


def plausible_wear(draws: np.ndarray) -> np.ndarray:
    """Return whether logarithms of parameters over what they were ``(..., d, p)`` may be of wear,
    ``(...)``: 95 % of each are below a factor of 2. No network knows of larger changes.
    """
    return ((np.abs(draws) < _LARGEST_WEAR).mean(axis=-2) > SURE).all(axis=-1)


def agreement_of(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the probability that draws ``(d, p)`` and others differ as much as they do, ``(p,)``:
    twice the share of pairs in which that of the larger draws is the smaller one.
    """
    agreement = np.empty(one.shape[1])
    for k, (a, b) in enumerate(zip(one.T, np.sort(other, axis=0).T, strict=True)):
        below = np.mean([np.searchsorted(b, a, side).mean() / len(b) for side in ("left", "right")])
        agreement[k] = 2.0 * min(below, 1.0 - below)
    return agreement


def open_network(path: str | Path) -> StateNetwork | ChangeNetwork:
    """Read a network, as ``open_model``; ``shipped.widening`` widens the draws of a state network.

    Raises:
        ModelFileError: If the file is not that of a network of a family.
    """
    with open_model(path) as saved:
        settings, arrays, weights = saved.settings, {}, {}
        of = {of.kind: of for of in (StateNetwork, ChangeNetwork)}.get(settings.get("kind"))
        if of is None:
            raise ModelFileError("it is not a network of a family of drives")
        for name in saved.arrays:
            own = name.removeprefix("network.")
            some, dtype = (arrays, "float64") if own == name else (weights, "float32")
            some[own] = saved.weight(name, dtype)
        Prior.from_settings(settings["prior"])  # raises if the prior is not valid
        own = ("members", Membership) if of is StateNetwork else ("change_bases", Basis)
        parts = {name: arrays[name] for name in ("usual", "centre", "scale")}
        for name, part in (("bases", Basis), own):
            paths = {m: [f"{name}.{m}.{field}" for field in part._fields] for m in MOTIONS}
            parts[name] = {m: part(*map(arrays.__getitem__, keys)) for m, keys in paths.items()}
        if of is StateNetwork:
            parts["widening"] = {
                count: np.array([factors.get(name, 1.0) for name in (*NAMES, *EVENTS)])
                for count, factors in widening(settings["family"]).items()
            }
        return of(settings=settings, network=Network(weights, of.atoms), **parts)


def shipped_networks(*kinds: str) -> Iterator[tuple[StateNetwork | ChangeNetwork, ...]]:
    """Yield the networks of each shipped family, of some kinds or all, opened as needed."""
    for family in FAMILIES:
        yield tuple(_shipped(family, kind) for kind in kinds or KINDS)


def shipped_levels() -> Iterator[StateNetwork]:
    """Yield the shipped state networks, in the order in which families are tried."""
    return (state for (state,) in shipped_networks("levels"))


@cache
def _shipped(family: str, kind: str) -> StateNetwork | ChangeNetwork:
    return open_network(model_file(family, kind))
