"""The package is a house of three wings and what joins them: which room may use which.

The studies, beside the house, use it; it knows nothing of them.
"""

import ast
import importlib
import pkgutil
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

import breaker

ROOT = Path(__file__).resolve().parents[1]

# From the ground up: a room uses those of lower floors only, and none beside it.
FLOORS = [
    {"common", "shipped"},
    {"quantities", "networks", "documents"},
    {"reading.files", "mechanism"},
    {"reading.instruments", "configuration", "paper.model"},
    {"reading.records", "workflow"},
    {"reading.inspection", "drive.simulation", "drive.family", "paper.posterior"},
    {"paper.validation", "drive.life", "drive.training"},
    {"drive.answers"},
    {"drive.fleet"},
    {"figures"},
    {"app"},  # `breaker view` starts it, and gives it what commands do
    {"cli"},  # draws a picture of what it inspects
]
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# The rooms outside of it that a wing may use. A training of a family is one of the paper's trainer.
WINGS = {
    "reading": {"common", "quantities", "documents"},
    "drive": {
        *("common", "shipped", "quantities", "documents"),
        *("mechanism", "configuration", "reading"),
    },
    "paper": {"common", "quantities", "mechanism", "networks"},
}
MAY_TOO = {"drive.training": {"networks", "paper"}}
# Parameters that are sections of the configuration, or a file of it.
SECTIONS = {"config", "settings", "endurance", "form", "format_settings", "planning", "sensor"}
SECTIONS |= {"prior", "family", "overlay"}
TORCH = {"networks", "paper.posterior", "drive.training"}
BESIDE = {"studies", "tests"}
LONGEST_FUNCTION = 55  # so that it is seen whole
# The modules that know a parameter by its name: names, formulas, equations, richer equations.
KNOWING = {"parameters", "drive_conditions", "kernels", "integrator"}
# Names of parameters that are nothing else; those that are, as whole texts or variables; and names
# of the sources of limits.
PARAMETER = re.compile(r"\b(?:k_[ab]|gamma_[ab])\b")
SHORT = {"mu", "L"}
SOURCE = {"model", "record", "change"}
HEAVY = {"torch", "numba", "xarray", "scipy", "pandas", "zarr", "matplotlib"}


def sources(*folders: str) -> dict[str, str]:
    """Text of every Python file in folders of the project, by its path."""
    return {
        str(file.relative_to(ROOT)): file.read_text(encoding="utf-8")
        for folder in folders
        for file in sorted((ROOT / folder).rglob("*.py"))
    }


PACKAGE = sources("src/breaker")
SCRIPTS = sources("workflow/scripts")
STUDIES = {f: t for f, t in sources("studies").items() if not f.startswith("studies/tests/")}


def room_in(module: str) -> str | None:
    """The room of a module such as ``breaker.drive.life.tracker``; None of what is in none."""
    parts = module.split(".")[1:]
    return next((name for n in (2, 1) if (name := ".".join(parts[:n])) in FLOOR), None)


def module_of(file: str) -> str:
    """The module that a file of the package is; a path of another file as it is."""
    parts = Path(file).with_suffix("").parts
    return ".".join(parts[1:]) if parts[0] == "src" else file


def room_of(file: str) -> str | None:
    """The room a file of the package is in; None for a script and for what is in no room."""
    return room_in(module_of(file)) if file.startswith("src/breaker/") else None


class Import(NamedTuple):
    """``from module import names`` in a file, or ``import module`` without names."""

    file: str
    module: str
    names: tuple[str, ...] = ()

    @property
    def room(self) -> str | None:
        """The room of the package that is imported from."""
        if self.module.split(".")[0] != "breaker":
            return None
        return room_in(self.module)

    def __str__(self) -> str:
        taken = f"from {self.module} import {', '.join(self.names)}"
        return f"{self.file}: {taken if self.names else f'import {self.module}'}"


