r"""Coupling flow of rational-quadratic splines over a conditional Gaussian.

Durkan et al. (2019), "Neural spline flows"; the conditional invertible network of the paper's
abstract. A coupling maps some dimensions of ``y`` by monotone splines. A small network computes the
knots of the splines from the other dimensions and the features. So the inverse and the determinant
of the Jacobian are known, and draws and density take one pass each, without a solver.

As in flow matching, a linear head first whitens, ``y = P(s) (theta - m(s))``; here it learns by the
same likelihood. Splines act on [-5, 5] and are the identity outside. All last layers start at zero,
which makes all splines the identity, so that a new network is the Gaussian of the head.

The forward direction maps data to noise.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.autograd.function import once_differentiable

from breaker.networks.blocks import Edge, GaussianHead, Hidden

_BOUND = 5.0  # end of the splines; a standard normal lies outside with a probability of 6e-7
# Smallest ratio of two bins and smallest slope at a knot that float32 can invert.
_SLOPE = 1e-3
_MOST = -math.log(_SLOPE)


def bend(x: Tensor, numbers: Tensor) -> tuple[Tensor, Tensor]:
    """Return the splines' values at x and the logs of their slopes there, ``(...)`` each.

    Args:
        x: One point for each spline, ``(...)``.
        numbers: Unbounded numbers, ``(..., 3 bins - 1)``. Damped to a bound, they are logarithms
            of the bins' widths, of their heights, and of the slopes at the inner knots.

    Example:
        >>> bend(torch.tensor([0.5, 7.0]), torch.zeros(2, 11))  # zeros are the identity
        (tensor([0.5000, 7.0000]), tensor([0., 0.]))
    """
    return _Bend.apply(x, numbers)


def unbend(y: Tensor, numbers: Tensor) -> Tensor:
    """Return the points at which splines have the values y, ``(...)``: the inverse of ``bend``."""
    piece = _Piece(y, _Knots(numbers), axis=1)
    rise, bow = y - piece.y0, piece.d0 + piece.d1 - 2.0 * piece.s
    a = piece.h * (piece.s - piece.d0) + rise * bow
    b = piece.h * piece.d0 - rise * bow
    c = -piece.s * rise
    t = 2.0 * c / (-b - (b * b - 4.0 * a * c).clamp_min(0.0).sqrt())
    return torch.where(piece.inside, piece.x0 + t * piece.w, y)


class _Knots:
    """Knots of splines, and intermediate results for gradients.

    Bins are the first axis, so that operations run along memory: with the short axis of bins last,
    they take three times as long. A softmax over bins takes longest.

    Attributes:
        damped: Divisors that bound the logarithms of widths, ``(2, bins, ...)``.
        widths: Sizes of the bins on both axes, unscaled, ``(2, bins, ...)``.
        ends: Positions of the knots, unscaled, ``(2, bins + 1, ...)``; the last is ``total``,
            ``(2, ...)``.
        slopes: Slopes at the knots, ``(bins + 1, ...)``, with divisors ``slope_damped`` inside.
    """

    def __init__(self, numbers: Tensor) -> None:
        bins = (numbers.shape[-1] + 1) // 3
        sizes, steep = numbers.movedim(-1, 0).contiguous().split([2 * bins, bins - 1])
        sizes = sizes.unflatten(0, (2, bins))
        self.damped = 1.0 + sizes.abs() * (2.0 / _MOST)
        self.widths = (sizes / self.damped).exp()
        ends = [torch.zeros_like(self.widths[:, 0])]
        for width in self.widths.unbind(1):
            ends.append(ends[-1] + width)
        self.total, self.ends = ends[-1], torch.stack(ends, 1)
        self.slope_damped = 1.0 + steep.abs() / _MOST
        end = torch.ones_like(numbers[..., 0]).unsqueeze(0)
        self.slopes = torch.cat([end, (steep / self.slope_damped).exp(), end])


class _Piece:
    """Pieces of splines that contain points, given by values on an axis: 0 for x, 1 for y."""

    def __init__(self, points: Tensor, knots: _Knots, *, axis: int) -> None:
        place = (points / (2.0 * _BOUND) + 0.5) * knots.total[axis]
        index = (knots.ends[axis, 1:-1] < place).sum(0, keepdim=True)
        self.both = torch.cat([index, index + 1])
        self.inside = points.abs() < _BOUND
        self.reached = knots.ends.gather(1, self.both.expand(2, *self.both.shape))
        low, high = self.reached.unbind(1)
        self.x0, self.y0 = (_BOUND * (2.0 * low / knots.total - 1.0)).unbind()
        self.w, self.h = (2.0 * _BOUND * (high - low) / knots.total).unbind()
        self.d0, self.d1 = knots.slopes.gather(0, self.both).unbind()
        self.s = self.h / self.w


class _Bend(torch.autograd.Function):
    """Value and log slope of splines, and their gradients."""

    @staticmethod
    def forward(ctx, x: Tensor, numbers: Tensor) -> tuple[Tensor, Tensor]:
        """Return the result of ``bend``."""
        knots = _Knots(numbers)
        p = _Piece(x, knots, axis=0)
        t = torch.where(p.inside, (x - p.x0) / p.w, 0.5)
        q, r = t * (1.0 - t), 1.0 - t
        below = p.s + (p.d0 + p.d1 - 2.0 * p.s) * q
        share = (p.s * t * t + p.d0 * q) / below
        steep = p.d1 * t * t + 2.0 * p.s * q + p.d0 * r * r
        value = torch.where(p.inside, p.y0 + p.h * share, x)
        log_slope = 2.0 * (p.s / below).log() + steep.log()
        ctx.piece, ctx.knots = p, knots
        ctx.save_for_backward(t, q, r, below, share, steep)
        return value, log_slope.where(p.inside, 0.0)

    @staticmethod
    @once_differentiable
    def backward(ctx, of_value: Tensor, of_slope: Tensor) -> tuple[Tensor, Tensor]:
        """Return the gradients of x and of the numbers."""
        t, q, r, below, share, steep = ctx.saved_tensors
        p = ctx.piece
        inside = p.inside.to(t.dtype)
        outer, of_value, of_slope = of_value * (1.0 - inside), of_value * inside, of_slope * inside
        # Gradients of the numerator's share, of the denominator and of the slope's numerator.
        of_share = of_value * p.h / below
        of_below = -of_share * share - 2.0 * of_slope / below
        of_steep = of_slope / steep
        bow, turn = p.d0 + p.d1 - 2.0 * p.s, 1.0 - 2.0 * t
        of_t = (
            of_share * (2.0 * p.s * t + p.d0 * turn)
            + of_below * bow * turn
            + of_steep * 2.0 * (p.d1 * t + p.s * turn - p.d0 * r)
        )
        of_s = (
            of_share * t * t
            + of_below * (1.0 - 2.0 * q)
            + of_steep * 2.0 * q
            + 2.0 * of_slope / p.s
        )
        of_d0 = (of_share + of_below) * q + of_steep * r * r
        of_d1 = of_below * q + of_steep * t * t
        of_x = of_t / p.w
        of_h = of_value * share + of_s / p.w
        of_w = -(of_s * p.s + of_t * t) / p.w
        of_ends = torch.stack(
            [
                torch.stack([-of_x - of_w, of_value - of_h]),
                torch.stack([of_w, of_h]),
            ],
            1,
        )
        of_numbers = _of_numbers(ctx.knots, p, of_ends, torch.stack([of_d0, of_d1]))
        return outer + of_x, of_numbers


def _of_numbers(knots: _Knots, piece: _Piece, of_ends: Tensor, of_slopes: Tensor) -> Tensor:
    """Return gradients of the numbers from gradients of a piece's ends and of its slopes.

    Args:
        knots, piece: Knots and pieces of the splines.
        of_ends: Gradients of the ends, ``(2 axes, 2 ends, ...)``.
        of_slopes: Gradients of the slopes at the ends, ``(2, ...)``.
    """
    of_ends = of_ends * (2.0 * _BOUND / knots.total).unsqueeze(1)
    # A knot is a share of the sum of bins: a bin moves the knots after it up, and all knots down.
    pull = (of_ends * piece.reached).sum(1) / knots.total
    bins = knots.widths.shape[1]
    order = torch.arange(bins, device=of_ends.device).view(bins, *[1] * (of_ends.dim() - 2))
    moved = [(order < end).to(of_ends.dtype) for end in piece.both]
    low, high = of_ends.unsqueeze(1).unbind(2)
    of_sizes = torch.addcmul(torch.addcmul(-pull.unsqueeze(1), moved[0], low), moved[1], high)
    of_sizes = of_sizes * knots.widths / (knots.damped * knots.damped)
    of_all = torch.zeros_like(knots.slopes).scatter(0, piece.both, of_slopes) * knots.slopes
    of_inner = of_all[1:-1] / (knots.slope_damped * knots.slope_damped)
    return torch.cat([of_sizes.flatten(0, 1), of_inner]).movedim(0, -1)


# ---- coupling flow ----


class Conditioner(nn.Module):
    """Network ``(y_a, s) -> splines of y_b``, with projected features added to its first layer.

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
        """Return numbers of the splines, ``(n, d, splines, 3 bins - 1)``.

        Args:
            y: Dimensions of the points that the coupling keeps, ``(n, d, inputs)``.
            shift: Projected features, ``(n, 1, hidden[0])``.
        """
        h = self.enter(y) + shift
        for layer in self.middle:
            h = layer(nn.functional.silu(h))
        return self.leave(nn.functional.silu(h)).unflatten(-1, (-1, 3 * self.bins - 1))


