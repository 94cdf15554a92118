"""The command `breaker`: answers about files, without the workflow.

Each command is a module with ``add``, its options, and ``run``, which returns the exit status: 0,
or 1 if it failed. Its help is the docstrings of the module and of ``add``.
"""

from breaker.cli.command import main, run

__all__ = ["main", "run"]
