"""The package is a house of rooms: which may use which, by which names, and how large they are.

The studies, a wing beside it, use the house, which knows nothing of them.
"""

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]

# From the ground up: a room uses those of lower floors only, and none beside it.
FLOORS = [
    {"stores", "shipped"},
    {"mechanism", "networks"},
    {"files"},
    {"records"},
    {"model", "workflow", "inspection"},
    {"posterior", "family"},
    {"validation", "wear"},
    {"answers"},
    {"fleet"},
    {"synthetic", "figures"},
    {"cli"},  # draws a picture of what it inspects
]
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# These are imported from their modules, so that a change of one figure concerns that figure only.
FROM_MODULES = {"figures"}
TORCH = {"networks", "posterior"}
BESIDE = {"studies", "tests"}
LONGEST_MODULE = 300
# Modules that may be longer: numba sees changes of one file only, so all that may change is in it.
LONGER = {
    "src/breaker/synthetic/integrator.py": 340,
    "src/breaker/files/lexicon.py": 600,  # tables alone, longer with every language
}
LONGEST_FUNCTION = 55
MOST_PARAMETERS = 5
# Functions that may take more, by file.
MORE_PARAMETERS = {
    # Compiled, in the innermost loops: plain numbers and arrays.
    "src/breaker/mechanism/kernels.py": {"_fill", "_follow", "simulate"},
    "src/breaker/synthetic/integrator.py": {
        *("_random", "_forces", "_rates", "_advance", "_margin", "_located", "follow"),
    },
    # Sizes of the paper's networks, by their names in the configuration and in saved models.
    "src/breaker/networks/deep_set.py": {"DeepSet.__init__"},
    "src/breaker/networks/summary.py": {"TimeSeriesNetwork.__init__"},
    # To be split with its room.
}
# Names of parameters that are nothing else, and of the sources of limits.
PARAMETER = re.compile(r"\b(?:k_[ab]|gamma_[ab])\b")
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


def room_of(file: str) -> str | None:
    """The room a file of the package is in; None for a script and the package's ``__init__``."""
    parts = Path(file).with_suffix("").parts
    return parts[2] if parts[:2] == ("src", "breaker") and parts[2] in FLOOR else None


class Import(NamedTuple):
    """``from module import names`` in a file, or ``import module`` without names."""

    file: str
    module: str
    names: tuple[str, ...] = ()

    @property
    def room(self) -> str | None:
        """The room of the package that is imported from."""
        top, *rest = self.module.split(".")
        return rest[0] if top == "breaker" and rest else None

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
            names = tuple(alias.name for alias in node.names)
            if node.module == "breaker":  # from breaker import room
                found += [Import(file, f"breaker.{name}") for name in names if name in FLOOR]
            else:
                found.append(Import(file, node.module, names))
    return tuple(found)


def imports(code: Mapping[str, str]) -> Iterator[Import]:
    """Every import of files."""
    for file, text in code.items():
        yield from imports_of(file, text)


