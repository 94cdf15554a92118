"""Run the commands of the tutorial, and write what they print and draw into it.

    python docs/tutorial/renew.py

A block of commands (```sh) may be followed by a block of its output (```text), in which `...`
stands for any lines. A shown line is that line of the output which differs from it in numbers
alone; where there is none, the text is to be mended by hand. Tests run the same commands.
"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from PIL import Image

HERE = Path(__file__).resolve().parent
PAGE = HERE / "README.md"

_BLOCK = re.compile(r"```sh\n(?P<commands>.*?)```(?:\n\n```text\n(?P<shown>.*?)```)?", re.S)
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_PROGRAM = """#!/bin/sh
exec "{python}" -c "from breaker.cli import main; exit(main())" "$@"
"""


class Step(NamedTuple):
    """Commands, and as much of their output as the text shows, if any."""

    commands: str
    shown: str


def steps(text: str) -> list[Step]:
    """Return the commands of a page, in order."""
    return [Step(each["commands"], each["shown"] or "") for each in _BLOCK.finditer(text)]


def run(
    text: str,
    folder: Path,
    python: str | Path = sys.executable,
    environment: Mapping[str, str] = os.environ,
) -> Iterator[tuple[Step, str]]:
    """Run all commands of a page in a folder; yields each step and its output.

    Args:
        python: Interpreter in whose environment the package is.
        environment: Variables of the commands, but for what is set here.

    Raises:
        RuntimeError: If a command fails.
    """
    programs = folder / ".programs"
    programs.mkdir()
    (programs / "breaker").write_text(_PROGRAM.format(python=python), encoding="utf-8")
    (programs / "breaker").chmod(0o755)
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    for step in steps(text):
        done = subprocess.run(
            ["bash", "-e", "-c", step.commands],
            cwd=folder,
            env={**environment, "PATH": path, "COLUMNS": "100"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        if done.returncode:
            raise RuntimeError(f"{step.commands}fails with {done.returncode}:\n{done.stdout}")
        yield step, done.stdout


def as_printed(shown: str, output: str) -> list[tuple[str, str]]:
    """Return each shown line with that of the output, in order; `...` stands for itself.

    Raises:
        ValueError: If a line is not printed, but for its numbers.
    """
    lines, pairs = iter(output.splitlines()), []
    for line in shown.splitlines():
        if line in ("...", "  ..."):
            pairs.append((line, line))
            continue
        found = next((each for each in lines if words(each) == words(line)), None)
        if found is None:
            raise ValueError(f"this is not printed, or not at its place:\n{line}\nin:\n{output}")
        pairs.append((line, found))
    return pairs


def words(line: str) -> str:
    """A line without its numbers and with single blanks."""
    return " ".join(_NUMBER.sub("0", line).split())


def small(picture: Path, target: Path) -> None:
    """Write a picture in few colours."""
    with Image.open(picture) as drawn:
        image = drawn.convert("RGB")
    image.thumbnail((900, 900))
    kept = image.quantize(128, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    kept.save(target, optimize=True)


def main() -> int:
    """Put outputs and pictures right."""
    text = PAGE.read_text(encoding="utf-8")
    new = text
    with TemporaryDirectory() as name:
        folder = Path(name)
        for step, output in run(text, folder):
            if step.shown:
                right = "".join(f"{line}\n" for _, line in as_printed(step.shown, output))
                new = new.replace(f"```text\n{step.shown}```", f"```text\n{right}```")
        for picture in re.findall(r"!\[[^\]]*\]\(([\w.]+\.png)\)", text):
            small(folder / picture, HERE / picture)
            print(f"{picture}: {(HERE / picture).stat().st_size / 1000:.0f} kB")
    PAGE.write_text(new, encoding="utf-8")
    print(f"{PAGE.name}: {'unchanged' if new == text else 'outputs put right'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
