"""Model files: a network in one safetensors file, without pickle.

A file contains the weights, and in its header the settings of the network, as JSON.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker import __version__

_REMEDY = "train it again"
# Errors raised by settings or tensors that do not describe a model.
_UNFIT = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)


class ModelFileError(ValueError):
    """A model file that cannot be used; the message names the file, the fault and the remedy."""


class SavedModel(NamedTuple):
    """A model file: settings of the model, and its weights by name."""

    settings: dict
    arrays: Mapping[str, np.ndarray]

    def weight(self, name: str, dtype: str) -> np.ndarray:
        """Return a tensor; raise a ModelFileError for a wrong type or a number not finite."""
        weights = np.array(self.arrays[name])
        if weights.dtype != dtype:
            raise ModelFileError(f"tensor {name} is of {weights.dtype}, not {dtype}")
        if not np.isfinite(weights).all():
            raise ModelFileError(f"tensor {name} has numbers that are not finite")
        return weights


@contextmanager
def open_model(path: str | Path) -> Iterator[SavedModel]:
    """Open a model file; errors that are raised while it is open get the file name and a remedy.

    Raises:
        FileNotFoundError: If there is no such file.
        ModelFileError: If it has another format, or does not describe a model.
    """
    from safetensors.numpy import load_file

    settings = settings_of(path)
    try:
        yield SavedModel(settings, load_file(path))
    except ModelFileError as error:
        raise ModelFileError(f"{path}: {error}; {_REMEDY}") from error
    except _UNFIT as error:
        why = f"its settings do not describe a model ({type(error).__name__}: {error})"
        raise ModelFileError(f"{path}: {why}; {_REMEDY}") from error


def settings_of(path: str | Path) -> dict:
    """Return the settings of a model file without reading its tensors; raise as ``open_model``."""
    from safetensors import SafetensorError, safe_open

    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no model file {path}; {_REMEDY}")
    try:
        with safe_open(path, framework="numpy") as file:
            settings = dict(json.loads(file.metadata()["settings"]))
    except (SafetensorError, *_UNFIT) as error:
        what = f"is not a model file of breaker ({error})"
        raise ModelFileError(f"{path} {what}; {_REMEDY}") from error
    settings.pop("breaker_version", None)
    return settings


def write_model(path: str | Path, settings: Mapping, weights: Mapping[str, np.ndarray]) -> None:
    """Write a model file. The same model gives the same bytes.

    The header has only one entry, because safetensors writes several in any order.
    """
    from safetensors.numpy import save_file

    text = json.dumps({"breaker_version": __version__, **settings}, sort_keys=True)
    arrays = {name: weight.copy(order="C") for name, weight in weights.items()}
    save_file(arrays, path, metadata={"settings": text})
