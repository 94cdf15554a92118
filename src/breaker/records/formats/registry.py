"""The formats of curve files, each a module: whatever the format, sheets come out.

A format is a module with

- ``ENDINGS``: what messages call a file of it, by ending in lower case;
- ``SIGNATURES``: first bytes that prove a file to be of it, whatever its ending; a file with the
  ending that has none of them is not. Empty for a format that is text, which reading proves;
- ``EXTRA``: the extra of this package that it needs; empty for none;
- ``read(opened, form)``: its sheets, see ``sheet.Sheet``. The form is the section
  ``endurance.format``, complete, or empty where nothing is known yet.

``example_format`` is one with all that there is to say. Each passes the tests of
``tests/records/format_contract.py``. Other distributions add such modules by the entry points
``breaker.formats``.
"""

import logging
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from breaker import DISTRIBUTION
from breaker.records.files import (
    Opened,
    RejectedCurveError,
    TooLargeError,
    as_opened,
    is_store,
)
from breaker.records.formats import comtrade, excel, lines, netcdf, text
from breaker.records.header import Header
from breaker.records.settings import FORMAT, READ_BY, complete
from breaker.records.sheet import Columns, LayoutError, Sheet, columns_of

_OLD = (".xls", ".xlsb", ".ods")
_OLD_WORKBOOK = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_OWN = (text, excel, comtrade, netcdf, lines)
_NAMES = ("ENDINGS", "SIGNATURES", "EXTRA", "read")


def added_formats() -> Iterator[ModuleType]:
    """Yield the formats of other distributions; the log names those that cannot be used."""
    for entry in entry_points(group="breaker.formats"):
        try:
            format_ = entry.load()
            if lacking := [name for name in _NAMES if not hasattr(format_, name)]:
                raise TypeError(f"it has no {' and no '.join(lacking)}")
        except Exception as error:  # whatever code of others raises
            said = "the format %s cannot be used (%s); its files are not read"
            logging.getLogger(__name__).error(said, entry.value, error)
        else:
            yield format_


FORMATS = (*_OWN, *added_formats())
"""All formats; a file of no known ending or signature is taken for one of the first, a text."""

ENDINGS = tuple(ending for each in FORMATS for ending in each.ENDINGS)
"""Endings of the files of records. A ``.cfg`` has a ``.dat`` beside it, a ``.zarr`` is a folder."""


def read_columns(
    file: str | Path | Opened, settings: Mapping, channel: str = "", line: int = 0
) -> Columns:
    """Read the columns of time and travel of one record.

    Args:
        file: File of one record, or one that is opened: then the same columns are read of it once.
        settings: The section ``endurance.format``, complete.
        channel: Column of the travel, where it is not that of the settings.
        line: That of the record, where each line is one; 0 for the first. Such columns are not kept
            with the file, which may have thousands of them.

    Raises:
        RejectedCurveError: If the file cannot be used.
    """
    opened = as_opened(file)
    if line:
        return _read(opened, settings, channel, line)
    form = tuple(repr(settings[key]) for key in READ_BY)
    # A rate is named in a remark where a column of the time is not there, else it reads nothing.
    rate = settings["rate"] if isinstance(settings["time_column"], str) else None
    return opened.once(("columns", channel, rate, form), lambda: _read(opened, settings, channel))


def _read(opened: Opened, settings: Mapping, channel: str, line: int = 0) -> Columns:
    form = {**settings, "travel_column": channel or settings["travel_column"], "line": line}
    first = None
    for sheet in _sheets(opened, form):
        try:
            columns = columns_of(sheet, form)
        except RejectedCurveError as error:
            first = first or error
            continue
        for array in (columns.time, columns.travel, columns.lines, *columns.beside.values()):
            if array is not None:
                array.flags.writeable = False  # others read the same
        return columns
    raise first or RejectedCurveError(opened.file, "has no table of samples")


def look_into(file: str | Path | Opened) -> Sheet:
    """Return the sheet of a file of which nothing is known: guessed of a text, as it is stated of
    other kinds.

    Args:
        file: The file, or one that is opened: then it is looked into once.

    Raises:
        LayoutError: If there are no columns of numbers.
        RejectedCurveError: If the file cannot be read.

    Example:
        >>> import tempfile
        >>> rows = [f"{i / 10:.1f};{i / 7:.3f}".replace(".", ",") for i in range(50)]
        >>> with tempfile.NamedTemporaryFile("w") as file:
        ...     print("Rig 3", "Zeit;Weg", "[msec];mm", *rows, sep="\\n", file=file, flush=True)
        ...     sheet = look_into(file.name)
        >>> sheet.settings
        {'encoding': 'utf-8', 'delimiter': ';', 'decimal': ','}
        >>> sheet.preamble, sheet.names, sheet.units
        ([['Rig 3']], ['Zeit', 'Weg'], ['ms', 'mm'])
    """
    opened = as_opened(file)
    return opened.once("sheet", lambda: _look(opened))