@cache
def table(text: str) -> dict[str, list[str]]:
    """The names a room shows lazily, by module: the table in its ``__init__``."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.keyword) and node.arg == "submod_attrs":
            return ast.literal_eval(node.value)
    return {}


def shown(text: str) -> set[str]:
    """Public names in the text of a room's ``__init__``: its table's, or its ``__all__``."""
    names = {name for names in table(text).values() for name in names}
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", None) == "__all__":
            names |= set(ast.literal_eval(node.value))
    return names


def inits(code: Mapping[str, str]) -> dict[str, str]:
    """Text of the ``__init__`` of each room."""
    return {
        room_of(file): text
        for file, text in code.items()
        if file.count("/") == 3 and file.endswith("__init__.py")
    }


# Each check takes files and returns what is wrong with them, in words.


def upward(code: Mapping[str, str]) -> list[str]:
    """Imports of a room that is not on a lower floor."""
    return [
        str(found)
        for found in imports(code)
        if (here := room_of(found.file)) is not None
        and found.room in FLOOR
        and found.room != here
        and FLOOR[found.room] >= FLOOR[here]
    ]


def hidden(code: Mapping[str, str]) -> list[str]:
    """Names of another room that it does not show, and ways around: its modules, itself whole.

    Within a room the modules are named: its ``__init__`` is for others.
    """
    modules = {(room_of(file), Path(file).stem) for file in code}
    public = {room: shown(text) for room, text in inits(code).items()}
    wrong = []
    for found in imports(code):
        if found.room is None:
            continue
        inside = room_of(found.file) == found.room
        from_room = found.module == f"breaker.{found.room}"
        if found.room == "cli":
            fine = inside or found.file == "src/breaker/__main__.py"
        elif inside or found.room in FROM_MODULES:
            named = bool(found.names) and {(found.room, n) for n in found.names} <= modules
            fine = not from_room or named
        elif found.room not in public:
            fine = False
        else:
            fine = from_room and found.names and set(found.names) <= public[found.room]
        if not fine:
            wrong.append(str(found))
    return wrong


def unused_rooms(code: Mapping[str, str]) -> list[str]:
    """Folders and modules of the package that are no room."""
    tops = {Path(file).parts[2] for file in code if file.startswith("src/breaker/")}
    return sorted(tops - {"__init__.py", "__main__.py"} - set(FLOOR))


def clashes(code: Mapping[str, str]) -> list[str]:
    """Public names that are names of modules too, and rows of a table without a module."""
    wrong = []
    for room, text in inits(code).items():
        modules = {Path(f).stem for f in code if room_of(f) == room} - {"__init__"}
        wrong += [f"{room} shows {name}, a module" for name in sorted(shown(text) & modules)]
        wrong += [f"{room} has no module {m}" for m in sorted(set(table(text)) - modules)]
    return wrong


def lost(code: Mapping[str, str]) -> list[str]:
    """Names that a table promises and its module does not define."""
    wrong = []
    for room, text in inits(code).items():
        for module, names in table(text).items():
            own = defined(code.get(f"src/breaker/{room}/{module}.py", ""))
            wrong += [f"{room}.{module} has no {name}" for name in names if name not in own]
    return wrong


def defined(text: str) -> set[str]:
    """Names that a module itself defines, none of those that it imports."""
    found = set()
    for node in ast.parse(text).body:
        each = getattr(node, "targets", [node])[0]
        found.add(getattr(each, "name", "") or getattr(getattr(each, "target", each), "id", ""))
    return found


@cache
def functions(text: str) -> list[tuple[str, int]]:
    """Name and lines of every function in a text."""
    return [
        (node.name, node.end_lineno - node.lineno + 1)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


def tall(code: Mapping[str, str]) -> list[str]:
    """Modules and functions that are too long."""
    wrong = []
    for file, text in code.items():
        if (lines := len(text.splitlines())) > LONGER.get(file, LONGEST_MODULE):
            wrong.append(f"{file} has {lines} lines")
        wrong += [
            f"{file}: {name} has {lines} lines"
            for name, lines in functions(text)
            if lines > LONGEST_FUNCTION
        ]
    return wrong


@cache
def parameters(text: str) -> list[tuple[str, int]]:
    """Name of every function in a text, a method's with its class, and number of parameters."""
    tree = ast.parse(text)
    methods = {
        method: f"{owner.name}."
        for owner in ast.walk(tree)
        if isinstance(owner, ast.ClassDef)
        for method in owner.body
    }
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            names = [each.arg for each in arguments]
            own = node in methods and names[:1] in (["self"], ["cls"])
            found.append((methods.get(node, "") + node.name, len(names) - own))
    return found


def broad(code: Mapping[str, str]) -> list[str]:
    """Functions with too many parameters, and names of such that are there no longer."""
    wrong = []
    for file, text in code.items():
        many = {name: count for name, count in parameters(text) if count > MOST_PARAMETERS}
        allowed = MORE_PARAMETERS.get(file, set())
        wrong += [f"{file}: {many[name]} parameters of {name}" for name in many.keys() - allowed]
        wrong += [f"{file}: {name} needs no exemption" for name in allowed - many.keys()]
    return wrong


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


def breaker_in_networks(code: Mapping[str, str]) -> list[str]:
    """Networks that know of breakers: anything of the package from outside their room."""
    return [
        str(found)
        for found in imports(code)
        if room_of(found.file) == "networks"
        and found.module.split(".")[0] == "breaker"
        and found.room != "networks"
    ]


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
def told_apart(text: str) -> list[tuple[int, str]]:
    """Lines that name a parameter of the model, or ask what a limit is read from."""
    tree, found = ast.parse(text), []
    docs = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node not in docs and isinstance(node.value, str):
            found += [(node.lineno, name) for name in PARAMETER.findall(node.value)]
        if isinstance(node, ast.Compare):
            asked = [node.left, *node.comparators]
            of = [each for each in asked if isinstance(each, ast.Attribute) and each.attr == "of"]
            found += [(node.lineno, ast.unparse(node))] if of and SOURCE & constants(asked) else []
    return found


def constants(nodes: Sequence[ast.expr]) -> set:
    """Values of those nodes that are constants."""
    return {each.value for each in nodes if isinstance(each, ast.Constant)}


def known_elsewhere(code: Mapping[str, str]) -> list[str]:
    """What ``mechanism`` alone knows: parameters by name, and what limits are read from."""
    return [
        f"{file}: line {line}: {what}"
        for file, text in code.items()
        if room_of(file) not in (None, "mechanism")
        for line, what in told_apart(text)
    ]


def of_a_study(code: Mapping[str, str]) -> list[str]:
    """Imports of studies, which the product does without, and of tests."""
    return [str(each) for each in imports(code) if each.module.split(".")[0] in BESIDE]


LONG_FUNCTION = "def f():\n" + "    pass\n" * LONGEST_FUNCTION
SHOWS = "import lazy_loader\nlazy_loader.attach(__name__, submod_attrs={})"

