"""The kinds of curve files, by their ending: whatever the kind, one form comes out."""

from collections.abc import Mapping
from pathlib import Path

from breaker.records.columns import Columns
from breaker.records.text import read_text

__all__ = ["read_columns"]


def read_columns(file: str | Path, settings: Mapping, channel: str = "") -> Columns:
    """Read the columns of time and travel of one record.

    Args:
        file: File of one record; of an ending that is not known, a text.
        settings: The section ``endurance.format``, complete.
        channel: Column of the travel, where it is not that of the settings.

    Raises:
        RejectedCurveError: If the file cannot be used.
    """
    return read_text(file, settings, channel)
