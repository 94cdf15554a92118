"""Neural networks: summary networks and conditional densities. They know nothing of breakers.

A summary network maps ``(n, t)`` to features ``(n, s)`` and has ``freeze``; an inference network
has ``loss``, ``sample`` and ``log_prob``, each with the shapes of ``FlowMatching``. A new kind is
one entry in a table below.
"""

from collections.abc import Mapping

from torch import nn

from breaker.networks.flow_matching import FlowMatching
from breaker.networks.summary import TimeSeriesNetwork

__all__ = ["INFERENCE_NETWORKS", "SUMMARY_NETWORKS", "build"]

SUMMARY_NETWORKS = {"time_series": TimeSeriesNetwork}
INFERENCE_NETWORKS = {"flow_matching": FlowMatching}


def build(
    settings: Mapping[str, Mapping], *, samples: int, dims: int
) -> tuple[nn.Module, nn.Module]:
    """Build a summary and an inference network from their settings.

    Args:
        settings: ``{"summary": {"kind": ..., **sizes}, "inference": {"kind": ..., **sizes}}``.
        samples: Length t of a series.
        dims: Number q of dimensions of what is inferred.

    Raises:
        ValueError: If a kind is unknown or its sizes do not fit together.
    """
    networks = []
    for role, table in (("summary", SUMMARY_NETWORKS), ("inference", INFERENCE_NETWORKS)):
        sizes = dict(settings[role])
        kind = sizes.pop("kind")
        if kind not in table:
            raise ValueError(f"unknown {role} network {kind!r}; known: {', '.join(table)}")
        networks.append((table[kind], sizes))
    (summary, summary_sizes), (inference, inference_sizes) = networks
    features = summary_sizes["features"]
    return summary(samples, **summary_sizes), inference(dims, features, **inference_sizes)
