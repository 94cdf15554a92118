"""Modules that a script depends on: every way to import, from any folder, and nothing else."""

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
    "other/third.py": "from breaker.room.first import one\n",  # they import each other
    "other/third.html": "",
}
FIRST = {"room/__init__.py", "room/first.py", "other/__init__.py"}
FIRST |= {"other/third.py", "other/third.html", "__init__.py"}
SECOND = {"room/__init__.py", "room/second.py", "__init__.py"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from breaker.room.first import one as uno, two", FIRST),
        ("from breaker.room import second", SECOND),
        ("import numpy, breaker.room.second as name", SECOND),
        ("from breaker import room", {"room/__init__.py", "__init__.py"}),
        ("def f():\n    from breaker.room.second import two", SECOND),
        ("if TYPE_CHECKING:\n    from breaker.room.first import one\nimport numpy", set()),
        ("import breakers.room\nfrom breakerroom import x\nimport numpy", set()),
    ],
)
def test_modules_behind_an_import(tmp_path, monkeypatch, text, expected):
    folder, script = tmp_path / "src/breaker", tmp_path / "script.py"
    for name, content in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content)
    monkeypatch.setattr(dependencies, "_PACKAGE", folder)
    script.write_text(text)
    assert {str(Path(file).relative_to(folder)) for file in modules_of(script)} == expected


def test_paths_are_those_that_snakemake_shows_wherever_it_works(tmp_path, monkeypatch):
    """Below the working directory relative to it, elsewhere absolute; the files are the same."""
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
