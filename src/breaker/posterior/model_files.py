"""Model files: all of a posterior in one safetensors file, without pickle.

Weights, and what the model leaves out where it was trained for that; in the header a JSON text with
all settings that made it.
"""

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from breaker.model import Discrepancy

__all__ = ["ModelFileError", "read", "write"]

_FORMAT = "breaker posterior 3"
_DISCREPANCY = ("mean", "slopes", "factor")  # tensors of these names
_Module = TypeVar("_Module", bound=nn.Module)


class ModelFileError(ValueError):
    """A model file that cannot be used; the message names the file, the fault and the remedy."""


def write(
    path: str | Path,
    settings: Mapping,
    weights: Mapping[str, Tensor],
    discrepancy: Discrepancy | None,
) -> None:
    """Write a model file."""
    header = {
        "format": _FORMAT,
        "breaker_version": version("breaker"),
        "settings": json.dumps(settings, sort_keys=True),
    }
    tensors = {name: each.detach().cpu().contiguous() for name, each in weights.items()}
    if discrepancy is not None:
        for name in _DISCREPANCY:
            array = getattr(discrepancy, name)
            tensors[f"discrepancy.{name}"] = torch.as_tensor(array, dtype=torch.float64)
    Path(path).write_bytes(_in_order(save(tensors, metadata=header)))


def read(kind: type[_Module], path: str | Path) -> _Module:
    """Build a ``kind(settings, discrepancy=...)`` from a model file.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is not a model file, is of another format, or holds tensors that do
            not fit its settings.
    """
    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no model file {path}")
    try:
        with safe_open(str(path), framework="pt") as file:
            header = file.metadata() or {}
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        left_out = {name: tensors.pop(f"discrepancy.{name}", None) for name in _DISCREPANCY}
        module = _build(kind, header, left_out)
        _check_shapes(module.state_dict(), tensors)
    except SafetensorError as error:
        raise ModelFileError(
            f"{path} is not a model file of breaker ({error}); train it anew"
        ) from error
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}") from error
    module.load_state_dict(tensors)
    return module


def _build(
    kind: type[_Module], header: Mapping[str, str], left_out: Mapping[str, Tensor | None]
) -> _Module:
    found = header.get("format")
    if found != _FORMAT:
        raise ModelFileError(
            f"its format is {found!r}, this version of breaker reads {_FORMAT!r}; train it anew"
        )
    try:
        arrays = {name: each.numpy() for name, each in left_out.items() if each is not None}
        discrepancy = Discrepancy(**arrays) if arrays else None
        return kind(json.loads(header["settings"]), discrepancy=discrepancy)
    except (ArithmeticError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise ModelFileError(
            f"its settings do not describe a model ({type(error).__name__}: {error}); train it anew"
        ) from error


def _check_shapes(expected: Mapping[str, Tensor], found: Mapping[str, Tensor]) -> None:
    shapes = [
        {name: tuple(each.shape) for name, each in part.items()} for part in (expected, found)
    ]
    for name in sorted(shapes[0].keys() | shapes[1].keys()):
        wanted, there = (each.get(name, "none") for each in shapes)
        if wanted != there:
            raise ModelFileError(
                f"tensor {name} has the shape {there}, its settings ask for {wanted}; train it anew"
            )


def _in_order(file: bytes) -> bytes:
    """Order the header of a safetensors file, whose texts the library writes in random order."""
    size = int.from_bytes(file[:8], "little")
    header = json.dumps(json.loads(file[8 : 8 + size]), sort_keys=True).encode()
    header += b" " * (-len(header) % 8)  # tensors begin at a multiple of 8, as the format asks
    return len(header).to_bytes(8, "little") + header + file[8 + size :]
