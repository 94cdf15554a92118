"""The posterior network of one motion: scaling by the prior, summary network, inference network.

Paper, Sec. 2 and 4 (Fig. 2): a summary network compresses a record, and an inference network, given
the summary, maps normal noise to posterior draws. Only this module connects networks and breaker:
the networks get the standardised outputs of ``joint_model.Model``.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Self

import numpy as np
import torch
from torch import Tensor, nn

from breaker.common.randomness import seed_integer
from breaker.common.tensor_file import ModelFileError, SavedModel, open_model, write_model
from breaker.model.parameters import Parameter
from breaker.model.sensor import Sensor
from breaker.networks.summary import build
from breaker.paper.bank import distance, excess
from breaker.paper.joint_model import Model

_MOST_STEPS = 1000  # solver steps that a file may ask for; limits the time of a draw


class Posterior(nn.Module):
    """Posterior of the parameters given a measured curve.

    Args:
        settings: ``{"motion", "model", "prior", "sensor", "network"}``, as in the configuration;
            further entries are kept, to document the training.
        seed: Seed of the initial weights.

    Attributes:
        model: Joint model of the network; ``sensor``, ``motion`` and ``outputs`` are the model's.
        name: Name of the training.
        solver_steps, density_solver_steps: Steps of the solver for sampling and for the density,
            chosen at the end of the training so that both converge. The density needs more steps,
            because importance weights need a smaller error.
    """

    def __init__(self, settings: Mapping, *, seed: int = 0) -> None:
        super().__init__()
        self.settings = dict(settings)
        self.model = Model.from_settings(settings)
        self.sensor: Sensor = self.model.sensor
        self.name = self.motion = self.model.motion
        self.outputs: tuple[Parameter, ...] = self.model.outputs
        samples, components = self.sensor.samples, settings["network"]["summary"]["components"]
        # Layers take initial weights from torch's global generator: fork it, so the seed decides.
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed_integer(seed, "first weights", self.motion))
            self.summary, self.inference = build(
                settings["network"], samples=samples, dims=len(self.outputs)
            )
        # Statistics of the bank's curves, in float64, for ``distance``.
        sizes = {"curve_mean": (samples,), "curve_weights": (samples, components)}
        sizes |= {"farthest": (), "margin": (), "lowest": (samples,), "highest": (samples,)}
        for name, size in sizes.items():
            self.register_buffer(name, torch.zeros(size, dtype=torch.float64))
        for name in ("solver_steps", "density_solver_steps"):
            self.register_buffer(name, torch.ones((), dtype=torch.int64))

    # Training, sampling, density.

    def loss(self, measured: Tensor, z: Tensor, noise: Tensor, time: Tensor) -> Tensor:
        """Return the loss of each row, ``(n,)``.

        Args:
            measured: Records, ``(n, t)``, mm.
            z: Standardised outputs, ``(n, q)``.
            noise, time: As in ``FlowMatching.loss``, ``(n, k, q)`` and ``(n, k, 1)``.
        """
        return self.inference.loss(z, self.summary(measured), noise, time)

    def validation_loss(self, measured: Tensor, z: Tensor, noise: Tensor, time: Tensor) -> Tensor:
        """Return the negative log density of each row, ``(n,)``; arguments as for ``loss``."""
        features = self.summary(measured)
        # Eight steps suffice to rank weights; ``training.convergence`` chooses the final numbers.
        return -self.inference.log_prob(z[:, None], features, steps=8)[:, 0]

    @torch.no_grad()
    def sample(self, measured: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """Draw from the posterior, one record at a time, so that draws do not depend on others.

        Args:
            measured: Records, ``(o, t)``, mm.
            noise: Standard normal numbers, ``(o, d, q)``.

        Returns:
            Draws in physical units, ``(o, d, q)``, float64. Some may lie outside the prior's
            support, which the network learns only from examples.

        Raises:
            ValueError: If the network does not accept a record; the message states the remedy.
            FloatingPointError: If a draw is not finite.
        """
        self._check(measured)
        draws = np.empty(noise.shape)
        for i, (record, start) in enumerate(zip(measured, noise, strict=True)):
            features = self.summary(self._tensor(record[None]))
            z = self.inference.sample(
                self._tensor(start[None]), features, steps=self.solver_steps.item()
            )[0]
            with np.errstate(over="ignore"):  # infinite draws are counted below
                draws[i] = self.model.destandardise(z.cpu().numpy())
        bad = ~np.isfinite(draws).all(axis=(1, 2))
        if bad.any():
            raise FloatingPointError(
                f"the draws of {bad.sum()} of {len(bad)} curves are not finite"
            )
        return draws

    @torch.no_grad()
    def log_prob(self, values: np.ndarray, measured: np.ndarray) -> np.ndarray:
        """Return the network's log density in physical units, ``(o, d, q), (o, t) -> (o, d)``."""
        self._check(measured)
        density = np.empty(values.shape[:2])
        for i, points in enumerate(values):
            z = self._tensor(self.model.standardise(points[None]))
            features = self.summary(self._tensor(measured[i : i + 1]))
            prob = self.inference.log_prob(z, features, steps=self.density_solver_steps.item())
            density[i] = prob[0].cpu().numpy()
        return density + self.model.log_scaling(values)

    def distance(self, measured: np.ndarray) -> np.ndarray:
        """Return the distance of records from the bank's curves, ``(o, t) -> (o,)``.

        This is the larger of the distances from the bank's centre and from its envelope, in units
        of the largest ones that the prior produces. A value above 1 is unlike any record of it.
        """
        self._check(measured)
        names = ("curve_mean", "curve_weights", "lowest", "highest")
        mean, weights, lowest, highest = (getattr(self, name).cpu().numpy() for name in names)
        far = distance(measured, mean, weights) / float(self.farthest)
        return np.maximum(far, excess(measured, lowest, highest) / float(self.margin))

    def _check(self, measured: np.ndarray) -> None:
        """Raise a ValueError for records ``(o, t)``, mm, that the network does not accept."""
        samples = self.sensor.samples
        if measured.ndim != 2 or measured.shape[1] != samples:
            raise ValueError(f"records must have the shape (o, {samples}), not {measured.shape}")
        for fault, bad in (("infinite", np.isinf(measured)), ("missing", np.isnan(measured))):
            if count := bad.any(axis=1).sum():
                raise ValueError(
                    f"{count} of {len(measured)} records have {fault} samples, which the network "
                    f"of {self.motion} does not accept; fill them in, or leave these records out"
                )

    def _tensor(self, values: np.ndarray) -> Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self.curve_mean.device)

    # Model files.

    def save(self, path: str | Path) -> None:
        """Write the model file."""
        weights = {name: weight.cpu().numpy() for name, weight in self.state_dict().items()}
        write_model(path, self.settings, weights)

    @classmethod
    def load(cls, path: str | Path, *, own_functions: bool = False) -> Self:
        """Read a model file, ready for inference.

        Args:
            own_functions: Whether to import and call functions that the file names (your own prior,
                simulator or summary network). Set it only for a file that you trust.

        Raises:
            FileNotFoundError: If there is no such file.
            ModelFileError: If it is not a model file, has another format, contains tensors that do
                not fit its settings, or names functions that are missing or not allowed.
        """
        with open_model(path) as saved:
            named = _functions(saved.settings)
            if named and not own_functions:
                raise ValueError(
                    f"it calls {', '.join(named)}; if you trust the file, load it with "
                    "Posterior.load(path, own_functions=True)"
                )
            with torch.device("meta"):  # shapes only, without memory
                posterior = cls(saved.settings)
            weights = _weights(saved, posterior.state_dict())
            posterior.load_state_dict(weights, assign=True)
        return posterior.eval()


def _functions(settings: Mapping) -> list[str]:
    """Return the functions, as ``module:function``, that the settings of a model name."""
    own = settings.get("model") or {}
    named = [own.get("prior"), own.get("simulator"), settings["network"]["summary"]["kind"]]
    return [text for text in named if isinstance(text, str) and ":" in text]


def _weights(saved: SavedModel, wanted: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return the tensors of a file; raise an error for a wrong type or a value not finite."""
    weights = {}
    for name in saved.arrays:
        array = saved.weight(name, str(wanted[name].dtype).removeprefix("torch."))
        if name.endswith("solver_steps") and not 1 <= array.item() <= _MOST_STEPS:
            raise ModelFileError(f"{name} is {array.item()}, but must be from 1 to {_MOST_STEPS}")
        # Copy to torch's memory, aligned like the weights of a network in training.
        weights[name] = torch.from_numpy(array).clone(memory_format=torch.contiguous_format)
    return weights
