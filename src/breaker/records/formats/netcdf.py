"""Curve files of labelled arrays: NetCDF and HDF5 (the extra ``netcdf``).

Only variables of the root are read; groups are ignored, links are rejected. Sizes are checked
before numbers are read.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from math import prod

import numpy as np

from breaker.records.files import Opened, RejectedCurveError, check_bytes, check_size
from breaker.records.sheet import Sheet

_HDF5 = b"\x89HDF\r\n\x1a\n"  # first bytes of version 4
_MISSING = ("_FillValue", "missing_value")
_NOTES = ("units", "scale_factor", "add_offset", *_MISSING)
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"
_Variable = tuple[Sequence[str], Mapping, "np.ndarray"]  # dimensions, attributes and values


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return a sheet of the variables along each dimension, the longest dimension first; see
    ``registry``. The time is the coordinate of a dimension, unless another variable has its name.
    """
    if opened.content.startswith(_HDF5):
        attributes, variables = _in_hdf5(opened)
    else:
        attributes, variables = _in_version_3(opened)
    by_dimension: dict = {}
    for name, (dimensions, notes, values) in variables.items():
        long = [pair for pair in zip(dimensions, values.shape, strict=True) if pair[1] > 1]
        if len(long) == 1:
            by_dimension.setdefault(long[0], {})[name] = notes, values.reshape(-1)
    if not by_dimension:
        reason = "has no variable of numbers along one dimension outside of groups"
        raise RejectedCurveError(opened.file, f"{reason}; export one")
    stated = [[f"{name} :", _text(text)] for name, text in attributes.items() if name[:1] != "_"]
    sheets = []
    for (along, size), stored in sorted(by_dimension.items(), key=lambda item: -item[0][1]):
        check_size(opened.file, size, len(stored))
        names, columns = list(stored), [_readings(*variable) for variable in stored.values()]
        # The reference date of times is not a part of their unit.
        units = [_text(notes.get("units", "")).split(" since ")[0] for notes, _ in stored.values()]
        timed = along in names and form.get("time_column", "") is not None
        clock = names.index(along) if timed else None
        sheets.append(Sheet(opened.file, names, columns, units, stated, clock=clock))
    return sheets


def _text(value: object) -> str:
    """Return an attribute as a text."""
    if isinstance(value, list | np.ndarray) and len(value) == 1:
        value = value[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _readings(notes: Mapping, stored: np.ndarray) -> np.ndarray:
    """Return values ``(t,)`` by the CF conventions: NaN where missing, with factor and offset."""
    factor, offset = notes.get("scale_factor", 1.0), notes.get("add_offset", 0.0)
    values = stored * np.float64(np.ravel(factor)[0]) + np.float64(np.ravel(offset)[0])
    for name in notes.keys() & _MISSING:
        values[np.isin(stored, notes[name])] = np.nan
    return values


def _in_version_3(opened: Opened) -> tuple[Mapping, dict[str, _Variable]]:
    """Return the attributes of a file of version 3, and its variables of numbers."""
    from scipy.io import netcdf_file

    with netcdf_file(io.BytesIO(opened.content), mmap=False) as file:
        file._attributes.pop("variables", None)
        return file._attributes, {
            name: (variable.dimensions, variable._attributes, variable.data)
            for name, variable in file.variables.items()
            if variable.data.dtype.kind in "iuf"
        }


def _in_hdf5(opened: Opened) -> tuple[Mapping, dict[str, _Variable]]:
    """Return the attributes of a file of version 4, and its variables of numbers."""
    import h5py

    # Opened by name: with a damaged file in memory, h5py may crash when the process ends.
    with h5py.File(opened.file, "r", locking=False) as file:
        check_size(opened.file, 0, len(file))
        variables, size = {}, 0
        for name in file:
            linked = not isinstance(file.get(name, getlink=True), h5py.HardLink)
            if not linked and file.get(name, getclass=True) is not h5py.Dataset:
                continue
            if linked or file[name].external or file[name].is_virtual:
                reason = f"has {name!r} in another place; export one file without links"
                raise RejectedCurveError(opened.file, reason)
            array = file[name]
            # A dimension without a coordinate is stored as if it were a variable.
            placeholder = _NO_VARIABLE in _text(array.attrs.get("NAME", ""))
            if placeholder or array.dtype.kind not in "iuf":
                continue
            size += array.nbytes
            chunk = prod(array.chunks or ()) * array.dtype.itemsize
            check_bytes(opened.file, max(size, chunk))
            scales = [scale[0].name.removeprefix("/") if len(scale) else "" for scale in array.dims]
            pairs = zip(scales, array.shape, strict=True)
            along = [name] if array.is_scale else [scale or str(length) for scale, length in pairs]
            notes = {key: array.attrs[key] for key in _NOTES if key in array.attrs}
            variables[name] = along, notes, array[()]
        return dict(file.attrs), variables
