"""Files of a configuration that are none are refused."""

import os
from pathlib import Path

import pytest

from breaker.configuration.yaml_sources import ConfigurationError, parse

REFUSED = {
    "a pipe": (os.mkfifo, "is a pipe, not a file"),
    "a folder": (os.mkdir, "is a folder, not a file"),
    "two files in one": ("seed: 1\n---\nseed: 2", "is not valid YAML"),
    "an alias within what it names": ("a: &a [*a]", "has a value that YAML cannot read"),
    "too many levels": (f"a: {'[' * 3000}{']' * 3000}", "has a value that YAML cannot read"),
}


def write(path: Path, content) -> Path:
    content(path) if callable(content) else path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_file_is_refused(tmp_path, name):
    content, reason = REFUSED[name]
    file = write(tmp_path / "mine.yaml", content)
    with pytest.raises(ConfigurationError, match=reason) as caught:
        parse(file)
    assert str(caught.value).startswith(str(file))


def test_aliases_and_merges_as_they_are_meant_are_read(tmp_path):
    text = "a: &a {x: 1}\nb: *a\nc: {<<: *a, y: 2}"
    content, _ = parse(write(tmp_path / "mine.yaml", text))
    assert content == {"a": {"x": 1}, "b": {"x": 1}, "c": {"x": 1, "y": 2}}
