"""Write a dataset as a Zarr store with its provenance, and open it."""

import json
import shutil
from pathlib import Path

import xarray as xr

from breaker import __version__


def describe(dataset: xr.Dataset, title: str, **settings: object) -> xr.Dataset:
    """Return the dataset with title, settings and version in its attributes."""
    text = json.dumps(settings, sort_keys=True)
    return dataset.assign_attrs(title=title, settings=text, breaker_version=__version__)


def save(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as one Zarr store, replacing an old one; equal datasets give equal bytes.

    The Zarr format is 2, because format 3 does not specify text yet.
    """
    shutil.rmtree(path, ignore_errors=True)
    plain = dataset.drop_encoding()  # the encoding contains lengths of texts that were read
    plain.to_zarr(path, mode="w", consolidated=True, zarr_format=2)


def open_store(path: str | Path) -> xr.Dataset:
    """Open a store that ``save`` has written; values are read when used.

    Raises:
        FileNotFoundError: If there is no store, or its writing was interrupted.
    """
    if not Path(path, ".zmetadata").is_file():  # written last
        remedy = f"Delete it (rm -r {path}) and run the same command again"
        raise FileNotFoundError(f"{path} is not there, or its writing was interrupted. {remedy}")
    return xr.open_zarr(path, chunks=None)
