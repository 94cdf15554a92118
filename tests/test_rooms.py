"""Which room of the package may use which, how large a function may be, and what starts fast."""

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

ROOT = Path(__file__).resolve().parents[1]

# From the ground up: a room uses those of lower floors only, and none beside it.
FLOORS = [
    {"common", "shipped"},
    {"model", "networks", "documents"},
    {"reading.files", "paper"},
    {"reading.instruments", "configuration"},
    {"reading.records", "workflow"},
    {"reading.inspection", "drive.simulation", "drive.family"},
    {"drive.life", "drive.training"},
    {"drive.answers"},
    {"drive.fleet"},
    {"figures"},
    {"app"},  # `breaker view` starts it, and gives it what commands do
    {"cli"},  # draws a picture of what it inspects
]
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# The rooms outside of it that a wing may use.
WINGS = {
    "reading": {"common", "model", "documents"},
    "drive": {*("common", "shipped", "model", "documents"), *("configuration", "reading")},
    "paper": {"common", "model", "networks"},
}
MAY_TOO = {"drive.training": {"networks"}}
TORCH = {"networks", "paper", "drive.training"}
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


def room_of(module: str) -> str | None:
    """Return the room of a module such as ``breaker.drive.life.tracker``; None if it has none."""
    parts = module.split(".")
    names = (".".join(parts[1:n]) for n in (3, 2) if parts[0] == "breaker")
    return next((name for name in names if name in FLOOR), None)


class Import(NamedTuple):
    """``from module import name`` in a file, or ``import module`` without a name."""

    file: str
    module: str
    name: str = ""

    @property
    def here(self) -> str | None:
        """The room that imports."""
        path = Path(self.file.removeprefix("src/"))
        return room_of(".".join(path.with_suffix("").parts)) if path.parts[0] == "breaker" else None

    @property
    def there(self) -> str | None:
        """The room that is imported from, also where it is taken as a whole."""
        return room_of(f"{self.module}.{self.name}")


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


def upward(code: dict[str, str]) -> list:
    """Find imports of a room that is not on a lower floor."""
    between = [e for e in imports(code) if e.here and e.there and e.here != e.there]
    return [each for each in between if FLOOR[each.there] >= FLOOR[each.here]]


def across(code: dict[str, str]) -> list:
    """Find imports of a wing from a room that it does without."""
    wrong = []
    for each in imports(code):
        wing = each.here and each.here.split(".")[0]
        if wing in WINGS and each.there:
            allowed = {wing} | WINGS[wing] | MAY_TOO.get(each.here, set())
            wrong += [] if {each.there, each.there.split(".")[0]} & allowed else [each]
    return wrong


def hidden(code: dict[str, str]) -> list:
    """Find names that start with an underscore, of another room."""
    return [e for e in imports(code) if e.there and e.there != e.here and e.name.startswith("_")]


def torch_elsewhere(code: dict[str, str]) -> list:
    """Find imports of torch outside the rooms that are built on it."""
    torch = [each for each in imports(code) if each.module.split(".")[0] == "torch"]
    return [e for e in torch if e.file.startswith("src/") and e.here not in TORCH]


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
    "upwards": (upward, "drive/family", "from breaker.drive.answers.words import say"),
    "beside": (upward, "drive/life", "def f():\n    import breaker.drive.training.bank"),
    "a network of breakers": (upward, "networks", "from breaker.model.parameters import Size"),
    "a network": (across, "reading/inspection", "from breaker.networks.blocks import Hidden"),
    "the reader": (across, "paper", "from breaker.reading.files.lexicon import UNITS"),
    "a wing as a whole": (across, "reading/inspection", "from breaker import networks"),
    "the paper": (across, "drive/answers", "def f():\n    import breaker.paper.correction"),
    "a hidden name": (hidden, "drive/life", "from breaker.model.curves import _travel"),
    "a long function": (tall, "model", "def f():\n" + "    pass\n" * LONGEST_FUNCTION),
    "torch": (torch_elsewhere, "drive/life", "import torch.nn"),
    "a study": (of_a_study, "drive/life", "def f():\n    from studies.lives import Life"),
}


@pytest.mark.parametrize("name", CHECKS)
def test_the_house_is_in_order_and_a_planted_fault_is_found(name):
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
    light = ["model.parameters", "model.limits", "reading.files.guards"]
    light += ["configuration.loading", "workflow.jobs", "workflow.dependencies"]
    assert HEAVY & loaded(*light) == set()
    assert "numba" in loaded("model.curves")


def test_reading_needs_no_torch_and_no_model():
    """Every module of the wing, imported together, leaves the model and torch outside."""
    wing = [Path(file).with_suffix("").parts for file in PACKAGE if "/reading/" in file]
    held = loaded(*(".".join(parts[2:]).removesuffix(".__init__") for parts in wing))
    assert not [name for name in held if name.startswith(("breaker.model.curves", "breaker.drive"))]
    assert "torch" not in held
