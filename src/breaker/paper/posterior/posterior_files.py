"""Posteriors in model files: a network is built only if the tensors of the file are its own.

The file itself is that of ``breaker.paper.model``. The network is built without memory, on torch's
device "meta", before any of its weights are read.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import torch
from torch import Tensor, nn

from breaker.common.tensor_file import ModelFileError, SavedModel, open_model

_STEPS = ("solver_steps", "density_solver_steps")  # tensors
_MOST_STEPS = 1000
_Module = TypeVar("_Module", bound=nn.Module)


def read(kind: type[_Module], path: str | Path) -> _Module:
    """Build a ``kind(settings)`` from a model file.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is not a model file, is of an unknown format, or holds settings or
            tensors that make no model.
    """
    with open_model(path) as saved:
        module = _build(kind, saved.settings)
        weights = _weights(saved, module.state_dict())
    module.load_state_dict(weights, assign=True)
    return module


def _build(kind: type[_Module], settings: Mapping) -> _Module:
    """The module without memory: its tensors have shapes alone."""
    try:
        with torch.device("meta"):
            return kind(settings)
    except (ArithmeticError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise ModelFileError.of_settings(error) from error


def _weights(saved: SavedModel, wanted: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The tensors of the file, if they are of the shapes and types wanted, and finite."""
    shapes = {name: tuple(each.shape) for name, each in wanted.items()}
    for name in sorted(saved.shapes.keys() | shapes.keys()):
        found, asked = (each.get(name, "none") for each in (saved.shapes, shapes))
        if found != asked:
            raise ModelFileError(
                f"tensor {name} has the shape {found}, its settings ask for {asked}"
            )
    weights = {}
    for name, each in wanted.items():
        array = saved.weight(name, str(each.dtype).removeprefix("torch."))
        if name in _STEPS and not 1 <= array.item() <= _MOST_STEPS:
            raise ModelFileError(f"{name} is {array.item()}, but must be from 1 to {_MOST_STEPS}")
        # In memory of torch's own, aligned like that of a network in training.
        weights[name] = torch.from_numpy(array).clone(memory_format=torch.contiguous_format)
    return weights