@cache
def imports_of(file: str, text: str) -> tuple[Import, ...]:
    """Every import of a file, wherever it stands: at the top, in a function, for types alone."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found += [Import(file, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{file} imports relatively"
            for alias in node.names:  # a room or wing may be taken by its name
                inner = f"{node.module}.{alias.name}"
                whole = node.module.split(".")[0] == "breaker" and room_in(inner)
                room = whole and room_in(node.module) != room_in(inner)
                found.append(
                    Import(file, inner) if room else Import(file, node.module, (alias.name,))
                )
    return tuple(found)


def imports(code: Mapping[str, str]) -> Iterator[Import]:
    """Every import of files."""
    for file, text in code.items():
        yield from imports_of(file, text)


# Each check takes files and returns what is wrong with them, in words.


def upward(code: Mapping[str, str]) -> list[str]:
    """Imports of a room that is not on a lower floor."""
    return [
        str(found)
        for found in imports(code)
        if (here := room_of(found.file)) is not None
        and found.room is not None
        and found.room != here
        and FLOOR[found.room] >= FLOOR[here]
    ]


def across(code: Mapping[str, str]) -> list[str]:
    """Imports of a wing from a room that it does without."""
    wrong = []
    for found in imports(code):
        here, there = room_of(found.file), found.room
        wing = here and here.split(".")[0]
        if wing not in WINGS or there is None:
            continue
        allowed = {wing} | WINGS[wing] | MAY_TOO.get(here, set())
        if not {there, there.split(".")[0]} & allowed:
            wrong.append(str(found))
    return wrong


def hidden(code: Mapping[str, str]) -> list[str]:
    """Names that start with an underscore, of another room, and the room itself taken whole."""
    modules = {module_of(file) for file in code}
    wrong = []
    for found in imports(code):
        if found.room is None or room_of(found.file) == found.room:
            continue
        private = any(name.startswith("_") for name in found.names)
        whole = not found.names and f"{found.module}.__init__" in modules
        if private or (whole and found.room not in ("shipped", "cli")):
            wrong.append(str(found))
    return wrong


def roomless(code: Mapping[str, str]) -> list[str]:
    """Modules of the package that are in no room."""
    doors = {f"src/breaker/{name}/__init__.py" for name in WINGS}
    own = {"src/breaker/__init__.py", "src/breaker/__main__.py"} | doors
    return [f for f in code if f.startswith("src/breaker/") and f not in own and not room_of(f)]


def twins(code: Mapping[str, str]) -> list[str]:
    """Names that two modules of the package have. A command has the name of what it does."""
    found = defaultdict(list)
    for file in code:
        if room_of(file) not in (None, "cli") and not file.endswith("__init__.py"):
            found[Path(file).stem].append(file)
    return [f"{name}: {', '.join(files)}" for name, files in found.items() if len(files) > 1]


def unexplained(code: Mapping[str, str]) -> list[str]:
    """Faces of rooms that hold more than the text that explains the room."""
    return [
        file
        for file, text in code.items()
        if file.startswith("src/breaker/")
        and file.endswith("/__init__.py")
        and room_of(file) not in (None, "shipped", "cli")
        and (len(ast.parse(text).body) != 1 or not ast.get_docstring(ast.parse(text)))
    ]


@cache
def functions(text: str) -> list[tuple[str, int]]:
    """Name and lines of every function in a text."""
    return [
        (node.name, node.end_lineno - node.lineno + 1)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


def tall(code: Mapping[str, str]) -> list[str]:
    """Functions that nobody sees whole."""
    return [
        f"{file}: {name} has {lines} lines"
        for file, text in code.items()
        for name, lines in functions(text)
        if lines > LONGEST_FUNCTION
    ]


@cache
def untyped_parameters(text: str) -> list[str]:
    """Parameters of functions that others may call, of which nobody knows what they hold."""
    return [
        f"line {node.lineno}: {node.name}({each.arg})"
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
        for each in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        if each.annotation is not None and each.arg not in SECTIONS
        if re.search(r"\b(?:Mapping|dict)\b(?!\[)", ast.unparse(each.annotation))
    ]


def untyped(code: Mapping[str, str]) -> list[str]:
    """Mappings without a type; sections of the configuration, which its schema checks, are none."""
    return [
        f"{file}: {each}"
        for file, text in code.items()
        if room_of(file)
        for each in untyped_parameters(text)
    ]


@cache
def packed_calls(text: str) -> list[int]:
    """Lines of calls that unpack a tuple or a list which is written there."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call)
        for each in node.args
        if isinstance(each, ast.Starred) and isinstance(each.value, ast.Tuple | ast.List)
    ]


