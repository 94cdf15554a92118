"""Summary networks: a time series ``(n, t)`` in, features ``(n, s)`` out."""

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from breaker.networks.blocks import ResidualMLP


class TimeSeriesNetwork(nn.Module):
    """Strided convolutions, GRU, skip GRU and a linear highway, after LSTNet.

    Lai, Chang, Yang & Liu (2018), "Modeling long- and short-term temporal patterns with deep
    neural networks", whose recurrent-skip layer joins hidden states ``skip`` steps apart, and
    whose linear part runs beside the non-linear one. Here the highway is a linear map of the
    whole series, and a residual network joins the parts.

    Inputs are scaled by frozen numbers, never by running moments: see ``freeze``.

    Args:
        samples: Length t of a series.
        features: Number s of features.
        components: Number of outputs of the highway.
        channels, kernels, strides: One entry a convolution, of equal lengths.
        gru_width: Width of the GRU.
        skip: Steps (after the convolutions) that the skip GRU spans.
        skip_width: Width of the skip GRU.
        width, blocks: Size of the residual network that joins the parts.

    Raises:
        ValueError: If the convolutions' settings differ in length, or leave fewer steps than the
            skip GRU spans.
    """

    def __init__(
        self,
        samples: int,
        features: int,
        *,
        components: int,
        channels: Sequence[int],
        kernels: Sequence[int],
        strides: Sequence[int],
        gru_width: int,
        skip: int,
        skip_width: int,
        width: int,
        blocks: int,
    ) -> None:
        super().__init__()
        if not len(channels) == len(kernels) == len(strides):
            raise ValueError("channels, kernels and strides need one entry for each convolution")
        steps, layers = samples, []
        for size_in, size_out, kernel, stride in zip(
            (1, *channels[:-1]), channels, kernels, strides, strict=True
        ):
            layers += [nn.Conv1d(size_in, size_out, kernel, stride), nn.SiLU()]
            steps = (steps - kernel) // stride + 1
        if steps < skip:
            raise ValueError(f"the convolutions leave {steps} steps, fewer than skip = {skip}")
        self.skip = skip
        self.convolutions = nn.Sequential(*layers)
        self.gru = nn.GRU(channels[-1], gru_width, batch_first=True)
        self.skip_gru = nn.GRU(channels[-1], skip_width, batch_first=True)
        self.highway = nn.Linear(samples, components)
        parts = components + gru_width + skip * skip_width
        self.join = ResidualMLP(parts, width, features, blocks=blocks)
        self.register_buffer("centre", torch.zeros(samples))
        self.register_buffer("scale", torch.ones(()))

    @torch.no_grad()
    def freeze(self, centre: Tensor, scale: Tensor, components: Tensor) -> None:
        """Set the input's frozen centre ``(t,)`` and scale ``()``, and where the highway starts.

        Args:
            components: First weights of the highway, ``(t, components)``, for centred input.
        """
        self.centre.copy_(centre)
        self.scale.copy_(scale)
        self.highway.weight.copy_(components.T)
        self.highway.bias.zero_()

    def recur(self, steps: Tensor) -> Tensor:
        """Last states of both GRUs, ``(n, steps, channels) -> (n, gru_width + skip skip_width)``.

        The skip GRU sees each of the ``skip`` interleaved series by itself; the oldest steps that
        do not fill a whole span are left out.
        """
        n, length, channels = steps.shape
        spans = length // self.skip
        interleaved = steps[:, length - spans * self.skip :].reshape(n, spans, self.skip, channels)
        series = interleaved.transpose(1, 2).reshape(n * self.skip, spans, channels)
        last = self.gru(steps)[1][0]
        skipped = self.skip_gru(series)[1][0]
        return torch.cat([last, skipped.reshape(n, -1)], dim=1)

    def forward(self, x: Tensor) -> Tensor:
        """Map ``(n, t)`` to ``(n, s)``."""
        centred = x - self.centre
        steps = self.convolutions((centred / self.scale).unsqueeze(1)).transpose(1, 2)
        return self.join(torch.cat([self.highway(centred), self.recur(steps)], dim=1))
