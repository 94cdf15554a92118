r"""Monotone rational-quadratic splines with their own derivative.

Durkan et al. (2019), "Neural spline flows", equations 4 to 8. On an interval between two knots
``(x0, y0)`` and ``(x1, y1)`` with slopes ``d0`` and ``d1``, with ``t = (x - x0) / (x1 - x0)`` and
the chord's slope ``s``::

    y = y0 + (y1 - y0) (s t^2 + d0 t (1 - t)) / (s + (d0 + d1 - 2 s) t (1 - t))

Splines act on [-5, 5] and leave alone what is beyond. The gradient of a value and of its log slope
is written out, for a training's tensors are so small that each operation costs its start: followed
operation by operation, a flow's loss and gradient take a third longer.
"""

import math

import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

_BOUND = 5.0
_SLOPE = 1e-3  # the smallest ratio of two bins, and the smallest slope at a knot
_MOST = -math.log(_SLOPE)


def bend(x: Tensor, numbers: Tensor) -> tuple[Tensor, Tensor]:
    """Return the splines' values at x and the logs of their slopes there, ``(...)`` each.

    Args:
        x: One point for each spline, ``(...)``.
        numbers: Unbounded numbers, ``(..., 3 bins - 1)``: logarithms up to a bound of the bins'
            widths, of their heights, and of the slopes at the inner knots.

    Example:
        >>> bend(torch.tensor([0.5, 7.0]), torch.zeros(2, 11))  # zeros are the identity
        (tensor([0.5000, 7.0000]), tensor([0., 0.]))
    """
    return _Bend.apply(x, numbers)


def unbend(y: Tensor, numbers: Tensor) -> Tensor:
    """Return where splines have the values y, ``(...)``; the inverse of ``bend``."""
    piece = _Piece(y, _Knots(numbers), axis=1)
    rise, bow = y - piece.y0, piece.d0 + piece.d1 - 2.0 * piece.s
    a = piece.h * (piece.s - piece.d0) + rise * bow
    b = piece.h * piece.d0 - rise * bow
    c = -piece.s * rise
    t = 2.0 * c / (-b - (b * b - 4.0 * a * c).clamp_min(0.0).sqrt())
    return torch.where(piece.inside, piece.x0 + t * piece.w, y)


class _Knots:
    """Knots of splines, and steps on the way to them.

    Bins come before all other axes, so that operations run along memory: over axes as short as
    a spline's, each takes three times as long. A softmax would do for the bins, but takes longest.

    Attributes:
        widths: Of the bins on either axis, unscaled, ``(2, bins, ...)``; ``damped`` as in them.
        ends: Places of the knots, unscaled, ``(2, bins + 1, ...)``, of which the last is ``total``,
            ``(2, ...)``.
        slopes: At the knots, ``(bins + 1, ...)``; ``slope_damped`` as in the inner ones.
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
    """The pieces of splines on which points lie, by their values on an axis: 0 for x, 1 for y."""

    def __init__(self, points: Tensor, knots: _Knots, *, axis: int) -> None:
        place = (points / (2.0 * _BOUND) + 0.5) * knots.total[axis]
        at = (knots.ends[axis, 1:-1] < place).sum(0, keepdim=True)
        self.at, self.both = at, torch.cat([at, at + 1])
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
        """See ``bend``."""
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
        # Of the numerator's share, of the denominator and of the slope's numerator.
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
    """Gradients of the numbers from those of a piece's ends and of the slopes there.

    Args:
        knots, piece: Those of the splines.
        of_ends: Gradients of its knots, ``(2 axes, 2 ends, ...)``.
        of_slopes: Of its slopes, ``(2, ...)``.
    """
    of_ends = of_ends * (2.0 * _BOUND / knots.total).unsqueeze(1)
    # A knot is a share of all bins: a bin moves those behind it one way, and all the other.
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
