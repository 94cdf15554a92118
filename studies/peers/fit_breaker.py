"""breaker: the default network and training, steps fitted to the budget."""

from collections.abc import Mapping
from copy import deepcopy

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.configuration.loading import defaults, of_motion
from breaker.networks.training import Trainer
from breaker.paper.joint_model import Model
from breaker.paper.posterior import Posterior
from breaker.paper.training import Rows, convergence, freeze_inputs, split


class Breaker:
    """The posterior of this package, in standardised outputs."""

    unit = 50

    def __init__(self, arm: str, configuration: Mapping | None = None) -> None:
        self.kind = arm.removeprefix("breaker_")
        self.configuration = deepcopy(configuration or defaults())
        self.configuration["network"]["inference"]["kind"] = self.kind

    def settings(self) -> dict:
        """Return what a table has to say about the arm."""
        used = self.configuration["training"]
        return {
            "estimator": f"{self.kind.replace('_', ' ')}, config/advanced.yaml",
            "optimiser": f"{used['optimiser']} {used['learning_rate']}, warm-up, cosine over the "
            f"budget, clip {Trainer.clip:g}, EMA {Trainer.ema}",
            "batch": used["batch"],
            "deviations": "none but the number of steps",
        }

    # Training.

    def train(self, bank: xr.Dataset, model: Model, steps: int, seed: int) -> dict:
        """Train on a bank for so many steps."""
        motion = model.motion
        own = of_motion(self.configuration, motion)
        network, training = own["network"], {**own["training"], "steps": steps}
        made_from = {key: self.configuration[key] for key in ("prior", "sensor")}
        made_from |= {"motion": motion, "network": network, "training": training, "seed": seed}
        parts = split(bank.sizes["curve"], training["validation_curves"])
        rows, validation = (bank.isel(curve=part) for part in parts)
        self.posterior = Posterior(made_from, seed=seed)
        freeze_inputs(self.posterior, rows, generator(seed, "components", motion))
        aside = Rows.of(validation, self.posterior)
        trainer = Trainer(self.posterior, Rows.of(rows, self.posterior), aside, training, seed)
        trainer.run()
        self.posterior.eval()
        return {
            "curves": steps * training["batch"],
            "parameters": sum(weight.numel() for weight in self.posterior.parameters()),
            "final_loss": float(np.mean(trainer.losses[-200:])),
            "best_validation_loss": trainer.best_loss,
        }

    # Inference: records (o, t), outputs (o, d, q).

    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` with the solver's steps that the training chose."""
        shape = (len(measured), draws, len(self.posterior.outputs))
        noise = np.random.default_rng(seed).standard_normal(shape)
        return self.posterior.model.standardise(self.posterior.sample(measured, noise))

    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Log density of ``(o, d, q)`` given records, ``(o, d)``."""
        values = self.posterior.model.destandardise(z)
        return self.posterior.log_prob(values, measured) - self.posterior.model.log_scaling(values)

    def choose_solver(self, measured: np.ndarray, z: np.ndarray | None = None) -> str:
        """Choose the solver's steps as the package does after its training."""
        del z  # draws are compared instead
        convergence(self.posterior, measured, 1)
        if not self.posterior.inference.solves:
            return "one pass"
        steps = self.posterior.steps, self.posterior.density_steps
        return f"midpoint, {steps[0]} steps for draws, {steps[1]} for the density"
