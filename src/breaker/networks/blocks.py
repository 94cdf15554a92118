"""Pieces that several networks share."""

from torch import Tensor, nn

__all__ = ["ResidualMLP"]


class ResidualMLP(nn.Module):
    """Linear layer in, residual blocks, linear layer out.

    A block adds ``W_2 silu(W_1 silu(h))`` to ``h``; its last layer starts at zero, so that a new
    network is linear and its depth costs nothing until it pays.

    Args:
        inputs, width, outputs: Sizes of the layers.
        blocks: Number of residual blocks.
    """

    def __init__(self, inputs: int, width: int, outputs: int, *, blocks: int) -> None:
        super().__init__()
        self.enter = nn.Linear(inputs, width)
        self.inner = nn.ModuleList(nn.Linear(width, width) for _ in range(blocks))
        self.outer = nn.ModuleList(nn.Linear(width, width) for _ in range(blocks))
        self.leave = nn.Linear(width, outputs)
        for layer in self.outer:
            nn.init.zeros_(layer.weight)
            nn.init.zeros_(layer.bias)

    def forward(self, x: Tensor) -> Tensor:
        """Map ``(..., inputs)`` to ``(..., outputs)``."""
        h = self.enter(x)
        for inner, outer in zip(self.inner, self.outer, strict=True):
            h = h + outer(nn.functional.silu(inner(nn.functional.silu(h))))
        return self.leave(nn.functional.silu(h))
