"""A file that is opened once, whatever is asked of it."""

from collections.abc import Callable, Hashable
from pathlib import Path
from typing import TypeVar

from breaker.files.guards import read_bytes

Found = TypeVar("Found")


class Opened:
    """A file, and what was found in it, each looked for once: for as long as this stands, the file
    is what it was when it was opened.

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
    def content(self) -> bytes:
        """Its bytes; raises as ``guards.read_bytes``."""
        return self.beside(self.file)

    def beside(self, file: str | Path) -> bytes:
        """The bytes of a file that belongs to it, under its own name."""
        return self.once(("content", str(file)), lambda: read_bytes(file))

    def once(self, what: Hashable, find: Callable[[], Found]) -> Found:
        """Return what is found under a name, or raise why it is not."""
        if what not in self._found:
            try:
                self._found[what] = find(), None
            except ValueError as error:
                self._found[what] = None, error
        found, error = self._found[what]
        if error is not None:
            raise error
        return found


def as_opened(file: str | Path | Opened) -> Opened:
    """Return a file as one that is opened."""
    return file if isinstance(file, Opened) else Opened(file)
