"""Files that are opened once, whatever is asked of them."""

from collections.abc import Callable, Hashable
from pathlib import Path
from typing import TypeVar

from breaker.reading.files.guards import read_bytes

Found = TypeVar("Found")

_KEPT = 2**26  # bytes of files that are kept open, and of their columns: some hundred exports


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
    def size(self) -> int:
        """Bytes that were read of it, and of the arrays that were found: all of a Zarr store."""
        found = (each for each, _ in self._found.values())
        return sum(len(e) if isinstance(e, bytes) else getattr(e, "nbytes", 0) for e in found)

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


class Files:
    """Files of a command, each opened once; of very many, those that were opened last are kept."""

    def __init__(self) -> None:
        self._opened: dict[str, Opened] = {}
        self._sizes: dict[str, int] = {}
        self._asked: set[str] = set()  # since sizes were taken, and may have grown

    def __getitem__(self, file: str | Path) -> Opened:
        """Return a file as one that is opened."""
        name = str(file)
        if name not in self._opened:
            self._sizes |= {each: self._opened[each].size for each in self._asked}
            self._asked.clear()
            size = sum(self._sizes.values())
            while self._opened and size > _KEPT:
                first = next(iter(self._opened))
                size -= self._sizes.pop(first)
                del self._opened[first]
            self._opened[name] = Opened(file)
        self._asked.add(name)
        return self._opened[name]
