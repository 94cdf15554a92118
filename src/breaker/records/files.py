"""The curve files of a folder and their operation numbers, and how any file is opened.

Light to import.
"""

import errno
import os
import re
import stat
from pathlib import Path

from breaker.records.manifest import Operation

__all__ = [
    "LARGEST",
    "RejectedCurveError",
    "csv_files",
    "list_curves",
    "operation_number",
    "printable",
    "read_bytes",
]

LARGEST = 64 * 2**20
"""Bytes of the largest file that is read; a record of 10 s at 100 kHz has a quarter of it."""

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
_WHY = {
    errno.ENOENT: "is not there: was it moved or deleted, or does a link lead nowhere?",
    errno.ELOOP: "is a link that leads back to itself; put the file itself there",
    errno.EACCES: "may not be read: give yourself the permission to",
    errno.EPERM: "may not be read: give yourself the permission to",
}


class RejectedCurveError(ValueError):
    """A curve file that cannot be used; the message names file, line and reason.

    It is one line of signs that can be printed, whatever stands in the name or in the file.
    """

    def __init__(self, file: str | Path, reason: str, *, line: int | None = None) -> None:
        place = f"{file}, line {line}" if line else f"{file}"
        super().__init__(printable(f"{place}: {reason}"))


def printable(text: str | Path) -> str:
    r"""Return a text on one line that can be printed and stored, with escapes for what cannot.

    Names of files may hold any byte: Python stands lone surrogates for those that are no UTF-8.

    >>> printable("caf\udce9\n.csv")
    'caf\\udce9\\n.csv'
    """
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in str(text)
    )


def read_bytes(file: str | Path) -> bytes:
    """Return the content of a file, at once or never: it waits for nothing.

    Raises:
        RejectedCurveError: If it is no regular file (a pipe, a device, a folder ...), is not there
            or may not be read, or is larger than ``LARGEST``.
    """
    try:
        _require_regular(file, os.stat(file))  # before opening: devices act when they are opened
        with open(file, "rb", opener=_without_waiting) as stream:
            _require_regular(file, os.fstat(stream.fileno()))
            content = stream.read(LARGEST + 1)
    except OSError as error:
        reason = _WHY.get(error.errno, f"cannot be read: {error.strerror}")
        raise RejectedCurveError(file, reason) from error
    except ValueError as error:
        if isinstance(error, RejectedCurveError):
            raise
        raise RejectedCurveError(file, f"is no name of a file: {error}") from error
    if len(content) > LARGEST:
        raise RejectedCurveError(file, _too_large("more"))
    return content


def _without_waiting(file: str, flags: int) -> int:
    return os.open(file, flags | getattr(os, "O_NONBLOCK", 0))


def _require_regular(file: str | Path, found: os.stat_result) -> None:
    """Reject what is no regular file, or too large a one."""
    if not stat.S_ISREG(found.st_mode):
        kind = _KINDS.get(stat.S_IFMT(found.st_mode), "something else")
        raise RejectedCurveError(file, f"is {kind}, not a file")
    if found.st_size > LARGEST:
        raise RejectedCurveError(file, _too_large(f"{found.st_size / 2**20:.0f} MiB"))


def _too_large(size: str) -> str:
    return (
        f"has {size}, but no record of one operation needs more than {LARGEST // 2**20} MiB; "
        "export it alone, with fewer channels or at a lower rate"
    )


def csv_files(folder: str | Path) -> list[Path]:
    """List the CSV files of a folder by name, ending in any case, without hidden files.

    The list is empty if there is no such folder.
    """
    if not Path(folder).is_dir():
        return []
    return sorted(
        file
        for file in Path(folder).iterdir()
        if file.suffix.lower() == ".csv" and not file.name.startswith(".")
    )


def operation_number(file: str | Path) -> int:
    """Return the number of the operation in a file, the last whole number in the file's name.

    Raises:
        ValueError: If the name has no number.
    """
    numbers = re.findall(r"\d+", Path(file).stem)
    if not numbers:
        raise ValueError(
            f"{file}: the name has no number, so it does not say which operation it is; rename it, "
            "to operation_0001.csv for example"
        )
    return int(numbers[-1])


def list_curves(folder: str | Path) -> list[Operation]:
    """List the curve files of one motion, ``folder/*.csv``, in the order of their operations.

    Raises:
        FileNotFoundError: If there is no such folder or no CSV file in it.
        ValueError: If a name has no number, or two files have the same one.
    """
    files = csv_files(folder)
    if not files:
        raise FileNotFoundError(
            f"{folder} has no CSV file: endurance.curves must name a folder with a subfolder of "
            "curve files for each motion"
        )
    listed: dict[int, Path] = {}
    for file in files:
        number = operation_number(file)
        if number in listed:
            raise ValueError(
                f"{file} and {listed[number]} are both operation {number}; rename one of them"
            )
        listed[number] = file
    return [Operation(number, listed[number]) for number in sorted(listed)]
