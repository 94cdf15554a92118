"""How far a life was followed, in a file: of a longer one only what was appended is gone through.

Whatever the path so far depends on is in a fingerprint: values, settings and code. Another life is
left alone and written over, as is this one where an operation was replaced.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from zipfile import BadZipFile

import numpy as np


def fingerprint(settings: object, arrays: Iterable[np.ndarray | None]) -> str:
    """Return a hash of settings, of arrays and of the code that follows lives."""
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    for file in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(file.read_bytes())
    for array in arrays:
        digest.update(repr(np.shape(array)).encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def read_kept(file: str) -> dict[str, np.ndarray]:
    """Return what ``keep`` wrote; nothing if the file is not there.

    Raises:
        ValueError: If the file cannot be read.
    """
    if not Path(file).exists():
        return {}
    try:
        with np.load(file) as kept:
            return dict(kept)
    except (BadZipFile, EOFError, ValueError) as error:
        raise ValueError(
            f"{file} cannot be read ({type(error).__name__}); delete it to follow the life from "
            "the start"
        ) from error


def keep(file: str, state: Mapping[str, np.ndarray | float | str]) -> None:
    """Write a state to a file, whole or not at all."""
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    partial = Path(file).with_suffix(".partial.npz")
    np.savez(partial, **state)
    partial.replace(file)
