"""How curves of a family's drives change with each parameter, predicted from their shapes.

The two-mass model predicts these changes badly for drives with additional effects: for drives of an
independent simulator, a third of the change remains. A regression over drives of the family leaves
10 %, with a covariance of its errors.
"""

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple, Self

import numpy as np

from breaker.common.tensor_file import open_model, write_model
from breaker.family.inputs import Basis
from breaker.model.parameters import MOTIONS, NAMES
from breaker.shipped import model_file

SETS = (MOTIONS, *((motion,) for motion in MOTIONS))
"""Motions whose records are at hand; each set has a regression of its own."""

_SHAPES, _SQUARED, _CHANGES = 20, 6, 40  # components of shapes, those with products, of changes
_FARTHEST = 3.0  # sds of a component; products of larger ones are extrapolations
_RIDGE = 3.0  # drives' worth of prior on each coefficient
_USUAL = 0.98  # share of drives whose errors count: a contact that bounces once more has no slope


class Sensitivities(NamedTuple):
    """A regression for the motions of one set, each with its grid and the travel at the contact.

    Attributes:
        shapes: Components of the shapes of all motions, one after the other.
        weights: Of the features of a drive, ``(f, p * k)``.
        curves: In which they change, ``(k, m * (g + 1))``.
        errors: Covariance of the errors of each parameter in these, ``(p, k, k)``.
    """

    shapes: Basis
    weights: np.ndarray
    curves: np.ndarray
    errors: np.ndarray

    @classmethod
    def fitted(cls, shapes: np.ndarray, paces: np.ndarray, changes: np.ndarray) -> Self:
        """Fit the regression to drives of a family.

        Args:
            shapes: Curves over their strokes, ``(n, m * g)``.
            paces: Logarithm of the duration of the last motion over the first, ``(n,)``.
            changes: Derivatives by the logarithm of each parameter, ``(n, p, m * (g + 1))``.
        """
        n, p, _ = changes.shape
        basis = Basis.of(shapes, _SHAPES)
        curves = np.linalg.svd(changes.reshape(n * p, -1), full_matrices=False)[2][:_CHANGES]
        x, y = _features(basis, shapes, paces), (changes @ curves.T).reshape(n, -1)

        def solved(some: np.ndarray) -> np.ndarray:
            square = x[some].T @ x[some] + _RIDGE * np.eye(x.shape[1])
            return np.linalg.solve(square, x[some].T @ y[some])

        even = np.arange(n) % 2 == 0  # each half is predicted by the other
        left = np.where(even[:, None], y - x @ solved(~even), y - x @ solved(even))
        errors = []
        for one in left.reshape(n, p, -1).swapaxes(0, 1):
            size = np.square(one).sum(axis=1)
            usual = one[size <= np.quantile(size, _USUAL)]
            errors.append(usual.T @ usual / len(usual))
        return cls(basis, solved(even | ~even), curves, np.array(errors))

    def of(self, shapes: np.ndarray, pace: float) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives for one drive, ``(p, m * (g + 1))``, and the covariances of their
        errors, ``(p, m * (g + 1), m * (g + 1))``; arguments as of ``fitted``.
        """
        changes = _features(self.shapes, shapes[None], np.array([pace])) @ self.weights
        errors = self.curves.T @ self.errors @ self.curves
        return changes.reshape(len(NAMES), -1) @ self.curves, errors


def _features(basis: Basis, shapes: np.ndarray, paces: np.ndarray) -> np.ndarray:
    """Return what the regression is on, ``(n, f)``: components, pace, and products of the first."""
    scores = basis.amplitudes(shapes) / np.sqrt(basis.variances)
    scores = np.clip(scores, -_FARTHEST, _FARTHEST)
    one, other = np.triu_indices(_SQUARED)
    return np.column_stack([np.ones(len(scores)), scores, paces, scores[:, one] * scores[:, other]])


def write_sensitivities(family: str, settings: Mapping, fits: Mapping[tuple, Sensitivities]):
    """Write the regressions of a family to the file that ships."""
    arrays = {}
    for motions, fit in fits.items():
        for name, part in (fit.shapes._asdict() | fit._asdict()).items():
            if name != "shapes":
                arrays[f"{' '.join(motions)}.{name}"] = np.float32(part)
    write_model(model_file(family, "sensitivities"), settings, arrays)


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
