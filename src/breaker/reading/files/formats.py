"""The formats of curve files, each a module: whatever the format, one form comes out.

A format is a module with

- ``ENDINGS``: what messages call a file of it, by ending in lower case;
- ``EXTRA``: the extra of this package that it needs; empty for none;
- ``claims(file)``: whether a file is of it;
- ``read(opened, settings, channel)``: ``Columns``, see ``read_columns``;
- ``look(opened)``: what it shows before anything is known of it, ``Labelled`` or ``Tables``; None
  where all of it is to be guessed.

``tests/files/test_formats.py`` is what each has to fulfil.
"""

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from breaker import DISTRIBUTION
from breaker.reading.files import comtrade, delimited_text, excel, netcdf
from breaker.reading.files.format_settings import READ_BY
from breaker.reading.files.guards import RejectedCurveError, TooLargeError
from breaker.reading.files.opened_file import Opened, as_opened
from breaker.reading.files.time_and_travel import Columns

FORMATS: tuple[ModuleType, ...] = (delimited_text, excel, comtrade, netcdf)
"""All formats; what none of them claims is taken for the first one, a text."""

ENDINGS = tuple(ending for each in FORMATS for ending in each.ENDINGS)
"""Endings of the files of records. A ``.cfg`` has a ``.dat`` beside it, a ``.zarr`` is a folder."""

_OLD = (".xls", ".xlsb", ".ods")


def read_columns(file: str | Path | Opened, settings: Mapping, channel: str = "") -> Columns:
    """Read the columns of time and travel of one record.

    Args:
        file: File of one record, or one that is opened: then the same columns are read of it once.
            Of an ending that is not known, it is a text.
        settings: The section ``endurance.format``, complete.
        channel: Column of the travel, where it is not that of the settings.

    Raises:
        RejectedCurveError: If the file cannot be used.
    """
    opened = as_opened(file)
    form = tuple(repr(settings[key]) for key in READ_BY)
    # A rate is named in a remark where a column of the time is not there, else it reads nothing.
    rate = settings["rate"] if isinstance(settings["time_column"], str) else None
    return opened.once(("columns", channel, rate, form), lambda: _read(opened, settings, channel))


def _read(opened: Opened, settings: Mapping, channel: str) -> Columns:
    format_ = format_of(opened.file)
    with understood(opened.file):
        columns = format_.read(opened, settings, channel)
    for each in (columns.time, columns.travel, columns.lines, *columns.beside.values()):
        if each is not None:
            each.flags.writeable = False  # others read the same
    return columns


def format_of(file: str | Path) -> ModuleType:
    """Return the format of a file.

    Raises:
        RejectedCurveError: If it is of a kind that cannot be read.
    """
    if Path(file).suffix.lower() in _OLD:
        raise RejectedCurveError(file, "is of a kind that cannot be read; save it as .xlsx")
    return next((each for each in FORMATS if each.claims(file)), delimited_text)


def is_text(file: str | Path) -> bool:
    """Say whether a file is a text; raise as ``format_of``."""
    return format_of(file) is delimited_text


@contextmanager
def understood(file: str | Path) -> Iterator[None]:
    """Turn whatever is raised while a file that is no text is read into a reason.

    Raises:
        RejectedCurveError: If anything is raised.
    """
    if is_text(file):
        yield
        return
    format_ = format_of(file)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of packages, about what is not read here
            yield
    except RejectedCurveError:
        raise
    except Exception as error:  # a damaged file raises anything in the package that reads it
        kind, said = format_.ENDINGS[Path(file).suffix.lower()], f"{type(error).__name__}: {error}"
        reason = f"is {kind} that cannot be read ({said[:200]}); is it whole? Export it again"
        if isinstance(error, TooLargeError):
            reason = str(error)
        if isinstance(error, ModuleNotFoundError):
            extra = f"{DISTRIBUTION}[{format_.EXTRA}]"
            reason = f'is {kind}, which needs {error.name}: pip install "{extra}"'
        raise RejectedCurveError(file, reason) from error
