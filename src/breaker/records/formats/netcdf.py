"""Curve files of labelled arrays, by xarray: NetCDF (version 4 needs the extra ``netcdf``), Zarr.

What a Zarr store states of its arrays is looked at before any of them is read: some codecs run what
stands in the data, and a chunk that is stored in a few bytes may be unpacked to any size. The HDF5
library reads version 4 in this process, so a hostile file can crash or hang the command.
"""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from breaker.common.lazy_numpy import np
from breaker.records.files import (
    Opened,
    RejectedCurveError,
    TooLargeError,
    check_size,
    is_store,
    read_bytes,
    require_folder,
)
from breaker.records.sheet import Sheet

if TYPE_CHECKING:
    import h5py

_MOST = 20_000_000  # values of all variables
_MOST_READS = 100_000  # of a NetCDF file of version 3, which has some ten for each variable
_REMEDY = "export the record alone"
_UNTOUCHED = {"decode_times": False, "decode_timedelta": False, "chunks": None}


ENDINGS = {".nc": "a NetCDF file", ".nc4": "a NetCDF file", ".zarr": "a Zarr store"}
SIGNATURES = (b"CDF\1", b"CDF\2", b"CDF\5", b"\x89HDF\r\n\x1a\n")
EXTRA = "netcdf"

_FILES = (".zarray", ".zmetadata", "zarr.json")  # of version 2, of all of its arrays, of version 3
_CODECS = re.compile(
    r"(?:numcodecs\.)?(?:blosc|zstd|gzip|zlib|lz4|lzma|bz2|crc32c?|adler32|fletcher32|shuffle|delta|"
    "quantize|fixedscaleoffset|bitround|vlen-utf8|vlen-bytes|bytes|transpose|sharding_indexed)"
)
_NAMING = ("id", "name", "configuration", "codecs", "index_codecs")
_LARGEST_CHUNK = 80_000_000  # bytes of a chunk
_MOST_BYTES, _MOST_CHUNKS = 320_000_000, 10_000  # stated; consolidated metadata do so again


def read(opened: Opened, form: Mapping) -> list[Sheet]:
    """Return the variables of a NetCDF file or a Zarr store along each dimension, those along the
    longest one first: see ``registry``. The time is the coordinate of a dimension, unless another
    variable has its name.
    """
    file, found = opened.file, []
    with _open(opened) as dataset:
        said = [[f"{name} :", str(value)] for name, value in dataset.attrs.items()]
        for along in sorted(dataset.sizes, key=dataset.sizes.get, reverse=True):
            every = {
                str(name): each
                for name, each in dataset.variables.items()
                if each.dtype.kind in "iuf" and _along(each) == along
            }
            check_size(file, dataset.sizes[along], len(every))
            names = list(every)
            columns = [each.values.reshape(-1).astype(float) for each in every.values()]
            texts = [_unit_text(each) for each in every.values()]
            timed = along in names and form.get("time_column", "") is not None
            clock = names.index(along) if timed else None
            if names:
                found.append(Sheet(file, names, columns, texts, said, clock=clock))
    if not found:
        raise RejectedCurveError(file, "has no variable of numbers along one dimension")
    return found


def _along(variable) -> str | None:
    """The only dimension along which a variable has several values."""
    long = [str(name) for name, size in variable.sizes.items() if size > 1]
    return long[0] if len(long) == 1 else None


def _open(opened: Opened):
    """Return the dataset of a NetCDF file, or of a Zarr store by its ending, undecoded.

    Raises:
        RejectedCurveError: If the file cannot be read, or a store states what may do harm.
        TooLargeError: If there are more values than a record has.
        ModuleNotFoundError: If a package for this version is not installed.
    """
    import xarray as xr

    file = opened.file
    if is_store(file):
        _check_store(file)
        return xr.open_zarr(file, **_UNTOUCHED)
    content = opened.content
    if content.startswith(SIGNATURES[-1]):
        import h5netcdf
        import h5py
        from xarray.backends import H5NetCDFStore

        # In memory: HDF5 crashes as a process ends that has left a file open which Python reads.
        held = h5py.File.in_memory(content)
        _check_hdf5(held)
        # Dimensions without a name get one, as xarray does for a file that it opens itself.
        store = H5NetCDFStore(h5netcdf.File(held, "r", phony_dims="access"))
        dataset = xr.open_dataset(store, **_UNTOUCHED)
    else:
        dataset = xr.open_dataset(_ReadOnce(content), engine="scipy", **_UNTOUCHED)
    if (size := sum(each.size for each in dataset.variables.values())) > _MOST:
        raise TooLargeError(f"has {size} values, but no record has more than {_MOST}; {_REMEDY}")
    return dataset


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


