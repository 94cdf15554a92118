"""How every file is opened: once, within bounds of memory, and without waiting. Light to import."""

import os
import stat
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import TypeVar

LARGEST = 64 * 2**20
"""Bytes of the largest file, packed or unpacked; 10 s at 100 kHz take a quarter of it."""

MOST_COLUMNS = 300
"""Columns of the widest table; exports have at most a tenth of it."""

MOST_PARTS = 10_000
"""Parts of a folder, and chunks, of one record: 300 columns of 10 chunks take a third of it."""

_MOST_SAMPLES = 1_200_000  # a record of 10 s at 100 kHz has a million

_REMEDY = "export the record alone, with fewer channels or at a lower rate"
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
    """Return a text on one line, with escapes for signs that cannot be printed or stored."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in str(text)
    )


def read_bytes(file: str | Path) -> bytes:
    """Return the content of a file, without waiting.

    Raises:
        RejectedCurveError: If it is not a regular file, may not be read, or exceeds ``LARGEST``.
    """
    content, why = b"", ""
    try:
        if stat.S_ISREG(os.stat(file).st_mode):  # a pipe waits as it is opened, a device may act
            with open(file, "rb") as stream:
                content = stream.read(LARGEST + 1)
        else:
            why = "is a folder, a pipe or a device, not a file"
    except FileNotFoundError:
        why = "is not there; was it moved or deleted, or does a link lead nowhere?"
    except (OSError, ValueError) as error:
        why = f"cannot be read: {error}"
    if why:
        raise RejectedCurveError(file, why)
    check_bytes(file, len(content))
    return content


def is_store(file: str | Path) -> bool:
    """Return whether a record of this name is a folder, by its ending."""
    return Path(file).suffix.lower() == ".zarr"


def check_store(folder: str | Path) -> None:
    """Reject a record that is no folder, has more parts or bytes than a record, or has parts that
    are neither folders nor files.
    """
    if not os.path.isdir(folder):
        raise RejectedCurveError(folder, "is not there, or not a folder; name that of the store")
    count = size = 0
    for place, folders, names in os.walk(folder):
        for part in (os.path.join(place, name) for name in [*folders, *names]):
            state, count = os.lstat(part), count + 1
            if not (stat.S_ISREG(state.st_mode) or stat.S_ISDIR(state.st_mode)):
                why = f"its part {os.path.relpath(part, folder)} is a link, a pipe or a device"
                raise RejectedCurveError(folder, f"{why}; put the file or folder itself there")
            size += state.st_size
        check_parts(folder, count)
        check_bytes(folder, size)


def check_parts(file: str | Path, count: int) -> None:
    """Reject more parts than ``MOST_PARTS``."""
    if count > MOST_PARTS:
        raise RejectedCurveError(file, f"has {count:,} parts; export the record in larger chunks")


def check_bytes(file: str | Path, size: int) -> None:
    """Reject more bytes than ``LARGEST``."""
    if size > LARGEST:
        raise RejectedCurveError(file, f"has more than {LARGEST // 2**20} MiB; {_REMEDY}")


def check_lines(file: str | Path, content: bytes) -> None:
    """Reject a text with more lines than a record has samples, before they are split."""
    check_size(file, max(content.count(b"\n"), content.count(b"\r")), 1)


def check_size(file: str | Path, samples: int, columns: int, *, line: int | None = None) -> None:
    """Reject a table with more columns, samples or bytes (8 a number) than a record."""
    most = min(_MOST_SAMPLES, LARGEST // (8 * max(1, columns)))
    if columns > MOST_COLUMNS or samples > most:
        rows = f", {samples:,} lines or samples of each" if samples else ""
        reason = f"has {columns:,} columns{rows}; {_REMEDY}"
        raise RejectedCurveError(file, reason, line=line)


class Opened:
    """A file with all that is derived from it, computed once, even if the file changes later."""

    def __init__(self, file: str | Path) -> None:
        self.file = file
        self._results: dict[Hashable, object] = {}

    @property
    def size(self) -> int:
        """Bytes that are kept: contents of files, and arrays."""
        kept = self._results.values()
        return sum(len(e) if isinstance(e, bytes) else getattr(e, "nbytes", 0) for e in kept)

    @property
    def content(self) -> bytes:
        """Its bytes; raises as ``read_bytes``."""
        return self.beside(self.file)

    def beside(self, file: str | Path) -> bytes:
        """Return the bytes of another file of the same record."""
        return self.once(("content", str(file)), lambda: read_bytes(file))

    def once(self, key: Hashable, find: Callable[[], Result]) -> Result:
        """Return the result of a function, which is called once for a key."""
        if key not in self._results:
            self._results[key] = find()
        return self._results[key]


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
