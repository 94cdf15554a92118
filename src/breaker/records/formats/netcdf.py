"""Curve files of labelled arrays: NetCDF and HDF5 files and Zarr stores (the extra ``netcdf``).

A process of its own reads HDF5 and Zarr, within bounds of time and memory: their libraries are
written in C, and a file that is damaged or made up may crash or hang them, or be unpacked to any
size. That process knows no codec that runs what stands in the data.
"""

from __future__ import annotations

import importlib.util
import io
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from typing import NamedTuple

from breaker.common.lazy_numpy import np
from breaker.records.files import (
    LARGEST,
    MOST_PARTS,
    Opened,
    RejectedCurveError,
    TooLargeError,
    check_size,
    is_store,
    require_folder,
)
from breaker.records.sheet import Sheet

ENDINGS = dict.fromkeys((".nc", ".nc4"), "a NetCDF file") | {
    ".h5": "an HDF5 file",
    ".hdf5": "an HDF5 file",
    ".zarr": "a Zarr store",
}
SIGNATURES = (b"CDF\1", b"CDF\2", b"CDF\5", b"\x89HDF\r\n\x1a\n")
EXTRA = "netcdf"

_SECONDS = 5  # of a processor, for one file: the largest records take a second
_MEMORY = 10 * LARGEST  # of the process, of which libraries take half
_MOST_READS = 10 * MOST_PARTS  # of a file of version 3, which has some ten for each variable
_REMEDY = "export the record alone, as CSV for example"


class _Variable(NamedTuple):
    """A variable as it stands in a file: the names of its dimensions, and what it states."""

    along: tuple[str, ...]
    attributes: Mapping
    values: np.ndarray


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the variables of numbers along each dimension, those along the longest one first: see
    ``registry``. The time is the coordinate of a dimension, unless another variable has its name.

    Raises:
        RejectedCurveError: If it cannot be read, or has no variable along one dimension.
        TooLargeError: If it has more values, variables or parts than a record.
        ModuleNotFoundError: If a package for this version is not installed.
    """
    attributes, variables = _contents(opened)
    sheets: dict[tuple[str, int], dict[str, _Variable]] = {}
    for name, variable in variables.items():
        sizes = zip(variable.along, variable.values.shape, strict=True)
        long = [(str(along), size) for along, size in sizes if size > 1]
        if len(long) == 1:
            sheets.setdefault(long[0], {})[name] = variable
    if not sheets:
        raise RejectedCurveError(opened.file, "has no variable of numbers along one dimension")
    own = {name: value for name, value in attributes.items() if not name.startswith("_")}
    said, found = [[f"{name} :", _text(value)] for name, value in own.items()], []
    for (along, size), those in sorted(sheets.items(), key=lambda each: -each[0][1]):
        check_size(opened.file, size, len(those))
        names, columns = list(those), [_readings(each) for each in those.values()]
        # A date that times are counted from is no part of their unit.
        units = [_text(each.attributes.get("units", "")) for each in those.values()]
        timed = along in names and form.get("time_column", "") is not None
        clock = names.index(along) if timed else None
        texts = [unit.split(" since ")[0] for unit in units]
        found.append(Sheet(opened.file, names, columns, texts, said, clock=clock))
    return found


def _text(value: object) -> str:
    """An attribute as a text."""
    if isinstance(value, list | np.ndarray) and len(value) == 1:
        value = value[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _readings(variable: _Variable) -> np.ndarray:
    """Values ``(t,)`` by the conventions of CF: NaN where missing, with factor and offset."""
    stored, about = variable.values.reshape(-1), variable.attributes
    missing = [about[name] for name in ("_FillValue", "missing_value") if name in about]
    factor, offset = about.get("scale_factor", 1.0), about.get("add_offset", 0.0)
    values = stored * np.float64(np.ravel(factor)[0]) + np.float64(np.ravel(offset)[0])
    for each in missing:
        values[np.isin(stored, each)] = np.nan
    return values


def _contents(opened: Opened) -> tuple[Mapping, dict[str, _Variable]]:
    """The attributes of a file, and its variables of numbers by name."""
    if is_store(opened.file):
        require_folder(opened.file)
        return _contents_apart(opened, "zarr", os.fsencode(os.path.abspath(opened.file)))
    if opened.content.startswith(SIGNATURES[-1]):
        return _contents_apart(opened, "h5py", opened.content)
    from scipy.io import netcdf_file

    with netcdf_file(_ReadOnce(opened.content), mmap=False) as file:
        file._attributes.pop("variables", None)
        return file._attributes, {
            name: _Variable(each.dimensions, each._attributes, each.data)
            for name, each in file.variables.items()
            if each.data.dtype.kind in "iuf"
        }


class _ReadOnce(io.BytesIO):
    """A file of version 3: its variables may be the same bytes, over and over."""

    def __init__(self, content: bytes) -> None:
        super().__init__(content)
        self._reads, self._bytes = _MOST_READS, 2 * len(content)

    def read(self, size: int | None = -1) -> bytes:
        found = super().read(size)
        self._reads, self._bytes = self._reads - 1, self._bytes - len(found)
        if min(self._reads, self._bytes) < 0:
            raise TooLargeError(f"has too many variables, or parts of it twice; {_REMEDY}")
        return found


# ---- in a process of its own ---------------------------------------------------------------------


def _contents_apart(
    opened: Opened, package: str, given: bytes
) -> tuple[Mapping, dict[str, _Variable]]:
    """What another process reads from the content of a file, or from a folder."""
    if importlib.util.find_spec(package) is None:
        raise ModuleNotFoundError(f"no module named {package}", name=package)
    answer = opened.once("answer", lambda: _answer(package, given))
    if not answer:
        reason = (
            f"cannot be read in {_SECONDS} s and {_MEMORY // 2**20} MiB, or crashes the library "
            f"that reads it; is it whole? Else {_REMEDY}"
        )
        raise RejectedCurveError(opened.file, reason)
    arrays = np.load(io.BytesIO(answer), allow_pickle=False)
    about = json.loads(str(arrays["about"]))
    if "error" in about:
        raise RejectedCurveError(opened.file, about["error"])
    return about["attributes"], {
        name: _Variable(along, attributes, arrays[f"values{number}"])
        for number, (name, along, attributes) in enumerate(about["variables"])
    }


def _answer(package: str, given: bytes) -> bytes:
    """What the other process writes; nothing where it was ended."""
    code = f"from {__name__} import _work; _work({package!r})"
    paths = os.pathsep.join(filter(None, sys.path))
    own = {**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-W", "ignore", "-c", code]
    done = subprocess.run(command, input=given, capture_output=True, env=own)
    return done.stdout if done.returncode == 0 else b""


def _work(package: str) -> None:
    """Read what the standard input holds, and write it to the standard output as arrays."""
    import resource

    resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    arrays = {}
    try:
        given = sys.stdin.buffer.read()
        attributes, variables = (_in_store if package == "zarr" else _in_hdf5)(given)
        described = [(name, each.along, each.attributes) for name, each in variables.items()]
        about = json.dumps({"attributes": attributes, "variables": described}, default=_plain)
        arrays = {f"values{number}": each.values for number, each in enumerate(variables.values())}
    except TooLargeError as error:
        about = json.dumps({"error": str(error)})
    except Exception as error:  # a damaged file raises anything in the package that reads it
        said = f"cannot be read ({type(error).__name__}: {str(error)[:200]}); is it whole?"
        about = json.dumps({"error": f"{said} Export it again"})
    np.savez(sys.stdout.buffer, about=np.array(about), **arrays)


def _plain(value: object) -> object:
    """An attribute as JSON has it."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else _text(value)


