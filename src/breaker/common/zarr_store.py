"""Write a dataset as a Zarr store, and open it only if it is as it was written.

Zarr takes a chunk without a file for fill values, so a lost file would turn into numbers without a
word. ``save`` lists size and checksum of every file of a store, and ``open_store`` compares them.
"""

import json
import shutil
import zlib
from pathlib import Path

import xarray as xr

from breaker import __version__

_CHECKSUMS = "checksums.json"


class StoreError(ValueError):
    """A store that is not as it was written; the text names file, fault and remedy."""

    def __init__(self, path: str | Path, fault: str) -> None:
        remedy = f"Delete this store (rm -r {path}) and run the same command again"
        super().__init__(f"{path}: {fault}. {remedy}")


def describe(dataset: xr.Dataset, title: str, **settings: object) -> xr.Dataset:
    """Return the dataset with what made it in its attributes: title, settings, version."""
    text = json.dumps(settings, sort_keys=True)
    return dataset.assign_attrs(title=title, settings=text, breaker_version=__version__)


def save(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as one Zarr store, in place of what is there; equal ones give equal bytes.

    The checksums are written last, so a store whose writing was interrupted has none.
    """
    path = Path(path)
    if path.is_dir():
        shutil.rmtree(path)
    write_zarr(dataset.drop_encoding(), path)  # which holds lengths of texts that were read
    (path / _CHECKSUMS).write_text(json.dumps(_checksums(path), indent=0), encoding="utf-8")


def write_zarr(content: xr.Dataset, folder: Path) -> None:
    """Write a dataset into a new folder, in Zarr's format 2.

    Format 3 does not specify text yet. Zarr fills memory alone: after an error, its threads would
    go on to write into a folder that its owner removes.
    """
    from zarr.storage import MemoryStore  # here, as those who write no store need no Zarr

    memory: dict = {}
    content.to_zarr(MemoryStore(memory), mode="w", consolidated=True, zarr_format=2)
    for name, buffer in sorted(memory.items()):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(buffer.to_bytes())


def open_store(path: str | Path) -> xr.Dataset:
    """Open a store that ``save`` has written, or raise a StoreError; values are read when used."""
    path = Path(path)
    if not path.is_dir():
        raise StoreError(path, "there is no such store")
    if not (path / _CHECKSUMS).is_file():
        raise StoreError(path, f"it has no {_CHECKSUMS}: its writing was interrupted")
    try:
        expected = dict(json.loads((path / _CHECKSUMS).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise StoreError(path, f"{_CHECKSUMS} cannot be read: {error}") from error
    actual = _checksums(path)
    for name, checksum in expected.items():
        if actual.get(name) != checksum:
            what = "has changed since it was written" if name in actual else "is lost"
            raise StoreError(path, f"its file {name} {what}")
    return xr.open_zarr(path, chunks=None)


def _checksums(store: Path) -> dict[str, list[int]]:
    """Return size in bytes and CRC-32 of each file of a store, by name."""
    checksums = {}
    for file in sorted(path for path in store.rglob("*") if path.is_file()):
        content = file.read_bytes()
        checksums[file.relative_to(store).as_posix()] = [len(content), zlib.crc32(content)]
    checksums.pop(_CHECKSUMS, None)
    return checksums
