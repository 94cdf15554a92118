"""The modules that a script of the workflow depends on, as inputs of its rule.

Snakemake looks at the script alone; named as inputs, modules count too, by their content. A script
depends on the modules that it imports, and on what these import in turn.
"""

import ast
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def modules_of(script: str | Path, *, itself: bool = False) -> list[str]:
    """Return the files of the package that a script imports, directly or not, sorted.

    Paths below the working directory are relative to it, so that a project can be moved.

    Args:
        script: A Python file.
        itself: Whether the script is one of them.
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
def _imported(file: Path) -> list[Path]:
    """Return files of the package that a file itself imports, packages on the way too."""
    found: list[Path] = []
    if file.suffix == ".py":
        for node in _statements(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    found += _files(alias.name, ())
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found += _files(node.module, [alias.name for alias in node.names])
    return found


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements below a node, but those of ``if TYPE_CHECKING:``, which never run."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
            continue  # an expression, which holds no import
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        yield child
        yield from _statements(child)


def _files(module: str, names: Sequence[str]) -> Iterator[Path]:
    """Yield files of ``from module import names``, or of ``import module`` without names."""
    package, *parts = module.split(".")
    if package != "breaker":
        return
    place = _PACKAGE
    for part in parts:
        yield place / "__init__.py"
        place = place / part
    if not place.is_dir():
        yield place.with_suffix(".py")
        yield from place.parent.glob(f"{place.name}.html")  # its template
        yield from place.parent.glob(f"{place.name}.yaml")  # its data
        return
    yield place / "__init__.py"
    for name in names:  # a module, or a package; what a package itself defines is in its file
        if (place / name).is_dir():
            yield place / name / "__init__.py"
        elif (file := place / f"{name}.py").exists():
            yield file
