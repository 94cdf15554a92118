"""Amortised Bayesian inference of a circuit breaker's mechanical parameters from travel curves."""

from importlib.metadata import version

__all__ = ["__version__"]

__version__ = version("breaker")
