"""How every file is opened: once, within bounds of memory, and without waiting. Light to import.

A file that cannot be used is refused in one line with its name, the reason and a remedy.
"""

import errno
import os
import stat
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import BinaryIO, TypeVar

LARGEST = 64 * 2**20
"""Bytes of the largest file, packed or unpacked; 10 s at 100 kHz take a quarter of it."""

MOST_COLUMNS = 300
"""Columns of the widest table; exports have at most a tenth of it."""

MOST_PARTS = 10_000
"""Files of a folder, and parts (variables, chunks) of a file, that is one record."""

_MOST_SAMPLES = 1_200_000  # a record of 10 s at 100 kHz has a million
_MOST_CELLS = LARGEST // 8  # as numbers of 8 bytes they fill ``LARGEST``

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

Found = TypeVar("Found")


class RejectedCurveError(ValueError):
    """A curve file that cannot be used; the message names file, line and reason.

    It is one line of signs that can be printed, whatever stands in the name or in the file.

    Attributes:
        reason: Why it cannot be used.
        line: Line of the file that shows it; None if there is none.
    """

    def __init__(self, file: str | Path, reason: str, *, line: int | None = None) -> None:
        self.reason, self.line = reason, line
        place = f"{file}, line {line}" if line else f"{file}"
        super().__init__(printable(f"{place}: {reason}"))


class TooLargeError(ValueError):
    """Content that would take too much memory or time, found where the file has no name."""


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


def no_file(file: str | Path) -> str:
    """Say why there is no regular file of a name; empty if there is one. It is not opened."""
    try:
        found = os.stat(file)
    except OSError as error:
        return _why(error)
    kind = _KINDS.get(stat.S_IFMT(found.st_mode), "something else")
    return "" if stat.S_ISREG(found.st_mode) else f"is {kind}, not a file"


def opened_at_once(file: str | Path) -> BinaryIO:
    """Open a regular file to be read; what it does not hold yet is not waited for."""
    return open(file, "rb", opener=_without_waiting)


def _without_waiting(file: str, flags: int) -> int:
    # Some files wait for more, as /proc/kmsg; Windows has no such, and no such flag.
    return os.open(file, flags | getattr(os, "O_NONBLOCK", 0))


def _why(error: OSError) -> str:
    return _WHY.get(error.errno, f"cannot be read: {error.strerror}")


def read_bytes(file: str | Path) -> bytes:
    """Return the content of a file, at once or never: it waits for nothing.

    Raises:
        RejectedCurveError: If it is no regular file (a pipe, a device, a folder ...), is not there
            or may not be read, or is larger than ``LARGEST``.
    """
    content = b""
    try:
        why = no_file(file)  # before opening: a pipe waits, and a device acts when it is opened
        if not why and (size := os.stat(file).st_size) > LARGEST:
            why = _too_large(f"{size / 2**20:.0f} MiB")
        if not why:
            with opened_at_once(file) as stream:
                content = stream.read(size + 1) or b""
                if len(content) > size:  # more than was stated
                    content += stream.read(LARGEST + 1 - len(content)) or b""
    except OSError as error:
        why = _why(error)
    except ValueError as error:
        why = f"is no name of a file: {error}"
    if len(content) > LARGEST:
        why = _too_large("more")
    if why:
        raise RejectedCurveError(file, why)
    return content


def require_folder(folder: str | Path) -> None:
    """Make sure that a record that is a folder can be read at once, like a file by ``read_bytes``.

    Raises:
        RejectedCurveError: If it is not a folder, contains a link to a folder or anything but
            folders and regular files, more than ``MOST_PARTS`` of them, or more than ``LARGEST``.
    """
    if not os.path.isdir(folder):
        raise RejectedCurveError(folder, no_file(folder) or "is a file, not a folder")
    size = count = 0
    for place, folders, names in os.walk(folder):
        for name in folders:
            if os.path.islink(os.path.join(place, name)):
                raise RejectedCurveError(folder, f"its part {name} is a link; put the folder there")
        for name in names:
            file = os.path.join(place, name)
            if why := no_file(file):
                raise RejectedCurveError(folder, f"its part {os.path.relpath(file, folder)} {why}")
            size += os.stat(file).st_size
        count += len(names) + len(folders)
        if count > MOST_PARTS or size > LARGEST:
            held = f"{size / 2**20:.0f} MiB" if size > LARGEST else f"{count} parts"
            raise RejectedCurveError(folder, _too_large(held))


