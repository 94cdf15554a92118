"""How far the model can be trusted on a drive, and what its own error costs.

The first operations determine parameters and difference together. Draws from their posterior give
the size of the drive's difference in each phase of a motion, and draws from what was learned give
that of drives of the family with the same parameters: a drive that differs by more is outside of
what all intervals rest on. What the error costs is the width of a quantity's interval, beside that
from the same records if the model were right.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from breaker.mechanism import NAMES, Limit
from breaker.model import Prior
from breaker.wear.learned import PHASES, by_phase
from breaker.wear.reference import Reference
from breaker.wear.state import State
from breaker.wear.trend import Follower

__all__ = ["trust_in"]

_DRAWS = 400
_QUANTILES = (0.05, 0.5, 0.95, 0.99)
_HALF = 1.6449  # sds of a normal in half its 90 % interval
_STEP = 1e-3  # of standardised parameters, for slopes of quantities


def trust_in(follower: Follower, state: State, rng: np.random.Generator) -> xr.Dataset:
    """Return how far a drive is from the model at the reference, and what each limit loses to it.

    Args:
        state: Any state of its trend.

    Returns:
        Dataset over ``phase``, ``quantile`` and ``part``: ``drive (phase, quantile)``, the root
        mean square of the drive's difference from the model at its own parameters, by the
        posterior, and ``family (phase, quantile)``, the same of drives of the family, both mm;
        ``half_width (part)``, half the 90 % interval of the quantity of a part of a limit, and
        ``half_width_if_right (part)``, the same if the model were right, in the quantity's unit.
        Where the model is held to be right, it differs by 0 and no width is known; before there is
        a reference, all are nan.
    """
    parts = [(limit, each) for limit in follower.limits for each in limit.quantities]
    phases = [f"{motion} {phase}" for motion in follower.models for phase in PHASES]
    sizes = np.full((2, len(phases), len(_QUANTILES)), 0.0 if follower.learned is None else np.nan)
    widths = np.full((2, len(parts)), np.nan)
    if follower.learned is not None and state.reference is not None:
        p, reference = len(NAMES), state.reference
        cov, exact = _covariances(follower, reference)
        mean = np.append(reference.centre, reference.difference)
        own = rng.multivariate_normal(mean, cov, _DRAWS, method="cholesky")
        usual = np.tile(mean, (_DRAWS, 1))
        n = len(reference.difference)
        usual[:, p:] = rng.multivariate_normal(np.zeros(n), follower.learned.new, _DRAWS)
        for i, each in enumerate((own, usual)):
            sizes[i] = np.quantile(_sizes(follower, each, reference.centre), _QUANTILES, axis=0).T
        slopes = _slopes(follower.limits, follower.prior, reference.centre)
        for i, each in enumerate((cov[:p, :p], exact)):
            widths[i] = _HALF * np.sqrt(np.einsum("ip,pq,iq->i", slopes, each, slopes))
    return xr.Dataset(
        {
            "drive": (("phase", "quantile"), sizes[0], {"unit": "mm"}),
            "family": (("phase", "quantile"), sizes[1], {"unit": "mm"}),
            "half_width": ("part", widths[0]),
            "half_width_if_right": ("part", widths[1]),
        },
        coords={
            "phase": phases,
            "quantile": list(_QUANTILES),
            "part_limit": ("part", [limit.name for limit, _ in parts]),
            "part_quantity": ("part", [quantity for _, quantity in parts]),
            "part_unit": ("part", [unit for limit in follower.limits for unit in limit.units]),
        },
    )


def _covariances(follower: Follower, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of parameters and difference, and of parameters without any, at the reference."""
    p, learned, count = len(NAMES), follower.learned, reference.records
    told = count / (1.0 + count * learned.rough) * reference.matrix
    cov = np.linalg.inv(block_diag(np.eye(p), np.linalg.inv(learned.new)) + told)
    exact = np.linalg.inv(np.eye(p) + count * reference.matrix[:p, :p])
    return 0.5 * (cov + cov.T), exact


def _sizes(follower: Follower, draws: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Root mean squares of differences by phase, mm, of draws ``(d, p + n)``: ``(d, phase)``."""
    p, learned, found = len(NAMES), follower.learned, []
    for motion, part in learned.parts(draws[:, p:]).items():
        model = follower.models[motion]
        left_out = learned.mean_of[motion].shift(draws[:, :p]) + part @ learned.basis[motion]
        place = np.append(centre, 0.0)[None, : len(model.names)]
        curve = model.curves(model.destandardise(place))[0]
        found.append([by_phase(each, curve, model.sensor.times, motion) for each in left_out])
    return np.concatenate(found, axis=1)


def _slopes(limits: Sequence[Limit], prior: Prior, centre: np.ndarray) -> np.ndarray:
    """Slopes of the quantities of all limits by the standardised parameters, ``(part, p)``."""
    moved = _STEP * np.eye(len(NAMES))
    theta = prior.destandardise(np.concatenate([centre + moved, centre - moved]))
    none = np.zeros((len(theta), 0))
    values = np.concatenate([none, *(each.evaluate(theta) for each in limits)], 1)
    up, down = np.split(values, 2)
    return (up - down).T / (2.0 * _STEP)
