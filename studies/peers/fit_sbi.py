"""sbi: neural posterior estimation with a spline flow behind a CNN.

Estimator, sizes and optimiser are sbi's defaults (Adam 5e-4, batch 200, norm of the gradient
clipped at 5, no schedule, the weights of the best validation). The loop around the estimator's loss
is ours, for sbi trains on a fixed data set: here every batch gets fresh noise and a fresh zero.
"""

import copy

import numpy as np
import torch
import xarray as xr
from sbi.inference.posteriors import DirectPosterior
from sbi.neural_nets import posterior_nn
from sbi.neural_nets.embedding_nets import CNNEmbedding
from torch import Tensor
from torch.distributions import MultivariateNormal

from breaker.common.randomness import seed_integer
from breaker.paper.bank import truth
from breaker.paper.joint_model import Model

_BATCH, _RATE, _CLIP = 200, 5e-4, 5.0
_SET_ASIDE = 1024  # rows for validation


class Sbi:
    """An estimator of sbi, in standardised outputs."""

    unit = 100  # steps between two validations

    def train(self, bank: xr.Dataset, model: Model, steps: int, seed: int) -> None:
        """Train on a bank for so many steps."""
        torch.manual_seed(seed_integer(seed, "sbi"))
        z = torch.from_numpy(model.standardise(truth(bank, model))).float()
        travel, self.sensor = torch.from_numpy(bank.travel.values), model.sensor
        embedding = CNNEmbedding(input_shape=(travel.shape[1],))
        some = slice(10_000)  # for the z-scores
        self.estimator = posterior_nn("nsf", embedding_net=embedding)(
            z[some], self._records(travel[some])
        )
        aside = slice(-_SET_ASIDE, None)
        validation = z[aside], self._records(travel[aside])
        optimiser = torch.optim.Adam(self.estimator.parameters(), lr=_RATE)
        best = np.inf, None
        for step in range(1, steps + 1):
            rows = torch.randint(len(z) - _SET_ASIDE, (_BATCH,))
            optimiser.zero_grad()
            self.estimator.loss(z[rows], self._records(travel[rows])).mean().backward()
            torch.nn.utils.clip_grad_norm_(self.estimator.parameters(), _CLIP)
            optimiser.step()
            if step % self.unit == 0 or step == steps:
                with torch.no_grad():
                    judged = self.estimator.loss(*validation).mean().item()
                if judged < best[0]:
                    best = judged, copy.deepcopy(self.estimator.state_dict())
        self.estimator.load_state_dict(best[1])
        self.estimator.eval()
        # Unbounded: like every other arm, nothing is rejected outside the prior's support.
        prior = MultivariateNormal(torch.zeros(z.shape[1]), torch.eye(z.shape[1]))
        self.posterior = DirectPosterior(self.estimator, prior)

    def _records(self, travel: Tensor) -> Tensor:
        noise = self.sensor.noise_sd * torch.randn(travel.shape)
        return (travel + noise + self.sensor.zero_sd * torch.randn(len(travel), 1)).float()

    @torch.no_grad()
    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` given records ``(o, t)``, mm."""
        torch.manual_seed(seed)
        x = torch.from_numpy(measured).float()
        drawn = self.posterior.sample_batched((draws,), x=x, show_progress_bars=False)
        return drawn.transpose(0, 1).double().numpy()

    @torch.no_grad()
    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the log density of ``(o, d, q)`` given records, ``(o, d)``."""
        x, z = torch.from_numpy(measured).float(), torch.from_numpy(z).float()
        return self.estimator.log_prob(z.transpose(0, 1), x).T.double().numpy()