def packed(code: Mapping[str, str]) -> list[str]:
    """Calls whose arguments are packed only to be unpacked."""
    return [f"{file}: line {line}" for file, text in code.items() for line in packed_calls(text)]


def torch_elsewhere(code: Mapping[str, str]) -> list[str]:
    """Imports of torch in the package outside the rooms that are built on it."""
    return [
        str(found)
        for found in imports(code)
        if found.module.split(".")[0] == "torch"
        and found.file.startswith("src/")
        and room_of(found.file) not in TORCH
    ]


@cache
def parameters_named(text: str) -> list[tuple[int, str]]:
    """Lines that name a parameter of the model, in a text or as a variable."""
    tree, found = ast.parse(text), []
    docs = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        named = node.value if isinstance(node, ast.Constant) and node not in docs else None
        named = getattr(node, "id", getattr(node, "attr", named))
        if isinstance(named, str):
            short = [named] if named in SHORT else []
            found += [(node.lineno, name) for name in [*PARAMETER.findall(named), *short]]
    return found


@cache
def told_apart(text: str) -> list[tuple[int, str]]:
    """Lines that ask what a limit is read from."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare):
            asked = [node.left, *node.comparators]
            of = [each for each in asked if isinstance(each, ast.Attribute) and each.attr == "of"]
            found += [(node.lineno, ast.unparse(node))] if of and SOURCE & constants(asked) else []
    return found


def constants(nodes: Sequence[ast.expr]) -> set:
    """Values of those nodes that are constants."""
    return {each.value for each in nodes if isinstance(each, ast.Constant)}


def parameters_known(code: Mapping[str, str]) -> list[str]:
    """Parameters by their names, in modules that need not know them."""
    return [
        f"{file}: line {line}: {what}"
        for file, text in code.items()
        if room_of(file) and Path(file).stem not in KNOWING
        for line, what in parameters_named(text)
    ]


def limits_known(code: Mapping[str, str]) -> list[str]:
    """What limits are read from, which two rooms alone know."""
    return [
        f"{file}: line {line}: {what}"
        for file, text in code.items()
        if room_of(file) not in (None, "quantities", "mechanism")
        for line, what in told_apart(text)
    ]


def of_a_study(code: Mapping[str, str]) -> list[str]:
    """Imports of studies, which the product does without, and of tests."""
    return [str(each) for each in imports(code) if each.module.split(".")[0] in BESIDE]


LONG_FUNCTION = "def f():\n" + "    pass\n" * LONGEST_FUNCTION

# Check, and files with which it has to find something wrong.
CHECKS = {
    "upwards": (upward, {"drive/family/a.py": "from breaker.drive.answers.words import say"}),
    "beside": (upward, {"drive/life/a.py": "def f():\n    import breaker.drive.training.bank"}),
    "a model in the reading": (
        across,
        {"reading/inspection/a.py": "from breaker.mechanism.curves import travel"},
    ),
    "the paper in a verdict": (
        across,
        {"drive/answers/a.py": "def f():\n    from breaker.paper.model.joint_model import Model"},
    ),
    "a family in the paper": (
        across,
        {"paper/validation/a.py": "from breaker.drive.family.membership import Match"},
    ),
    "the reader in the paper": (
        across,
        {"paper/model/a.py": "from breaker.reading.files.lexicon import UNITS"},
    ),
    "a wing as a whole": (across, {"reading/inspection/a.py": "from breaker import mechanism"}),
    "a hidden name": (hidden, {"drive/life/a.py": "from breaker.mechanism.curves import _travel"}),
    "a room as a whole": (hidden, {"../../workflow/scripts/a.py": "import breaker.figures"}),
    "a room without a floor": (roomless, {"cellar/a.py": ""}),
    "a module in a wing": (roomless, {"reading/a.py": ""}),
    "two modules of one name": (twins, {"paper/model/tracker.py": ""}),
    "code in a face": (unexplained, {"mechanism/__init__.py": '"""A room."""\nx = 1'}),
    "a long function": (tall, {"mechanism/a.py": LONG_FUNCTION}),
    "an untyped mapping": (untyped, {"drive/life/a.py": "def f(row: Mapping | None): pass"}),
    "an untyped row": (untyped, {"drive/life/a.py": "def f(*, rows: Sequence[dict]): pass"}),
    "a packed tuple": (packed, {"mechanism/a.py": "f(1, *(a, b))"}),
    "a network of breakers": (
        upward,
        {"networks/a.py": "from breaker.quantities.parameters import NAMES"},
    ),
    "a parameter by its name": (parameters_known, {"drive/life/a.py": "WORSE = {'k_a': -1}"}),
    "a parameter in an equation": (
        parameters_known,
        {"mechanism/a.py": "def f(theta):\n    gamma_b = theta[4]"},
    ),
    "a parameter by its letter": (parameters_known, {"quantities/a.py": "GAP = 'L'"}),
    "a limit by its source": (
        limits_known,
        {"drive/life/a.py": "def f(limit):\n    return limit.of == 'change'"},
    ),
    "torch in a life": (torch_elsewhere, {"drive/life/a.py": "import torch.nn"}),
    "a study in a room": (
        of_a_study,
        {"drive/life/a.py": "def f():\n    from studies.lives import Life"},
    ),
}


@pytest.mark.parametrize("check", dict.fromkeys(check for check, _ in CHECKS.values()))
def test_the_house_is_in_order(check):
    assert check({**PACKAGE, **SCRIPTS}) == []


def test_studies_take_no_hidden_names():
    assert hidden({**PACKAGE, **STUDIES}) == []


@pytest.mark.parametrize("name", CHECKS)
def test_a_planted_fault_is_found(name):
    check, planted = CHECKS[name]
    before = set(check({**PACKAGE, **SCRIPTS}))
    files = {(Path("src/breaker") / file).as_posix(): text for file, text in planted.items()}
    files = {file.removeprefix("src/breaker/../../"): text for file, text in files.items()}
    assert len(set(check({**PACKAGE, **SCRIPTS, **files})) - before) == 1


# A figure is looked at, a command is run, and a training takes minutes.
@pytest.mark.parametrize("room", sorted(set(FLOOR) - {"figures", "cli", "drive.training"}))
def test_every_room_has_an_example(room):
    """They are run with the tests."""
    texts = [text for file, text in PACKAGE.items() if room_of(file) == room]
    assert any(">>> " in text for text in texts)


def test_every_imported_name_is_there():
    """Of all modules, also where a function alone imports it."""
    for found in imports({**PACKAGE, **SCRIPTS, **STUDIES}):
        if found.room is not None and found.names:
            module = importlib.import_module(found.module)
            names = {name for _, name, _ in pkgutil.iter_modules(getattr(module, "__path__", ()))}
            assert all(hasattr(module, n) or n in names for n in found.names), str(found)


def loaded(*modules: str) -> set[str]:
    """Which of the heavy packages a fresh interpreter holds after importing modules."""
    code = f"import sys, {', '.join(modules)}; print(*sys.modules)"
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return HEAVY & set(result.stdout.split())


def test_what_rules_read_is_light():
    light = ["quantities.parameters", "mechanism.limits", "reading.files.guards"]
    light += ["configuration.loading", "workflow.jobs", "workflow.dependencies"]
    assert loaded(*(f"breaker.{module}" for module in light)) == set()


def test_what_is_heavy_is_noticed():
    assert "numba" in loaded("breaker.mechanism.curves")


def test_reading_needs_no_torch_and_no_model():
    """Every module of the wing, imported together, leaves the model and torch outside."""
    wing = [module_of(f) for f in PACKAGE if f.startswith("src/breaker/reading/")]
    modules = ", ".join(module.removesuffix(".__init__") for module in wing)
    code = f"import sys, {modules}; print(*sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    held = set(shown.stdout.split())
    assert not [name for name in held if name.startswith(("breaker.mechanism", "breaker.drive"))]
    assert "torch" not in held
    assert breaker.__name__ in held
