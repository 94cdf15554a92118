"""Formats of others that raise, or lack something: each is named, and nothing else is affected."""

import logging

import pytest

from breaker.records.files import RejectedCurveError
from breaker.records.formats import registry as formats
from breaker.records.formats.registry import FORMATS, added_formats, read_columns
from breaker.records.settings import complete
from tests.plugins.distribution import install

GOOD = """
ENDINGS, SIGNATURES, EXTRA = {'.bad': 'a bad record'}, (), ''
def read(opened, form): raise RuntimeError('no')
"""


@pytest.fixture
def plugged(tmp_path, monkeypatch):
    """Installs a distribution of one module, for this test."""

    def install_module(text):
        install(
            tmp_path / "bad", "bad-plugin", {"bad": "module_of_bad"}, {"module_of_bad.py": text}
        )
        monkeypatch.syspath_prepend(tmp_path / "bad")
        monkeypatch.delitem(__import__("sys").modules, "module_of_bad", raising=False)

    return install_module


@pytest.mark.parametrize("text", ["1 / 0", "import nothing_of_this_name", "ENDINGS = {}"])
def test_a_format_that_is_none_is_named_and_left_out(plugged, caplog, text):
    plugged(text)
    with caplog.at_level(logging.ERROR):
        assert [*added_formats()] == []
    assert "module_of_bad" in caplog.text


def test_a_format_that_raises_refuses_its_own_files_alone(plugged, monkeypatch, tmp_path):
    plugged(GOOD)
    monkeypatch.setattr(formats, "FORMATS", (*FORMATS, *added_formats()))
    for name in ("a.bad", "a.csv"):
        (tmp_path / name).write_bytes(b"time,travel\ns,mm\n0.1,1\n0.2,2\n")
    with pytest.raises(RejectedCurveError, match="a bad record"):
        read_columns(tmp_path / "a.bad", complete({}))
    assert read_columns(tmp_path / "a.csv", complete({})).travel.size == 2
