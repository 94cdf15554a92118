"""Which modules a script stands on: every way to import, from any folder, and nothing else."""

from pathlib import Path

import pytest

from breaker.workflow import dependencies
from breaker.workflow.dependencies import modules_of
from tests.workflow.conftest import ROOT

FILES = {
    "__init__.py": "",
    "room/__init__.py": "",
    "room/first.py": "import numpy\nfrom breaker.other.third import three\n",
    "room/second.py": "",
    "other/__init__.py": "",
    "other/third.py": "",
    "other/page.py": "",
    "other/page.html": "",
    "tool.py": "def f():\n    import breaker.room.second\n",
}
ONE = {"room/__init__.py", "room/first.py", "other/__init__.py", "other/third.py"}
TWO = {"room/__init__.py", "room/second.py"}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A small package in place of the real one; returns a function from a script to its modules."""
    folder = tmp_path / "src/breaker"
    for name, text in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    monkeypatch.setattr(dependencies, "_PACKAGE", folder)
    script = tmp_path / "script.py"

    def result(text: str, **more: bool) -> set[str]:
        dependencies._imported.cache_clear()
        script.write_text(text)
        return {str(Path(file).relative_to(folder)) for file in modules_of(script, **more)}

    return result


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from breaker.room.first import one", ONE | {"__init__.py"}),
        ("from breaker.room import second", TWO | {"__init__.py"}),
        ("from breaker.room.first import one as uno, two", ONE | {"__init__.py"}),
        ("from breaker import room", {"room/__init__.py", "__init__.py"}),
        ("import breaker.room.second as name", TWO | {"__init__.py"}),
        ("import numpy, breaker.room.second", TWO | {"__init__.py"}),
        (
            "from breaker.other.page import html",
            {"__init__.py", "other/__init__.py", "other/page.py", "other/page.html"},
        ),
        ("import breaker.tool", TWO | {"__init__.py", "tool.py"}),
        ("def f():\n    from breaker.room.second import two", TWO | {"__init__.py"}),
        ("if TYPE_CHECKING:\n    from breaker.room.first import one\nimport numpy", set()),
        ("import breakers.room\nfrom breakerroom import x\nimport numpy", set()),
    ],
)
def test_modules_behind_an_import(package, text, expected):
    assert package(text) == expected


def test_modules_that_import_each_other_end(package, tmp_path):
    (tmp_path / "src/breaker/other/third.py").write_text("from breaker.room.first import one")
    assert package("from breaker.room.first import one") == ONE | {"__init__.py"}


def test_paths_are_those_that_snakemake_shows_wherever_it_works(tmp_path, monkeypatch):
    """Below the working directory relative to it, elsewhere whole; the files are the same."""
    script = ROOT / "workflow/scripts/quality.py"
    monkeypatch.chdir(ROOT)
    here = modules_of("workflow/scripts/quality.py")
    monkeypatch.chdir(tmp_path)
    elsewhere = modules_of(script)
    assert all(not Path(file).is_absolute() for file in here)
    assert [str(ROOT / file) for file in here] == elsewhere
    assert "src/breaker/paper/validation.py" in here
    assert not [file for file in here if "networks/" in file]
    assert {*modules_of(script, itself=True)} - {*elsewhere} == {str(script)}
