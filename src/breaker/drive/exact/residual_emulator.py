"""What a small network has learned of simulated residuals: a stand-in for the simulator nearby.

The residuals of a drive are those of its records in units of their noise, so that the log
likelihood is half of their square. A network of two hidden layers adds to a linear fit; what it
says is a proposal, which the simulator judges.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

_FINEST = 0.003  # variance of a component of residuals, below which it stays as it is
_RIDGE = 1e-6
_SOLVED = 20_000  # drives, of which the linear parts are solved
_HIDDEN = (128, 128)
_BATCH, _RATE, _WARMING = 256, 12e-3, 0.1
_MOMENTS = (0.9, 0.99)  # of Adam
_NEAR = 20.0  # nats below the middle, at which a drive counts half


@dataclass(eq=False)
class ResidualEmulator:
    """Log likelihoods of drives, and their slopes.

    Attributes:
        used: Which numbers of a drive are inputs, ``(q,)``.
        centre, scale: Of the inputs.
        ends: Least and largest of those that it has learned from, ``(2, i)``: beyond them it tells
            what it tells there.
        linear: Coefficients, ``(i, k)``.
        layers: Weights and offsets of the layers, float32.
        rest: Square of the residuals beyond the components.
    """

    used: np.ndarray
    centre: np.ndarray
    scale: np.ndarray
    ends: np.ndarray
    linear: np.ndarray
    layers: list[np.ndarray]
    rest: float

    @classmethod
    def fit(
        cls,
        numbers: np.ndarray,
        residuals: np.ndarray,
        power: float,
        steps: int,
        rng: np.random.Generator,
        before: "ResidualEmulator | None" = None,
    ) -> "ResidualEmulator":
        """Learn from simulated drives.

        Args:
            numbers: Of drives, ``(n, q)``.
            residuals: Of their curves, in units of the noise, ``(n, r)``, finite.
            power: Of the likelihood: the smaller, the farther off drives count.
            steps: Of the training.
            before: An emulator of the same records, from whose hidden layers this one starts.
        """
        below = 0.5 * np.einsum("nr,nr->n", residuals, residuals, dtype=np.float64)
        weights = 1.0 / (1.0 + power * np.maximum(below - np.median(below), 0.0) / _NEAR)
        new = cls._of_inputs(numbers, before)
        inputs = new.inputs(numbers).astype(np.float32)
        layers, axes = new._begun(inputs, residuals, weights, power, rng, before)
        wanted = residuals @ axes - inputs @ new.linear
        shares = weights / weights.mean()
        size = np.float32(np.sqrt(shares @ np.square(wanted).mean(axis=1) / len(shares)) + 1e-12)
        wanted /= size
        layers[-2] /= size
        layers[-1] /= size
        new.layers = _trained(layers, inputs, wanted, shares.astype(np.float32), steps, rng)
        new.layers[-2] *= size
        new.layers[-1] *= size
        return new

    def _begun(self, inputs, residuals, weights, power, rng, before):
        """Layers to begin with, and the axes of residuals: by some of the drives, which tell what
        is linear as well as all.
        """
        some = slice(None, None, 1 + len(inputs) // _SOLVED)
        inputs, residuals, weights = inputs[some], residuals[some], weights[some]
        weights = (weights / weights.sum())[:, None]
        hidden = self._hidden_of(before, rng)
        middle = (weights * residuals).sum(axis=0, dtype=np.float64).astype(np.float32)
        off = residuals - middle
        variances, axes = np.linalg.eigh((off * np.sqrt(weights)).T @ (off * np.sqrt(weights)))
        axes = axes[:, variances > _FINEST / power].astype(np.float32)
        there = middle @ axes
        self.rest = float(middle @ middle - there @ there)
        told = np.column_stack([inputs, _forward(hidden, inputs)[0], np.ones(len(inputs))])
        square = (told * weights).T @ told
        square += _RIDGE * np.eye(len(square))
        solved = np.linalg.solve(square, (told * weights).T @ (residuals @ axes))
        self.linear, *last = np.split(solved.astype(np.float32), [inputs.shape[1], len(solved) - 1])
        return [*hidden, last[0], last[1][0]], axes

    @classmethod
    def _of_inputs(cls, numbers, before) -> "ResidualEmulator":
        """One with the inputs of drives ``(n, q)``, of which it has learned nothing."""
        sd = numbers.std(axis=0)
        varies = sd > 1e-9 * np.abs(numbers).mean(axis=0) + 1e-12
        used = varies if before is None else before.used
        own = numbers[:, used]
        new = cls(used, own.mean(axis=0), own.std(axis=0) + 1e-9, *[np.empty(0)] * 2, [], 0.0)
        inputs = new.inputs(numbers)
        new.ends = np.stack([inputs.min(axis=0), inputs.max(axis=0)])
        return new

    def _hidden_of(self, before, rng) -> list[np.ndarray]:
        """Hidden layers: drawn, or those of an emulator before, for the inputs of this one."""
        if before is not None:
            first, offset, *others = (each.copy() for each in before.layers[:-2])
            offset += ((self.centre - before.centre) / before.scale) @ first
            first *= (self.scale / before.scale)[:, None]
            return [each.astype(np.float32) for each in (first, offset, *others)]
        layers = []
        for one, two in pairwise([self.centre.size, *_HIDDEN]):
            weights = rng.standard_normal((one, two)) / np.sqrt(one)
            layers += [weights.astype(np.float32), np.zeros(two, dtype=np.float32)]
        return layers

    def inputs(self, numbers: np.ndarray) -> np.ndarray:
        """Inputs of drives ``(n, q)``, ``(n, i)``."""
        return (numbers[:, self.used] - self.centre) / self.scale

    def log_likelihood(self, numbers: np.ndarray) -> np.ndarray:
        """Log likelihoods of drives ``(n, q)``, ``(n,)``."""
        return self._told(np.clip(self.inputs(numbers), *self.ends).astype(np.float32))[0]

    def slopes(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Log likelihoods of drives ``(n, q)``, ``(n,)``, and their slopes, ``(n, q)``."""
        inputs = self.inputs(numbers)
        within = np.clip(inputs, *self.ends)
        log, told, kept = self._told(within.astype(np.float32))
        slope = _backward(self.layers, kept, -told)[0] - told @ self.linear.T
        found = np.zeros(numbers.shape)
        found[:, self.used] = np.where(inputs == within, slope, 0.0) / self.scale
        return log, found

    def _told(self, inputs: np.ndarray):
        by_network, kept = _forward(self.layers, inputs)
        told = inputs @ self.linear + by_network
        square = np.einsum("nk,nk->n", told, told, dtype=np.float64)
        return -0.5 * (square + self.rest), told, kept


