"""How every file is opened: once, within bounds of memory, and without waiting. Light to import."""

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
    errno.EACCES: "cannot be read without permission; give yourself the permission",
}

_TOO_LARGE = (
    f"has more than {LARGEST // 2**20} MiB, which no record of one operation needs; export it "
    "alone, with fewer channels or at a lower rate"
)
Result = TypeVar("Result")


class RejectedCurveError(ValueError):
    """A curve file that cannot be used; the message is one printable line.

    Attributes:
        reason: Why the file cannot be used, and what to do.
        line: Line of the file that shows the reason; None if there is none.
    """

    def __init__(self, file: str | Path, reason: str, *, line: int | None = None) -> None:
        self.reason, self.line = reason, line
        place = f"{file}, line {line}" if line else f"{file}"
        super().__init__(printable(f"{place}: {reason}"))


def printable(text: str | Path) -> str:
    r"""Return a text on one line, with escapes for signs that cannot be printed or stored.

    >>> printable("caf\udce9\n.csv")
    'caf\\udce9\\n.csv'
    """
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in str(text)
    )


def no_file(file: str | Path) -> str:
    """Return why a name is not that of a regular file, or ""; the file is not opened."""
    try:
        kind = stat.S_IFMT(os.stat(file).st_mode)
    except (OSError, ValueError) as error:
        return _why(error)
    return "" if kind == stat.S_IFREG else f"is {_KINDS.get(kind, 'something else')}, not a file"


def _why(error: OSError | ValueError) -> str:
    return _WHY.get(getattr(error, "errno", None), f"cannot be read: {error}")


def opened_at_once(file: str | Path) -> BinaryIO:
    """Open a regular file to be read, without waiting for content that is not there yet."""
    # Reading /proc/kmsg, for example, waits. Windows has neither such files nor the flag.
    flag = getattr(os, "O_NONBLOCK", 0)
    return open(file, "rb", opener=lambda name, flags: os.open(name, flags | flag))


def read_bytes(file: str | Path) -> bytes:
    """Return the content of a file, without waiting.

    Raises:
        RejectedCurveError: If it is not a regular file, may not be read, or exceeds ``LARGEST``.
    """
    content, why = b"", no_file(file)  # before opening: a pipe waits, and a device may act
    if not why:
        try:
            with opened_at_once(file) as stream:
                content = stream.read(LARGEST + 1) or b""
        except OSError as error:
            why = _why(error)
    if len(content) > LARGEST:
        why = _TOO_LARGE
    if why:
        raise RejectedCurveError(file, why)
    return content


def require_folder(folder: str | Path) -> None:
    """Make sure that a record that is a folder can be read at once.

    Raises:
        RejectedCurveError: If it is not a folder, contains a link to a folder, or anything but
            folders and files, more than ``MOST_PARTS`` of them, or more than ``LARGEST`` bytes.
    """
    if not os.path.isdir(folder):
        raise RejectedCurveError(folder, no_file(folder) or "is a file, not a folder")
    size = count = 0
    for place, folders, names in os.walk(folder):
        count += len(folders) + len(names)
        for part in (os.path.join(place, name) for name in [*folders, *names]):
            why = "" if os.path.isdir(part) else no_file(part)
            if os.path.isdir(part) and os.path.islink(part):
                why = "is a link; put the folder there"
            if why:
                name = os.path.relpath(part, folder)
                raise RejectedCurveError(folder, f"its part {name} {why}")
            size += os.stat(part).st_size
        if count > MOST_PARTS or size > LARGEST:
            why = _TOO_LARGE if size > LARGEST else f"has more than {MOST_PARTS} parts"
            raise RejectedCurveError(folder, why)


def is_store(file: str | Path) -> bool:
    """Return whether a record of this name is a folder, by its ending."""
    return Path(file).suffix.lower() == ".zarr"


def check_lines(file: str | Path, content: bytes) -> None:
    """Reject a text with more lines than a record has samples, before they are split."""
    if max(content.count(b"\n"), content.count(b"\r")) > _MOST_SAMPLES:
        reason = f"has more than {_MOST_SAMPLES:,} lines; export a shorter part of the record"
        raise RejectedCurveError(file, reason)


def check_size(file: str | Path, samples: int, columns: int, *, line: int | None = None) -> None:
    """Reject a table with more columns, samples or bytes (8 a number) than a record."""
    if columns > MOST_COLUMNS:
        reason = f"has {columns:,} columns, but records have at most {MOST_COLUMNS}"
        raise RejectedCurveError(file, f"{reason}; export fewer channels", line=line)
    most = min(_MOST_SAMPLES, LARGEST // (8 * max(1, columns)))
    if samples > most:
        reason = f"has {samples:,} samples, but of {columns} columns at most {most:,} are read"
        raise RejectedCurveError(file, f"{reason}; export fewer channels, or a shorter part")


class Opened:
    """A file with all that is derived from it, computed once, even if the file changes later."""

    def __init__(self, file: str | Path) -> None:
        self.file = file
        self._results: dict[Hashable, tuple[object, ValueError | None]] = {}

    @property
    def size(self) -> int:
        """Bytes that are kept: contents of files, and arrays."""
        kept = (result for result, _ in self._results.values())
        return sum(len(e) if isinstance(e, bytes) else getattr(e, "nbytes", 0) for e in kept)

    @property
    def content(self) -> bytes:
        """Its bytes; raises as ``read_bytes``."""
        return self.beside(self.file)

    def beside(self, file: str | Path) -> bytes:
        """Return the bytes of another file of the same record."""
        return self.once(("content", str(file)), lambda: read_bytes(file))

    def once(self, key: Hashable, find: Callable[[], Result]) -> Result:
        """Return the result of a function, or raise its ValueError, once computed for a key."""
        if key not in self._results:
            try:
                self._results[key] = find(), None
            except ValueError as error:
                self._results[key] = None, error
        result, error = self._results[key]
        if error is not None:
            raise error
        return result


def as_opened(file: str | Path | Opened) -> Opened:
    """Return a file as one that is opened."""
    return file if isinstance(file, Opened) else Opened(file)


class Files:
    """Files of a command, each opened once; they are kept until they exceed ``LARGEST`` bytes."""

    def __init__(self) -> None:
        self._opened: dict[str, Opened] = {}
        self._last, self._size = Opened(""), 0

    def __getitem__(self, file: str | Path) -> Opened:
        """Return a file as one that is opened."""
        if (name := str(file)) not in self._opened:
            self._size += self._last.size
            if self._size > LARGEST:
                self._opened, self._size = {}, 0
            self._last = self._opened[name] = Opened(file)
        return self._opened[name]
