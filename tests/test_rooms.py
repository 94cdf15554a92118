"""What may be imported from where, how large a function may be, and what starts fast."""

import ast
import importlib
import pkgutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from importlinter.cli import lint_imports

ROOT = Path(__file__).resolve().parents[1]

LONGEST_FUNCTION = 55  # lines, so that it is seen whole
HEAVY = {"torch", "numba", "xarray", "scipy", "pandas", "zarr", "matplotlib"}


def sources(*folders: str) -> dict[str, str]:
    """Return the text of every Python file in folders of the project, by its path."""
    return {
        file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8")
        for folder in folders
        for file in sorted((ROOT / folder).rglob("*.py"))
    }


PACKAGE = sources("src/breaker")
OTHERS = sources("workflow/scripts", "studies")


def folder_of(module: str) -> str | None:
    """Return the folder of a module such as ``breaker.model.curves``; None if it is another's."""
    parts = module.split(".")
    return parts[1] if parts[0] == "breaker" and len(parts) > 1 else None


class Import(NamedTuple):
    """``from module import name`` in a file, or ``import module`` without a name."""

    file: str
    module: str
    name: str = ""

    @property
    def here(self) -> str | None:
        """The folder that imports."""
        path = Path(self.file.removeprefix("src/")).with_suffix("")
        return folder_of(".".join(path.parts))

    @property
    def there(self) -> str | None:
        """The folder that is imported from, also where it is taken as a whole."""
        return folder_of(f"{self.module}.{self.name}")


@cache
def imports_of(file: str, text: str) -> list[Import]:
    """Return every import of a file, also those within functions."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found += [Import(file, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found += [Import(file, node.module, alias.name) for alias in node.names]
    return found


def imports(code: dict[str, str]) -> Iterator[Import]:
    """Yield every import of files."""
    for file, text in code.items():
        yield from imports_of(file, text)


# Each check takes files and returns what is wrong with them.


def hidden(code: dict[str, str]) -> list:
    """Find names that start with an underscore, of another folder."""
    between = [each for each in imports(code) if each.there and each.there != each.here]
    names = [each for each in between if each.name.startswith("_")]
    return [each for each in names if not each.name.endswith("__")]


def of_a_study(code: dict[str, str]) -> list:
    """Find imports of studies and tests in the package."""
    own = [each for each in imports(code) if each.file.startswith("src/")]
    return [each for each in own if each.module.split(".")[0] in ("studies", "tests")]


def tall(code: dict[str, str]) -> list:
    """Find functions of the package that are too long."""
    return [
        (file, node.name)
        for file, text in code.items()
        if not file.startswith("studies/")
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and node.end_lineno - node.lineno >= LONGEST_FUNCTION
    ]


# A check, and a file with which it has to find something wrong.
CHECKS = {
    "a hidden name": (hidden, "prognosis", "from breaker.model.curves import _travel"),
    "a long function": (tall, "model", "def f():\n" + "    pass\n" * LONGEST_FUNCTION),
    "a study": (of_a_study, "prognosis", "def f():\n    from studies.lives import Life"),
}


def test_folders_import_those_below_them():
    """The contracts of ``.importlinter``."""
    assert lint_imports(config_filename=str(ROOT / ".importlinter"), no_cache=True) == 0


@pytest.mark.parametrize("name", CHECKS)
def test_the_code_is_in_order_and_a_planted_fault_is_found(name):
    check, room, text = CHECKS[name]
    assert check(PACKAGE | OTHERS) == []
    assert len(check({f"src/breaker/{room}/a.py": text})) == 1


def test_every_imported_name_is_there():
    """Of all modules, also where a function alone imports it."""
    for each in imports(PACKAGE | OTHERS):
        if each.there and each.name:
            module = importlib.import_module(each.module)
            names = {name for _, name, _ in pkgutil.iter_modules(getattr(module, "__path__", ()))}
            assert hasattr(module, each.name) or each.name in names, each


def loaded(*modules: str) -> set[str]:
    """Return what a fresh interpreter holds after importing modules of the package."""
    names = ", ".join(f"breaker.{module}" for module in modules)
    command = [sys.executable, "-c", f"import sys, {names}; print(*sys.modules)"]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(result.stdout.split())


def test_what_rules_read_is_light():
    light = ["model.parameters", "model.limits", "records.files"]
    light += ["configuration.loading", "workflow.jobs", "workflow.dependencies"]
    assert HEAVY & loaded(*light) == set()
    assert "numba" in loaded("model.curves")
