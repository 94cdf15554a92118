"""Modules that a script of the workflow depends on, as inputs of its rule.

Snakemake detects changes of the script only. With modules as inputs, their changes also rerun a
rule. A script depends on the modules that it imports, directly or through other modules.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def modules_of(script: str | Path, *, itself: bool = False) -> list[str]:
    """Return the files of the package that a script imports, directly or not, and ``itself``.

    Paths are sorted, and relative below the working directory, so that a project can be moved.
    """
    waiting = [Path(script).resolve()]
    modules = set(waiting if itself else [])
    while waiting:
        new = _imported(waiting.pop()) - modules
        modules |= new
        waiting.extend(new)
    here = Path.cwd()
    return sorted(str(f.relative_to(here)) if f.is_relative_to(here) else str(f) for f in modules)


@cache
def _imported(file: Path) -> set[Path]:
    """Return files of the package that a file imports directly, with their parent packages."""
    if file.suffix != ".py":
        return set()
    names = _names(ast.parse(file.read_text(encoding="utf-8")))
    return {path for name in names for path in _files(name)}


def _names(node: ast.AST) -> Iterator[str]:
    """Yield dotted names that are imported below a node, except under ``if TYPE_CHECKING:``."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            above = f"{child.module}." if isinstance(child, ast.ImportFrom) else ""
            yield from (above + alias.name for alias in child.names)
        elif not isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
            continue  # an expression contains no import
        elif not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield from _names(child)


def _files(name: str) -> Iterator[Path]:
    """Yield the files of a dotted name: packages, and a module with its template and data."""
    package, *parts = name.split(".")
    place = _PACKAGE
    for part in ["", *parts] if package == "breaker" else []:
        place = place / part
        if place.is_dir():
            yield place / "__init__.py"
        elif place.with_suffix(".py").is_file():
            files = (place.with_suffix(ending) for ending in (".py", ".html", ".yaml"))
            yield from (file for file in files if file.is_file())
