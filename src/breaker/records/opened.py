"""Curves that were read before, from their stores."""

from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from breaker.files import RejectedCurveError
from breaker.stores import open_store

__all__ = ["open_curves"]


def open_curves(stores: Sequence[str | Path]) -> xr.Dataset:
    """Read stores of consecutive operations as one dataset over ``operation``.

    Raises:
        RejectedCurveError: If not one operation was accepted, since then the settings are wrong;
            the first reasons are listed.
    """
    parts = [open_store(store) for store in stores]
    curves = xr.concat(parts, dim="operation", join="outer", combine_attrs="override").load()
    if not curves.accepted.any():
        raise RejectedCurveError(
            Path(str(curves.file.values[0])).parent,
            f"none of {curves.sizes['operation']} {curves.attrs['motion']} files can be used; "
            "check endurance.format and the folder. The first reasons: "
            + " | ".join(curves.reason.values[:3].tolist()),
        )
    return curves
