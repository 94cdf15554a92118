"""What the records of one breaker say of its parameters, by draws of a network of its family.

All records of a breaker share what is particular in it, so that many of them say hardly more than
one does. So its posterior is that of one of its operations, whichever: the draws of all together.
"""

from dataclasses import dataclass

import numpy as np

from breaker.mechanism import powers
from breaker.model import Prior

__all__ = ["Fit", "fit_breaker"]


@dataclass(frozen=True, eq=False)
class Fit:
    """A breaker's normal likelihood of the standardised parameters.

    Attributes:
        matrix: Information of the records, ``(p, p)``.
        weighted: The information times the parameters that the records alone would lead to,
            ``(p,)``.
    """

    matrix: np.ndarray
    weighted: np.ndarray

    def posterior(self, precision: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance under a normal prior with mean 0, ``(p,)`` and ``(p, p)``."""
        cov = np.linalg.inv(self.matrix + precision)
        return cov @ self.weighted, cov


def fit_breaker(theta: np.ndarray, family: Prior) -> Fit:
    """Return the likelihood of a breaker, from draws of its posterior.

    Args:
        theta: Draws by a network that knows no size, ``(n, p)``: its prior is that of the family,
            at all sizes alike.
        family: Prior of the family at a size near.

    Example:
        Draws of the prior say nothing, but for the size:

        >>> family = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> fit = fit_breaker(family.sample(4000, np.random.default_rng(1)), family)
        >>> bool((np.linalg.eigvalsh(fit.matrix)[:5] < 0.2).all())
        True
    """
    z = family.standardise(theta)
    precision = np.linalg.inv(np.cov(z.T))
    along, _ = np.linalg.qr((powers() / family.log_sds).T)
    # The prior is taken off the posterior; where draws happen to be wider, they say nothing.
    sizes, axes = np.linalg.eigh(precision - (np.eye(len(z.T)) - along @ along.T))
    matrix = (axes * np.maximum(sizes, 0.0)) @ axes.T
    return Fit(matrix, precision @ z.mean(axis=0))
