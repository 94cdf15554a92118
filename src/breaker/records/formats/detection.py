"""Read curve files of all formats as sheets.

A format is a module with ``read``, which is imported when a file of the format is read. This module
contains the endings and first bytes of each format. To add a format, copy ``example_format`` and
extend ``FORMATS``. Each format passes the tests of ``tests/records/format_contract.py``.
"""

import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np

from breaker.records.files import Opened, RejectedCurveError, as_opened
from breaker.records.formats import text
from breaker.records.header import Header
from breaker.records.settings import FORMAT, complete
from breaker.records.sheet import Columns, Sheet, columns_of

UNREAD = {
    **dict.fromkeys((".xls", ".xlsb", ".ods"), "is of a kind that is not read; save it as .xlsx"),
    ".cff": "is COMTRADE in a single file, which is not read; export it as .cfg and .dat",
    **dict.fromkeys((".nc", ".h5", ".mat"), "is a file of arrays, which is not read; save a text"),
}
"""Formats of records that are not read, by ending, with the remedy."""

_REFUSED = {
    **UNREAD,
    **dict.fromkeys((".yaml", ".yml"), "is a file of settings, not a record; name it by --config"),
    **dict.fromkeys((".png", ".jpg", ".pdf"), "is a picture, not a record; export its numbers"),
}


class Format(NamedTuple):
    """A format of curve files.

    Attributes:
        module: Name of the module with its function ``read``: see ``example_format``.
        endings: Names of the kind of file in messages, by ending in lower case.
        signatures: First bytes that identify the format, whatever the ending of the file; a file
            with the ending but without these bytes is rejected. Empty for texts.
        extra: Extra of this package that the format needs, or empty.
    """

    module: str
    endings: Mapping[str, str]
    signatures: tuple[bytes, ...] = ()
    extra: str = ""


_HERE = "breaker.records.formats"
_WORKBOOKS = dict.fromkeys((".xlsx", ".xlsm"), "an Excel workbook")

TEXT = Format(f"{_HERE}.text", dict.fromkeys((".csv", ".txt", ".tsv", ".lvm"), "a text"))
EXCEL = Format(f"{_HERE}.excel", _WORKBOOKS, (b"PK\3\4",), "excel")
COMTRADE = Format(f"{_HERE}.comtrade", {".cfg": "a COMTRADE record"})
LINES = Format(f"{_HERE}.lines", {})  # texts with a record on each line

FORMATS = (TEXT, EXCEL, COMTRADE, LINES)
"""All formats; a file without a known ending or signature is read as a text, the first format."""

ENDINGS = tuple(ending for form in FORMATS for ending in form.endings)
"""Endings of the files of records. A ``.cfg`` has a ``.dat`` next to it."""


def read_columns(
    file: str | Path | Opened, settings: Mapping, channel: str = "", line: int = 0
) -> Columns:
    """Read the columns of time and travel of one record.

    Args:
        file: File of one record, or an ``Opened``, which keeps the columns.
        settings: The section ``endurance.format``, complete.
        channel: Column of the travel, if it differs from the settings.
        line: Line of the record, if each line is a record; 0 for the first. Records on lines are
            not kept, since a file may have thousands.

    Raises:
        RejectedCurveError: If the file cannot be used.
    """
    opened = as_opened(file)
    form = {**settings, "travel_column": channel or settings["travel_column"], "line": line}
    return _read(opened, form) if line else opened.once(repr(form), lambda: _read(opened, form))


def _read(opened: Opened, form: Mapping) -> Columns:
    error = RejectedCurveError(opened.file, "has no table of samples")
    for k, sheet in enumerate(_sheets(opened, form)):
        try:
            columns = columns_of(sheet, form)
        except RejectedCurveError as rejection:
            error = error if k else rejection
            continue
        for array in (columns.time, columns.travel, columns.lines, *columns.paired.values()):
            if array is not None:
                array.flags.writeable = False  # the arrays are shared
        return columns
    raise error


