"""Functions by name: installed, in the working directory, and not there."""

import sys

import pytest

from breaker.common.named_functions import file_of, load


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "models").mkdir()
    (tmp_path / "own_function.py").write_text("VALUE = 1\n\ndef seven():\n    return 7\n")
    (tmp_path / "models" / "below.py").write_text("from own_function import seven\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", sys.path[:])
    yield tmp_path
    for name in ("own_function", "models", "models.below"):
        sys.modules.pop(name, None)


def test_a_function_of_the_working_directory_or_an_installed_module_is_found(folder):
    assert load("own_function:seven")() == load("models.below:seven")() == 7
    assert str(file_of("models.below:seven")) == "models/below.py"
    assert load("breaker.common.named_functions:load") is load
    assert file_of("breaker.common.named_functions:load").name == "named_functions.py"


def test_the_file_is_found_without_running_it(folder):
    (folder / "own_function.py").write_text("raise SystemExit\n")
    assert str(file_of("own_function:seven")) == "own_function.py"


ABSENT = ["none:seven", "no.such:seven", "models:seven", "sys:exit", "own_function:eight"]
WRONG = ["own_function", "own_function:", "own-function:seven", "own_function:VALUE"]


@pytest.mark.parametrize("text", [*ABSENT, *WRONG])
def test_what_is_not_there_is_an_error_that_names_it(folder, text):
    with pytest.raises(ValueError, match=text):
        load(text)
