"""What commands write: never what they read, never what is not theirs, whole or not at all."""

import json
import os
import stat
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from breaker.cli.command_inputs import ADVANCED, MOTIONS, PROJECT
from breaker.common.atomic_writes import whole
from breaker.common.visible_text import say
from breaker.reading.files.guards import opened_at_once
from breaker.shipped import DEFAULTS

_PICTURES = (".png", ".pdf", ".svg", ".jpg", ".jpeg")
_REPORTS = (".html", ".pdf")
_PAGE = b'content="breaker report"'  # in the head of a report that is a page
_STARTS = (b"\x89PNG", b"%PDF", b"<?xml", b"\xff\xd8\xff")  # of the content of pictures
_COLUMNS = {"motion", "operation", "output", "interval_95_lower"}  # of a table of answers


def check_outputs(wanted: Sequence[tuple[str | None, str]], read: Iterable[str]) -> None:
    """Refuse what cannot or must not be written, before any work is done.

    A result replaces a result of its kind: a table of answers, a picture, a report, a store of
    draws. Lines that a user completes, such as a configuration or a table of operations, replace
    nothing.

    Args:
        wanted: Name and kind of each output that a command has: "table", "picture", "report",
            "store" or "lines". No name where it is not asked for.
        read: Files and folders that the command was given.

    Raises:
        OSError: If the folder of an output is not there or may not be written, or something is at
            its place that is not replaced.
        ValueError: If it is read, or would be by the next command, if two outputs are one, or a
            picture has no ending of one.
    """
    read = [Path(each) for each in (*read, ADVANCED, PROJECT, DEFAULTS)]
    earlier: list[Path] = []
    for name, kind in wanted:
        if name is None:
            continue
        _check_name(name)
        target = Path(os.path.realpath(name))
        if any(target.is_relative_to(each) or each.is_relative_to(target) for each in earlier):
            raise ValueError(f"{name} is, or is in, another output of this command; name another")
        earlier.append(target)
        _check_not_read(name, target, read, kind)
        _check_place(name, target, kind)
        if os.path.lexists(target):
            _check_own(name, target, kind)
        if not os.access(target if target.exists() else target.parent, os.W_OK):
            raise PermissionError(f"{name} may not be written; name another")


def _check_name(name: str) -> None:
    """Refuse a name that no file can have, and a link that leads nowhere but to itself."""
    try:
        os.stat(name)
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return  # see below
    except OSError as error:
        raise OSError(f"{name} cannot be written: {error.strerror}; name another") from error
    except ValueError as error:
        raise ValueError(f"{name} is no name of a file: {error}; name another") from error


def _check_place(name: str, target: Path, kind: str) -> None:
    """Refuse a place at which no file of a kind can be."""
    if not target.parent.is_dir():
        folder = Path(name).parent
        raise FileNotFoundError(f"there is no folder {folder}/ for {name}; make it first")
    if target.is_dir() and not (kind == "store" and _is_store_of_draws(target)):
        raise IsADirectoryError(f"{name} is a folder, and is not replaced; name another")
    if kind == "picture" and target.suffix.lower() not in _PICTURES:
        raise ValueError(f"{name} is no name of a picture; end it in {' or '.join(_PICTURES[:3])}")
    if kind == "report" and target.suffix.lower() not in _REPORTS:
        raise ValueError(f"{name} is no name of a report; end it in {' or '.join(_REPORTS)}")
    if kind == "store" and target.is_file():
        raise FileExistsError(f"{name} is a file, and a store is a folder; name another")
    if any(each.suffix.lower() == ".zarr" for each in target.parents):
        raise ValueError(f"{name} is within a Zarr store, of which it is no part; name another")


