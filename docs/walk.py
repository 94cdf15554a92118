"""Run the commands of pages, and write the numbers of their output into the pages.

    python docs/walk.py

Blocks of output (```text) may follow a block of commands (```sh); `...` in them matches any lines.
A shown line may differ from the output only in numbers, which are corrected. Any other difference
is an error. Tests and `make dist` run the same commands.
"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
PAGES = (HERE / "start" / "read-a-result.md", HERE / "how-to" / "compare-inspections.md")

_BLOCK = re.compile(r"```(?P<kind>sh|text)\n(?P<content>.*?)```", re.S)
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_PROGRAM = """#!/bin/sh
exec "{python}" -c "from breaker.cli import main; exit(main())" "$@"
"""


class Step(NamedTuple):
    """Commands, and the blocks of their output on the page."""

    commands: str
    shown: list[str]


def steps(text: str) -> list[Step]:
    """Return the commands of a page, in order."""
    made: list[Step] = []
    for block in _BLOCK.finditer(text):
        if block["kind"] == "sh":
            made.append(Step(block["content"], []))
        else:
            made[-1].shown.append(block["content"])
    return made


def run(
    text: str,
    folder: Path,
    python: str | Path = sys.executable,
    environment: Mapping[str, str] = os.environ,
) -> Iterator[tuple[Step, str]]:
    """Run all commands of a page in a folder, and yield the steps with their output.

    Args:
        python: Interpreter of an environment with the package.
        environment: Variables of the commands, in addition to variables set here.

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


def as_printed(shown: str, output: str) -> str:
    """Return a shown block with the numbers of the output; `...` matches any lines.

    Raises:
        ValueError: If the output lacks a line, or has the line at another place.
    """
    lines, right = iter(output.splitlines()), []
    for line in shown.splitlines():
        printed = line
        if line.strip() != "...":
            printed = next((other for other in lines if words(other) == words(line)), None)
        if printed is None:
            raise ValueError(f"the commands do not print this line here:\n{line}\nin:\n{output}")
        right.append(f"{printed}\n")
    return "".join(right)


def words(line: str) -> str:
    """Return a line without its numbers and with single blanks."""
    return " ".join(_NUMBER.sub("0", line).split())


def main() -> int:
    """Correct the numbers of all pages."""
    for page in PAGES:
        new = text = page.read_text(encoding="utf-8")
        with TemporaryDirectory() as name:
            for step, output in run(text, Path(name)):
                for shown in step.shown:
                    new = new.replace(shown, as_printed(shown, output))
        page.write_text(new, encoding="utf-8")
        print(f"{page.name}: {'unchanged' if new == text else 'numbers put right'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
