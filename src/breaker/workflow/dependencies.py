"""The modules that a script of the workflow depends on, as inputs of its rule.

Snakemake looks at the script alone; named as inputs, modules count too, by their content. A script
depends on the modules that it imports, and on what these import in turn.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def modules_of(script: str | Path, *, itself: bool = False) -> list[str]:
    """Return the files of the package that a script imports, directly or not, and ``itself``.

    Sorted; those below the working directory are relative to it, so that a project can be moved.
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
    """Return files of the package that a file itself imports, packages on the way too."""
    if file.suffix != ".py":
        return set()
    names = _names(ast.parse(file.read_text(encoding="utf-8")))
    return {path for name in names for path in _files(name)}


def _names(node: ast.AST) -> Iterator[str]:
    """Yield dotted names that are imported below a node, but under ``if TYPE_CHECKING:``."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            above = f"{child.module}." if isinstance(child, ast.ImportFrom) else ""
            yield from (above + alias.name for alias in child.names)
        elif not isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
            continue  # an expression, which holds no import
        elif not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield from _names(child)


def _files(name: str) -> Iterator[Path]:
    """Yield the files of a dotted name: packages, and a module with its template and its data."""
    package, *parts = name.split(".")
    place = _PACKAGE
    for part in ["", *parts] if package == "breaker" else []:
        place = place / part
        if place.is_dir():
            yield place / "__init__.py"
        elif place.with_suffix(".py").is_file():
            files = (place.with_suffix(ending) for ending in (".py", ".html", ".yaml"))
            yield from (file for file in files if file.is_file())
