"""Write the files of commands, completely or not at all, and never over work of the user."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from breaker.common.clean_text import print_text

_ENDINGS = {"picture": (".png", ".pdf", ".svg"), "report": (".html",)}


def check_outputs(wanted: Sequence[tuple[str | None, str]]) -> None:
    """Refuse outputs that cannot be written or would replace work of the user, before any work.

    Pictures and reports are replaced. Other files, such as a record, a configuration or a table of
    operations, may contain work of the user.

    Args:
        wanted: Name, or None, and kind of each output: "picture", "report" or "lines".

    Raises:
        OSError, ValueError: If an output is refused; the message states the remedy.
    """
    for name, kind in wanted:
        if name is None:
            continue
        target, endings = Path(name), _ENDINGS.get(kind)
        if endings and target.suffix.lower() not in endings:
            what = f"{name} is not the name of a {kind}"
            raise ValueError(f"{what}. End it in {' or '.join(endings)}")
        if not target.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {target.parent}/. Make it for {name}")
        if target.exists() and not (endings and target.is_file()):
            raise FileExistsError(f"{name} exists and is not replaced. Name another, or delete it")


def write(name: str, content: bytes) -> None:
    """Write a file under a temporary name, then rename it; a link is replaced, not its target."""
    part = Path(name).with_name(f".breaker-{os.getpid()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, name)
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
        print_text(text, on_stderr=as_json)
