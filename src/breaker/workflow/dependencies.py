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
    """Return the files of the package that a script imports, directly or not, sorted.

    Args:
        script: A Python file.
        itself: Whether the script is one of them.

    Returns:
        Paths relative to the working directory where they are below it, so that a project can be
        moved.
    """
    waiting = [Path(script).resolve()]
    found = set(waiting if itself else [])
    while waiting:
        new = set(_imported(waiting.pop())) - found
        found |= new
        waiting.extend(new)
    here = Path.cwd()
    return sorted(str(f.relative_to(here)) if f.is_relative_to(here) else str(f) for f in found)


@cache
def _imported(file: Path) -> tuple[Path, ...]:
    """Files of the package that a file itself imports, ``__init__`` of the rooms on the way too."""
    if file.suffix != ".py":
        return ()
    return tuple(
        path
        for node in _statements(ast.parse(file.read_text(encoding="utf-8")))
        for module, names in _imports(node)
        if module.split(".")[0] == "breaker"
        for path in _files(module, names)
    )


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements below a node, but those of ``if TYPE_CHECKING:``, which never run."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
            continue  # an expression, which holds no import
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        yield child
        yield from _statements(child)


def _imports(node: ast.AST) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Modules of an import statement, and the names that are taken from each."""
    if isinstance(node, ast.Import):
        yield from ((alias.name, ()) for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
        yield node.module, tuple(alias.name for alias in node.names)


def _files(module: str, names: tuple[str, ...]) -> Iterator[Path]:
    """Files behind ``from module import names``, or behind ``import module`` without names."""
    place = _PACKAGE
    for part in module.split(".")[1:]:
        yield place / "__init__.py"
        place = place / part
    if not place.is_dir():
        yield place.with_suffix(".py")
        yield from place.parent.glob(f"{place.name}.html")  # its template
        yield from place.parent.glob(f"{place.name}.yaml")  # its data
        return
    yield place / "__init__.py"
    for name in names:  # a module, or a room; what a face itself defines is in its file
        if (place / name).is_dir():
            yield place / name / "__init__.py"
        elif (file := place / f"{name}.py").exists():
            yield file
