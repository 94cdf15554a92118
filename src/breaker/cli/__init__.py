"""The command `breaker`: answers about files, without the workflow.

Each command is a module with ``add``, its options, and ``run``, which returns the exit status: 0,
or 1 where it failed. Its help is the docstrings of the module and of ``add``.
"""

import sys
from collections.abc import Sequence

__all__ = ["main", "run"]


def run() -> int:
    """Run the command as a process of its own; an interrupt is heeded from the first import on."""
    try:
        from breaker.cli import command

        return command.run()
    except KeyboardInterrupt:
        print("breaker: interrupted", file=sys.stderr)
        return 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command within this process."""
    from breaker.cli import command

    return command.main(arguments)
