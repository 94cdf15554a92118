"""Model files: all of a network in one safetensors file, without pickle.

A file holds weights, and in its header the settings that made them, as JSON, and a checksum. It may
come from anywhere, so nothing in it is used before it is known to be finite and of the right size.
The plan of the workflow reads settings where neither numpy nor safetensors may be there.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from breaker import __version__
from breaker.common.compiling import np

_FORMAT = "breaker network 1"
_LARGEST = 10_000  # layers, widths and samples; ten times those of any network of the project
_REMEDY = "train it anew"
# What is raised where settings are not those of a model.
_UNFIT = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)


class ModelFileError(ValueError):
    """A model file that cannot be used; the message names the file, the fault and the remedy."""


class SavedModel(NamedTuple):
    """A model file: the settings that made the model, and its weights by their names."""

    settings: dict
    arrays: Mapping[str, np.ndarray]

    def weight(self, name: str, dtype: str) -> np.ndarray:
        """Return a tensor of the weights; refuse another type, and numbers that are not finite."""
        weights = np.array(self.arrays[name])  # which may be changed, unlike that of the file
        if weights.dtype != dtype:
            raise ModelFileError(f"tensor {name} is of {weights.dtype}, not {dtype}")
        if not np.isfinite(weights).all():
            raise ModelFileError(f"tensor {name} has numbers that are not finite")
        return weights


@contextmanager
def open_model(path: str | Path) -> Iterator[SavedModel]:
    """Open a model file; what is raised while it is open names the file and the remedy.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it is of another format, was changed, or makes no model.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    content = _content(path)
    try:
        arrays = load(content)
    except (SafetensorError, KeyError) as error:  # KeyError: a type that numpy does not have
        raise _not_a_model(path, error) from error
    try:
        header, tensors = _parts(content)
        about = header.get("__metadata__", {})
        settings = _settings(about)
        if (given := about.get("checksum")) != _checksum(tensors, about):
            what = "is another" if given else "is missing"
            raise ModelFileError(f"its checksum {what}: it was changed after it was written")
        yield SavedModel(settings, arrays)
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}; {_REMEDY}") from error
    except _UNFIT as error:
        why = f"its settings do not describe a model ({type(error).__name__}: {error})"
        raise ModelFileError(f"{path}: {why}; {_REMEDY}") from error


def settings_of(path: str | Path) -> dict:
    """Return the settings of a model file, whatever its tensors; raise as ``open_model``."""
    content = _content(path)
    try:
        return _settings(_parts(content)[0]["__metadata__"])
    except _UNFIT as error:  # such as a ModelFileError
        raise _not_a_model(path, error) from error


def write_model(path: str | Path, settings: Mapping, weights: Mapping[str, np.ndarray]) -> None:
    """Write a model file. The same model gives the same bytes."""
    from safetensors.numpy import save

    header = {"format": _FORMAT, "breaker_version": __version__}
    header["settings"] = json.dumps(settings, sort_keys=True)
    arrays = {name: weight.copy(order="C") for name, weight in weights.items()}
    Path(path).write_bytes(_finished(save(arrays, metadata=header)))


def _not_a_model(path: str | Path, error: Exception) -> ModelFileError:
    return ModelFileError(f"{path} is not a model file of breaker ({error}); {_REMEDY}")


def _content(path: str | Path) -> bytes:
    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no model file {path}; {_REMEDY}")
    return Path(path).read_bytes()


def _parts(content: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the header of a safetensors file, and its tensors."""
    end = 8 + int.from_bytes(content[:8], "little")
    return json.loads(content[8:end]), content[end:]


def _checksum(tensors: bytes, about: Mapping[str, str]) -> str:
    actual = hashlib.sha256(tensors).hexdigest() + about["settings"]
    return hashlib.sha256(actual.encode()).hexdigest()


def _finished(content: bytes) -> bytes:
    """Add the checksum to a safetensors file, and sort its header, which the library does not."""
    header, tensors = _parts(content)
    about = header["__metadata__"]
    about["checksum"] = _checksum(tensors, about)
    text = json.dumps(header, sort_keys=True).encode()
    text += b" " * (-len(text) % 8)  # tensors begin at a multiple of 8, as the format asks
    return len(text).to_bytes(8, "little") + text + tensors


def _settings(about: Mapping[str, str]) -> dict:
    """Return settings, in which numbers are finite and sizes are such as networks have."""
    if (given := about.get("format")) != _FORMAT:
        raise ModelFileError(f"its format is {given!r}, this version of breaker reads {_FORMAT!r}")
    settings = dict(json.loads(about["settings"], parse_float=_finite, parse_constant=_finite))
    _check_sizes([settings.get("network"), settings.get("sensor", {}).get("samples", 0)])
    return settings


def _finite(text: str) -> float:
    if not math.isfinite(value := float(text)):
        raise ValueError(f"a number is {value}")
    return value


def _check_sizes(lengths: object) -> None:
    """Refuse large numbers in settings, and long lists."""
    many = isinstance(lengths, Mapping | list)
    size = len(lengths) if many else lengths
    if isinstance(size, int | float) and size > _LARGEST:
        raise ValueError(f"a size is {size:g}, and sizes are at most {_LARGEST}")
    for length in (lengths.values() if isinstance(lengths, Mapping) else lengths) if many else ():
        _check_sizes(length)
