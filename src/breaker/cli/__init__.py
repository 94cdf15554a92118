"""The command `breaker`: what one wants of files without the workflow.

Each command is a module with ``add``, its options, and a function that writes, prints and returns
the exit status: 0, or 1 where it failed. Its help is the docstrings of the module and of ``add``.
"""

import sys

__all__ = ["main", "run"]


def run() -> int:
    """Run the command as a process of its own; see ``command.run``.

    Imports take a second, in which an interrupt is to be one, too: so none stands above.
    """
    try:
        from breaker.cli import command

        return command.run()
    except KeyboardInterrupt:
        print("breaker: interrupted", file=sys.stderr)
        return 130


def __getattr__(name: str):
    if name != "main":
        raise AttributeError(name)
    from breaker.cli.command import main

    return main
