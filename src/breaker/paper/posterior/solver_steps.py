"""After a training: the number of solver steps, and the density of held-out rows."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from breaker.common.randomness import generator
from breaker.paper.posterior.estimator import Posterior
from breaker.paper.posterior.training_batches import truth

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
    values = truth(rows, posterior)[:, None]
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
