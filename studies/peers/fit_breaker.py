"""breaker: a network and training of the configuration, its steps fitted to a budget."""

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
    """The posterior of this package, in standardised outputs.

    Args:
        kind: Inference network, "coupling_flow" or "flow_matching".
    """

    unit = 50

    def __init__(self, kind: str = "coupling_flow", configuration: Mapping | None = None) -> None:
        self.configuration = deepcopy(configuration or defaults())
        self.configuration["network"]["inference"]["kind"] = kind

    def train(self, bank: xr.Dataset, model: Model, steps: int, seed: int) -> None:
        """Train on a bank for so many steps, and choose the solver."""
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
        Trainer(self.posterior, Rows.of(rows, self.posterior), aside, training, seed).run()
        self.posterior.eval()
        some = model.sensor.corrupt(bank.travel.values[-100:], generator(1, "solver"))
        convergence(self.posterior, some, 1)

    def sample(self, measured: np.ndarray, draws: int, seed: int) -> np.ndarray:
        """Draw ``(o, d, q)`` given records ``(o, t)``, mm."""
        shape = (len(measured), draws, len(self.posterior.outputs))
        noise = np.random.default_rng(seed).standard_normal(shape)
        return self.posterior.model.standardise(self.posterior.sample(measured, noise))

    def log_prob(self, measured: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the log density of ``(o, d, q)`` given records, ``(o, d)``."""
        values = self.posterior.model.destandardise(z)
        return self.posterior.log_prob(values, measured) - self.posterior.model.log_scaling(values)
