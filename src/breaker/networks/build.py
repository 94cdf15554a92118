"""Neural networks: summary networks and conditional densities. They know nothing of breakers.

A summary network maps records ``(n, t)`` to features ``(n, s)``. It has ``freeze``, and
``missing``, the largest share of samples that may be NaN, in training and after. An inference
network has ``loss``, ``sample`` and ``log_prob`` with the shapes of ``FlowMatching``, and
``solves``: whether it takes solver steps. A new kind is one entry in a table below.
"""

from collections.abc import Mapping
from functools import partial

from torch import nn

from breaker.networks.coupling_flow import CouplingFlow
from breaker.networks.flow_matching import FlowMatching
from breaker.networks.summary import TimeSeriesNetwork

SUMMARY_NETWORKS = {"time_series": TimeSeriesNetwork}
INFERENCE_NETWORKS = {"flow_matching": FlowMatching, "coupling_flow": CouplingFlow}


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
        networks.append(partial(table[kind], **sizes))
    summary, inference = networks
    return summary(samples), inference(dims, settings["summary"]["features"])
