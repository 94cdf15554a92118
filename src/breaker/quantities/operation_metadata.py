"""What is known of an operation beside its record: names of columns, from tables to results."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

CONDITIONS = ("temperature", "voltage")
"""What an operation depends on beside the drive."""

ABOUT = ("breaker", "phase", "date", *CONDITIONS, "event")
"""What is known of an operation and kept through to all results; empty where it is not."""


def metadata_names(data: "xr.Dataset") -> list[str]:
    """Return which of ``ABOUT`` a dataset of operations has a value of, for any operation."""
    return [
        name
        for name in ABOUT
        if name in data and any(value == value and value != "" for value in data[name].values)
    ]
