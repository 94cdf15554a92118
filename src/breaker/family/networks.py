"""The networks of a family as arrays: the state of a drive, and its changes. Needs no torch.

Inputs are shapes, and outputs are in units of stroke and duration of the first motion. So estimates
scale exactly with the size of the drive.
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
"""Meaning of the size of each additional effect, by name, in the order of outputs of networks.

Forces that depend on the speed are given at the mean speed of a closing from 10 to 50 % of its
travel. ``build_up`` is in ms. The size of an absent effect is exactly 0.
"""

# Effects that wear: outputs of a change network.
WEARING = tuple(name for name in EFFECTS if name not in ("sliding_contact", "train_mass"))
SURE = 0.95  # probability, or share of draws, from which a change, its cause or size is reported
LEAST_AGREEMENT = 0.01  # p-value below which closing and opening contradict each other

_AT_ONCE = 8_000  # draws: half a million at once would take some GB
_LARGEST = 100.0  # output, a log size or a time over a duration, far beyond that of any drive
# Share of the variance added by widening that is independent between outputs: errors for drives of
# an independent simulator are not along the posterior. With 0, a recorded contact narrows L too
# much: 76 % of 95 % intervals contain it for drives with all effects; with this share 89 %.
_INDEPENDENT = 0.25
_BEYOND = 1e-3  # share of draws beyond _LARGEST that is tolerated; sound networks have 1e-6
_LARGEST_WEAR = np.log(2.0)  # change of a log parameter; families wear by less than half of it


class Network:
    """Residual network with an autoregressive mixture: features of an input, and draws given these.

    A test compares results with ``blocks.ResidualMLP`` and ``mixture.AutoregressiveMixture``.
    Weights are named as in ``training.FamilyNetwork``. Outputs with ``atoms`` may be 0.
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
        """Draw outputs ``(n, d, q)`` given features ``(n, s)``, with the same random numbers for
        each row. Outputs that the inputs do not determine, not ``there (q,)``, are 0.
        """
        n, q = len(features), self.dims
        head = self._layer("head", features, "inference")
        place, scale, below = np.split(head, [q, 2 * q], axis=1)
        weights = np.zeros((n, q, q), dtype=head.dtype)
        weights[:, *np.tril_indices(q, -1)] = below
        scale = np.exp(np.clip(scale, -WIDEST, WIDEST))
        shift = self._layer("project", features, "inference").reshape(n, q, -1, 1)
        # Linear parts of outputs: place, scale, weights of previous outputs, half the shift.
        linear = place[..., None], scale[..., None], weights[:, :, None], 0.5 * shift
        uniform, normal = rng.random((draws, q, 2)), rng.standard_normal((draws, q))
        parts = [slice(k, k + _AT_ONCE) for k in range(0, draws, _AT_ONCE)]
        drawn = [self._outputs(linear, there, uniform[part].T, normal[part].T) for part in parts]
        return np.concatenate(drawn, axis=2).transpose(0, 2, 1)

    def _outputs(self, linear, there, uniform, normal):
        """Return outputs ``(n, q, d)`` from random numbers ``(2, q, d)`` and ``(q, d)``."""
        place, scale, weights, half_shift = linear
        (n, q), draws, dtype = place.shape[:2], normal.shape[1], place.dtype
        enter, leave, bias = (self.arrays[f"inference.{k}"] for k in ("enter", "leave", "bias"))
        # Weights on residual and atom of each previous output, side by side, halved.
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
    """Return ``x / (1 + e^-x)`` from half of x, with the fewest passes over the array."""
    y = np.tanh(half)  # without overflow
    y += 1.0
    y *= half
    return y


