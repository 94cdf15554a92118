r"""Coupling flow of rational-quadratic splines over a conditional Gaussian.

Durkan et al. (2019), "Neural spline flows"; the conditional invertible network of the paper's
abstract. A coupling bends some dimensions of ``y``, each by a monotone spline whose knots a small
network computes from the other dimensions and from the features. So the inverse and the
determinant of the Jacobian are known, and both draws and density take one pass, without a solver.

As in flow matching, ``y = P(s) (theta - m(s))`` is whitened first, by a linear head that here
learns by the same likelihood. Splines act on [-5, 5] and leave alone what is beyond. All last
layers start at zero, which makes a spline the identity: a new network is the Gaussian itself.

Data to noise is the forward direction.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from breaker.networks.blocks import Edge, GaussianHead, Hidden
from breaker.networks.splines import bend, unbend


class Conditioner(nn.Module):
    """Network ``(y_a, s) -> splines of y_b``, its first layer shifted by projected features.

    Args:
        inputs: Number of dimensions in ``y_a``.
        splines: Number of dimensions in ``y_b``.
        bins: Bins of a spline.
        hidden: Widths of the hidden layers.
    """

    def __init__(self, inputs: int, splines: int, *, bins: int, hidden: Sequence[int]) -> None:
        super().__init__()
        self.bins = bins
        self.enter = Edge(inputs, hidden[0])
        self.middle = nn.ModuleList(
            Hidden(size_in, size_out) for size_in, size_out in pairwise(hidden)
        )
        self.leave = Edge(hidden[-1], splines * (3 * bins - 1))
        nn.init.zeros_(self.leave.weight)
        nn.init.zeros_(self.leave.bias)

    def forward(self, y: Tensor, shift: Tensor) -> Tensor:
        """Numbers of the splines, ``(n, d, splines, 3 bins - 1)``.

        Args:
            y: The points' dimensions that stay, ``(n, d, inputs)``.
            shift: Projected features, ``(n, 1, hidden[0])``.
        """
        h = self.enter(y) + shift
        for layer in self.middle:
            h = layer(nn.functional.silu(h))
        return self.leave(nn.functional.silu(h)).unflatten(-1, (-1, 3 * self.bins - 1))


class CouplingFlow(nn.Module):
    """Conditional density ``q(theta | s)`` with the methods ``loss``, ``sample``, ``log_prob``.

    Args:
        dims: Number q of dimensions of theta, two at least.
        features: Number s of features of the condition.
        transforms: Number of couplings.
        bins: Bins of a spline.
        hidden: Widths of the hidden layers of each coupling's network, one at least.
    """

    solves = False  # one pass, whatever the steps

    def __init__(
        self, dims: int, features: int, *, transforms: int, bins: int, hidden: Sequence[int]
    ) -> None:
        super().__init__()
        self.dims = dims
        self.head = GaussianHead(features, dims)
        self.project = Edge(features, transforms * hidden[0])
        masks = [_mask(dims, k) for k in range(transforms)]
        # Dimensions of each coupling, those that stay before those that it bends.
        orders = torch.stack([torch.argsort(~mask, stable=True) for mask in masks])
        self.register_buffer("orders", orders, persistent=False)
        self.register_buffer("places", orders.argsort(), persistent=False)
        self.conditioners = nn.ModuleList(
            Conditioner(int(mask.sum()), int((~mask).sum()), bins=bins, hidden=hidden)
            for mask in masks
        )

    def whitened_to_noise(self, y: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        """Bend y ``(n, d, q)`` to noise, given features ``(n, s)``; with log slopes ``(n, d)``."""
        log_slope = y.new_zeros(y.shape[:-1])
        for conditioner, order, place, shift in self._couplings(features):
            stay, turn = _parted(y, order, conditioner)
            turned, log_slopes = bend(turn, conditioner(stay, shift))
            y = torch.cat([stay, turned], -1).index_select(-1, place)
            log_slope = log_slope + log_slopes.sum(-1)
        return y, log_slope

    def noise_to_whitened(self, noise: Tensor, features: Tensor) -> Tensor:
        """Undo ``whitened_to_noise``, ``(n, d, q)``."""
        y = noise
        for conditioner, order, place, shift in reversed(self._couplings(features)):
            stay, turn = _parted(y, order, conditioner)
            turned = unbend(turn, conditioner(stay, shift))
            y = torch.cat([stay, turned], -1).index_select(-1, place)
        return y

    def _couplings(self, features: Tensor) -> list[tuple[Conditioner, Tensor, Tensor, Tensor]]:
        """Couplings with their shifts, for which features are projected once a curve."""
        shifts = self.project(features).unsqueeze(1).chunk(len(self.orders), dim=-1)
        return list(zip(self.conditioners, self.orders, self.places, shifts, strict=True))

    def loss(self, theta: Tensor, features: Tensor, noise: Tensor, time: Tensor) -> Tensor:
        """Return minus the log density of each row, ``(n,)``.

        Args:
            theta: Data, ``(n, q)``.
            features: Condition, ``(n, s)``.
            noise, time: What flow matching needs; not used.
        """
        return -self.log_prob(theta.unsqueeze(1), features, steps=1).squeeze(1)

    def sample(self, noise: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Map noise ``(n, d, q)`` to draws ``(n, d, q)``; ``steps`` is not used."""
        return self.head(features).restore(self.noise_to_whitened(noise, features))

    def log_prob(self, theta: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Return the log density of ``(n, d, q)``, ``(n, d)``; ``steps`` is not used."""
        base = self.head(features)
        noise, log_slope = self.whitened_to_noise(base.whiten(theta), features)
        log_normal = -0.5 * (noise.square().sum(-1) + self.dims * math.log(2 * math.pi))
        return log_normal + log_slope + base.log_det.unsqueeze(1)


def _parted(y: Tensor, order: Tensor, conditioner: Conditioner) -> list[Tensor]:
    """Return the dimensions of y that a coupling leaves alone, and those that it bends."""
    stay = conditioner.enter.in_features
    return y.index_select(-1, order).split([stay, len(order) - stay], -1)


def _mask(dims: int, k: int) -> Tensor:
    """Return which dimensions coupling k leaves alone, ``(q,)`` of bool.

    Dimensions are told apart by a binary digit of their number, one digit after the other and each
    both ways round, so that after two couplings a digit any two dimensions have met.
    """
    digits = (dims - 1).bit_length()
    # On the CPU: sizes of layers follow from it, also where a module is built without memory.
    digit = torch.arange(dims, device="cpu") >> (k // 2 % digits) & 1
    return digit == k % 2