def _too_large(size: str) -> str:
    return (
        f"has {size}, but no record of one operation needs more than {LARGEST // 2**20} MiB; "
        "export it alone, with fewer channels or at a lower rate"
    )


def check_lines(file: str | Path, content: bytes) -> None:
    """Reject a text with more lines than a record has samples, before they are split."""
    if max(content.count(b"\n"), content.count(b"\r")) > _MOST_SAMPLES:
        reason = f"has more than {_MOST_SAMPLES:,} lines; export a shorter part of the record"
        raise RejectedCurveError(file, reason)


def check_size(file: str | Path, samples: int, columns: int, *, line: int | None = None) -> None:
    """Reject a table with more columns, samples or cells than a record, before they are built."""
    if columns > MOST_COLUMNS:
        reason = f"has {columns:,} columns, but records have at most {MOST_COLUMNS}"
        raise RejectedCurveError(file, f"{reason}; export fewer channels", line=line)
    most = min(_MOST_SAMPLES, _MOST_CELLS // max(1, columns))
    if samples > most:
        reason = f"has {samples:,} samples, but of {columns} columns at most {most:,} are read"
        raise RejectedCurveError(file, f"{reason}; export fewer channels, or a shorter part")


class Opened:
    """A file with everything that is derived from it, computed once: the content is that of the
    first access, even if the file changes later.

    Args:
        file: Its name.

    Example:
        >>> import tempfile
        >>> with tempfile.NamedTemporaryFile("w") as text:
        ...     file = Opened(text.name)
        ...     print("1,2", file=text, flush=True)
        ...     [file.once("signs", lambda: len(file.content)), len(file.content)]
        [4, 4]
    """

    def __init__(self, file: str | Path) -> None:
        self.file = file
        self._found: dict[Hashable, tuple[object, ValueError | None]] = {}

    @property
    def size(self) -> int:
        """Bytes that are kept: content of files, and arrays (all of a Zarr store)."""
        kept = (result for result, _ in self._found.values())
        return sum(len(e) if isinstance(e, bytes) else getattr(e, "nbytes", 0) for e in kept)

    @property
    def content(self) -> bytes:
        """Its bytes; raises as ``read_bytes``."""
        return self.beside(self.file)

    def beside(self, file: str | Path) -> bytes:
        """Return the bytes of another file of the same record."""
        return self.once(("content", str(file)), lambda: read_bytes(file))

    def once(self, key: Hashable, find: Callable[[], Found]) -> Found:
        """Return the result of ``find``, computed at the first call with this key.

        Raises:
            ValueError: As the first call did.
        """
        if key not in self._found:
            try:
                self._found[key] = find(), None
            except ValueError as error:
                self._found[key] = None, error
        result, error = self._found[key]
        if error is not None:
            raise error
        return result


def as_opened(file: str | Path | Opened) -> Opened:
    """Return a file as one that is opened."""
    return file if isinstance(file, Opened) else Opened(file)


class Files:
    """Files of a command, each opened once; those opened last are kept, up to ``LARGEST`` bytes."""

    def __init__(self) -> None:
        self._opened: dict[str, Opened] = {}
        self._sizes: dict[str, int] = {}
        self._asked: set[str] = set()  # since sizes were taken, and may have grown

    def __getitem__(self, file: str | Path) -> Opened:
        """Return a file as one that is opened."""
        name = str(file)
        if name not in self._opened:
            self._sizes |= {asked: self._opened[asked].size for asked in self._asked}
            self._asked.clear()
            size = sum(self._sizes.values())
            while self._opened and size > LARGEST:
                first = next(iter(self._opened))
                size -= self._sizes.pop(first)
                del self._opened[first]
            self._opened[name] = Opened(file)
        self._asked.add(name)
        return self._opened[name]


def is_store(file: str | Path) -> bool:
    """Say whether a record of this name is a folder, by its ending."""
    return Path(file).suffix.lower() == ".zarr"