def look_into(file: str | Path | Opened, channel: str | int = "", line: int = 0) -> Sheet:
    """Return the first sheet of a file or line without settings, or the first sheet that contains
    the column ``channel``. The layout of a text is estimated; other formats state it.

    Raises:
        RejectedCurveError: If the file cannot be read, or there are no columns of numbers.
    """
    opened = as_opened(file)

    def look() -> list[Sheet]:
        sheets = [e for e in _sheets(opened, {"line": line} if line else {}) if e.columns]
        if not sheets:
            raise RejectedCurveError(opened.file, "has no table with columns of numbers")
        # Instruments write overflow values, such as the resistance of open contacts.
        return [
            replace(e, columns=[np.where(np.abs(c) < 1e16, c, np.nan) for c in e.columns])
            for e in sheets
        ]

    sheets = look() if line else opened.once("sheets", look)
    return next((e for e in sheets if channel and e.place_of(channel) is not None), sheets[0])


def records_in(file: str | Path | Opened) -> list:
    """Return the records of a file with one record on each line, see ``lines.RecordLine``; an empty
    list for other files, or if the file cannot be read.
    """
    opened = as_opened(file)
    with suppress(RejectedCurveError):
        if format_of(opened) is LINES:
            return opened.once("records", lambda: import_module(LINES.module).records_in(opened))
    return []


def stated_in(
    file: str | Path | Opened, settings: Mapping = FORMAT, channel: str = "", line: int = 0
) -> Header:
    """Return the header of a file; an empty header if the file cannot be read.

    Args:
        file, channel, line: As in ``read_columns``.
        settings: The section ``endurance.format``; ``look_into`` reads files that do not fit it.
    """
    opened = as_opened(file)
    with suppress(ValueError):
        return read_columns(opened, complete(settings), channel, line).sheet.stated
    with suppress(ValueError):
        return look_into(opened, channel, line).stated
    return Header()


def format_of(opened: Opened) -> Format:
    """Return the format of a file, by its first bytes or else by its ending.

    Raises:
        RejectedCurveError: If the format cannot be read, or the content contradicts the ending.
    """
    return opened.once("format", lambda: _format_of(opened))


def _format_of(opened: Opened) -> Format:
    file, ending = opened.file, Path(opened.file).suffix.lower()
    named = next((form for form in FORMATS if ending in form.endings), TEXT)
    if ending in _REFUSED:
        raise RejectedCurveError(file, _REFUSED[ending])
    if ending == ".dat":
        return COMTRADE  # its error names the .cfg
    for form in FORMATS:
        if opened.content.startswith(form.signatures):
            return form
    if named is TEXT and text.first_line(opened.content):
        lines = import_module(LINES.module)
        return LINES if lines.form_of(opened) else TEXT
    if named.signatures and not any(signature in opened.content for signature in named.signatures):
        reason = f"ends as {named.endings[ending]}, but does not begin as one"
        raise RejectedCurveError(file, f"{reason}; is it complete? Export it again")
    return named


def _sheets(opened: Opened, form: Mapping) -> Sequence[Sheet]:
    """Return the sheets of a file; turn any error of a format other than text into a rejection."""
    format_, file = format_of(opened), opened.file
    kinds = TEXT.endings if format_ is LINES else format_.endings
    kind = kinds.get(Path(file).suffix.lower()) or next(iter(kinds.values()), "")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # packages warn about parts that are not read here
            sheets = import_module(format_.module).read(opened, form)
    except RejectedCurveError:
        raise
    except Exception as error:  # a damaged file raises anything in the package that reads it
        if format_ in (TEXT, LINES):
            raise
        reason = f"that cannot be read ({str(error)[:200]}); is it complete? Export it again"
        if isinstance(error, ModuleNotFoundError):
            remedy = f'run `pip install ".[{format_.extra}]"` in a clone of the project'
            reason = f"which needs {error.name}: {remedy}"
        raise RejectedCurveError(file, f"is {kind}, {reason}") from error
    return [replace(sheet, kind=kind or sheet.kind) for sheet in sheets]
