"""The command `breaker`: what one wants of files without the workflow.

Each command is a module with ``add``, its options, and a function that prints and returns the exit
status: 0, or 1 where it failed.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submod_attrs={"command": ["main", "run"]}
)