def _look(opened: Opened) -> Sheet:
    for sheet in _sheets(opened, {}):
        if len(sheet.columns):
            return sheet
    raise LayoutError(opened.file, "has no table with columns of numbers")


def _sheets(opened: Opened, form: Mapping) -> Sequence[Sheet]:
    """The sheets of a file, each with what messages call the file."""
    format_, file = format_of(opened), opened.file
    kind, said = _kind(format_, file), ()
    with _understood(file, format_):
        sheets = format_.read(opened, form)
    if format_.SIGNATURES and format_ is not _named(file):
        said = (f"is {kind} by its content, whatever its name ends in",)
    kinds = {"kind": kind} if kind else {}
    return [replace(each, remarks=(*each.remarks, *said), **kinds) for each in sheets]


def records_in(file: str | Path | Opened) -> list[lines.RecordLine]:
    """Return the records of a file that has one on each line; none where it is of another kind, or
    cannot be read. Of other files, no more than the first lines are looked at.
    """
    opened = as_opened(file)
    with suppress(RejectedCurveError):
        if format_of(opened) is lines:
            return opened.once("records", lambda: lines.records_in(opened))
    return []


def stated_in(
    file: str | Path | Opened, settings: Mapping = FORMAT, channel: str = "", line: int = 0
) -> Header:
    """Return what a file states above its samples; nothing of one that cannot be read.

    Args:
        file: The file, or one that is opened.
        settings: The section ``endurance.format``; where a file cannot be read by it, it is looked
            into.
        channel, line: As of ``read_columns``.
    """
    opened = as_opened(file)
    with suppress(ValueError):
        with suppress(ValueError):
            if format_of(opened) in (text, lines):
                return read_columns(opened, complete(settings), channel, line).stated
        return look_into(opened).stated
    return Header()


def format_of(opened: Opened) -> ModuleType:
    """Return the format of a file: the one that its content proves, or else the one of its ending.

    Raises:
        RejectedCurveError: If it is of a kind that cannot be read, or not of that of its ending.
    """
    named = _named(opened.file)
    if is_store(opened.file):
        return named  # a folder
    if _ending(opened.file) in _OLD or opened.content.startswith(_OLD_WORKBOOK):
        raise RejectedCurveError(opened.file, "is of a kind that cannot be read; save it as .xlsx")
    if comtrade.is_data(opened):
        return comtrade  # which says what is lacking
    for each in FORMATS:
        if opened.content.startswith(each.SIGNATURES):
            return each
    if named is text and lines.sniff(opened):
        return lines
    if named.SIGNATURES and not any(each in opened.content for each in named.SIGNATURES):
        kind = named.ENDINGS[_ending(opened.file)]
        reason = f"ends as {kind}, but does not begin as one; is it whole? Export it again"
        raise RejectedCurveError(opened.file, reason)
    return named


def _ending(file: str | Path) -> str:
    return os.path.splitext(file)[1].lower()


def _named(file: str | Path) -> ModuleType:
    """The format of a file by its ending."""
    ending = _ending(file)
    return next((each for each in FORMATS if ending in each.ENDINGS), text)


def _kind(format_: ModuleType, file: str | Path) -> str:
    """What messages call a file; empty of a text without a known ending."""
    usual = "" if format_ is text else next(iter(format_.ENDINGS.values()), "")
    return format_.ENDINGS.get(_ending(file), usual)


def kind_in(opened: Opened) -> str:
    """Return what messages call a file; empty of a text without a known ending."""
    return _kind(format_of(opened), opened.file)


@contextmanager
def _understood(file: str | Path, format_: ModuleType) -> Iterator[None]:
    """Turn whatever is raised while a file that is no text is read into a reason.

    Raises:
        RejectedCurveError: If anything is raised.
    """
    if format_ in (text, lines):
        yield
        return
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of packages, about what is not read here
            yield
    except RejectedCurveError:
        raise
    except Exception as error:  # a damaged file raises anything in the package that reads it
        kind, said = _kind(format_, file), f"{type(error).__name__}: {error}"
        reason = f"is {kind} that cannot be read ({said[:200]}); is it whole? Export it again"
        if isinstance(error, TooLargeError):
            reason = str(error)
        if isinstance(error, ModuleNotFoundError):
            extra = f"{DISTRIBUTION}[{format_.EXTRA}]"
            reason = f'is {kind}, which needs {error.name}: pip install "{extra}"'
        raise RejectedCurveError(file, reason) from error
