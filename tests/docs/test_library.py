"""The page on the package as a library: its code runs as it stands."""

import doctest
import importlib
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.usefixtures("one_thread")
PAGE = Path(__file__).parents[2] / "docs" / "library.md"
TEXT = PAGE.read_text(encoding="utf-8")
IMPORTS = re.compile(r">>> from (breaker[\w.]*) import (.*)")


class Any(doctest.OutputChecker):
    """Accept whatever is printed: digits of a training differ between processors."""

    def check_output(self, want, got, flags):
        return True


def test_the_page_runs_as_it_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # no folder of the project is needed
    test = doctest.DocTestParser().get_doctest(TEXT, {}, PAGE.name, str(PAGE), 0)
    result = doctest.DocTestRunner(Any()).run(test)
    assert result.failed == 0
    assert result.attempted > 20


def test_names_are_public_and_from_the_module_that_defines_them():
    for module, names in IMPORTS.findall(TEXT):
        held = vars(importlib.import_module(module))
        for name in names.split(", "):
            assert not name.startswith("_")
            if callable(held[name]):
                assert held[name].__module__ == module, f"{module}.{name}"
