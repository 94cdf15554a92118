"""Write the files of commands: completely or not at all, and never over work of the user."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from breaker.common.text import say

_ENDINGS = {"picture": (".png", ".pdf", ".svg", ".jpg", ".jpeg"), "report": (".html",)}
# Bytes near the beginning of each kind of output. A file of lines, such as a configuration or a
# table of operations, may contain work of the user and is never replaced.
_MARKS = {
    "picture": (b"\x89PNG", b"%PDF", b"<svg", b"\xff\xd8\xff"),
    "report": (b'content="breaker report"',),
    "table": (b",interval_95_lower,",),
    "lines": (),
}


def check_outputs(wanted: Sequence[tuple[str | None, str]]) -> None:
    """Refuse outputs that cannot be written or would replace something else, before any work.

    Args:
        wanted: Name, or None, and kind of each output: "table", "picture", "report" or "lines".

    Raises:
        OSError, ValueError: If an output is refused; the message states the remedy.
    """
    for name, kind in wanted:
        if name is None:
            continue
        target, endings = Path(name), _ENDINGS.get(kind)
        if endings and target.suffix.lower() not in endings:
            what = f"{name} is not the name of a {kind}"
            raise ValueError(f"{what}. End it in {' or '.join(endings[:3])}")
        if not target.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {target.parent}/. Make it for {name}")
        if target.exists() and not _is_own(target, kind):
            what = "exists and may hold work of yours: it is not overwritten"
            raise FileExistsError(f"{name} {what}. Name another file, or delete it")


def _is_own(target: Path, kind: str) -> bool:
    """Return whether a file is empty, or an output of the same kind."""
    if not target.is_file():  # such as a folder or a pipe
        return False
    with target.open("rb") as stream:
        begins = stream.read(4096)
    return not begins or any(mark in begins for mark in _MARKS[kind])


def write(name: str, content: bytes) -> None:
    """Write a file under a temporary name, then rename it."""
    target = Path(os.path.realpath(name))  # a link stays a link
    part = target.with_name(f".breaker-{os.getpid()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, target)
    except OSError as error:
        remedy = "make room there, or name another place"
        raise OSError(f"{name} could not be written: {error.strerror}; {remedy}") from error
    finally:
        part.unlink(missing_ok=True)


def write_lines(name: str, text: str) -> str:
    """Write lines to a file, and return a sentence on it."""
    write(name, text.encode("utf-8"))
    return f"written to {name}"


def draw(figure, name: str) -> str:
    """Write a figure to a file, and return a sentence on it."""
    from breaker.figures.style import encoded

    write(name, encoded(figure, Path(name).suffix[1:].lower()))
    return f"drawn in {name}"


def say_written(written: Iterable[str], as_json: bool = False) -> None:
    """Print sentences on written files, on stderr if stdout has a JSON document."""
    for text in written:
        say(text, on_stderr=as_json)