# Check, and files with which it has to find something wrong.
CHECKS = {
    "upwards": (upward, {"records/a.py": "from breaker.model import Prior"}),
    "beside": (upward, {"wear/a.py": "def f():\n    from breaker.validation import ranks"}),
    "a module of another room": (
        hidden,
        {"model/a.py": "from breaker.mechanism.parameters import NAMES"},
    ),
    "a hidden name": (hidden, {"model/a.py": "from breaker.mechanism import _travel"}),
    "figures from their room": (hidden, {"../../workflow/scripts/a.py": "import breaker.figures"}),
    "no such room": (hidden, {"model/a.py": "from breaker.cellar import wine"}),
    "a room without a floor": (unused_rooms, {"cellar/a.py": ""}),
    "a name that is a module": (
        clashes,
        {"model/__init__.py": SHOWS.replace("{}", "{'prior': ['prior']}")},
    ),
    "a missing name": (
        lost,
        {"model/__init__.py": SHOWS.replace("{}", "{'prior': ['Posterior']}")},
    ),
    "a long module": (tall, {"model/a.py": "\n" * (LONGEST_MODULE + 1)}),
    "a long function": (tall, {"model/a.py": LONG_FUNCTION}),
    "a broad function": (broad, {"model/a.py": "def f(a, b, /, c, *, d, e=1, f=2):\n    pass"}),
    "an exemption without a function": (broad, {"networks/deep_set.py": ""}),
    "a packed tuple": (packed, {"model/a.py": "f(1, *(a, b))"}),
    "a network of breakers": (
        breaker_in_networks,
        {"networks/a.py": "from breaker.mechanism import NAMES"},
    ),
    "torch in the wear": (torch_elsewhere, {"wear/a.py": "import torch.nn"}),
    "a parameter by its name": (known_elsewhere, {"wear/a.py": "WORSE = {'k_a': -1}"}),
    "a limit by its source": (
        known_elsewhere,
        {"wear/a.py": "def f(limit):\n    return limit.of == 'change'"},
    ),
    "a study in a room": (
        of_a_study,
        {"wear/a.py": "def f():\n    from studies.lives import Life"},
    ),
}


@pytest.mark.parametrize("check", dict.fromkeys(check for check, _ in CHECKS.values()))
def test_the_house_is_in_order(check):
    assert check({**PACKAGE, **SCRIPTS}) == []


def test_studies_come_in_by_the_doors():
    assert hidden({**PACKAGE, **STUDIES}) == []


@pytest.mark.parametrize("name", CHECKS)
def test_a_planted_fault_is_found(name):
    check, planted = CHECKS[name]
    before = set(check({**PACKAGE, **SCRIPTS}))
    files = {(Path("src/breaker") / file).as_posix(): text for file, text in planted.items()}
    files = {file.removeprefix("src/breaker/../../"): text for file, text in files.items()}
    assert len(set(check({**PACKAGE, **SCRIPTS, **files})) - before) == 1


@pytest.mark.parametrize("room", sorted(set(FLOOR) - FROM_MODULES - {"cli"}))
def test_every_public_name_is_there(room):
    module = importlib.import_module(f"breaker.{room}")
    assert module.__all__
    assert set(module.__all__) == shown(PACKAGE[f"src/breaker/{room}/__init__.py"])
    for name in module.__all__:
        assert getattr(module, name) is not None


@pytest.mark.parametrize("room", sorted(set(FLOOR) - FROM_MODULES - {"cli"}))
def test_every_room_has_an_example(room):
    """They are run with the tests."""
    texts = [text for file, text in PACKAGE.items() if room_of(file) == room]
    assert any(">>> " in text for text in texts)


def loaded(*modules: str) -> set[str]:
    """Which of the heavy packages a fresh interpreter holds after importing modules."""
    code = f"import sys, {', '.join(modules)}; print(*sys.modules)"
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return HEAVY & set(result.stdout.split())


def test_what_rules_read_is_light():
    rooms = [f"breaker.{room}" for room in sorted(set(FLOOR) - {"networks"})]
    light = ["mechanism.parameters", "mechanism.limits", "files.guards"]
    light += ["workflow.configuration", "workflow.jobs", "workflow.code"]
    assert loaded(*rooms, *(f"breaker.{module}" for module in light)) == set()


def test_what_is_heavy_is_noticed():
    assert "numba" in loaded("breaker.mechanism.curves")


@pytest.mark.parametrize(("plugins", "expected"), [((), False), (("-p", "zarr.testing"), True)])
def test_no_plugin_of_pytest_loads_numpy(plugins, expected):
    """It would have as many threads as there are cores before tests/conftest.py says one."""
    options = ["--markers", "--noconftest", *plugins]
    code = f"import pytest, sys; pytest.main({options}); print('numpy' in sys.modules)"
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    assert result.stdout.split()[-1] == str(expected)
