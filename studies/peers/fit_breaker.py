"""breaker: the default network and training, steps fitted to the budget."""

import tempfile
from pathlib import Path

import numpy as np
import torch
import xarray as xr

from breaker.model import generator
from breaker.posterior import (
    Checkpoint,
    Posterior,
    Rows,
    Trainer,
    convergence,
    freeze_inputs,
    records,
    split,
)
from breaker.workflow import chosen_network
from studies.peers.common import read_settings

__all__ = ["Breaker"]


class Breaker:
    """The posterior of this package, in standardised outputs."""

    def __init__(self, tool: str) -> None:
        self.tool = tool
        self.configuration = read_settings()
        if tool == "breaker_coupling":
            for network in self.configuration["network"].values():
                network["inference"]["kind"] = "coupling_flow"

    @property
    def unit(self) -> int:
        """Steps between two evaluations."""
        return self._training["evaluate_every"]

    @property
    def _training(self) -> dict:
        return self.configuration["training"]["closing"]

    def settings(self) -> dict:
        """Return what a table has to say about the arm."""
        kind = self.configuration["network"]["closing"]["inference"]["kind"].replace("_", " ")
        used = self._training
        return {
            "estimator": f"{kind} over a conditional Gaussian, config/config.yaml",
            "optimiser": f"{used['optimiser']} {used['learning_rate']}, warm-up, cosine over the "
            f"budget, clip {used['clip']}, EMA {used['ema']}",
            "batch": used["batch"],
            "deviations": "number of steps",
        }

    # Training.

    def train_on(self, bank: xr.Dataset, motion: str, steps: int, seed: int) -> dict:
        """Train on a bank for so many steps."""
        network = chosen_network(self.configuration["network"][motion])
        training = {**self.configuration["training"][motion], "steps": steps}
        training["checkpoint_every"] = steps + 1
        made_from = {key: self.configuration[key] for key in ("prior", "sensor")}
        made_from |= {"motion": motion, "network": network, "training": training, "seed": seed}
        counts = training["validation_curves"], training["held_out_curves"]
        parts = (bank.isel(curve=part) for part in split(bank.sizes["curve"], *counts))
        rows, validation, self.unseen = parts
        self.posterior = Posterior(made_from, seed=seed)
        freeze_inputs(self.posterior, rows, generator(seed, "components", motion))
        device = torch.device("cpu")
        with tempfile.TemporaryDirectory() as folder:
            trainer = Trainer(
                posterior=self.posterior,
                rows=Rows.of(rows, self.posterior, device),
                validation=Rows.of(validation, self.posterior, device),
                settings=training,
                seed=seed,
                checkpoint=Checkpoint(Path(folder) / "state.pt", "benchmark"),
            )
            trainer.run()
        self.seed = seed
        return {
            "curves": steps * training["batch"],
            "parameters": sum(weight.numel() for weight in self.posterior.parameters()),
            "final_loss": float(np.mean(trainer.losses[-200:])),
            "best_validation_loss": trainer.best_loss,
        }

    # Files.

    def save(self, folder: Path) -> None:
        """Choose the solver's steps, which is no part of the training, and write the model."""
        measured = records(self.posterior.eval(), self.unseen, self.seed)
        convergence(self.posterior, measured, self.configuration["solver"], self.seed)
        self.posterior.save(folder / "model.safetensors")

    def load(self, folder: Path, samples: int, outputs: int) -> None:
        """Read the model."""
        self.posterior = Posterior.load(folder / "model.safetensors")

    # Inference: records (o, t), outputs (o, d, q).

    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` with the solver's steps that the training chose."""
        shape = (len(measured), draws, len(self.posterior.outputs))
        noise = np.random.default_rng(seed).standard_normal(shape)
        return self.posterior.model.standardise(self.posterior.sample(measured, noise))

    def sample_with_calls(self, measured: np.ndarray, draws: int, calls: int) -> np.ndarray:
        """Draw ``(o, d, q)`` with so many calls of the velocity network: two a step."""
        if not self.posterior.inference.solves:
            raise NotImplementedError("a coupling flow is one call")
        kept = self.posterior.steps
        self.posterior.solver_steps.fill_(calls // 2)
        found = self.sample(measured, draws, 0)
        self.posterior.solver_steps.fill_(kept)
        return found

    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Log density of ``(o, d, q)`` given records, ``(o, d)``."""
        values = self.posterior.model.destandardise(z)
        return self.posterior.log_prob(values, measured) - self.posterior.model.log_scaling(values)

    def choose_solver(self, measured: np.ndarray, z: np.ndarray) -> str:
        """Say how draws and densities are computed: no differently for many of them."""
        if not self.posterior.inference.solves:
            return "one pass"
        return (
            f"{self.posterior.steps} midpoint steps for draws, {self.posterior.density_steps} for "
            "the density, as chosen after the training"
        )
