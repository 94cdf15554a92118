"""The kinds of curve files, by their ending: whatever the kind, one form comes out."""

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from breaker import DISTRIBUTION
from breaker.files.columns import Columns
from breaker.files.grids import read_grid
from breaker.files.guards import RejectedCurveError, TooLargeError
from breaker.files.recorders import read_comtrade
from breaker.files.text import read_text
from breaker.files.workbooks import read_workbook

OTHER_KINDS = {
    ".xlsx": (read_workbook, "an Excel workbook", "excel"),
    ".xlsm": (read_workbook, "an Excel workbook", "excel"),
    ".cfg": (read_comtrade, "a COMTRADE record", "comtrade"),
    ".cff": (read_comtrade, "a COMTRADE record", "comtrade"),
    ".nc": (read_grid, "a NetCDF file", "netcdf"),
    ".nc4": (read_grid, "a NetCDF file", "netcdf"),
    ".zarr": (read_grid, "a Zarr store", "netcdf"),
}
"""What is no text, by ending: its reader, its name, and the extra of this package that it needs."""

_OLD = (".xls", ".xlsb", ".ods")


def read_columns(file: str | Path, settings: Mapping, channel: str = "") -> Columns:
    """Read the columns of time and travel of one record.

    Args:
        file: File of one record; of an ending that is not known, a text.
        settings: The section ``endurance.format``, complete.
        channel: Column of the travel, where it is not that of the settings.

    Raises:
        RejectedCurveError: If the file cannot be used.
    """
    if not is_other_kind(file):
        return read_text(file, settings, channel)
    with understood(file):
        return OTHER_KINDS[Path(file).suffix.lower()][0](file, settings, channel)


def is_other_kind(file: str | Path) -> bool:
    """Say whether a file is no text, by its ending.

    Raises:
        RejectedCurveError: If it is of a kind that cannot be read.
    """
    ending = Path(file).suffix.lower()
    if ending in _OLD:
        raise RejectedCurveError(file, "is of a kind that cannot be read; save it as .xlsx")
    return ending in OTHER_KINDS


@contextmanager
def understood(file: str | Path) -> Iterator[None]:
    """Turn whatever is raised while a file that is no text is read into a reason.

    Raises:
        RejectedCurveError: If anything is raised.
    """
    _, kind, extra = OTHER_KINDS[Path(file).suffix.lower()]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of packages, about what is not read here
            yield
    except RejectedCurveError:
        raise
    except Exception as error:  # a damaged file raises anything in the package that reads it
        said = f"{type(error).__name__}: {error}"[:200]
        reason = f"is {kind} that cannot be read ({said}); is it whole? Export it again"
        if isinstance(error, TooLargeError):
            reason = str(error)
        if isinstance(error, ModuleNotFoundError):
            reason = f'is {kind}, which needs {error.name}: pip install "{DISTRIBUTION}[{extra}]"'
        raise RejectedCurveError(file, reason) from error