def _check_not_read(name: str, target: Path, read: Sequence[Path], kind: str) -> None:
    """Refuse what is read by this command, by whatever path or link, or would be by the next."""
    from breaker.reading.files.formats import ENDINGS
    from breaker.reading.files.operations_table import MANIFEST

    folders = {os.path.realpath(each / sub) for each in read for sub in ("", *MOTIONS)}
    parts = (part for each in read for part in _parts(each))
    if target.exists() and any(os.path.exists(part) and target.samefile(part) for part in parts):
        raise ValueError(
            f"{name} is there already: it is what is read, and would be replaced; name another"
        )
    ending = target.suffix.lower()
    table = kind == "lines" and target.name == MANIFEST
    if str(target.parent) in folders and ending in ENDINGS and not table:
        raise ValueError(
            f"{name} would be read as a record: {target.parent.name} is a folder of records, and "
            f"files there that end in {ending} are; name another place"
        )


def _parts(named: Path) -> Iterator[Path]:
    """What belongs to a file or folder that is read, two folders deep."""
    yield named
    if named.is_dir():
        yield from named.glob("*")
        yield from named.glob("*/*")
    elif named.suffix.lower() == ".cfg":  # the data of a COMTRADE record stand beside it
        yield from named.parent.glob(f"{named.stem}.*")


def _check_own(name: str, target: Path, kind: str) -> None:
    """Refuse to replace what is no result of an earlier command."""
    found = os.stat(target)
    for stream in (sys.stdout, sys.stderr):
        try:
            same = os.path.samestat(found, os.fstat(stream.fileno()))
        except (OSError, ValueError):  # of a stream that is no file
            continue
        if same:
            raise ValueError(f"{name} is where the text goes; name another file")
    if target.is_dir():
        return
    if not stat.S_ISREG(found.st_mode):
        raise FileExistsError(f"{name} is a pipe or a device, not a file; name another")
    with opened_at_once(target) as stream:
        begins = stream.read(4096) or b""
    if kind == "table":
        own = {*begins.partition(b"\n")[0].decode(errors="replace").split(",")} >= _COLUMNS
    else:
        own = kind in ("picture", "report") and begins.startswith(_STARTS)
        own |= kind == "report" and _PAGE in begins
    if begins and not own:
        raise FileExistsError(
            f"{name} is there already and may hold work of yours: it is not overwritten. Name "
            "another file, or delete it"
        )


def _is_store_of_draws(folder: Path) -> bool:
    """Whether a folder is a store that an earlier command has written."""
    try:
        about = json.loads((folder / "posterior" / ".zattrs").read_text(encoding="utf-8"))
        return about.get("inference_library") == "breaker"
    except (OSError, ValueError, AttributeError):
        return False


def draw(figure, name: str) -> str:
    """Write a figure to a file, whole or not at all, and return what to say of it."""
    from breaker.figures.encoding import encoded, without_font

    write_bytes(name, encoded(figure, Path(name).suffix[1:].lower()))
    return "\n".join(filter(None, [f"drawn in {name}", without_font([figure])]))


def write_bytes(name: str, content: bytes) -> None:
    """Write a file, whole or not at all; raise as ``write``."""
    write(name, lambda part: part.write_bytes(content))


def write(name: str, fill: Callable[[Path], object]) -> None:
    """Write a file or a folder, whole or not at all.

    Args:
        name: Its name.
        fill: What writes it under the name that it is given.

    Raises:
        OSError: If it cannot be written, as on a full disk; what was there stays.
    """
    try:
        with whole(name) as part:
            fill(part)
    except OSError as error:
        remedy = "make room there, or name another place"
        raise OSError(f"{name} could not be written: {error.strerror}; {remedy}") from error


def write_lines(name: str, text: str) -> str:
    """Write lines to a file, whole or not at all, and return what to say of it."""
    write_bytes(name, text.encode("utf-8"))
    return f"written to {name}"


def say_written(written: Iterable[str], as_json: bool = False) -> None:
    """Print what was written, last: beside a JSON document, not in it."""
    for text in written:
        say(text, beside=as_json)
