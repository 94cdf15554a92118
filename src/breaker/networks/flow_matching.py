r"""Flow matching over a conditional Gaussian.

Lipman et al. (2023), "Flow matching for generative modeling"; Wildberger et al. (2023), "Flow
matching for scalable simulation-based inference". A velocity field ``v(y, t | s)`` carries noise
``eps ~ N(0, 1)`` at t = 0 to data at t = 1. Sampling integrates ``dy/dt = v`` from 0 to 1; the
density integrates backwards and adds the divergence.

Two choices make the field small, so that few solver steps and a small network suffice:

- The data are whitened first, ``y = P(s) (theta - m(s))``, with mean and lower-triangular factor
  from a linear head that is trained with the field, by maximum likelihood. The field then only
  describes the non-Gaussian part of the posterior.
- The path is ``y_t = sin(pi t / 2) y + cos(pi t / 2) eps`` (the trigonometric interpolant of
  Albergo & Vanden-Eijnden, 2023), which keeps unit variance: for a Gaussian posterior the best
  field is zero, whereas along a straight path the variance first falls and then rises.

The field starts at zero, so that a new network is the Gaussian of the head.

The divergence is exact: the q unit tangents pass through the residual blocks by the chain rule,
together with the velocity, which needs the same activations.
"""

import math

import torch
from torch import Tensor, nn

from breaker.networks.blocks import Edge, GaussianHead, Hidden

# Numbers in the tangents of a block of points: 256 kB fit into the cache of a CPU core, and 64 MB
# into the memory of any GPU.
_TANGENTS = {"cpu": 2**16, "cuda": 2**24}


def _silu_and_slope(x: Tensor) -> tuple[Tensor, Tensor]:
    """Return ``silu(x) = x sigmoid(x)`` and its derivative."""
    gate = x.sigmoid()
    value = x * gate
    return value, torch.addcmul(gate, value, 1.0 - gate)


class VelocityField(nn.Module):
    """Residual network ``(y, t, s) -> dy/dt``, conditioned on features projected once per curve.

    Args:
        dims: Number q of dimensions of y.
        features: Number s of features.
        width, blocks: Size of the network.
        frequencies: Number of frequencies of the time embedding.
    """

    def __init__(
        self, dims: int, features: int, *, width: int, blocks: int, frequencies: int = 8
    ) -> None:
        super().__init__()
        self.enter = Edge(dims, width)
        self.condition = Edge(features, width * (blocks + 1))
        self.time = nn.Linear(2 * frequencies, width * (blocks + 1))
        self.inner = nn.ModuleList(Hidden(width, width) for _ in range(blocks))
        self.outer = nn.ModuleList(Hidden(width, width) for _ in range(blocks))
        self.leave = Edge(width, dims)
        for layer in (*self.outer, self.leave):
            nn.init.zeros_(layer.weight)
            nn.init.zeros_(layer.bias)
        self.register_buffer("frequencies", math.pi * torch.arange(1, frequencies + 1) / 2)

    def project(self, features: Tensor) -> Tensor:
        """Project features ``(n, s)`` to the shifts of all blocks, ``(n, 1, width (blocks+1))``."""
        return self.condition(features).unsqueeze(1)

    def forward(self, y: Tensor, time: Tensor, projected: Tensor) -> Tensor:
        """Return the velocity at points ``(n, d, q)`` and times ``(n, d, 1)`` or ``(1, 1, 1)``."""
        shifts = self._shifts(time, projected)
        h = self.enter(y) + shifts[0]
        for inner, outer, shift in zip(self.inner, self.outer, shifts[1:], strict=True):
            h = h + outer(nn.functional.silu(inner(nn.functional.silu(h)) + shift))
        return self.leave(nn.functional.silu(h))

    def with_divergence(self, y: Tensor, time: Tensor, projected: Tensor) -> tuple[Tensor, Tensor]:
        """Return the velocity ``(n, d, q)`` and its divergence ``(n, d)``.

        ``tangents[i]`` is ``dh / dy_i``. A block multiplies it by its linear layers and the slopes
        of silu. The last layer needs only the diagonal of the Jacobian.
        """
        shifts = self._shifts(time, projected)
        h = self.enter(y) + shifts[0]
        tangents = self.enter.weight.T[:, None, None].expand(-1, *h.shape)
        for inner, outer, shift in zip(self.inner, self.outer, shifts[1:], strict=True):
            value, slope = _silu_and_slope(h)
            within, slope_within = _silu_and_slope(inner(value) + shift)
            h = h + outer(within)
            moved = nn.functional.linear(tangents * slope, inner.weight).mul_(slope_within)
            tangents = torch.addmm(
                tangents.flatten(0, -2), moved.flatten(0, -2), outer.weight.T
            ).view_as(moved)
        value, slope = _silu_and_slope(h)
        rows = self.leave.weight[:, None, None]
        return self.leave(value), ((tangents * rows).sum(0) * slope).sum(-1)

    def _shifts(self, time: Tensor, projected: Tensor) -> tuple[Tensor, ...]:
        """Return the shifts of all blocks from time and features."""
        angles = time * self.frequencies
        embedded = self.time(torch.cat([angles.sin(), angles.cos()], dim=-1))
        return (projected + embedded).split(self.enter.out_features, dim=-1)


