r"""Autoregressive mixtures: joint densities, dimension by dimension, with or without atoms.

Each dimension is a mixture of Gaussians given the features and the earlier dimensions (Uria,
Murray & Larochelle, 2013, "RNADE: the real-valued neural autoregressive density-estimator"):

``theta_i = a_i(s) + sum_{j < i} w_ij(s) theta_j + e^{b_i(s)} r_i``,

where the residual ``r_i`` is a mixture whose weights, means and widths a small network computes
from the features s and the earlier residuals. Linear and Gaussian dependence needs no hidden layer.
With atoms, a dimension may also be exactly 0, with its own probability. Dimensions that a condition
does not have are left out. The reader of the weights (``networks.Network``) draws from the density.
"""

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from breaker.networks import CLIP, WIDEST


class AutoregressiveMixture(nn.Module):
    """Conditional density ``q(theta | s)``.

    Args:
        dims: Number q of dimensions of theta.
        features: Number s of features of the condition.
        components: Number of Gaussians of a mixture.
        width: Width of the network of a dimension.
        atoms: Dimensions that may be exactly 0, ``(q,)`` of bool; none if empty.
    """

    def __init__(
        self,
        dims: int,
        features: int,
        *,
        components: int,
        width: int,
        atoms: Sequence[bool] = (),
    ) -> None:
        super().__init__()
        self.dims, self.components = dims, components
        self.head = nn.Linear(features, 2 * dims + dims * (dims - 1) // 2)
        self.project = nn.Linear(features, dims * width)
        seen = 2 * dims  # residuals, and which of them are atoms
        self.enter = nn.Parameter(torch.randn(dims, seen, width) / math.sqrt(seen))
        self.leave = nn.Parameter(torch.zeros(dims, width, 3 * components + 1))
        start = torch.zeros(dims, 3 * components + 1)
        start[:, components : 2 * components] = torch.linspace(-1.0, 1.0, components)
        self.bias = nn.Parameter(start)
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)
        earlier = torch.ones(dims, dims).tril(-1).repeat(1, 2)
        self.register_buffer("earlier", earlier, persistent=False)
        self.register_buffer("atoms", torch.tensor(atoms or (False,) * dims), persistent=False)

    def log_prob(self, theta: Tensor, features: Tensor, there: Tensor) -> Tensor:
        """Return the log density of each dimension given the earlier ones, ``(n, q)``.

        Args:
            theta: Data, ``(n, q)``; an exact 0 in a dimension of ``atoms`` is an atom.
            features: Condition, ``(n, s)``.
            there: Dimensions that count, ``(n, q)`` of 0 and 1; the result is 0 for others.
        """
        n, q = theta.shape
        place, scale, weights = self._linear(features)
        theta = theta * there
        residual = (theta - place - (weights @ theta.unsqueeze(-1)).squeeze(-1)) * torch.exp(-scale)
        atom = (self.atoms & (theta == 0.0)).to(theta.dtype)
        free = there * (1.0 - atom)
        seen = torch.cat([residual.clamp(-CLIP, CLIP) * free, atom * there], dim=1)
        shift = self.project(features).reshape(n, q, -1)
        hidden = torch.einsum("nj,ij,ijw->niw", seen, self.earlier, self.enter) + shift
        numbers = torch.einsum("niw,iwk->nik", nn.functional.silu(hidden), self.leave) + self.bias
        logits, means, widths = numbers[..., :-1].chunk(3, dim=-1)
        widths = widths.clamp(-WIDEST, WIDEST)
        normal = -0.5 * ((residual.unsqueeze(-1) - means) * torch.exp(-widths)).square()
        normal = normal - widths - 0.5 * math.log(2.0 * math.pi)
        density = torch.logsumexp(torch.log_softmax(logits, dim=-1) + normal, dim=-1) - scale
        odds = numbers[..., -1]
        with_atoms = torch.where(
            atom > 0.0,
            nn.functional.logsigmoid(odds),
            nn.functional.logsigmoid(-odds) + density,
        )
        return torch.where(self.atoms, with_atoms, density) * there

    def _linear(self, features: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return places and log scales ``(n, q)``, and lower-triangular weights ``(n, q, q)``."""
        n, q = len(features), self.dims
        place, scale, below = self.head(features).split([q, q, q * (q - 1) // 2], dim=1)
        weights = torch.zeros((n, q, q), dtype=features.dtype, device=features.device)
        rows, columns = torch.tril_indices(q, q, offset=-1, device=features.device)
        weights[:, rows, columns] = below
        return place, scale.clamp(-WIDEST, WIDEST), weights
