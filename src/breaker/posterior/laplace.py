"""Draws to start the exact posterior from, of any drive, without a network.

The mode of the exact posterior is climbed to by damped Gauss-Newton steps, and draws are of a wide
Student-t with the curvature there. Adaptive importance sampling (``corrections``) makes the exact
posterior of them, as of a network's.
"""

import numpy as np

from breaker.model import Model, linearise, linearise_beside

__all__ = ["approximate", "mode"]

_STEPS = 20
_REACHED = 1e-3  # prior sd
_FREEDOM = 5.0  # of the Student-t


def approximate(model: Model, record: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return draws about the mode of a record's posterior, ``(n, q)``, physical units.

    Args:
        model: Joint model.
        record: On the sensor's grid, ``(t,)``, mm; NaN where a sample is missing.
        n: Number of draws.
        rng: Their generator.
    """
    highest, precision = mode(model, record)
    root = np.linalg.inv(np.linalg.cholesky(precision))  # root.T @ root is the covariance
    spread = np.sqrt(rng.chisquare(_FREEDOM, n) / _FREEDOM)
    wide = rng.standard_normal((n, len(highest))) / spread[:, None]
    return model.destandardise(highest + wide @ root)


def mode(model: Model, record: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mode, ``(q,)``, standardised, and the negative curvature there, ``(q, q)``."""
    prior = model.precision
    z = np.zeros(len(prior))
    for _ in range(_STEPS):
        curves, (slopes,) = linearise(model, z[None], records=record[None])
        residual = model.sensor.whiten(record - curves[0])
        beside, known = linearise_beside(model, z, record)
        precision = slopes @ slopes.T + known @ known.T + prior
        step = np.linalg.solve(precision, slopes @ residual - known @ beside - prior @ z)
        z = z + step * min(1.0, 1.0 / np.abs(step).max())
        if np.abs(step).max() < _REACHED:
            break
    return z, precision
