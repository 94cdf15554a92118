"""Trained networks read as arrays: features of an input, and draws given these. Needs no torch.

The same numbers as ``networks.ResidualMLP`` and ``networks.AutoregressiveMixture`` give, which a
test holds: see there for what they compute.
"""

from collections.abc import Mapping, Sequence

import numpy as np

_CLIP, _WIDEST = 5.0, 7.0  # as of ``AutoregressiveMixture``


class Network:
    """Residual network and autoregressive mixture on top of it.

    Args:
        arrays: Weights by their names in ``posterior.FamilyNetwork``.
        atoms: Which outputs may be exactly 0, ``(q,)`` of bool; none if it is empty.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], atoms: Sequence[bool] = ()) -> None:
        self.arrays = arrays
        self.blocks = sum(name.startswith("summary.inner.") for name in arrays) // 2
        self.dims, self.width, outputs = arrays["inference.leave"].shape
        self.components = (outputs - 1) // 3
        self.atoms = tuple(atoms) or (False,) * self.dims

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
        shift = self._layer("project", features, "inference").reshape(n, q, -1)
        enter, leave, bias = (self.arrays[f"inference.{k}"] for k in ("enter", "leave", "bias"))
        theta, seen = np.zeros((n, draws, q)), np.zeros((n, draws, 2 * q), dtype=head.dtype)
        uniform, normal = rng.random((draws, q, 2)), rng.standard_normal((draws, q))
        for i in np.flatnonzero(there):
            earlier = np.r_[:i, q : q + i]
            hidden = _silu(seen[..., earlier] @ enter[i, earlier] + shift[:, None, i])
            numbers = hidden @ leave[i] + bias[i]
            logits, means, widths = np.split(numbers[..., :-1], 3, axis=-1)
            share = np.cumsum(np.exp(logits - logits.max(axis=-1, keepdims=True)), axis=-1)
            chosen = (share < uniform[:, i, :1] * share[..., -1:]).sum(axis=-1, keepdims=True)
            mean, width = (np.take_along_axis(e, chosen, axis=-1)[..., 0] for e in (means, widths))
            residual = mean + np.exp(np.clip(width, -_WIDEST, _WIDEST)) * normal[:, i]
            atom = np.zeros((n, draws), dtype=bool)
            if self.atoms[i]:
                atom = uniform[:, i, 1] < _logistic(numbers[..., -1])
            value = place[:, i, None] + np.einsum("ndq,nq->nd", theta, weights[:, i])
            value += scale[:, i, None] * residual
            theta[..., i] = np.where(atom, 0.0, value)
            seen[..., i] = np.where(atom, 0.0, np.clip(residual, -_CLIP, _CLIP))
            seen[..., q + i] = atom
        return theta


def _silu(x: np.ndarray) -> np.ndarray:
    return x * _logistic(x)


def _logistic(x: np.ndarray) -> np.ndarray:
    return 0.5 + 0.5 * np.tanh(0.5 * x)  # without overflow