class FlowMatching(nn.Module):
    """Conditional density ``q(theta | s)`` with the methods ``loss``, ``sample``, ``log_prob``.

    Args:
        dims: Number q of dimensions of theta.
        features: Number s of features of the condition.
        width, blocks: Size of the velocity field.
    """

    solves = True  # solver steps determine the accuracy

    def __init__(self, dims: int, features: int, *, width: int, blocks: int) -> None:
        super().__init__()
        self.dims = dims
        self.head = GaussianHead(features, dims)
        self.field = VelocityField(dims, features, width=width, blocks=blocks)

    def loss(self, theta: Tensor, features: Tensor, noise: Tensor, time: Tensor) -> Tensor:
        """Return the loss of each row, ``(n,)``: flow matching plus the base's log likelihood.

        Args:
            theta: Data, ``(n, q)``.
            features: Condition, ``(n, s)``.
            noise: Start points, ``(n, k, q)``: the k points of a row share one condition.
            time: Times in [0, 1], ``(n, k, 1)``.
        """
        base = self.head(features)
        whitened = base.whiten(theta.unsqueeze(1))
        base_loss = 0.5 * whitened.square().sum((1, 2)) - base.log_det

        target = whitened.detach()
        sine, cosine = (0.5 * math.pi * time).sin(), (0.5 * math.pi * time).cos()
        velocity = 0.5 * math.pi * (cosine * target - sine * noise)
        field = self.field(sine * target + cosine * noise, time, self.field.project(features))
        return base_loss + (field - velocity).square().sum(-1).mean(-1)

    def sample(self, noise: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Map noise ``(n, d, q)`` to draws ``(n, d, q)`` by the midpoint rule."""
        projected, y = self.field.project(features), noise
        for k in range(steps):
            middle = y + self.field(y, self._time(k / steps, y), projected) / (2 * steps)
            y = y + self.field(middle, self._time((k + 0.5) / steps, y), projected) / steps
        return self.head(features).restore(y)

    def log_prob(self, theta: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Return the log density of ``(n, d, q)``, ``(n, d)``, by the midpoint rule backwards.

        Points are processed in blocks, so that their tangents stay in the cache.
        """
        base, projected = self.head(features), self.field.project(features)
        width = self.field.enter.out_features
        points = max(1, _TANGENTS[theta.device.type] // (self.dims * width))
        curves = zip(base.whiten(theta).split(points), projected.split(points), strict=True)
        density = [
            torch.cat(
                [
                    self._carry_back(y, shifts, steps)
                    for y in block.split(max(1, points // len(block)), dim=1)
                ],
                dim=1,
            )
            for block, shifts in curves
        ]
        return torch.cat(density) + base.log_det.unsqueeze(1)

    def _carry_back(self, y: Tensor, projected: Tensor, steps: int) -> Tensor:
        """Return the log density ``(n, d)`` of whitened points ``(n, d, q)``."""
        divergence = torch.zeros_like(y[..., 0])
        for k in range(steps, 0, -1):
            middle = y - self.field(y, self._time(k / steps, y), projected) / (2 * steps)
            time = self._time((k - 0.5) / steps, y)
            velocity, trace = self.field.with_divergence(middle, time, projected)
            y, divergence = y - velocity / steps, divergence + trace / steps
        log_normal = -0.5 * (y.square().sum(-1) + self.dims * math.log(2 * math.pi))
        return log_normal - divergence

    @staticmethod
    def _time(t: float, y: Tensor) -> Tensor:
        return torch.full((1, 1, 1), t, dtype=y.dtype, device=y.device)
