"""Plugins that raise, or are not what they say: each is named, and nothing else is affected."""

import logging

import pytest

from breaker.reading.files import formats
from breaker.reading.files.format_plugins import plugin_formats
from breaker.reading.files.format_settings import complete
from breaker.reading.files.guards import Opened, RejectedCurveError
from breaker.reading.inspection.file_contents import look_into
from tests.plugins.distribution import install

NAMED = " of bad-plugin 1.0"
GOOD = {
    "ENDINGS": "ENDINGS = {'.bad': 'a bad record'}",
    "read": "def read(opened, settings, channel=''): return 1",
    "look": "def look(opened): return None",
}


@pytest.fixture
def plugged(tmp_path, monkeypatch):
    """Installs a distribution of one module, for this test."""

    def install_module(text, name="bad-plugin"):
        module = f"module_of_{name.replace('-', '_')}"
        install(tmp_path / name, name, {"bad": module}, {f"{module}.py": text})
        monkeypatch.syspath_prepend(tmp_path / name)
        monkeypatch.delitem(__import__("sys").modules, module, raising=False)

    return install_module


def module(**other):
    return "\n".join((GOOD | other).values())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 / 0", "cannot be used (ZeroDivisionError"),
        ("import nothing_of_this_name", "cannot be used (ModuleNotFoundError"),
        ("raise SystemExit('usage')", "cannot be used (SystemExit: usage"),
        (module(look=""), "cannot be used (ValueError: it has no look)"),
        (module(ENDINGS="ENDINGS = ['.bad']"), "cannot be used (ValueError"),
        (module(ENDINGS="ENDINGS = {'bad': 'x'}"), "cannot be used (ValueError: its ENDINGS"),
        (
            module(ENDINGS="ENDINGS = {'.csv': 'x'}"),
            "cannot be used (ValueError: another format reads files of .csv)",
        ),
        (
            module(ENDINGS="ENDINGS = {'.dat': 'x'}"),
            "cannot be used (ValueError: another format reads files of .dat)",
        ),
    ],
)
def test_a_format_that_is_none_is_named_and_left_out(plugged, caplog, text, said):
    plugged(text)
    with caplog.at_level(logging.ERROR):
        assert plugin_formats({".csv", ".dat"}) == ()
    assert f"the format bad{NAMED} {said}" in caplog.text


@pytest.fixture
def read_by(plugged, monkeypatch):
    """Puts a format behind those of the package."""

    def put(text):
        plugged(text)
        added = plugin_formats({".csv"})
        assert len(added) == 1
        monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, *added))

    return put


@pytest.mark.parametrize(
    ("read", "said"),
    [
        ("return 1", "ValueError: read returns int, not Columns"),
        ("raise RuntimeError('no')", "RuntimeError: no"),
        ("raise SystemError", "SystemError"),
        ("raise SystemExit('bye')", "SystemExit: bye"),
        ("return Columns([0.0], np.zeros(3), np.arange(3))", "time is not one array"),
        ("return Columns(None, np.zeros(3), np.zeros(3))", "lines has no numbers of that kind"),
        ("return Columns(None, np.array(['a']), np.arange(1))", "travel has no numbers"),
    ],
)
def test_a_format_that_reads_no_record_is_named(read_by, tmp_path, read, said):
    head = (
        "import numpy as np\nfrom breaker.reading.files.sample_table import Columns\n"
        f"def read(opened, settings, channel=''): {read}"
    )
    read_by(module(read=head))
    file = tmp_path / "a.bad"
    file.write_bytes(b"1")
    with pytest.raises(RejectedCurveError) as refused:
        formats.read_columns(file, complete({}))
    assert str(refused.value).startswith(f"{file}: is a bad record that cannot be read: the format")
    assert NAMED in str(refused.value)
    assert said in str(refused.value)


@pytest.mark.parametrize(
    "look",
    [
        "return 1",
        "raise RuntimeError('no')",
        "raise SystemExit",
        "return Labelled({}, [], ['a'], ['mm'], [])",
        "return Tables((1 / 0 for _ in range(2)), 'no')",
    ],
)
def test_a_format_that_shows_nothing_is_named(read_by, tmp_path, look):
    head = (
        f"from breaker.reading.files.sample_table import Labelled, Tables\ndef look(opened): {look}"
    )
    read_by(module(look=head))
    file = tmp_path / "a.bad"
    file.write_bytes(b"1")
    with pytest.raises(RejectedCurveError, match=NAMED):
        look_into(Opened(file))


def test_a_format_is_asked_for_no_other_file(read_by, tmp_path):
    read_by(module(read="def read(opened, settings, channel=''): raise RuntimeError('no')"))
    for name, content in (("a.csv", b"BAD,1\n"), ("a.log", b"BAD,1\n")):
        (tmp_path / name).write_bytes(content)
        assert formats.format_of(Opened(tmp_path / name)) is formats.FORMATS[0]


def test_of_two_formats_of_one_ending_one_is_used(plugged, caplog):
    for name in ("bad-plugin", "worse-plugin"):
        plugged(module(), name)
    assert len(plugin_formats(())) == 1
    assert "another format reads files of .bad" in caplog.text
