"""The page on the package as a library: its code runs as it stands and prints what stands there."""

import doctest
import importlib
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.usefixtures("one_thread")
PAGE = Path(__file__).parents[2] / "docs" / "library.md"
TEXT = PAGE.read_text(encoding="utf-8")
IMPORTS = re.compile(r">>> from (breaker[\w.]*) import (.*)")


class Rounded(doctest.OutputChecker):
    """Numbers agree to one in their last digit: other processors round a training otherwise."""

    number = re.compile(r"-?\d+(?:\.(\d+))?")

    def check_output(self, want, got, flags):
        if super().check_output(self.number.sub("0", want), self.number.sub("0", got), flags):
            pairs = zip(self.number.finditer(want), self.number.finditer(got), strict=True)
            return all(self.close(*pair) for pair in pairs)
        return False

    def close(self, want, got):
        return abs(float(want[0]) - float(got[0])) < 1.5 * 10.0 ** -len(want[1] or "")


def run(text, name="library.md"):
    """Run the examples of a text; returns how many there are and how many print something else."""
    test = doctest.DocTestParser().get_doctest(text, {}, name, str(PAGE), 0)
    result = doctest.DocTestRunner(Rounded(), optionflags=doctest.NORMALIZE_WHITESPACE).run(test)
    return result.attempted, result.failed


def test_the_page_runs_as_it_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # no folder of the project is needed
    examples, failed = run(TEXT)
    assert failed == 0
    assert examples > 20


def test_a_network_takes_thirty_lines():
    """Examples of the first section but imports, a statement over several lines by its lines."""
    first = TEXT[TEXT.index("## A network") : TEXT.index("## The exact posterior")]
    lines = re.findall(r"^(?:>>>|\.\.\.) (?!from |import ).*", first, flags=re.MULTILINE)
    assert 15 < len(lines) <= 30


def test_names_are_public_and_from_the_module_that_defines_them():
    for module, names in IMPORTS.findall(TEXT):
        held = vars(importlib.import_module(module))
        for name in names.split(", "):
            assert not name.startswith("_")
            if callable(held[name]):
                assert held[name].__module__ == module, f"{module}.{name}"
