"""Model files: all of a posterior in one safetensors file, without pickle.

Weights, and what the model leaves out where it was trained for that; in the header a JSON text with
all settings that made it, and a checksum. A file may come from anywhere, so nothing is built before
its sizes are known to be those of the tensors in it: the module is built without memory, on torch's
device "meta", and takes the tensors of the file as they are.
"""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from breaker.mechanism import NAMES
from breaker.model import Discrepancy

__all__ = ["ModelFileError", "read", "write"]

_FORMAT = "breaker posterior 3"
_HEADER = ("format", "breaker_version", "settings", "checksum")
_DISCREPANCY = tuple(f"discrepancy.{name}" for name in ("mean", "slopes", "factor"))
_LONGEST_HEADER = 1_000_000  # bytes
_LARGEST = 100_000  # size in the settings of sensor and network
_MOST = 100  # layers of one kind, one number each or as many as a number says
_LAYERS = ("blocks", "pair_blocks", "transforms")
_STEPS = ("solver_steps", "density_solver_steps")  # tensors
_MOST_STEPS = 1000
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
            array = getattr(discrepancy, name.partition(".")[2])
            tensors[name] = torch.as_tensor(array, dtype=torch.float64)
    Path(path).write_bytes(_finished(save(tensors, metadata=header)))


def read(kind: type[_Module], path: str | Path) -> _Module:
    """Build a ``kind(settings, discrepancy=...)`` from a model file.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is not a model file, is of another format, or holds settings or
            tensors that make no model.
    """
    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no model file {path}")
    try:
        tensors = _hash_of_tensors(path)
        with safe_open(str(path), framework="pt") as file:
            header = file.metadata() or {}
            settings = _settings(header)
            # Files of earlier versions have none.
            if header.get("checksum") not in (None, _checksum(tensors, header)):
                raise ModelFileError("its checksum is another: it was changed after it was written")
            names = set(file.keys())
            discrepancy = _discrepancy(file, settings) if names & {*_DISCREPANCY} else None
            module = _build(kind, settings, discrepancy)
            weights = _weights(file, names.difference(_DISCREPANCY), module.state_dict())
    except SafetensorError as error:
        raise ModelFileError(
            f"{path} is not a model file of breaker ({error}); train it anew"
        ) from error
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}; train it anew") from error
    module.load_state_dict(weights, assign=True)
    return module


def _hash_of_tensors(path: str | Path) -> str:
    """Read the tensors through; a header that would take long to read is refused."""
    with Path(path).open("rb") as file:
        size = int.from_bytes(file.read(8), "little")
        if size > _LONGEST_HEADER:
            raise SafetensorError("its header is too long")
        file.seek(size, 1)
        return hashlib.file_digest(file, "sha256").hexdigest()


def _checksum(tensors: str, header: Mapping[str, str]) -> str:
    """Hash of the hash of all tensors and of the settings."""
    return hashlib.sha256((tensors + header["settings"]).encode()).hexdigest()


def _settings(header: Mapping[str, str]) -> dict:
    """Settings in which every number is finite, and the sizes of layers are of use."""
    if header.get("format") != _FORMAT:
        raise ModelFileError(
            f"its format is {header.get('format')!r}, this version of breaker reads {_FORMAT!r}"
        )
    if unknown := sorted(header.keys() - {*_HEADER}):
        raise ModelFileError(f"its header has {', '.join(map(repr, unknown))}, which is not known")
    try:
        settings = json.loads(header["settings"])
        for place, number in _numbers(settings):
            if not math.isfinite(number):
                raise ValueError(f"{'.'.join(place)} is {number}")
            most = _MOST if place[-1] in _LAYERS else _LARGEST
            if place[0] == "network" and number > most:
                raise ValueError(f"{'.'.join(place)} is {number:g}, more than {most}")
        if settings["sensor"]["samples"] > _LARGEST:
            raise ValueError(f"sensor.samples is more than {_LARGEST}")
    except (ArithmeticError, KeyError, RecursionError, TypeError, ValueError) as error:
        raise _no_model(error) from error
    return settings


def _numbers(found: object, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], float]]:
    """Yield the numbers in settings, and where they are; refuse long lists in a network."""
    if isinstance(found, dict):
        for key, each in found.items():
            yield from _numbers(each, (*place, key))
    elif isinstance(found, list):
        if place[:1] == ("network",) and len(found) > _MOST:
            raise ValueError(f"{'.'.join(place)} has more than {_MOST} entries")
        for each in found:
            yield from _numbers(each, place)
    elif isinstance(found, int | float):
        yield place or ("settings",), float(found)


def _discrepancy(file: safe_open, settings: Mapping) -> Discrepancy:
    """What the model leaves out, of the parameters and the samples that it has."""
    try:
        arrays = {name.partition(".")[2]: file.get_tensor(name) for name in _DISCREPANCY}
        for name, each in arrays.items():
            _check_tensor(f"discrepancy.{name}", each, torch.float64)
        found = Discrepancy(**{name: each.clone().numpy() for name, each in arrays.items()})
        wanted = (len(NAMES), settings["sensor"]["samples"])
        if found.slopes.shape != wanted:
            raise ValueError(f"discrepancy.slopes has the shape {found.slopes.shape}, not {wanted}")
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise error if isinstance(error, ModelFileError) else _no_model(error) from error
    return found


def _build(kind: type[_Module], settings: Mapping, discrepancy: Discrepancy | None) -> _Module:
    """The module without memory: its tensors have shapes alone."""
    try:
        with torch.device("meta"):
            return kind(settings, discrepancy=discrepancy)
    except (ArithmeticError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise _no_model(error) from error


def _no_model(error: Exception) -> ModelFileError:
    return ModelFileError(f"its settings do not describe a model ({type(error).__name__}: {error})")


def _weights(file: safe_open, names: set[str], wanted: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The tensors of the file, if they are of the shapes and types wanted, and finite."""
    for name in sorted(names | wanted.keys()):
        shapes = (
            tuple(file.get_slice(name).get_shape()) if name in names else "none",
            tuple(wanted[name].shape) if name in wanted else "none",
        )
        if shapes[0] != shapes[1]:
            raise ModelFileError(
                f"tensor {name} has the shape {shapes[0]}, its settings ask for {shapes[1]}"
            )
    found = {}
    for name, each in wanted.items():
        # A copy of its own: the file may be written over while the model is in use.
        found[name] = file.get_tensor(name).clone()
        _check_tensor(name, found[name], each.dtype)
        if name in _STEPS and not 1 <= found[name].item() <= _MOST_STEPS:
            raise ModelFileError(
                f"{name} is {found[name].item()}, but must be from 1 to {_MOST_STEPS}"
            )
    return found


def _check_tensor(name: str, tensor: Tensor, wanted: torch.dtype) -> None:
    if tensor.dtype != wanted:
        raise ModelFileError(f"tensor {name} is of {tensor.dtype}, not {wanted}")
    if not tensor.isfinite().all():
        raise ModelFileError(f"tensor {name} has numbers that are not finite")


def _finished(file: bytes) -> bytes:
    """Add the checksum to a safetensors file, and order its header, which the library writes in
    random order."""
    size = int.from_bytes(file[:8], "little")
    found, tensors = json.loads(file[8 : 8 + size]), file[8 + size :]
    metadata = found["__metadata__"]
    metadata["checksum"] = _checksum(hashlib.sha256(tensors).hexdigest(), metadata)
    header = json.dumps(found, sort_keys=True).encode()
    header += b" " * (-len(header) % 8)  # tensors begin at a multiple of 8, as the format asks
    return len(header).to_bytes(8, "little") + header + tensors
