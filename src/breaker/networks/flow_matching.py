r"""Flow matching over a conditional Gaussian.

Lipman et al. (2023), "Flow matching for generative modeling"; Wildberger et al. (2023), "Flow
matching for scalable simulation-based inference". A velocity field ``v(y, t | s)`` carries noise
``eps ~ N(0, 1)`` at t = 0 to data at t = 1; sampling integrates ``dy/dt = v`` from 0 to 1, the
density integrates back and adds the divergence.

Two choices make the field small, so that few solver steps and a small network do:

- The data are whitened first, ``y = P(s) (theta - m(s))``, with mean and lower-triangular factor
  from a linear head that is trained along by maximum likelihood. What is left to the field is
  where the posterior is not Gaussian.
- The path is ``y_t = sin(pi t / 2) y + cos(pi t / 2) eps`` (the trigonometric interpolant of
  Albergo & Vanden-Eijnden, 2023), which keeps unit variance: for a Gaussian posterior the best
  field is zero, where a straight path would first shrink and then spread.

The field starts at zero, so that a new network is the Gaussian itself.
"""

import math

import torch
from torch import Tensor, nn

__all__ = ["FlowMatching"]


class VelocityField(nn.Module):
    """Residual network ``(y, t, s) -> dy/dt``, conditioned on features projected once a curve.

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
        self.enter = nn.Linear(dims, width)
        self.condition = nn.Linear(features, width * (blocks + 1))
        self.time = nn.Linear(2 * frequencies, width * (blocks + 1))
        self.inner = nn.ModuleList(nn.Linear(width, width) for _ in range(blocks))
        self.outer = nn.ModuleList(nn.Linear(width, width) for _ in range(blocks))
        self.leave = nn.Linear(width, dims)
        for layer in (*self.outer, self.leave):
            nn.init.zeros_(layer.weight)
            nn.init.zeros_(layer.bias)
        self.register_buffer("frequencies", math.pi * torch.arange(1, frequencies + 1) / 2)

    def project(self, features: Tensor) -> Tensor:
        """Project features ``(n, s)`` to the shifts of all blocks, ``(n, 1, width (blocks+1))``."""
        return self.condition(features).unsqueeze(1)

    def forward(self, y: Tensor, time: Tensor, projected: Tensor) -> Tensor:
        """Velocity ``(n, d, q)`` at points of that shape, times ``(n, d, 1)`` or ``(1, 1, 1)``."""
        angles = time * self.frequencies
        embedded = self.time(torch.cat([angles.sin(), angles.cos()], dim=-1))
        width = self.enter.out_features
        shifts = (projected + embedded).split(width, dim=-1)
        h = self.enter(y) + shifts[0]
        for inner, outer, shift in zip(self.inner, self.outer, shifts[1:], strict=True):
            h = h + outer(nn.functional.silu(inner(nn.functional.silu(h)) + shift))
        return self.leave(nn.functional.silu(h))


class FlowMatching(nn.Module):
    """Conditional density ``q(theta | s)`` with the methods ``loss``, ``sample``, ``log_prob``.

    Args:
        dims: Number q of dimensions of theta.
        features: Number s of features of the condition.
        width, blocks: Size of the velocity field.
    """

    def __init__(self, dims: int, features: int, *, width: int, blocks: int) -> None:
        super().__init__()
        self.dims = dims
        self.head = nn.Linear(features, 2 * dims + dims * (dims - 1) // 2)
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)
        self.field = VelocityField(dims, features, width=width, blocks=blocks)

    def base(self, features: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Mean ``(n, q)``, factor P ``(n, q, q)`` and log determinant of P ``(n,)``."""
        mean, log_diagonal, below = self.head(features).split(
            [self.dims, self.dims, self.dims * (self.dims - 1) // 2], dim=-1
        )
        unit = torch.eye(self.dims, dtype=features.dtype, device=features.device)
        factor = unit.repeat(len(features), 1, 1)
        rows, columns = torch.tril_indices(self.dims, self.dims, offset=-1, device=features.device)
        factor[:, rows, columns] = below
        return mean, log_diagonal.exp().unsqueeze(-1) * factor, log_diagonal.sum(-1)

    def loss(self, theta: Tensor, features: Tensor, noise: Tensor, time: Tensor) -> Tensor:
        """Return the loss of each row, ``(n,)``: flow matching plus the base's log likelihood.

        Args:
            theta: Data, ``(n, q)``.
            features: Condition, ``(n, s)``.
            noise: Start points, ``(n, k, q)``: k times a row share one condition.
            time: Times in [0, 1], ``(n, k, 1)``.
        """
        mean, factor, log_det = self.base(features)
        whitened = torch.einsum("nij,nj->ni", factor, theta - mean)
        base_loss = 0.5 * whitened.square().sum(-1) - log_det

        target = whitened.detach().unsqueeze(1)
        sine, cosine = (0.5 * math.pi * time).sin(), (0.5 * math.pi * time).cos()
        velocity = 0.5 * math.pi * (cosine * target - sine * noise)
        field = self.field(sine * target + cosine * noise, time, self.field.project(features))
        return base_loss + (field - velocity).square().sum(-1).mean(-1)

    def sample(self, noise: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Carry noise ``(n, d, q)`` to draws ``(n, d, q)`` by the midpoint rule."""
        mean, factor, _ = self.base(features)
        projected, y = self.field.project(features), noise
        for k in range(steps):
            middle = y + self.field(y, self._time(k / steps, y), projected) / (2 * steps)
            y = y + self.field(middle, self._time((k + 0.5) / steps, y), projected) / steps
        shifted = torch.linalg.solve_triangular(factor, y.transpose(1, 2), upper=False)
        return mean.unsqueeze(1) + shifted.transpose(1, 2)

    def log_prob(self, theta: Tensor, features: Tensor, *, steps: int) -> Tensor:
        """Return the log density of ``(n, d, q)``, ``(n, d)``: the same rule, backwards."""
        mean, factor, log_det = self.base(features)
        projected = self.field.project(features)
        y = torch.einsum("nij,ndj->ndi", factor, theta - mean.unsqueeze(1))
        divergence = torch.zeros_like(y[..., 0])
        for k in range(steps, 0, -1):
            velocity = self.field(y, self._time(k / steps, y), projected)
            middle = y - velocity / (2 * steps)
            velocity, trace = self._field_and_trace(middle, (k - 0.5) / steps, projected)
            y, divergence = y - velocity / steps, divergence + trace / steps
        log_normal = -0.5 * (y.square().sum(-1) + self.dims * math.log(2 * math.pi))
        return log_normal - divergence + log_det.unsqueeze(1)

    @staticmethod
    def _time(t: float, y: Tensor) -> Tensor:
        return torch.full((1, 1, 1), t, dtype=y.dtype, device=y.device)

    def _field_and_trace(self, y: Tensor, t: float, projected: Tensor) -> tuple[Tensor, Tensor]:
        """Velocity ``(n, d, q)`` and its exact divergence ``(n, d)``, one tangent a dimension."""
        time = self._time(t, y)

        def field(point: Tensor) -> Tensor:
            return self.field(point, time, projected)

        trace = torch.zeros_like(y[..., 0])
        for i in range(self.dims):
            tangent = torch.zeros_like(y)
            tangent[..., i] = 1.0
            velocity, slope = torch.func.jvp(field, (y,), (tangent,))
            trace = trace + slope[..., i]
        return velocity, trace
