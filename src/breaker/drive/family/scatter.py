"""Scatter of a drive's operations, from few of them beside what is usual of drives."""

from typing import TypeVar

import numpy as np

V = TypeVar("V", float, np.ndarray)


def beside_usual(squares: V, seen: float, usual: V, known: float) -> V:
    """Return a variance, or a covariance, of what is seen beside what is usual.

    Args:
        squares: Sum of the squares, or products, of what is seen.
        seen: Of how many degrees of freedom.
        usual: The usual variance.
        known: How well that is known, as from so many degrees of freedom.

    Example:
        >>> beside_usual(squares=16.0, seen=4, usual=1.0, known=4)
        2.5
    """
    return (squares + known * usual) / (seen + known)
