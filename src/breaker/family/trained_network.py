"""Trained networks read as arrays: features of an input, and draws given these. Needs no torch.

The same numbers as ``blocks.ResidualMLP`` and ``mixture.AutoregressiveMixture`` give, as a test
shows.
"""

from collections.abc import Mapping, Sequence

import numpy as np

_CLIP, _WIDEST = 5.0, 7.0  # as of ``AutoregressiveMixture``
_AT_ONCE = 2_000  # draws whose arrays stay in a processor's cache


class Network:
    """Residual network and autoregressive mixture on top of it.

    Args:
        arrays: Weights by their names in ``network_training.FamilyNetwork``.
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
