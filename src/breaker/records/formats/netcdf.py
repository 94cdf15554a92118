"""Curve files of labelled arrays: NetCDF and HDF5 files and Zarr stores (the extra ``netcdf``).

Variables of the root are read; groups are not looked into, however many there are. Sizes are
checked before numbers are read.
"""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from breaker.common.lazy_numpy import np
from breaker.records.files import (
    LARGEST,
    MOST_PARTS,
    Opened,
    RejectedCurveError,
    check_size,
    is_store,
    require_folder,
)
from breaker.records.sheet import Sheet

if TYPE_CHECKING:
    import h5py

ENDINGS = dict.fromkeys((".nc", ".nc4"), "a NetCDF file") | {
    ".h5": "an HDF5 file",
    ".hdf5": "an HDF5 file",
    ".zarr": "a Zarr store",
}
SIGNATURES = (b"CDF\1", b"CDF\2", b"CDF\5", b"\x89HDF\r\n\x1a\n")
EXTRA = "netcdf"

_MISSING = ("_FillValue", "missing_value")
_ABOUT = ("units", "scale_factor", "add_offset", *_MISSING)
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"


class _Variable(NamedTuple):
    """A variable as it stands in a file: names of its dimensions, its attributes, its values."""

    along: tuple[str, ...]
    about: Mapping
    values: np.ndarray


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the variables of numbers along each dimension, those along the longest one first: see
    ``registry``. The time is the coordinate of a dimension, unless another variable has its name.

    Raises:
        RejectedCurveError: If there is no variable along one dimension, or more than a record has.
        ModuleNotFoundError: If a package for this version is not installed.
    """
    if is_store(opened.file):
        attributes, variables = _in_store(opened)
    elif opened.content.startswith(SIGNATURES[-1]):
        attributes, variables = _in_hdf5(opened)
    else:
        attributes, variables = _in_version_3(opened)
    by_dimension: dict[tuple[str, int], dict[str, _Variable]] = {}
    for name, variable in variables.items():
        sizes = zip(variable.along, variable.values.shape, strict=True)
        long = [pair for pair in sizes if pair[1] > 1]
        if len(long) == 1:
            by_dimension.setdefault(long[0], {})[name] = variable
    if not by_dimension:
        reason = "has no variable of numbers along one dimension outside of groups; export one"
        raise RejectedCurveError(opened.file, reason)
    stated = [[f"{name} :", _text(attributes[name])] for name in attributes if name[:1] != "_"]
    sheets = []
    for (along, size), those in sorted(by_dimension.items(), key=lambda item: -item[0][1]):
        check_size(opened.file, size, len(those))
        names, columns = list(those), [_readings(each) for each in those.values()]
        # A date that times are counted from is not a part of their unit.
        units = [_text(each.about.get("units", "")).split(" since ")[0] for each in those.values()]
        timed = along in names and form.get("time_column", "") is not None
        clock = names.index(along) if timed else None
        sheets.append(Sheet(opened.file, names, columns, units, stated, clock=clock))
    return sheets


def _text(value: object) -> str:
    """An attribute as a text."""
    if isinstance(value, list | np.ndarray) and len(value) == 1:
        value = value[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _readings(variable: _Variable) -> np.ndarray:
    """Values ``(t,)`` by the conventions of CF: NaN where missing, with factor and offset."""
    stored, about = variable.values.reshape(-1), variable.about
    factor, offset = about.get("scale_factor", 1.0), about.get("add_offset", 0.0)
    values = stored * np.float64(np.ravel(factor)[0]) + np.float64(np.ravel(offset)[0])
    for name in _MISSING:
        if name in about:
            values[np.isin(stored, about[name])] = np.nan
    return values


def _check_bytes(file: str | Path, size: int) -> None:
    if size > LARGEST:
        reason = f"has {size} bytes of numbers, or in one chunk; export the record alone, as CSV"
        raise RejectedCurveError(file, reason)


def _in_version_3(opened: Opened) -> tuple[Mapping, dict[str, _Variable]]:
    """The attributes of a file of version 3, and its variables of numbers by name."""
    from scipy.io import netcdf_file

    with netcdf_file(io.BytesIO(opened.content), mmap=False) as file:
        file._attributes.pop("variables", None)
        return file._attributes, {
            name: _Variable(each.dimensions, each._attributes, each.data)
            for name, each in file.variables.items()
            if each.data.dtype.kind in "iuf"
        }


def _in_hdf5(opened: Opened) -> tuple[Mapping, dict[str, _Variable]]:
    """The same of an HDF5 file; a link may lead to any file, and is refused."""
    import h5py

    _check_texts(opened)
    # By its name, since h5py may crash as the process ends where a damaged file is one in memory.
    with h5py.File(opened.file, "r", locking=False) as file:
        return _of_root(opened, file)


def _of_root(opened: Opened, file: h5py.File) -> tuple[Mapping, dict[str, _Variable]]:
    """Return the attributes and the variables in the root of an HDF5 file."""
    import h5py

    variables, size = {}, 0
    if len(file) > MOST_PARTS:
        raise RejectedCurveError(
            opened.file, f"has more than {MOST_PARTS} parts; export one record"
        )
    for name in file:
        if not isinstance(file.get(name, getlink=True), h5py.HardLink):
            reason = f"has a link {name!r} to another place; export one file without links"
            raise RejectedCurveError(opened.file, reason)
        if file.get(name, getclass=True) is not h5py.Dataset:
            continue
        part = file[name]
        # A dimension without a coordinate is stored as if it were a variable.
        if part.dtype.kind not in "iuf" or _NO_VARIABLE in _text(part.attrs.get("NAME", "")):
            continue
        if part.external or part.is_virtual:
            raise RejectedCurveError(opened.file, f"has {name!r} in another file; export one file")
        size += part.nbytes
        _check_bytes(opened.file, max(size, prod(part.chunks or ()) * part.dtype.itemsize))
        check_size(opened.file, 0, len(variables) + 1)
        scales = [scale[0].name.removeprefix("/") if len(scale) else "" for scale in part.dims]
        pairs = zip(scales, part.shape, strict=True)
        along = [name] if part.is_scale else [scale or str(length) for scale, length in pairs]
        about = {key: part.attrs[key] for key in _ABOUT if key in part.attrs}
        variables[name] = _Variable(tuple(along), about, part[()])
    return dict(file.attrs), variables


def _check_texts(opened: Opened) -> None:
    """Refuse damaged collections of texts, on which HDF5 2.0 hangs (1 of 1,000 mutated files). Each
    object has a number (0 for the free rest) and a size; the next one follows.
    """
    for start in re.finditer(b"GCOL\1\0\0\0", opened.content):
        place, (size,) = start.end() + 8, struct.unpack_from("<Q", opened.content, start.end())
        end = start.start() + size
        while place + 16 <= end:
            number, size = struct.unpack_from("<H6xQ", opened.content, place)
            step = 16 + (size + 7) // 8 * 8 if number else size
            if step < 16 or place + step > end:
                raise RejectedCurveError(opened.file, "has damaged texts; copy it again")
            place += step


def _in_store(opened: Opened) -> tuple[Mapping, dict[str, _Variable]]:
    """The same of a Zarr store."""
    require_folder(opened.file)
    import zarr

    store = zarr.open_group(str(opened.file), mode="r")
    arrays = {name: each for name, each in store.arrays() if each.dtype.kind in "iuf"}
    size, chunks = sum(each.nbytes for each in arrays.values()), 0
    for array in arrays.values():
        size = max(size, prod(array.shards or array.chunks) * array.dtype.itemsize)
        chunks += array.nchunks
    _check_bytes(opened.file, size)
    if chunks > MOST_PARTS:
        raise RejectedCurveError(
            opened.file, f"has {chunks} chunks; export the record in larger ones"
        )
    variables = {}
    for name, array in arrays.items():
        along = getattr(array.metadata, "dimension_names", None)
        along = along or array.attrs.get("_ARRAY_DIMENSIONS") or map(str, array.shape)
        about = dict(array.attrs)
        if array.metadata.zarr_format == 2 and array.fill_value:
            about["_FillValue"] = array.fill_value  # in version 2, it stands for missing samples
        variables[name] = _Variable(tuple(along), about, array[...])
    return dict(store.attrs), variables