def _trained(layers, inputs, wanted, shares, steps, rng) -> list[np.ndarray]:
    """Layers trained further by Adam, with a rate that rises, and falls as a cosine."""
    first, second = ([np.zeros_like(each) for each in layers] for _ in range(2))
    for step in range(1, steps + 1):
        way = step / steps
        cosine = 0.5 * (1.0 + np.cos(np.pi * max(0.0, (way - _WARMING) / (1.0 - _WARMING))))
        rate = _RATE * min(1.0, way / _WARMING) * cosine
        chosen = rng.integers(0, len(inputs), _BATCH)
        told, kept = _forward(layers, inputs[chosen])
        told -= wanted[chosen]
        told *= shares[chosen, None] * np.float32(2.0 / _BATCH)
        _, slopes = _backward(layers, kept, told, weights=True)
        for each, by, one, two in zip(layers, slopes, first, second, strict=True):
            one *= _MOMENTS[0]
            one += (1.0 - _MOMENTS[0]) * by
            two *= _MOMENTS[1]
            by *= by
            by *= 1.0 - _MOMENTS[1]
            two += by
            size = np.sqrt(two / (1.0 - _MOMENTS[1] ** step))
            size += 1e-8
            np.divide(one, size, out=size)
            size *= rate / (1.0 - _MOMENTS[0] ** step)
            each -= size
    return layers


def _forward(layers, inputs):
    """What layers tell of inputs ``(n, i)``, and what the way back needs.

    The layer behind the hidden ones is linear. Hidden ones alone tell what the last of them does.
    """
    kept, there = [], inputs
    for weights, offset in zip(layers[:-2:2], layers[1:-2:2], strict=True):
        there = _bent(there, weights, offset, kept)
    if len(layers) == 2 * len(_HIDDEN):
        return _bent(there, *layers[-2:], kept), kept
    kept.append((there, None, None))
    return there @ layers[-2] + layers[-1], kept


def _bent(there, weights, offset, kept):
    """A hidden layer, whose function is x / (1 + exp(-x))."""
    found = there @ weights
    found += offset
    share = np.negative(found)
    with np.errstate(over="ignore"):  # of which the share is 0
        np.exp(share, out=share)
    share += 1.0
    np.reciprocal(share, out=share)
    found *= share
    kept.append((there, share, found))
    return found


def _backward(layers, kept, slope, weights=False):
    """Slopes by the inputs, ``(n, i)``, and with ``weights`` by those of the layers."""
    found = []
    for k in range(len(layers) - 2, -1, -2):
        there, share, bent = kept[k // 2]
        if share is not None:
            bend = 1.0 - share
            bend *= bent
            bend += share
            slope *= bend
        if weights:
            found = [there.T @ slope, slope.sum(axis=0), *found]
        slope = slope @ layers[k].T if k or not weights else slope
    return slope, found
