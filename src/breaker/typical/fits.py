"""What the records of one breaker say of its parameters.

All records of a breaker share what the model leaves out of it, so that many of them say hardly
more than one does. So a breaker's likelihood is the mean of those of its records, not their
product; that of closing and that of opening are multiplied.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breaker.mechanism import NAMES
from breaker.model import Model, information

__all__ = ["Fit", "fit_breaker"]

_ROUNDS = 30
_REACHED = 1e-3  # prior sd: a step that ends a fit


@dataclass(frozen=True, eq=False)
class Fit:
    """A breaker's normal likelihood of the standardised parameters, about the posterior's mode.

    Attributes:
        mode: Mode of the posterior, ``(p,)``.
        matrix: Information of the records there, ``(p, p)``.
        weighted: The information times the parameters that the records alone would lead to,
            ``(p,)``.
        reached: Whether the steps ended at the mode.
    """

    mode: np.ndarray
    matrix: np.ndarray
    weighted: np.ndarray
    reached: bool

    def posterior(self, precision: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance under a normal prior with mean 0, ``(p,)`` and ``(p, p)``."""
        cov = np.linalg.inv(self.matrix + precision)
        return cov @ self.weighted, cov


def fit_breaker(
    models: Mapping[str, Model], records: Mapping[str, np.ndarray], starts: np.ndarray
) -> Fit:
    """Fit all records of a breaker at once, from several starts: the highest mode found.

    Args:
        records: Records of each, ``(n, t)``, mm; NaN where a sample is missing. A motion may be
            absent.
        starts: Standardised parameters, ``(s, p)``.

    Example:
        >>> from breaker.model import reference_model
        >>> model = reference_model("closing")
        >>> record = model.curves(np.append(model.prior.medians, 0.0)[None])
        >>> fit = fit_breaker({"closing": model}, {"closing": record}, np.ones((1, 7)))
        >>> fit.reached, bool(np.abs(fit.mode).max() < 1e-3)
        (True, True)
    """
    fits = [_climb_or_stop(models, records, start) for start in starts]
    heights = [_height(models, records, fit) if fit.reached else -np.inf for fit in fits]
    return fits[int(np.argmax(heights))]


def _climb_or_stop(
    models: Mapping[str, Model], records: Mapping[str, np.ndarray], start: np.ndarray
) -> Fit:
    """Climb from a start; not reached where it leads to drives that cannot be simulated."""
    try:
        return _climb(models, records, start)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        p = len(NAMES)
        return Fit(start, np.zeros((p, p)), np.zeros(p), reached=False)


def _climb(models: Mapping[str, Model], records: Mapping[str, np.ndarray], z: np.ndarray) -> Fit:
    """Gauss-Newton steps from a start, none farther than a prior sd in any parameter."""
    precision = next(iter(models.values())).prior.precision
    for _ in range(_ROUNDS):
        matrix, slope = _likelihood(models, records, z)
        step = np.linalg.solve(matrix + precision, slope - precision @ z)
        if reached := bool(np.abs(step).max() < _REACHED):
            break
        z = z + step * min(1.0, 1.0 / np.abs(step).max())
    return Fit(z, matrix, slope + matrix @ z, reached)


def _likelihood(
    models: Mapping[str, Model], records: Mapping[str, np.ndarray], z: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Information ``(p, p)`` and slope ``(p,)`` of the log likelihood at parameters ``(p,)``."""
    matrix, slope = np.zeros((len(NAMES), len(NAMES))), np.zeros(len(NAMES))
    for motion, each in records.items():
        found = information(models[motion], each, np.tile(z, (len(each), 1)), np.zeros(len(each)))
        matrix += found.matrix.mean(axis=0)
        slope += found.slope.mean(axis=0)
    return matrix, slope


def _height(models: Mapping[str, Model], records: Mapping[str, np.ndarray], fit: Fit) -> float:
    """Log density of the posterior at a mode, but for a constant."""
    precision = next(iter(models.values())).prior.precision
    height = -0.5 * fit.mode @ precision @ fit.mode
    for motion, each in records.items():
        model, places = models[motion], np.tile(fit.mode, (len(each), 1))
        onset = information(model, each, places, np.zeros(len(each))).onset
        z = np.column_stack([places, onset])[:, : len(model.names)]
        square = model.sensor.chi_square(each, model.curves(model.destandardise(z)))
        height -= 0.5 * (square + np.square(onset)).mean()
    return float(height)