def _in_hdf5(content: bytes) -> tuple[Mapping, dict[str, _Variable]]:
    """What is in an HDF5 file; variables of groups are named by their paths."""
    import h5py

    file = h5py.File.in_memory(content)
    found: dict[str, h5py.Dataset] = {}
    size = count = 0

    def look(name: str, part: h5py.Group | h5py.Dataset) -> None:
        nonlocal size, count
        if isinstance(part, h5py.Group):
            links = [part.get(each, getlink=True) for each in part]
            elsewhere = any(isinstance(link, h5py.ExternalLink) for link in links)
            count += len(links)
        else:
            elsewhere = bool(part.external) or part.is_virtual
            # A dimension without a coordinate is stored as if it were a variable.
            none = "This is a netCDF dimension but not a netCDF variable"
            if part.dtype.kind in "iuf" and none not in str(part.attrs.get("NAME")):
                found[name], size = part, size + part.nbytes
        if elsewhere:
            raise TooLargeError(f"has {name!r} in another file; export it as one file")
        if size > LARGEST or count > MOST_PARTS:
            raise TooLargeError(f"has {count} parts with {size} bytes of numbers; {_REMEDY}")

    def along(name: str, part: h5py.Dataset) -> list[str]:
        scales = [scale[0].name.removeprefix("/") if len(scale) else "" for scale in part.dims]
        pairs = zip(scales, part.shape, strict=True)
        return [name] if part.is_scale else [scale or str(size) for scale, size in pairs]

    look("/", file)
    file.visititems(look)
    return dict(file.attrs), {
        name: _Variable(along(name, part), dict(part.attrs), part[()])
        for name, part in found.items()
    }


def _in_store(folder: bytes) -> tuple[Mapping, dict[str, _Variable]]:
    """What is in a Zarr store."""
    import numcodecs.registry
    import zarr

    numcodecs.registry.codec_registry.pop("pickle", None)
    numcodecs.registry.entries.clear()  # of other distributions
    store = zarr.open_group(os.fsdecode(folder), mode="r")
    arrays = {name: each for name, each in store.arrays() if each.dtype.kind in "iuf"}
    size = sum(array.nbytes for array in arrays.values())
    count = sum(array.nchunks for array in arrays.values())
    if size > LARGEST or count > MOST_PARTS:
        raise TooLargeError(f"has {count} chunks with {size} bytes of numbers; {_REMEDY}")
    return dict(store.attrs), {
        name: _Variable(
            getattr(array.metadata, "dimension_names", None)
            or array.attrs.get("_ARRAY_DIMENSIONS", [str(size) for size in array.shape]),
            _stated(array),
            array[...],
        )
        for name, array in arrays.items()
    }


def _stated(array) -> dict:
    """Attributes of an array of a store; in version 2, what fills it is what is missing."""
    fills = array.metadata.zarr_format == 2 and bool(array.fill_value)
    return {**array.attrs, **({"_FillValue": array.fill_value} if fills else {})}