@dataclass(frozen=True, eq=False)
class TrainedNetwork:
    """A network, with the scales of its inputs and outputs.

    Attributes:
        outputs, atoms: Names of outputs, and which of them may be exactly 0; of the class.
        settings: Settings of its training, with ``prior`` and the name of the ``family``.
        network: The weights.
        bases: Components of the shapes of each motion.
        usual: Mean and sd of the logarithms of stroke and duration, ``(2, 2)``.
        centre, scale: Centres and scales of the outputs, ``(q,)``.
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
        by_motion, either = dict(zip(MOTIONS, motions.T, strict=True)), motions.any(axis=1)
        return np.column_stack([by_motion.get(name.split()[-1], either) for name in cls.outputs])

    def sample(
        self, features: np.ndarray, there: np.ndarray, draws: int, rng: np.random.Generator
    ) -> np.ndarray:
        """Return ``Network.sample`` in the units of the outputs."""
        return self.centre + self.scale * self.network.sample(features, there, draws, rng)


@dataclass(frozen=True)
class StateDraws:
    """Posterior draws of the state of a drive.

    Attributes:
        theta: Parameters, ``(d, p)``, physical units.
        release: Start of each recorded motion, ``(d,)``, ms after 10 % of its travel.
        switching: Touch or separation of the drive's own contact, likewise.
        effects: Size of each of ``EFFECTS``, ``(d,)``.
    """

    theta: np.ndarray
    release: Mapping[str, np.ndarray]
    switching: Mapping[str, np.ndarray]
    effects: Mapping[str, np.ndarray] = field(default_factory=dict)

    def of(self, chosen: np.ndarray) -> "StateDraws":
        """Return the draws with the indices ``chosen (k,)``."""
        named = (
            {name: values[chosen] for name, values in draws.items()}
            for draws in (self.release, self.switching, self.effects)
        )
        return StateDraws(self.theta[chosen], *named)


@dataclass(frozen=True, eq=False)
class StateNetwork(TrainedNetwork):
    """A trained network that estimates the state of a drive from records of one operation.

    ``members`` are distances of drives of the family, by motion. ``widening`` are factors on the
    sds of draws, ``(p + 4,)``, by the number of recorded motions; without factors they are 1.
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
        """Draw from the posterior of one operation, by a record of each recorded motion, physical
        units, and the size of the drive relative to the family, if it is known.

        Raises:
            ModelFileError: If many draws are not finite, or far beyond any drive.
        """
        motions = [motion for motion in MOTIONS if motion in records]
        unit = size or UNIT
        seen = {
            m: e._replace(stroke=e.stroke / unit.lengths, duration=e.duration / unit.times)
            for m, e in records.items()
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
    """Return draws ``(d, k)`` whose sds about their medians are multiplied by factors ``(k,)``."""
    off, added = y - np.median(y, axis=0), np.square(factors) - 1.0
    independent = np.sqrt(_INDEPENDENT * added) * rng.permuted(off, axis=0)
    return y + (np.sqrt(1.0 + (1.0 - _INDEPENDENT) * added) - 1.0) * off + independent


def effect_outputs(sizes: Mapping[str, np.ndarray], duration: np.ndarray) -> np.ndarray:
    """Return outputs of networks for sizes of effects or their changes, ``(n,)`` by name, in units
    of a duration: about linear in small sizes, and logarithmic in large ones.
    """
    units = {"build_up": duration}
    return np.arcsinh(np.column_stack([v / units.get(name, 1.0) for name, v in sizes.items()]))


def effect_draws(
    outputs: np.ndarray, names: Iterable[str], duration: float
) -> dict[str, np.ndarray]:
    """Return sizes of effects, or their changes, by name, from outputs ``(..., m)``."""
    units, values = {"build_up": duration}, np.moveaxis(outputs, -1, 0)
    return {n: units.get(n, 1.0) * np.sinh(v) for n, v in zip(names, values, strict=True)}


@dataclass(frozen=True, eq=False)
class ChangeNetwork(TrainedNetwork):
    """A trained network that estimates changes between two inspections.

    Inputs are the earlier curves of the drive and their change, by motion in components of
    ``change_bases``, and the noise of both. No change of an output has a probability of its own.
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
        """Draw from the posteriors of n changes, with or without effects, with the same random
        numbers for each change.

        Args:
            references: Earlier records of each recorded motion, physical units.
            changes: Changes of the same motions after ``without_onset``, in units of the
                references, with the noise of both.

        Returns:
            Logarithms of the parameters over their earlier values, ``(n, d, p)``, 0 without a
            change; and changes of the size of each of ``WEARING``, ``(n, d)``, of ``build_up`` as
            a share of the duration.
        """
        x = change_inputs(references, changes, self.bases, self.change_bases, self.usual)
        there = self.there(np.array([[m in references for m in MOTIONS]]))[0]
        there[len(NAMES) :] &= effects
        y = self.sample(self.network.features(x), there, draws, rng)
        return y[..., : len(NAMES)], effect_draws(y[..., -len(WEARING) :], WEARING, 1.0)


def plausible_wear(draws: np.ndarray) -> np.ndarray:
    """Return whether draws of log ratios of parameters ``(..., d, p)`` may be of wear, ``(...)``:
    95 % of each are below a factor of 2. No network was trained with larger changes.
    """
    return ((np.abs(draws) < _LARGEST_WEAR).mean(axis=-2) > SURE).all(axis=-1)


def agreement_of(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return p-values ``(p,)`` of the difference of two sets of draws ``(d, p)``: twice the share
    of pairs in which the draw from the set of larger draws is the smaller one.
    """
    agreement = np.empty(one.shape[1])
    for k, (a, b) in enumerate(zip(one.T, np.sort(other, axis=0).T, strict=True)):
        below = np.mean([np.searchsorted(b, a, side).mean() / len(b) for side in ("left", "right")])
        agreement[k] = 2.0 * min(below, 1.0 - below)
    return agreement


def open_network(path: str | Path) -> StateNetwork | ChangeNetwork:
    """Read a network, as ``open_model``; ``shipped.widening`` widens the draws of a state network.

    Raises:
        ModelFileError: If the file is not a network of a family.
    """
    with open_model(path) as saved:
        settings, arrays, weights = saved.settings, {}, {}
        kind = {cls.kind: cls for cls in (StateNetwork, ChangeNetwork)}.get(settings.get("kind"))
        if kind is None:
            raise ModelFileError("it is not a network of a family of drives")
        for name in saved.arrays:
            bare = name.removeprefix("network.")
            group, dtype = (arrays, "float64") if bare == name else (weights, "float32")
            group[bare] = saved.weight(name, dtype)
        Prior.from_settings(settings["prior"])  # raises if the prior is not valid
        more = ("members", Membership) if kind is StateNetwork else ("change_bases", Basis)
        parts = {name: arrays[name] for name in ("usual", "centre", "scale")}
        for name, part in (("bases", Basis), more):
            paths = {m: [f"{name}.{m}.{field}" for field in part._fields] for m in MOTIONS}
            parts[name] = {m: part(*map(arrays.__getitem__, keys)) for m, keys in paths.items()}
        if kind is StateNetwork:
            parts["widening"] = {
                count: np.array([factors.get(name, 1.0) for name in (*NAMES, *EVENTS)])
                for count, factors in widening(settings["family"]).items()
            }
        return kind(settings=settings, network=Network(weights, kind.atoms), **parts)


def shipped_networks() -> Iterator[tuple[StateNetwork, ChangeNetwork]]:
    """Yield the networks of each shipped family, opened as needed."""
    return (tuple(_shipped(family, kind) for kind in KINDS) for family in FAMILIES)


def shipped_levels() -> Iterator[StateNetwork]:
    """Yield the shipped state networks, in the order in which families are tried."""
    return (_shipped(family, StateNetwork.kind) for family in FAMILIES)


@cache
def _shipped(family: str, kind: str) -> StateNetwork | ChangeNetwork:
    return open_network(model_file(family, kind))
