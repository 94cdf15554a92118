"""Summary networks, and both networks of a posterior from their settings.

A summary network compresses a time series ``(n, t)`` to features ``(n, s)`` (paper, Fig. 2). The
paper uses BayesFlow's TimeSeriesNetwork, which is an LSTNet, too.
"""

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor, nn

from breaker.common.named_functions import load
from breaker.networks.blocks import ResidualMLP
from breaker.networks.coupling_flow import CouplingFlow
from breaker.networks.flow_matching import FlowMatching

INFERENCE_NETWORKS = {"flow_matching": FlowMatching, "coupling_flow": CouplingFlow}


def build(
    settings: Mapping[str, Mapping], *, samples: int, dims: int
) -> tuple[nn.Module, nn.Module]:
    """Build a summary and an inference network from their settings.

    Args:
        settings: ``{"summary": {"kind": ..., **sizes}, "inference": {"kind": ..., **sizes}}``. The
            kind of a summary network is "time_series" or ``module:function``: see ``OwnNetwork``.
        samples: Length t of a series.
        dims: Number q of inferred dimensions.

    Raises:
        ValueError: If a kind is unknown or its sizes do not fit together.
    """
    sizes, inference = dict(settings["summary"]), dict(settings["inference"])
    kind, features = sizes.pop("kind"), sizes["features"]
    if ":" in kind:
        summary = OwnNetwork(load(kind)(samples, features), samples, features)
    elif kind == "time_series":
        summary = TimeSeriesNetwork(samples, **sizes)
    else:
        raise ValueError(f"unknown summary network {kind!r}; known: time_series, module:function")
    kind = inference.pop("kind")
    if kind not in INFERENCE_NETWORKS:
        known = ", ".join(INFERENCE_NETWORKS)
        raise ValueError(f"unknown inference network {kind!r}; known: {known}")
    return summary, INFERENCE_NETWORKS[kind](dims, features, **inference)


class SummaryNetwork(nn.Module):
    """Summary network that scales its input by frozen numbers instead of running moments."""

    def __init__(self, samples: int) -> None:
        super().__init__()
        self.register_buffer("centre", torch.zeros(samples))
        self.register_buffer("scale", torch.ones(()))

    @torch.no_grad()
    def freeze(self, centre: Tensor, scale: Tensor, components: Tensor) -> None:
        """Set the centre ``(t,)`` and the scale ``()`` of the input.

        Args:
            components: Principal components of centred series, ``(t, c)``, as initial weights of
                some networks.
        """
        del components
        self.centre.copy_(centre)
        self.scale.copy_(scale)


class OwnNetwork(SummaryNetwork):
    """Summary network made by a function of the user; its input is centred and scaled.

    Args:
        network: Module that maps ``(n, t)`` to ``(n, s)``, without dropout or batch normalisation,
            because checkpoints contain only weights and the random state of batches.

    Raises:
        ValueError: If the features have another shape.
    """

    def __init__(self, network: nn.Module, samples: int, features: int) -> None:
        super().__init__(samples)
        self.network = network
        with torch.no_grad():
            shape = tuple(network(torch.zeros(2, samples)).shape)
        if shape != (2, features):
            raise ValueError(
                f"network.summary.kind: the network maps (2, {samples}) to {shape}, not to "
                f"(2, {features}); let its last layer have the number of features it is called with"
            )

    def forward(self, x: Tensor) -> Tensor:
        """Map ``(n, t)`` to ``(n, s)``."""
        return self.network((x - self.centre) / self.scale)


class TimeSeriesNetwork(SummaryNetwork):
    """Strided convolutions, GRU, skip GRU and a linear highway, after LSTNet.

    Lai, Chang, Yang & Liu (2018), "Modeling long- and short-term temporal patterns with deep
    neural networks": its recurrent-skip layer connects hidden states at a distance of ``skip``
    steps, and a linear part adds to the non-linear part. Here this highway is a linear map of the
    entire series, and a residual network joins the parts.

    Args:
        samples: Length t of a series.
        features: Number s of features.
        components: Number of outputs of the highway.
        channels, kernels, strides: One entry per convolution, of equal lengths.
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
        super().__init__(samples)
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

    @torch.no_grad()
    def freeze(self, centre: Tensor, scale: Tensor, components: Tensor) -> None:
        """Set the scaling of the input, and initial weights of the highway, ``(t, components)``."""
        super().freeze(centre, scale, components)
        self.highway.weight.copy_(components.T)
        self.highway.bias.zero_()

    def recur(self, steps: Tensor) -> Tensor:
        """Return the last states of both GRUs, ``(n, steps, channels) -> (n, states)``.

        The skip GRU processes each of the ``skip`` interleaved series separately. It omits the
        oldest steps that do not fill a span.
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
