"""Write a dataset as a Zarr store, and open it only if its files are unchanged.

Zarr reads fill values for a chunk without a file, so a lost file would silently become numbers.
``save`` lists the checksums of all files of a store, and ``open_store`` compares them.
"""

import json
import shutil
import zlib
from pathlib import Path

import xarray as xr

from breaker import __version__

_CHECKSUMS = "checksums.json"


class StoreError(ValueError):
    """Error of a changed or incomplete store; the text names file, fault and remedy."""

    def __init__(self, path: str | Path, fault: str) -> None:
        remedy = f"Delete this store (rm -r {path}) and run the same command again"
        super().__init__(f"{path}: {fault}. {remedy}")


def describe(dataset: xr.Dataset, title: str, **settings: object) -> xr.Dataset:
    """Return the dataset with title, settings and version in its attributes."""
    text = json.dumps(settings, sort_keys=True)
    return dataset.assign_attrs(title=title, settings=text, breaker_version=__version__)


def save(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as one Zarr store, replacing an old one; equal datasets give equal bytes.

    The checksums are written last, so an incomplete store has none. The Zarr format is 2, because
    format 3 does not specify text yet.
    """
    path = Path(path)
    shutil.rmtree(path, ignore_errors=True)
    plain = dataset.drop_encoding()  # the encoding contains lengths of texts that were read
    plain.to_zarr(path, mode="w", consolidated=True, zarr_format=2)
    (path / _CHECKSUMS).write_text(json.dumps(_checksums(path), indent=0), encoding="utf-8")


def open_store(path: str | Path) -> xr.Dataset:
    """Open a store that ``save`` has written, or raise a StoreError; values are read when used."""
    path = Path(path)
    try:
        expected = json.loads((path / _CHECKSUMS).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        fault = f"it has no {_CHECKSUMS}: it is not there, or its writing was interrupted"
        raise StoreError(path, fault) from error
    actual = _checksums(path)
    for name, checksum in expected.items():
        if actual.get(name) != checksum:
            what = "has changed since it was written" if name in actual else "is lost"
            raise StoreError(path, f"its file {name} {what}")
    return xr.open_zarr(path, chunks=None)


def _checksums(store: Path) -> dict[str, int]:
    """Return the CRC-32 of each file of a store, by name."""
    return {
        file.relative_to(store).as_posix(): zlib.crc32(file.read_bytes())
        for file in sorted(store.rglob("*"))
        if file.is_file() and file.name != _CHECKSUMS
    }
