"""Batches of records from a bank: fresh noise and a fresh zero every time a row is drawn."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
import xarray as xr
from torch import Tensor

from breaker.common.randomness import generator
from breaker.networks.training import DrawnRows
from breaker.paper.bank import distance, excess, principal_components, simulate, truth
from breaker.paper.posterior import Posterior

_ROWS_FOR_COMPONENTS = 65536  # more change no weight visibly


def split(curves: int, *counts: int) -> list[slice]:
    """Split the rows of a bank into the first ones and, from the end, parts of the sizes given."""
    ends = np.cumsum([curves - sum(counts), *counts]).tolist()
    return [slice(i, j) for i, j in zip([0, *ends[:-1]], ends, strict=True)]


class Batch(NamedTuple):
    """What ``Posterior.loss`` takes, in its order.

    Attributes:
        measured: Records, ``(n, t)``, mm.
        z: Standardised outputs, ``(n, q)``.
        noise, time: Start points ``(n, 1, q)`` and times ``(n, 1, 1)`` of flow matching.
    """

    measured: Tensor
    z: Tensor
    noise: Tensor
    time: Tensor


@dataclass
class Rows(DrawnRows):
    """Rows of a bank, on the device of a training.

    Attributes:
        travel: Noise-free curves, ``(n, t)``, mm.
        z: Standardised outputs, ``(n, q)``.
        noise_sd, zero_sd: Errors of the sensor, mm.
    """

    travel: Tensor
    z: Tensor
    noise_sd: float
    zero_sd: float

    @classmethod
    def of(
        cls, bank: xr.Dataset, posterior: Posterior, device: torch.device | str = "cpu"
    ) -> "Rows":
        """Take the rows of a bank for a posterior, onto the device that it is on."""
        z = posterior.model.standardise(truth(bank, posterior.model))
        return cls(
            travel=torch.as_tensor(bank.travel.values, dtype=torch.float32, device=device),
            z=torch.as_tensor(z, dtype=torch.float32, device=device),
            noise_sd=posterior.sensor.noise_sd,
            zero_sd=posterior.sensor.zero_sd,
        )

    def __len__(self) -> int:
        return len(self.z)

    def draw(self, rows: Tensor, rng: torch.Generator) -> Batch:
        """Return a batch for ``Posterior.loss``."""
        device = self.travel.device
        n, q = len(rows), self.z.shape[1]
        travel = self.travel[rows]
        error = self.noise_sd * torch.randn(travel.shape, generator=rng, device=device)
        zero = self.zero_sd * torch.randn((n, 1), generator=rng, device=device)
        noise = torch.randn((n, 1, q), generator=rng, device=device)
        time = torch.rand((n, 1, 1), generator=rng, device=device)
        return Batch(travel + error + zero, self.z[rows], noise, time)


@dataclass
class OnlineRows:
    """Rows that are simulated for the batch that takes them: no row is seen twice.

    Attributes:
        posterior: What is trained.
        device: Of the training.
    """

    posterior: Posterior
    device: torch.device | str = "cpu"

    def batch(self, step: int, n: int, rng: torch.Generator) -> Batch:
        """Return the batch of ``n`` rows of any step of a training."""
        del step
        seed = torch.randint(2**62, (), generator=rng, device=rng.device).item()
        bank = simulate(self.posterior.model, n, np.random.default_rng(seed))
        rows = Rows.of(bank, self.posterior, self.device)
        return rows.draw(torch.arange(n, device=rng.device), rng)


def freeze_inputs(posterior: Posterior, rows: xr.Dataset, rng: np.random.Generator) -> None:
    """Set what a posterior takes from the bank once: scales, components, the farthest curve.

    Args:
        rows: Rows of the bank.
        rng: Generator of their noise. The records' distance from the bank's centre, and how far
            they leave its envelope, at their 0.9999 quantiles, are the farthest that the prior
            produces.
    """
    rows = rows.isel(curve=slice(_ROWS_FOR_COMPONENTS))
    travel, sensor = rows.travel.values.astype(np.float64), posterior.sensor
    mean, weights = principal_components(travel, sensor, posterior.curve_weights.shape[1])
    lowest, highest = travel.min(axis=0), travel.max(axis=0)
    records = sensor.corrupt(travel, rng)
    frozen = {
        "curve_mean": mean,
        "curve_weights": weights,
        "farthest": np.quantile(distance(records, mean, weights), 0.9999),
        "lowest": lowest,
        "highest": highest,
        # At least the noise: a small bank's records may leave its envelope by less.
        "margin": max(sensor.noise_sd, np.quantile(excess(records, lowest, highest), 0.9999)),
    }
    for name, value in frozen.items():
        getattr(posterior, name).copy_(torch.as_tensor(np.array(value), dtype=torch.float64))
    scale = torch.as_tensor(np.std(travel - mean))
    posterior.summary.freeze(posterior.curve_mean, scale, posterior.curve_weights)


# ---- solver steps ----


_DIFFERENCES = ("mean_difference", "max_difference", "density_difference")
_DENSITY_EVERY = 5  # draw of a curve whose density is compared: a density costs more than a draw


def records(posterior: Posterior, rows: xr.Dataset, seed: int) -> np.ndarray:
    """Make records ``(n, t)``, mm, of bank rows: with all that is added to an exact curve."""
    rng = generator(seed, "held out", posterior.motion)
    return posterior.sensor.corrupt(rows.travel.values.astype(np.float64), rng)


def held_out_log_density(
    posterior: Posterior, measured: np.ndarray, rows: xr.Dataset
) -> tuple[float, float]:
    """Return the mean log density of the truth of rows, and its standard error.

    In standardised outputs, so that it does not depend on units: nats above the prior's scale.
    """
    values = truth(rows, posterior.model)[:, None]
    density = posterior.log_prob(values, measured)[:, 0] - posterior.model.log_scaling(values)[:, 0]
    return float(density.mean()), float(density.std(ddof=1) / np.sqrt(len(density)))


def convergence(
    posterior: Posterior, measured: np.ndarray, settings: Mapping, seed: int
) -> xr.Dataset:
    """Choose the number of solver steps: the fewest that agree with a fine solver.

    Draws from the same noise with each candidate are compared with the finest, in posterior
    standard deviations of standardised outputs; log densities of some of the finest draws, in
    nats. The posterior's steps for either are set to the fewest whose mean absolute difference is
    within the tolerance: importance weights ask more of a density than a figure asks of draws.

    An inference network without a solver takes one step, and nothing is compared.

    Args:
        measured: Records, ``(n, t)``, mm.
        settings: The section ``solver`` of the configuration.

    Returns:
        Dataset over ``solver_steps`` with ``mean_difference``, ``max_difference`` and
        ``density_difference``, and the attributes ``solves``, 0 for a network without a solver,
        whose differences are zero by construction, ``chosen_steps``, ``chosen_density_steps`` and
        ``reference_steps``.

    Raises:
        ValueError: If no candidate is within a tolerance.
    """
    if posterior.inference.solves:
        candidates, reference = sorted(settings["candidates"]), settings["reference"]
        differences = _differences(posterior, measured, candidates, settings, seed)
        chosen = [
            _fewest(candidates, differences[row], settings[key], key)
            for row, key in ((0, "tolerance"), (2, "density_tolerance"))
        ]
    else:
        candidates, reference, differences, chosen = [1], 1, np.zeros((3, 1)), [1, 1]
    posterior.solver_steps.fill_(chosen[0])
    posterior.density_solver_steps.fill_(chosen[1])
    return xr.Dataset(
        {name: ("solver_steps", row) for name, row in zip(_DIFFERENCES, differences, strict=True)},
        coords={"solver_steps": candidates},
        attrs={
            "solves": int(posterior.inference.solves),
            "chosen_steps": chosen[0],
            "chosen_density_steps": chosen[1],
            "reference_steps": reference,
        },
    )


def _differences(
    posterior: Posterior,
    measured: np.ndarray,
    candidates: list[int],
    settings: Mapping,
    seed: int,
) -> np.ndarray:
    """Differences from the finest solver, as named in ``_DIFFERENCES``, ``(3, candidates)``."""
    measured = measured[: settings["curves"]]
    rng = generator(seed, "solver", posterior.motion)
    noise = rng.standard_normal((len(measured), settings["draws"], len(posterior.outputs)))

    def draw(steps: int) -> np.ndarray:
        posterior.solver_steps.fill_(steps)
        return posterior.model.standardise(posterior.sample(measured, noise))

    def density(steps: int) -> np.ndarray:
        posterior.density_solver_steps.fill_(steps)
        return posterior.log_prob(points, measured)

    finest = draw(settings["reference"])
    spread = finest.std(axis=1, ddof=1, keepdims=True)
    points = posterior.model.destandardise(finest[:, ::_DENSITY_EVERY])
    finest_density = density(settings["reference"])
    columns = []
    for steps in candidates:
        of_draws = np.abs(draw(steps) - finest) / spread
        of_density = np.abs(density(steps) - finest_density)
        columns.append((of_draws.mean(), of_draws.max(), of_density.mean()))
    return np.transpose(columns)


def _fewest(candidates: list[int], differences: np.ndarray, tolerance: float, key: str) -> int:
    good = np.flatnonzero(differences <= tolerance)
    if good.size == 0:
        raise ValueError(
            f"no candidate of solver.candidates is within solver.{key} = {tolerance}; the best "
            f"differs by {differences.min():.3g}: allow more steps"
        )
    return candidates[good[0]]
