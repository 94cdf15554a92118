"""After a training: the number of solver steps, and the density of held-out rows."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.model import generator
from breaker.posterior.batches import truth
from breaker.posterior.estimator import Posterior

__all__ = ["convergence", "held_out_log_density", "records"]

_DIFFERENCES = ("mean_difference", "max_difference", "density_difference")
_DENSITY_EVERY = 5  # draw of a curve whose density is compared: a density costs more than a draw


def records(posterior: Posterior, rows: xr.Dataset, seed: int) -> np.ndarray:
    """Make records ``(n, t)``, mm, of bank rows, with zero and noise."""
    rng = generator(seed, "held out", posterior.motion)
    return posterior.sensor.corrupt(rows.travel.values.astype(np.float64), rng)


def held_out_log_density(
    posterior: Posterior, measured: np.ndarray, rows: xr.Dataset
) -> tuple[float, float]:
    """Return the mean log density of the truth of rows, and its standard error.

    In standardised outputs, so that it does not depend on units: nats above the prior's scale.
    """
    values = truth(rows, posterior)[:, None]
    density = posterior.log_prob(values, measured)[:, 0] - posterior.log_scaling(values)[:, 0]
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
    if not posterior.inference.solves:
        posterior.solver_steps.fill_(1)
        posterior.density_solver_steps.fill_(1)
        nothing = {name: ("solver_steps", [0.0]) for name in _DIFFERENCES}
        attrs = {"solves": 0, **dict.fromkeys(("chosen_steps", "chosen_density_steps"), 1)}
        return xr.Dataset(nothing, {"solver_steps": [1]}, attrs | {"reference_steps": 1})
    rng = generator(seed, "solver", posterior.motion)
    measured = measured[: settings["curves"]]
    shape = (len(measured), settings["draws"], len(posterior.outputs))
    noise = rng.standard_normal(shape)

    def solve(steps: int, points: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        posterior.solver_steps.fill_(steps)
        posterior.density_solver_steps.fill_(steps)
        z = posterior.standardise(posterior.sample(measured, noise))
        some = z[:, ::_DENSITY_EVERY] if points is None else points
        return z, posterior.log_prob(posterior.destandardise(some), measured)

    finest, finest_density = solve(settings["reference"])
    spread = finest.std(axis=1, ddof=1, keepdims=True)
    candidates = sorted(settings["candidates"])
    rows = []
    for steps in candidates:
        z, density = solve(steps, finest[:, ::_DENSITY_EVERY])
        difference = np.abs(z - finest) / spread
        rows.append((difference.mean(), difference.max(), np.abs(density - finest_density).mean()))
    mean, largest, density = np.transpose(rows)
    chosen = _fewest(candidates, mean, settings["tolerance"], "tolerance")
    for_density = _fewest(candidates, density, settings["density_tolerance"], "density_tolerance")
    posterior.solver_steps.fill_(chosen)
    posterior.density_solver_steps.fill_(for_density)
    return xr.Dataset(
        {
            name: ("solver_steps", values)
            for name, values in zip(_DIFFERENCES, (mean, largest, density), strict=True)
        },
        coords={"solver_steps": candidates},
        attrs={
            "solves": 1,
            "chosen_steps": chosen,
            "chosen_density_steps": for_density,
            "reference_steps": settings["reference"],
        },
    )


def _fewest(candidates: list[int], differences: np.ndarray, tolerance: float, key: str) -> int:
    good = np.flatnonzero(differences <= tolerance)
    if good.size == 0:
        raise ValueError(
            f"no candidate of solver.candidates is within solver.{key} = {tolerance}; the best "
            f"differs by {differences.min():.3g}: allow more steps"
        )
    return candidates[good[0]]
