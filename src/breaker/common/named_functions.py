"""Functions that a configuration names as ``module:function``: a prior, simulator or network.

A module is searched among the installed ones, then in the working directory.
"""

import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path


def load(text: str) -> Callable:
    """Return the function of ``module:function``; raise a ValueError with a remedy if missing."""
    file = file_of(text)
    module, _, name = text.partition(":")
    attribute = getattr(import_module(module), name, None)
    if not callable(attribute):
        raise ValueError(f"{text}: {file} has no function {name!r}; define it, or name another")
    return attribute


def file_of(text: str) -> Path:
    """Return the file of a module without running it, relative below the working directory; raise
    a ValueError with a remedy if the text has another form or the module is missing.
    """
    module, colon, name = text.partition(":")
    if not (colon and all(part.isidentifier() for part in [*module.split("."), name])):
        raise ValueError(f"{text!r} must have the form module:function, such as own_prior:prior")
    here = Path.cwd()
    if str(here) not in sys.path:
        sys.path.append(str(here))
    try:
        spec = find_spec(module)
    except ModuleNotFoundError:  # a package above it
        spec = None
    if spec is None or not spec.has_location:
        path = f"{module.replace('.', '/')}.py"
        raise ValueError(f"{text}: no module {module!r}; install it, or put {path} into {here}")
    file = Path(spec.origin)
    return file.relative_to(here) if file.is_relative_to(here) else file
