"""What a Zarr store states of its arrays, looked at before any of them is read.

Some codecs run what stands in the data, and a chunk that is stored in a few bytes may be unpacked
to any size.
"""

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from breaker.reading.files.guards import RejectedCurveError, read_bytes, require_folder

_FILES = (".zarray", ".zmetadata", "zarr.json")  # of version 2, of all of its arrays, of version 3
_CODECS = re.compile(
    r"(?:numcodecs\.)?(?:blosc|zstd|gzip|zlib|lz4|lzma|bz2|crc32c?|adler32|fletcher32|shuffle|delta|"
    "quantize|fixedscaleoffset|bitround|vlen-utf8|vlen-bytes|bytes|transpose|sharding_indexed)"
)
_NAMING = ("id", "name", "configuration", "codecs", "index_codecs")
_LARGEST = 80_000_000  # bytes of a chunk
_MOST_BYTES, _MOST_CHUNKS = 320_000_000, 10_000  # stated; consolidated metadata do so again


def check_store(folder: str | Path) -> None:
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
            if chunk > _LARGEST or size > _MOST_BYTES or count > _MOST_CHUNKS:
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
