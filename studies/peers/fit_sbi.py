"""sbi: neural posterior estimation with a spline flow, and flow matching, both behind a CNN.

Estimators, their sizes and the optimiser are sbi's defaults (Adam 5e-4, batch 200, norm of the
gradient clipped at 5, no schedule, the weights of the best validation kept). The loop around the
estimator's own loss is ours, for sbi trains on a fixed data set in memory: here every batch gets
fresh noise and a fresh zero, as everywhere else.
"""

import copy

import numpy as np
import torch
import xarray as xr
from sbi.inference.posteriors import DirectPosterior, VectorFieldPosterior
from sbi.neural_nets import posterior_flow_nn, posterior_nn
from sbi.neural_nets.embedding_nets import CNNEmbedding
from torch import Tensor
from torch.distributions import MultivariateNormal

from breaker.common.randomness import seed_integer
from breaker.paper.joint_model import Model
from studies.peers.common import truth

_BATCH, _RATE, _CLIP = 200, 5e-4, 5.0
_EVERY = 100  # steps between two evaluations on the validation rows
_SET_ASIDE = 1024  # of them
_TIMES = 10  # of flow matching's validation, as in sbi
_Z_SCORES = 10_000  # records that the z-scores are taken from


class Sbi:
    """One estimator of sbi, in standardised outputs.

    Args:
        arm: "sbi_npe" or "sbi_fmpe".
    """

    unit = _EVERY

    def __init__(self, arm: str) -> None:
        self.flow_matching = arm == "sbi_fmpe"

    # Training.

    def settings(self) -> dict:
        """Return what a table has to say about the arm."""
        estimator = "posterior_flow_nn('mlp')" if self.flow_matching else "posterior_nn('nsf')"
        return {
            "estimator": f"{estimator}, CNNEmbedding, all sizes as by default",
            "optimiser": f"Adam {_RATE}, no schedule, clip {_CLIP}",
            "batch": _BATCH,
            "deviations": "fresh noise in every batch, by a loop around the estimator's loss; "
            f"best of the validations every {_EVERY} steps instead of every epoch",
        }

    def train(self, bank: xr.Dataset, model: Model, steps: int, seed: int) -> dict:
        """Train on a bank for so many steps."""
        torch.manual_seed(seed_integer(seed, "sbi"))
        travel, z = torch.from_numpy(bank.travel.values), torch.from_numpy(truth(bank, model))
        z, self.sensor = z.float(), model.sensor
        first = torch.arange(_Z_SCORES)
        self._build(z[first], self._records(travel[first]))
        aside = slice(-_SET_ASIDE, None)
        validation = z[aside], self._records(travel[aside])
        optimiser = torch.optim.Adam(self.estimator.parameters(), lr=_RATE)
        losses, best = [], (np.inf, None)
        for step in range(1, steps + 1):
            rows = torch.randint(len(z) - _SET_ASIDE, (_BATCH,))
            optimiser.zero_grad()
            loss = self.estimator.loss(z[rows], self._records(travel[rows])).mean()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(self.estimator.parameters(), _CLIP)
            optimiser.step()
            losses.append(loss.item())
            if step % _EVERY == 0 or step == steps:
                judged = self._validate(*validation)
                if judged < best[0]:
                    best = judged, copy.deepcopy(self.estimator.state_dict())
        self.estimator.load_state_dict(best[1])
        self.estimator.eval()
        return {
            "curves": steps * _BATCH,
            "parameters": sum(weight.numel() for weight in self.estimator.parameters()),
            "final_loss": float(np.mean(losses[-200:])),
            "best_validation_loss": best[0],
        }

    def _records(self, travel: Tensor) -> Tensor:
        noise = self.sensor.noise_sd * torch.randn(travel.shape)
        return travel + noise + self.sensor.zero_sd * torch.randn(len(travel), 1)

    def _build(self, z: Tensor, records: Tensor) -> None:
        embedding = CNNEmbedding(input_shape=(records.shape[1],))
        if self.flow_matching:
            build = posterior_flow_nn("mlp", embedding_net=embedding)
        else:
            build = posterior_nn("nsf", embedding_net=embedding)
        self.estimator = build(z, records)
        # Unbounded: like every other arm, nothing is rejected outside the prior's support.
        prior = MultivariateNormal(torch.zeros(z.shape[1]), torch.eye(z.shape[1]))
        if self.flow_matching:
            self.posterior = VectorFieldPosterior(self.estimator, prior, sample_with="ode")
        else:
            self.posterior = DirectPosterior(self.estimator, prior)

    @torch.no_grad()
    def _validate(self, z: Tensor, records: Tensor) -> float:
        """Loss on fixed records; flow matching's at fixed times with fixed start points."""
        if not self.flow_matching:
            return self.estimator.loss(z, records).mean().item()
        times = torch.linspace(0.05, 0.95, _TIMES)
        with torch.random.fork_rng():
            torch.manual_seed(0)
            losses = [self.estimator.loss(z, records, times=t.expand(len(z))) for t in times]
        return torch.stack(losses).mean().item()

    # Inference: records (o, t), outputs (o, d, q).

    @torch.no_grad()
    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` with the defaults of the tool."""
        torch.manual_seed(seed)
        x = torch.from_numpy(measured).float()
        found = self.posterior.sample_batched((draws,), x=x, show_progress_bars=False)
        return found.transpose(0, 1).double().numpy()

    @torch.no_grad()
    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Log density of ``(o, d, q)`` given records, ``(o, d)``, with the tool's defaults."""
        x = torch.from_numpy(measured).float()
        z = torch.from_numpy(z).float().transpose(0, 1)
        if self.flow_matching:
            self.posterior.potential_fn.set_x(x)
            density = self.posterior.potential_fn.flow.log_prob(z)
        else:
            density = self.estimator.log_prob(z, x)
        return density.T.double().numpy()

    def choose_solver(self, measured: np.ndarray, z: np.ndarray) -> str:
        """Say how draws and densities are computed: no differently for many of them."""
        return "the default"
