"""After a training: the solver's steps, and the density of rows that it has not seen."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.batches import truth
from breaker.posterior import Posterior
from breaker.randomness import generator

__all__ = ["convergence", "held_out_log_density", "records"]


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
    """Choose the solver's steps: the fewest whose draws are those of a fine solver.

    Draws from the same noise with each candidate are compared with the finest, in posterior
    standard deviations of standardised outputs. The posterior's steps are set to the fewest whose
    mean difference is within the tolerance.

    Args:
        measured: Records, ``(n, t)``, mm.
        settings: The section ``solver`` of the configuration.

    Returns:
        Dataset over ``solver_steps`` with ``mean_difference`` and ``max_difference``.

    Raises:
        ValueError: If no candidate is within the tolerance.
    """
    rng = generator(seed, "solver", posterior.motion)
    measured = measured[: settings["curves"]]
    shape = (len(measured), settings["draws"], len(posterior.outputs))
    noise = rng.standard_normal(shape)

    def draws(steps: int) -> np.ndarray:
        posterior.solver_steps.fill_(steps)
        return posterior.standardise(posterior.sample(measured, noise))

    finest = draws(settings["reference"])
    spread = finest.std(axis=1, ddof=1, keepdims=True)
    candidates = sorted(settings["candidates"])
    differences = [np.abs(draws(steps) - finest) / spread for steps in candidates]
    means = np.array([difference.mean() for difference in differences])
    good = np.flatnonzero(means <= settings["tolerance"])
    if good.size == 0:
        raise ValueError(
            f"no candidate of solver.candidates is within solver.tolerance = "
            f"{settings['tolerance']}; the best differs by {means.min():.3g}: allow more steps"
        )
    chosen = candidates[good[0]]
    posterior.solver_steps.fill_(chosen)
    return xr.Dataset(
        {
            "mean_difference": ("solver_steps", means),
            "max_difference": ("solver_steps", [d.max() for d in differences]),
        },
        coords={"solver_steps": candidates},
        attrs={"chosen_steps": chosen, "reference_steps": settings["reference"]},
    )
