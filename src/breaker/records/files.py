"""Open files: each once, within bounds of memory, and without waiting. Light to import."""

import os
import stat
from collections.abc import Callable, Hashable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

LARGEST = 64 * 2**20
"""Bytes of the largest file, packed or unpacked; 10 s at 100 kHz take a quarter of this."""

MOST_COLUMNS = 300
"""Columns of the widest table; exports have at most a tenth of this."""

_KEPT = LARGEST // 4  # bytes of files that stay opened; their numbers may take ten times as many
_MOST_SAMPLES = 1_200_000  # most samples of a record; 10 s at 100 kHz are a million

_REMEDY = "export the record alone, with fewer channels or at a lower rate"
Result = TypeVar("Result")


class RejectedCurveError(ValueError):
    """Curve file that cannot be used; the message is one printable line.

    Attributes:
        file: The file, printable.
        reason: Reason why the file cannot be used, and the remedy.
        line: Line of the file that shows the reason; None if there is none.
    """

    def __init__(self, file: str | Path, reason: str, *, line: int | None = None) -> None:
        self.file, self.reason, self.line = printable(file), reason, line
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
        if stat.S_ISREG(os.stat(file).st_mode):  # opening a pipe waits, and a device may act
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
    """A file and results derived from it, each computed once, even if the file changes later."""

    def __init__(self, file: str | Path) -> None:
        self.file = file
        self._results: dict[Hashable, object] = {}

    @property
    def content(self) -> bytes:
        """Bytes of the file; raises as ``read_bytes``."""
        return self.companion(self.file)

    def companion(self, file: str | Path) -> bytes:
        """Return the bytes of another file of the same record."""
        return self.once(("content", str(file)), lambda: read_bytes(file))

    def once(self, key: Hashable, find: Callable[[], Result]) -> Result:
        """Return the result of a function, which is called once for each key."""
        if key not in self._results:
            self._results[key] = find()
        return self._results[key]


def as_opened(file: str | Path | Opened) -> Opened:
    """Return a file as an ``Opened``."""
    return file if isinstance(file, Opened) else Opened(file)


class Files:
    """Files of a command, each opened once; the last files are kept."""

    def __init__(self) -> None:
        self._opened: dict[str, Opened] = {}
        self._size = 0

    def __getitem__(self, file: str | Path) -> Opened:
        """Return a file as an ``Opened``."""
        if (name := str(file)) not in self._opened:
            with suppress(OSError, ValueError):  # reading the file names the reason
                self._size += os.path.getsize(file)
            if self._size > _KEPT:
                self._opened, self._size = {}, 0
            self._opened[name] = Opened(file)
        return self._opened[name]
