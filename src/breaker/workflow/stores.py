"""Zarr stores: the attributes of every result, and how it is written."""

import json
from importlib.metadata import version
from pathlib import Path

import xarray as xr

__all__ = ["describe", "save"]


def describe(dataset: xr.Dataset, title: str, **settings: object) -> xr.Dataset:
    """Return the dataset with what made it in its attributes: title, settings, version."""
    return dataset.assign_attrs(
        title=title,
        settings=json.dumps(settings, sort_keys=True),
        breaker_version=version("breaker"),
    )


def save(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as one Zarr store, in place of what is there.

    The time of writing is not stored, so the same dataset gives the same bytes. Format 2,
    as format 3 does not specify text yet. How an array was stored where it was read from is
    forgotten: a text would keep the length that it had there.
    """
    dataset.drop_encoding().to_zarr(path, mode="w", consolidated=True, zarr_format=2)
