"""From the travel curve of a circuit breaker to the state of its drive, with its uncertainty.

docs/development.md is the map of its rooms. A name is imported from the module that defines it. The
workflow is in ``Snakefile`` and ``workflow``.
"""

__all__ = ["DISTRIBUTION", "__version__"]

DISTRIBUTION = "breaker-drive"
"""What pip calls the package; on the package index ``breaker`` is another project."""

__version__ = "0.1.0"
