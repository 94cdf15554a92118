"""Training data of the networks, and the choice of solver steps after a training (paper, Sec. 4).

A record is a bank's curve plus noise and a zero, which are drawn again every time a row is drawn.
The trainer, ``networks.training``, does not depend on the data. After the training, the number of
solver steps is chosen, and the log density of held-out rows is computed.
"""

from collections.abc import Sequence
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

_ROWS_FOR_COMPONENTS = 65536  # more rows do not change the components visibly


def split(curves: int, *counts: int) -> list[slice]:
    """Split the rows of a bank into first rows and parts of sizes ``counts`` at the end."""
    ends = np.cumsum([curves - sum(counts), *counts]).tolist()
    return [slice(i, j) for i, j in zip([0, *ends[:-1]], ends, strict=True)]


class Batch(NamedTuple):
    """Arguments of ``Posterior.loss``. Each start point comes with its mirror image at the same
    time, so that most of the noise in flow matching's gradient cancels.
    """

    measured: Tensor  # records (n, t), mm
    z: Tensor  # standardised outputs (n, q)
    noise: Tensor  # start points (n, 2, q)
    time: Tensor  # their times (n, 2, 1)


@dataclass
class Rows(DrawnRows):
    """Rows of a bank on the device of a training.

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
        """Convert the rows of a bank to rows of a posterior on ``device``."""
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
        """Return a batch of ``rows`` for ``Posterior.loss``."""
        n, travel, where = len(rows), self.travel[rows], {"device": self.travel.device}
        error = self.noise_sd * torch.randn(travel.shape, generator=rng, **where)
        zero = self.zero_sd * torch.randn((n, 1), generator=rng, **where)
        noise = torch.randn((n, 1, self.z.shape[1]), generator=rng, **where)
        time = torch.rand((n, 1, 1), generator=rng, **where)
        pair = torch.cat([noise, -noise], 1)
        return Batch(travel + error + zero, self.z[rows], pair, time.expand(n, 2, 1))


@dataclass
class OnlineRows(DrawnRows):
    """Rows that are simulated for each batch, so that no row is used twice."""

    posterior: Posterior
    device: torch.device | str = "cpu"

    def batch(self, step: int, n: int, rng: torch.Generator) -> Batch:
        """Return a batch of ``n`` rows, for any step of a training."""
        del step
        seed = torch.randint(2**62, (), generator=rng, device=rng.device).item()
        bank = simulate(self.posterior.model, n, np.random.default_rng(seed))
        rows = Rows.of(bank, self.posterior, self.device)
        return rows.draw(torch.arange(n, device=rng.device), rng)


def freeze_inputs(posterior: Posterior, rows: xr.Dataset, rng: np.random.Generator) -> None:
    """Set the statistics of the bank in a posterior: scales, components, largest distances.

    Args:
        rows: Rows of the bank.
        rng: Generator of the noise of their records. The 0.9999 quantiles of the records' distances
            from centre and envelope of the bank are the largest distances that the prior produces.
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
        # At least the noise, because records of a small bank may leave its envelope by less.
        "margin": max(sensor.noise_sd, np.quantile(excess(records, lowest, highest), 0.9999)),
    }
    for name, value in frozen.items():
        getattr(posterior, name).copy_(torch.as_tensor(np.array(value), dtype=torch.float64))
    scale = torch.as_tensor(np.std(travel - mean))
    posterior.summary.freeze(posterior.curve_mean, scale, posterior.curve_weights)


# ---- after a training ----------------------------------------------------------------------------


def records(posterior: Posterior, rows: xr.Dataset, seed: int) -> np.ndarray:
    """Return records ``(n, t)``, mm, of bank rows: curves with noise and zero."""
    rng = generator(seed, "held out", posterior.motion)
    return posterior.sensor.corrupt(rows.travel.values.astype(np.float64), rng)


def held_out_log_density(
    posterior: Posterior, measured: np.ndarray, rows: xr.Dataset
) -> tuple[float, float]:
    """Return the mean log density at the true values of rows, and its standard error, nats.

    It is the density of standardised outputs, so that it does not depend on units.
    """
    values = truth(rows, posterior.model)[:, None]
    density = posterior.log_prob(values, measured)[:, 0] - posterior.model.log_scaling(values)[:, 0]
    return float(density.mean()), float(density.std(ddof=1) / np.sqrt(len(density)))


def convergence(
    posterior: Posterior,
    measured: np.ndarray,
    seed: int,
    *,
    candidates: Sequence[int] = (2, 4, 6, 8, 12, 16),
    reference: int = 64,
    tolerance: float = 0.01,
) -> xr.Dataset:
    """Choose and set the numbers of solver steps: the smallest that agree with a fine solver.

    Draws from the same noise are compared in posterior standard deviations of standardised outputs,
    and log densities of some draws of the fine solver in nats. For draws and for densities, the
    smallest number with a mean absolute difference within the tolerance is chosen, else the most.

    Args:
        measured: Records, ``(n, t)``, mm; the first 50 are used.
        candidates: Numbers of steps to choose from, rising.
        reference: Steps of the fine solver. Doubling the midpoint steps divides the error by four,
            so its error is 1/16 of the error with the most steps.
        tolerance: Largest mean difference, posterior sd or nats. The default of 0.01 is invisible
            in figures, and a quarter of the largest divergence that is accepted.

    Returns:
        Dataset over ``solver_steps`` with ``mean_difference``, ``max_difference`` and
        ``density_difference``, and the attributes ``solves`` (0 for a network without a solver,
        which takes one step), ``chosen_steps``, ``chosen_density_steps`` and ``reference_steps``.
    """
    solves = posterior.inference.solves
    if not solves:
        candidates, reference = [1], 1
    differences = _differences(posterior, measured[:50], candidates, reference, seed)
    good = differences <= tolerance
    good[-1] = True
    chosen, _, of_density = (candidates[i] for i in good.argmax(axis=0))
    posterior.solver_steps.fill_(chosen)
    posterior.density_solver_steps.fill_(of_density)
    names = ("mean_difference", "max_difference", "density_difference")
    return xr.Dataset(
        {name: ("solver_steps", row) for name, row in zip(names, differences.T, strict=True)},
        coords={"solver_steps": list(candidates)},
        attrs={
            "solves": int(solves),
            "chosen_steps": chosen,
            "chosen_density_steps": of_density,
            "reference_steps": reference,
        },
    )


def _differences(
    posterior: Posterior, measured: np.ndarray, candidates: Sequence[int], reference: int, seed: int
) -> np.ndarray:
    """Return mean and largest difference of draws and mean difference of densities, ``(c, 3)``."""
    rng = generator(seed, "solver", posterior.motion)
    noise = rng.standard_normal((len(measured), 100, len(posterior.outputs)))

    def draw(steps: int) -> np.ndarray:
        posterior.solver_steps.fill_(steps)
        return posterior.model.standardise(posterior.sample(measured, noise))

    def density(steps: int) -> np.ndarray:
        posterior.density_solver_steps.fill_(steps)
        return posterior.log_prob(points, measured)

    finest = draw(reference)
    spread = finest.std(axis=1, ddof=1, keepdims=True)
    # Use every fifth draw, because a density costs as much as eight draws.
    points = posterior.model.destandardise(finest[:, ::5])
    finest_density = density(reference)
    rows = []
    for steps in candidates:
        of_draws = np.abs(draw(steps) - finest) / spread
        of_density = np.abs(density(steps) - finest_density)
        rows.append((of_draws.mean(), of_draws.max(), of_density.mean()))
    return np.array(rows)
