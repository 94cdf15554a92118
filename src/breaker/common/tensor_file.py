"""Model files: all of a network in one safetensors file, without pickle.

Weights, and in the header a JSON text with all settings that made them, and a checksum. A file may
come from anywhere, so nothing in it is used before it is known to be finite and of the size that it
should have. This module needs no torch: it reads and writes arrays, and knows nothing of networks.
The plan of the workflow reads settings alone, where neither numpy nor safetensors may be there.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from breaker import __version__
from breaker.common.lazy_numpy import np

if TYPE_CHECKING:
    from safetensors import safe_open

_FORMAT = "breaker network 1"
_HEADER = ("format", "breaker_version", "settings", "checksum")
_LONGEST_HEADER = 1_000_000  # bytes
_LARGEST = 100_000  # size in the settings of sensor and network
_MOST = 100  # layers of one kind, one number each or as many as a number says
_LAYERS = ("blocks", "pair_blocks", "transforms")
_REMEDY = "train it anew"
_TYPES = {"F64": "float64", "F32": "float32", "I64": "int64"}


class ModelFileError(ValueError):
    """A model file that cannot be used; the message names the file, the fault and the remedy."""

    @classmethod
    def of_settings(cls, error: Exception) -> ModelFileError:
        """Return the error of a file from whose settings no model can be built."""
        reason = f"{type(error).__name__}: {error}"
        return cls(f"its settings do not describe a model ({reason})")


@dataclass(frozen=True, eq=False)
class SavedModel:
    """An open model file.

    Attributes:
        settings: What made the model, every number finite.
        shapes: Shapes of the weights, by their names.
    """

    settings: dict
    shapes: Mapping[str, tuple[int, ...]]
    _file: safe_open

    def weight(self, name: str, dtype: str) -> np.ndarray:
        """Return a tensor of the weights.

        Raises:
            ModelFileError: If it is of another type than ``dtype``, or has numbers that are not
                finite.
        """
        found = self._file.get_slice(name).get_dtype()
        if _TYPES.get(found) != dtype:
            raise ModelFileError(f"tensor {name} is of {_TYPES.get(found, found)}, not {dtype}")
        # A copy of its own: the file may be written over while the model is in use.
        array = np.array(self._file.get_tensor(name))
        if not np.isfinite(array).all():
            raise ModelFileError(f"tensor {name} has numbers that are not finite")
        return array


@contextmanager
def open_model(path: str | Path) -> Iterator[SavedModel]:
    """Open a model file; what is raised while it is open names the file and the remedy.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is not a model file, is of another format, was changed after it was
            written, or holds settings or tensors that make no model.
    """
    from safetensors import SafetensorError, safe_open

    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no model file {path}; {_REMEDY}")
    try:
        tensors = _hash_of_tensors(path)
        with safe_open(str(path), framework="numpy") as file:
            header = file.metadata() or {}
            settings = _settings(header)
            if header.get("checksum") != _checksum(tensors, header):
                what = "is another" if "checksum" in header else "is missing"
                raise ModelFileError(f"its checksum {what}: it was changed after it was written")
            shapes = {name: tuple(file.get_slice(name).get_shape()) for name in list(file.keys())}
            yield SavedModel(settings, shapes, file)
    except SafetensorError as error:
        raise ModelFileError(
            f"{path} is not a model file of breaker ({error}); {_REMEDY}"
        ) from error
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}; {_REMEDY}") from error


def settings_of(path: str | Path) -> dict:
    """Return the settings of a model file, without a look at its tensors.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is not a model file, or is of another format.
    """
    try:
        with Path(path).open("rb") as file:
            size = int.from_bytes(file.read(8), "little")
            header = json.loads(file.read(min(size, _LONGEST_HEADER)))
        return _settings(header["__metadata__"])
    except FileNotFoundError as error:
        raise FileNotFoundError(f"there is no model file {path}; {_REMEDY}") from error
    except (KeyError, TypeError, ValueError) as error:  # such as a ModelFileError
        raise ModelFileError(
            f"{path} is not a model file of breaker ({error}); {_REMEDY}"
        ) from error


def write_model(path: str | Path, settings: Mapping, weights: Mapping[str, np.ndarray]) -> None:
    """Write a model file. The same model gives the same bytes."""
    from safetensors.numpy import save

    header = {
        "format": _FORMAT,
        "breaker_version": __version__,
        "settings": json.dumps(settings, sort_keys=True),
    }
    arrays = {name: np.array(each, order="C") for name, each in weights.items()}
    Path(path).write_bytes(_finished(save(arrays, metadata=header)))


def _hash_of_tensors(path: str | Path) -> str:
    """Read the tensors through; a header that would take long to read is refused."""
    from safetensors import SafetensorError

    if not os.path.getsize(path):  # such as /proc/kmsg, which waits for more
        raise SafetensorError("it is empty")
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
    if (found := header.get("format")) != _FORMAT:
        raise ModelFileError(f"its format is {found!r}, this version of breaker reads {_FORMAT!r}")
    if unknown := sorted(header.keys() - {*_HEADER}):
        raise ModelFileError(f"its header has {', '.join(map(repr, unknown))}, which is not known")
    try:
        settings = json.loads(header["settings"])
        if not isinstance(settings, dict):
            raise TypeError("they are no section")
        for place, number in _numbers(settings):
            if not math.isfinite(number):
                raise ValueError(f"{'.'.join(place)} is {number}")
            most = _MOST if place[-1] in _LAYERS else _LARGEST
            if place[0] == "network" and number > most:
                raise ValueError(f"{'.'.join(place)} is {number:g}, more than {most}")
        if settings.get("sensor", {}).get("samples", 0) > _LARGEST:
            raise ValueError(f"sensor.samples is more than {_LARGEST}")
    except (ArithmeticError, KeyError, RecursionError, TypeError, ValueError) as error:
        raise ModelFileError.of_settings(error) from error
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
