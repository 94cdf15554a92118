"""Posteriors in model files: a network is built only if the tensors of the file are its own.

The file itself is that of ``breaker.model``. The network is built without memory, on torch's device
"meta", before any of its weights are read.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import torch
from torch import Tensor, nn

from breaker.model import (
    FORMATS,
    Discrepancy,
    ModelFileError,
    SavedModel,
    open_model,
    write_model,
)

__all__ = ["read", "write"]

_STEPS = ("solver_steps", "density_solver_steps")  # tensors
_MOST_STEPS = 1000
_Module = TypeVar("_Module", bound=nn.Module)


def write(
    path: str | Path,
    settings: Mapping,
    weights: Mapping[str, Tensor],
    discrepancy: Discrepancy | None,
) -> None:
    """Write a model file."""
    arrays = {name: each.detach().cpu().numpy() for name, each in weights.items()}
    write_model(path, settings, arrays, discrepancy)


def read(kind: type[_Module], path: str | Path) -> _Module:
    """Build a ``kind(settings, discrepancy=...)`` from a model file of any format.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is not a model file, is of an unknown format, or holds settings or
            tensors that make no model.
    """
    with open_model(path) as saved:
        module = _build(kind, saved.settings, saved.discrepancy)
        weights = _weights(saved, module.state_dict())
    module.load_state_dict(weights, assign=True)
    return module


def _build(kind: type[_Module], settings: Mapping, discrepancy: Discrepancy | None) -> _Module:
    """The module without memory: its tensors have shapes alone."""
    try:
        with torch.device("meta"):
            return kind(settings, discrepancy=discrepancy)
    except (ArithmeticError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise ModelFileError.of_settings(error) from error


def _weights(saved: SavedModel, wanted: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The tensors of the file, if they are of the shapes and types wanted, and finite."""
    places = _places(saved.format, wanted)
    shapes = dict(places.values())
    for name in sorted(saved.shapes.keys() | shapes.keys()):
        found, asked = (each.get(name, "none") for each in (saved.shapes, shapes))
        if found != asked:
            raise ModelFileError(
                f"tensor {name} has the shape {found}, its settings ask for {asked}"
            )
    weights = {}
    for name, each in wanted.items():
        array = saved.weight(places[name][0], str(each.dtype).removeprefix("torch."))
        if name in _STEPS and not 1 <= array.item() <= _MOST_STEPS:
            raise ModelFileError(f"{name} is {array.item()}, but must be from 1 to {_MOST_STEPS}")
        # In memory of torch's own, aligned like that of a network in training.
        own = torch.from_numpy(array).expand(each.shape)
        weights[name] = own.clone(memory_format=torch.contiguous_format)
    return weights


def _places(format_: str, wanted: Mapping[str, Tensor]) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Name and shape that each tensor has in a file of a format."""
    places = {name: (name, tuple(each.shape)) for name, each in wanted.items()}
    if format_ in FORMATS[:2]:  # of one scale, the only one that such a model is asked at
        places |= {name: (name, ()) for name in ("farthest", "margin")}
    if format_ == FORMATS[0]:  # the same steps for draws and density
        places["density_solver_steps"] = ("solver_steps", ())
    return places
