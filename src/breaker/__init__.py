"""From the travel curve of a circuit breaker to the state of its drive, with its uncertainty.

docs/development.md is the map of its rooms. A name is imported from the module that defines it. The
workflow is in ``Snakefile`` and ``workflow``.
"""

__all__ = ["__version__"]

__version__ = "0.1.0"