class CouplingFlow(nn.Module):
    """Conditional density ``q(theta | s)`` with the methods ``loss``, ``sample``, ``log_prob``.

    Args:
        dims: Number q of dimensions of theta, at least two.
        features: Number s of features of the condition.
        transforms: Number of couplings.
        bins: Bins of a spline.
        hidden: Widths of the hidden layers of each coupling's network, at least one.
    """

    solves = False  # one pass, with any number of steps

    def __init__(
        self, dims: int, features: int, *, transforms: int, bins: int, hidden: Sequence[int]
    ) -> None:
        super().__init__()
        self.dims = dims
        self.head = GaussianHead(features, dims)
        self.project = Edge(features, transforms * hidden[0])
        masks = [_mask(dims, k) for k in range(transforms)]
        # Dimensions of each coupling: first the ones it keeps, then the ones it bends.
        orders = torch.stack([torch.argsort(~mask, stable=True) for mask in masks])
        self.register_buffer("orders", orders, persistent=False)
        self.register_buffer("places", orders.argsort(), persistent=False)
        self.conditioners = nn.ModuleList(
            Conditioner(int(mask.sum()), int((~mask).sum()), bins=bins, hidden=hidden)
            for mask in masks
        )

    def whitened_to_noise(self, y: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        """Map y ``(n, d, q)`` to noise, given features ``(n, s)``; with log slopes ``(n, d)``."""
        log_slope = y.new_zeros(y.shape[:-1])
        for conditioner, order, place, shift in self._couplings(features):
            stay, turn = _parted(y, order, conditioner)
            turned, log_slopes = bend(turn, conditioner(stay, shift))
            y = torch.cat([stay, turned], -1).index_select(-1, place)
            log_slope = log_slope + log_slopes.sum(-1)
        return y, log_slope

    def noise_to_whitened(self, noise: Tensor, features: Tensor) -> Tensor:
        """Invert ``whitened_to_noise``, ``(n, d, q)``."""
        y = noise
        for conditioner, order, place, shift in reversed(self._couplings(features)):
            stay, turn = _parted(y, order, conditioner)
            turned = unbend(turn, conditioner(stay, shift))
            y = torch.cat([stay, turned], -1).index_select(-1, place)
        return y

    def _couplings(self, features: Tensor) -> list[tuple[Conditioner, Tensor, Tensor, Tensor]]:
        """Return couplings with their shifts; features are projected once per curve."""
        shifts = self.project(features).unsqueeze(1).chunk(len(self.orders), dim=-1)
        return list(zip(self.conditioners, self.orders, self.places, shifts, strict=True))

    def loss(self, theta: Tensor, features: Tensor, noise: Tensor, time: Tensor) -> Tensor:
        """Return the negative log density of each row, ``(n,)``.

        Args:
            theta: Data, ``(n, q)``.
            features: Condition, ``(n, s)``.
            noise, time: Arguments of flow matching; not used.
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
    """Return the dimensions of y that a coupling keeps, and the ones that it bends."""
    stay = conditioner.enter.in_features
    return y.index_select(-1, order).split([stay, len(order) - stay], -1)


def _mask(dims: int, k: int) -> Tensor:
    """Return the dimensions that coupling k keeps, ``(q,)`` of bool.

    A coupling splits dimensions by a binary digit of their number. Each digit serves two couplings
    with exchanged roles, so that all pairs of dimensions are split once all digits have served.
    """
    digits = (dims - 1).bit_length()
    # On the CPU, because layer sizes depend on it, also for a module built on the meta device.
    digit = torch.arange(dims, device="cpu") >> (k // 2 % digits) & 1
    return digit == k % 2
