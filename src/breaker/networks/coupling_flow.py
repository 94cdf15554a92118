r"""Coupling flow of rational-quadratic splines over a conditional Gaussian.

Durkan et al. (2019), "Neural spline flows"; the conditional invertible network of the paper's
abstract. The splines and the coupling are those of the library zuko. A coupling bends some
dimensions of ``y``, each by a monotone spline whose knots a small network computes from the other
dimensions and from the features. So the inverse and the determinant of the Jacobian are known,
and both draws and density take one pass, without a solver.

As in flow matching, ``y = P(s) (theta - m(s))`` is whitened first, by a linear head that here
learns by the same likelihood. Splines act on [-5, 5] and leave alone what is beyond. All last
layers start at zero, which makes a spline the identity: a new network is the Gaussian itself.

Data to noise is the forward direction.
"""

import math
from collections.abc import Sequence
from copy import copy
from functools import partial
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.distributions import Transform
from zuko.transforms import (
    ComposedTransform,
    CouplingTransform,
    DependentTransform,
    MonotonicRQSTransform,
)

from breaker.networks.blocks import GaussianHead

__all__ = ["CouplingFlow"]

_BOUND = 5.0  # splines act on [-5, 5] whitened sds
_SLOPE = 1e-3  # the smallest ratio of two bins, and the smallest slope at a knot


class _Spline(MonotonicRQSTransform):
    """zuko's, by whose helper torch would import sympy in every process, for a second."""

    def bin(self, k: Tensor) -> tuple[Tensor, ...]:
        """Whether points ``(...)`` are in a bin ``k``, ends, slopes there and mean slope of it."""
        inside, k = (k >= 0) & (k < self.bins), k % self.bins
        ends = torch.stack((k, k + 1), -1)
        knots = (self.horizontal, self.vertical, self.derivatives)
        (x0, x1), (y0, y1), (d0, d1) = (each.gather(-1, ends).unbind(-1) for each in knots)
        return inside, x0, x1, y0, y1, d0, d1, (y1 - y0) / (x1 - x0)


_IDENTITY = _Spline(torch.zeros(1), torch.zeros(1), torch.zeros(0))


def spline(sizes: Tensor, slopes: Tensor) -> MonotonicRQSTransform:
    """Return monotone rational-quadratic splines, from unbounded numbers of any size.

    The knots are those that zuko's constructor makes, here computed for both axes at once and
    without softmax, which over axes as short as the bins takes most of a draw's time.

    Args:
        sizes: Logarithms of the bins' widths and heights up to a bound, ``(..., 2 bins)``.
        slopes: Logarithms of the slopes at the inner knots up to a bound, ``(..., bins - 1)``.
    """
    most = -math.log(_SLOPE)
    bins = (sizes / (1.0 + sizes.abs() * (2.0 / most))).exp().unflatten(-1, (2, -1))
    knots = nn.functional.pad(bins.cumsum(-1), (1, 0))
    made = copy(_IDENTITY)
    made.horizontal, made.vertical = (_BOUND * (2.0 * knots / knots[..., -1:] - 1.0)).unbind(-2)
    made.derivatives = nn.functional.pad(slopes / (1.0 + slopes.abs() / most), (1, 1)).exp()
    return made


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
        self.enter = nn.Linear(inputs, hidden[0])
        self.middle = nn.ModuleList(
            nn.Linear(size_in, size_out) for size_in, size_out in pairwise(hidden)
        )
        self.leave = nn.Linear(hidden[-1], splines * (3 * bins - 1))
        nn.init.zeros_(self.leave.weight)
        nn.init.zeros_(self.leave.bias)

    def forward(self, shift: Tensor, y: Tensor) -> Transform:
        """Splines of d points given ``y_a (n, d, inputs)`` and the shift ``(n, 1, hidden[0])``."""
        h = self.enter(y) + shift
        for layer in self.middle:
            h = layer(nn.functional.silu(h))
        numbers = self.leave(nn.functional.silu(h)).unflatten(-1, (-1, 3 * self.bins - 1))
        return DependentTransform(spline(*numbers.split([2 * self.bins, self.bins - 1], -1)), 1)


class CouplingFlow(nn.Module):
    """Conditional density ``q(theta | s)`` with the methods ``loss``, ``sample``, ``log_prob``.

    Args:
        dims: Number q of dimensions of theta.
        features: Number s of features of the condition.
        transforms: Number of couplings.
        bins: Bins of a spline.
        hidden: Widths of the hidden layers of each coupling's network.

    Raises:
        ValueError: If there is no second dimension to couple, or no hidden layer.
    """

    solves = False  # one pass, whatever the steps

    def __init__(
        self, dims: int, features: int, *, transforms: int, bins: int, hidden: Sequence[int]
    ) -> None:
        super().__init__()
        if dims < 2:
            raise ValueError(f"a coupling needs at least two dimensions, not {dims}")
        if not hidden:
            raise ValueError("the networks of the couplings need at least one hidden layer")
        self.dims = dims
        self.head = GaussianHead(features, dims)
        self.project = nn.Linear(features, transforms * hidden[0])
        masks = torch.stack([_mask(dims, k) for k in range(transforms)])
        self.register_buffer("masks", masks, persistent=False)
        self.conditioners = nn.ModuleList(
            Conditioner(int(mask.sum()), int((~mask).sum()), bins=bins, hidden=hidden)
            for mask in masks
        )

    def transform(self, features: Tensor) -> Transform:
        """Map from y to noise, ``(n, d, q)``, given features ``(n, s)``, projected once a curve."""
        shifts = self.project(features).unsqueeze(1).chunk(len(self.masks), dim=-1)
        return ComposedTransform(
            *(
                CouplingTransform(partial(conditioner, shift), mask)
                for conditioner, shift, mask in zip(
                    self.conditioners, shifts, self.masks, strict=True
                )
            )
        )

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
        return self.head(features).restore(self.transform(features).inv(noise))

    def log_prob(self, theta: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Return the log density of ``(n, d, q)``, ``(n, d)``; ``steps`` is not used."""
        base = self.head(features)
        noise, log_slope = self.transform(features).call_and_ladj(base.whiten(theta))
        log_normal = -0.5 * (noise.square().sum(-1) + self.dims * math.log(2 * math.pi))
        return log_normal + log_slope + base.log_det.unsqueeze(1)


def _mask(dims: int, k: int) -> Tensor:
    """Return which dimensions coupling k leaves alone, ``(q,)`` of bool.

    Dimensions are told apart by a binary digit of their number, one digit after the other and each
    both ways round, so that after two couplings a digit any two dimensions have met.
    """
    digits = (dims - 1).bit_length()
    # On the CPU: sizes of layers follow from it, also where a module is built without memory.
    digit = torch.arange(dims, device="cpu") >> (k // 2 % digits) & 1
    return digit == k % 2
