"""What commands write: whole or not at all, and never over what is not theirs."""

import os
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from breaker.common.text import say
from breaker.model.parameters import MOTIONS

_ENDINGS = {"picture": (".png", ".pdf", ".svg", ".jpg", ".jpeg"), "report": (".html", ".pdf")}
_PICTURES = (b"\x89PNG", b"%PDF", b"<?xml", b"\xff\xd8\xff")  # first bytes of pictures
_WORDS = {"table": b",interval_95_lower,", "report": b'content="breaker report"'}  # near the top


def check_outputs(wanted: Sequence[tuple[str | None, str]], read: Iterable[str]) -> None:
    """Refuse what cannot or must not be written, before any work is done.

    A result replaces a result of its kind, so never a record. Lines that a user completes, such as
    a configuration or a table of operations, replace nothing.

    Args:
        wanted: Name, or None, and kind of each output: "table", "picture", "report" or "lines".
        read: Files and folders that the command was given.

    Raises:
        OSError, ValueError: With the remedy.
    """
    folders = {os.path.realpath(Path(source, sub)) for source in read for sub in ("", *MOTIONS)}
    earlier: list[Path] = []
    for name, kind in wanted:
        if name is None:
            continue
        target = Path(os.path.realpath(name))
        if any(target.is_relative_to(other) or other.is_relative_to(target) for other in earlier):
            raise ValueError(f"{name} is, or is in, another output of this command; name another")
        earlier.append(target)
        _check_output(name, target, kind, among_records=str(target.parent) in folders)


def _check_output(name: str, target: Path, kind: str, *, among_records: bool) -> None:
    from breaker.records.formats.registry import ENDINGS
    from breaker.records.operations import MANIFEST

    ending, endings = target.suffix.lower(), _ENDINGS.get(kind)
    if endings and ending not in endings:
        raise ValueError(f"{name} is no name of a {kind}; end it in {' or '.join(endings[:3])}")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {Path(name).parent}/; make it for {name}")
    if os.path.lexists(target) and not _is_own(target, kind):
        what = "is there already and may hold work of yours: it is not overwritten"
        raise FileExistsError(f"{name} {what}. Name another, or delete it")
    table = kind == "lines" and target.name == MANIFEST
    if among_records and ending in ENDINGS and not table:
        raise ValueError(f"{name} would be read as a record of this folder; name another place")
    if not os.access(target if target.exists() else target.parent, os.W_OK):
        raise PermissionError(f"{name} may not be written; name another")


def _is_own(target: Path, kind: str) -> bool:
    """Return whether what is at a place is empty, or a result of the same kind."""
    if not target.is_file():  # such as a pipe or a device
        return False
    with target.open("rb") as stream:
        begins = stream.read(4096)
    of_words = kind in _WORDS and _WORDS[kind] in begins
    return not begins or of_words or (kind in _ENDINGS and begins.startswith(_PICTURES))


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Yield a hidden name beside a path; what is written there takes its place at the end.

    What a link leads to is replaced. A file keeps its permissions. After any error, such as an
    OSError where it cannot be replaced, what was there stays.
    """
    target = Path(os.path.realpath(path))
    # A name of its own, as that of the target may have the greatest length.
    part, old = (target.with_name(f".{secrets.token_hex(4)}{target.suffix[:10]}") for _ in "12")
    try:
        yield part
        if not part.is_dir():
            with open(part, "r+b") as stream:  # Windows synchronises no file that is only read
                os.fsync(stream.fileno())  # some file systems find out now that they are full
            if target.exists():
                shutil.copymode(target, part)
        elif target.exists():  # a folder takes the place of none but an empty one
            os.rename(target, old)
        os.replace(part, target)
    except BaseException:
        if old.exists():
            os.rename(old, target)
        raise
    finally:
        for leftover in (part, old):
            if leftover.is_dir():
                shutil.rmtree(leftover, ignore_errors=True)
            else:
                leftover.unlink(missing_ok=True)


def write(name: str, fill: Callable[[Path], object]) -> None:
    """Let a function write a file or a folder under a name, whole or not at all."""
    try:
        with whole(name) as part:
            fill(part)
    except OSError as error:
        remedy = "make room there, or name another place"
        raise OSError(f"{name} could not be written: {error.strerror}; {remedy}") from error


def write_lines(name: str, text: str) -> str:
    """Write lines to a file, and return what to say of it."""
    write(name, lambda part: part.write_bytes(text.encode("utf-8")))
    return f"written to {name}"


def draw(figure, name: str) -> str:
    """Write a figure to a file, and return what to say of it."""
    from breaker.figures.style import encoded, without_font

    content = encoded(figure, Path(name).suffix[1:].lower())
    write(name, lambda part: part.write_bytes(content))
    return "\n".join(filter(None, [f"drawn in {name}", without_font([figure])]))


def say_written(written: Iterable[str], as_json: bool = False) -> None:
    """Print what was written, last: on stderr beside a JSON document."""
    for text in written:
        say(text, on_stderr=as_json)
