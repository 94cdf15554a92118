"""How curves of a family's drives change with each parameter, predicted from their shapes.

The two-mass model predicts the change of drives of an independent simulator with an error of a
third. A regression over drives of the family has an error of 10 %, with a covariance of its errors.
``envs/sensitivities.py`` fits the shipped regressions.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from breaker.common.tensor_file import open_model
from breaker.family.inputs import Basis
from breaker.model.parameters import MOTIONS, NAMES
from breaker.shipped import model_file

SETS = (MOTIONS, *((motion,) for motion in MOTIONS))  # recorded motions, each set has a regression
_SQUARED = 6  # components of shapes whose products are features
_FARTHEST = 3.0  # sds at which components are cut; products of larger ones are extrapolations


class Sensitivities(NamedTuple):
    """A regression for the motions of one set, each with its grid and the travel at the contact.

    Attributes:
        shapes: Components of the shapes of all motions, one after the other.
        weights: Weights of the features of a drive, ``(f, p * k)``.
        curves, errors: Basis of changes, ``(k, m * (g + 1))``, and covariance of the errors of each
            parameter in this basis, ``(p, k, k)``.
    """

    shapes: Basis
    weights: np.ndarray
    curves: np.ndarray
    errors: np.ndarray

    def of(self, shapes: np.ndarray, pace: float) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of a drive's curves by the logarithm of each parameter, ``(p, c)``, c
        being ``m * (g + 1)``, and covariances of their errors, ``(p, c, c)``.

        Args:
            shapes: Curves of the drive over their strokes, ``(m * g,)``.
            pace: Logarithm of the duration of the last motion over the first.
        """
        changes = features(self.shapes, shapes[None], np.array([pace])) @ self.weights
        errors = self.curves.T @ self.errors @ self.curves
        return changes.reshape(len(NAMES), -1) @ self.curves, errors


def features(basis: Basis, shapes: np.ndarray, paces: np.ndarray) -> np.ndarray:
    """Return features of the regression, ``(n, f)``: components, pace, and first products."""
    scores = basis.amplitudes(shapes) / np.sqrt(basis.variances)
    scores = np.clip(scores, -_FARTHEST, _FARTHEST)
    i, j = np.triu_indices(_SQUARED)
    return np.column_stack([np.ones(len(scores)), scores, paces, scores[:, i] * scores[:, j]])


@cache
def shipped_sensitivities(family: str) -> dict[tuple[str, ...], Sensitivities]:
    """Return the regressions of a family by their motions."""
    fits, names = {}, (*Basis._fields, *Sensitivities._fields[1:])
    with open_model(model_file(family, "sensitivities")) as saved:
        for motions in SETS:
            paths = (f"{' '.join(motions)}.{name}" for name in names)
            parts = [np.float64(saved.weight(path, "float32")) for path in paths]
            fits[motions] = Sensitivities(Basis(*parts[:3]), *parts[3:])
    return fits
