"""Pieces that several networks share."""

from typing import NamedTuple

import torch
from torch import Tensor, nn


class Hidden(nn.Linear):
    """Linear layer between two hidden layers, which ``training.optimisers`` finds by its class."""


class Edge(nn.Linear):
    """Linear layer into the first hidden layer or out of the last, found likewise."""


class ResidualMLP(nn.Module):
    """Linear layer in, residual blocks, linear layer out.

    A block adds ``W_2 silu(W_1 silu(h))`` to ``h``. Its last layer starts at zero, so that all
    blocks of a new network are the identity.

    Args:
        inputs, width, outputs: Sizes of the layers.
        blocks: Number of residual blocks.
    """

    def __init__(self, inputs: int, width: int, outputs: int, *, blocks: int) -> None:
        super().__init__()
        self.enter = Edge(inputs, width)
        self.inner = nn.ModuleList(Hidden(width, width) for _ in range(blocks))
        self.outer = nn.ModuleList(Hidden(width, width) for _ in range(blocks))
        self.leave = Edge(width, outputs)
        for layer in self.outer:
            nn.init.zeros_(layer.weight)
            nn.init.zeros_(layer.bias)

    def forward(self, x: Tensor) -> Tensor:
        """Map ``(..., inputs)`` to ``(..., outputs)``."""
        h = self.enter(x)
        for inner, outer in zip(self.inner, self.outer, strict=True):
            h = h + outer(nn.functional.silu(inner(nn.functional.silu(h))))
        return self.leave(nn.functional.silu(h))


class Gaussian(NamedTuple):
    """Gaussians for n conditions: ``y = P (theta - mean)`` is standard normal.

    Attributes:
        mean: Mean, ``(n, q)``.
        factor: Lower-triangular P, ``(n, q, q)``; ``P^T P`` is the precision.
        log_det: Log determinant of P, ``(n,)``.
    """

    mean: Tensor
    factor: Tensor
    log_det: Tensor

    def whiten(self, theta: Tensor) -> Tensor:
        """Map theta ``(n, d, q)`` to y."""
        return torch.einsum("nij,ndj->ndi", self.factor, theta - self.mean.unsqueeze(1))

    def restore(self, y: Tensor) -> Tensor:
        """Map y ``(n, d, q)`` to theta."""
        shifted = torch.linalg.solve_triangular(self.factor, y.transpose(1, 2), upper=False)
        return self.mean.unsqueeze(1) + shifted.transpose(1, 2)


class GaussianHead(nn.Linear):
    """Linear map from features to a Gaussian of theta, initially the standard normal.

    A conditional density of the whitened ``y`` then only describes the non-Gaussian part of the
    posterior.

    Args:
        features: Number s of features.
        dims: Number q of dimensions of theta.
    """

    def __init__(self, features: int, dims: int) -> None:
        super().__init__(features, 2 * dims + dims * (dims - 1) // 2)
        self.dims = dims
        nn.init.zeros_(self.weight)
        nn.init.zeros_(self.bias)

    def forward(self, features: Tensor) -> Gaussian:
        """Map features ``(n, s)`` to n Gaussians."""
        q, outputs = self.dims, super().forward(features)
        mean, log_diagonal, below = outputs.split([q, q, q * (q - 1) // 2], dim=-1)
        factor = torch.eye(q, dtype=outputs.dtype, device=outputs.device).repeat(len(mean), 1, 1)
        rows, columns = torch.tril_indices(q, q, offset=-1, device=outputs.device)
        factor[:, rows, columns] = below
        return Gaussian(mean, log_diagonal.exp().unsqueeze(-1) * factor, log_diagonal.sum(-1))
