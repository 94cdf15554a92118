"""Curves that were read before, from their stores."""

from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from breaker.files import RejectedCurveError
from breaker.stores import open_store

__all__ = ["open_curves", "require_any"]


def open_curves(stores: Sequence[str | Path]) -> xr.Dataset:
    """Read stores of consecutive operations as one dataset over ``operation``.

    Raises:
        RejectedCurveError: If not one operation was accepted.
    """
    parts = [open_store(store) for store in stores]
    curves = xr.concat(parts, dim="operation", join="outer", combine_attrs="override").load()
    require_any(curves)
    return curves


def require_any(curves: xr.Dataset) -> None:
    """Raise an error if no curve can be used, since then the settings are wrong.

    Raises:
        RejectedCurveError: If not one operation was accepted; the first reasons are listed.
    """
    if not curves.accepted.any():
        raise RejectedCurveError(
            Path(str(curves.file.values[0])).parent,
            f"none of {curves.sizes['operation']} {curves.attrs['motion']} files can be used; "
            "check endurance.format and the folder. The first reasons: "
            + " | ".join(curves.reason.values[:3].tolist()),
        )