def _unit_text(variable) -> str:
    """Return the unit that a variable states, without the date that times are counted from."""
    return str(variable.attrs.get("units", "")).split(" since ")[0]


def _check_hdf5(file: h5py.File) -> None:
    """Refuse values in other files, which would be read whatever these are, and too large chunks.

    Raises:
        TooLargeError: If a part is in another file, or a chunk is larger than ``_LARGEST_CHUNK``.
    """
    import h5py

    def look(name: str, part: h5py.Group | h5py.Dataset) -> None:
        if isinstance(part, h5py.Group):
            links = (part.get(each, getlink=True) for each in part)
            apart = any(isinstance(link, h5py.ExternalLink) for link in links)
        else:
            apart = bool(part.external) or part.is_virtual
            if (size := math.prod(part.chunks or ()) * part.dtype.itemsize) > _LARGEST_CHUNK:
                raise TooLargeError(f"has {name!r} in chunks of {size} bytes; {_REMEDY}")
        if apart:
            raise TooLargeError(f"has {name!r} in another file; export it as one file")

    look("/", file)
    file.visititems(look)


def _check_store(folder: str | Path) -> None:
    """Make sure that a Zarr store can be read: by no code of its own, and in bounds.

    Raises:
        RejectedCurveError: If it is no folder of files, an array has a codec that is not known to
            be harmless, or the arrays are too large or of too many chunks.
    """
    require_folder(folder)
    size = count = 0
    for part in sorted(Path(folder).rglob("*")):
        for array in _arrays(json.loads(read_bytes(part))) if part.name in _FILES else ():
            place = f"its part {part.relative_to(folder)} has"
            for name in _names([array.get(key) for key in ("compressor", "filters", "codecs")]):
                if not _CODECS.fullmatch(name):
                    why = "is not known to be harmless; write it again with zstd, or as NetCDF"
                    raise RejectedCurveError(folder, f"{place} the codec {name!r}, which {why}")
            chunk, every, chunks = _extent(array)
            size, count = size + every, count + chunks
            if chunk > _LARGEST_CHUNK or size > _MOST_BYTES or count > _MOST_CHUNKS:
                why = "with others are too many; write the record alone, with few chunks"
                held = f"{chunks} chunks of {chunk} bytes"
                raise RejectedCurveError(folder, f"{place} {held}, which {why}")


def _arrays(found: object) -> Iterator[dict]:
    """Whatever states a shape, however deep it stands."""
    if isinstance(found, dict):
        if isinstance(found.get("shape"), list | int):
            yield found
        for each in found.values():
            yield from _arrays(each)


def _names(found: object) -> Iterator[str]:
    """Names of codecs, and of those within them."""
    if isinstance(found, str):
        yield found
    elif isinstance(found, dict):
        yield from _names([found.get(key) for key in _NAMING])
    elif isinstance(found, list):
        for each in found:
            yield from _names(each)


def _extent(array: dict) -> tuple[int, int, int]:
    """Bytes of a chunk and of all chunks, unpacked, and the number of chunks, also of those that a
    chunk has."""
    shape, grids = _sizes(array["shape"]), sorted(_grids(array), key=math.prod)
    most, fewest = (
        math.prod(-(-n // m) for n, m in zip(shape, grid, strict=True))
        for grid in (grids[0], grids[-1])
    )
    chunk = math.prod(grids[-1]) * _width(array.get("data_type", array.get("dtype")))
    return chunk, chunk * fewest, most


def _grids(found: object) -> Iterator[list[int]]:
    """The shapes of chunks, and of chunks within them."""
    if isinstance(found, dict):
        yield from (_sizes(found[key]) for key in ("chunks", "chunk_shape") if key in found)
    if isinstance(found, dict | list):
        for each in found.values() if isinstance(found, dict) else found:
            yield from _grids(each)


def _sizes(stated: list[int] | int) -> list[int]:
    return stated if isinstance(stated, list) else [stated]


def _width(kind: object) -> int:
    """Bytes of a value; of a text without a length, those of its address."""
    if isinstance(kind, dict):
        return int(kind.get("configuration", {}).get("length_bytes", 8))
    return 8 if kind in ("string", "|O") else np.dtype(kind).itemsize
