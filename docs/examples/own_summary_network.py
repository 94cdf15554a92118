"""A summary network of your own: a deep set, a mean over pairs of time and travel.

In the configuration: ``network: {summary: {kind: own_summary_network:DeepSet}}``
"""

import torch
from torch import nn


class DeepSet(nn.Module):
    """Map centred and scaled records (n, t) to features (n, s)."""

    def __init__(self, samples, features):
        super().__init__()
        self.register_buffer("times", torch.linspace(-1.0, 1.0, samples))
        self.pair = nn.Sequential(nn.Linear(2, 64), nn.SiLU(), nn.Linear(64, 64))
        self.join = nn.Sequential(nn.SiLU(), nn.Linear(64, features))

    def forward(self, records):
        pairs = torch.stack([self.times.expand_as(records), records], dim=-1)
        return self.join(self.pair(pairs).mean(dim=1))
