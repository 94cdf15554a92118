"""The command `breaker`: answers about files, without the workflow.

Each command is a module with ``add``, which adds its options, and ``run``, which returns the exit
status: 0, or 1 if it failed. The docstrings of the module and of ``add`` are the help.
"""

from breaker.cli.command import main, run

__all__ = ["main", "run"]
