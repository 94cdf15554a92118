"""Cubics through samples about a time."""

import operator
from dataclasses import dataclass

import numpy as np

_DEGREE = 3
_STEPS = 6  # in search of a time


def weights_of(shares: np.ndarray) -> np.ndarray:
    """Coefficients of a polynomial by the samples at shares ``(w,)``, ``(degree + 1, w)``."""
    powers = shares[:, None] ** np.arange(_DEGREE + 1)
    return np.linalg.solve(powers.T @ powers, powers.T)


@dataclass(frozen=True, eq=False)
class LocalCubic:
    """Polynomial through samples about a time, in halves of its width from there."""

    near: float
    half: float
    coefficients: list[float]  # of degree + 1
    window: np.ndarray  # samples, (w,)
    inverse: np.ndarray  # each coefficient's weights of these samples, (degree + 1, w)
    error: float

    def value(self, time: float, order: int = 0) -> float:
        """Value, or a derivative of an order, mm/ms^order."""
        return sum(map(operator.mul, self._powers(time, order), self.coefficients))

    def weights(self, time: float, order: int = 0) -> np.ndarray:
        """Weights of the samples in that, ``(w,)``."""
        return np.array(self._powers(time, order)) @ self.inverse

    def solve(self, time: float, value: float, order: int = 0) -> float:
        """Time within the fit, near another, at which its value or a derivative is one given."""
        for _ in range(_STEPS):
            slope = self.value(time, order + 1)
            step = (self.value(time, order) - value) / slope if slope else 0.0
            time = min(max(time - step, self.near - self.half), self.near + self.half)
            if abs(step) < 1e-9 * self.half:
                break
        return time

    def _powers(self, time: float, order: int) -> tuple[float, ...]:
        """Factors on the coefficients that make the value, or a derivative."""
        u = (time - self.near) / self.half
        if order == 0:
            return 1.0, u, u * u, u * u * u
        if order == 1:
            return 0.0, 1.0 / self.half, 2.0 * u / self.half, 3.0 * u * u / self.half
        return 0.0, 0.0, 2.0 / self.half**2, 6.0 * u / self.half**2
