r"""Local cubic interpolation between the samples of a grid.

The polynomial of Lagrange through the four nearest samples. Its error is at most
``3/128 h^4 max|f''''|`` between the middle two of them and ``1/24 h^4 max|f''''|`` in the first
and the last interval of the grid, for samples h apart. Where the second derivative of f jumps by
J between two samples, it is at most ``0.036 h^2 |J|`` between the middle two, ``0.058 h^2 |J|``
in a first or last interval. On the grid itself it is exact.
"""

import torch
from torch import Tensor

__all__ = ["NODES", "cubic"]

NODES = 4  # samples that a value is made of, the least that a grid has to have


def cubic(positions: Tensor, samples: int) -> tuple[Tensor, Tensor]:
    """Return which samples of a grid make up the value at a position, and their weights.

    Args:
        positions: In steps of the grid, within ``[0, samples - 1]``, of any shape ``(*)``.
        samples: Number of samples of the grid, at least four.

    Returns:
        Indices and weights, both ``(*, 4)``.
    """
    first = (positions.floor() - 1).clamp(0, samples - NODES)
    x = positions - first
    a, b, c = x - 1, x - 2, x - 3
    weights = torch.stack([-a * b * c / 6, x * b * c / 2, -x * a * c / 2, x * a * b / 6], dim=-1)
    return first.long().unsqueeze(-1) + torch.arange(NODES, device=x.device), weights
