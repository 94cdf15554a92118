"""Plugins that raise, or are not what they say: each is named, and nothing else is affected."""

import logging

import numpy as np
import pytest

from breaker.common.plugins import FAMILIES, FORMATS, PluginError, plugins
from breaker.drive.simulation.own_family import family_of
from breaker.drive.training.family_bank import simulate_family
from breaker.mechanism.limits import from_list
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

    def install_module(group, text, name="bad-plugin"):
        module = f"module_of_{name.replace('-', '_')}"
        at = f"{module}:VALUE" if group == "breaker.limits" else module
        install(tmp_path / name, name, {group: {"bad": at}}, {f"{module}.py": text})
        monkeypatch.syspath_prepend(tmp_path / name)
        monkeypatch.delitem(__import__("sys").modules, module, raising=False)
        plugins.cache_clear()

    yield install_module
    plugins.cache_clear()


def module(**other):
    return "\n".join((GOOD | other).values())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 / 0", "cannot be loaded (ZeroDivisionError"),
        ("import nothing_of_this_name", "cannot be loaded (ModuleNotFoundError"),
        ("raise SystemExit('usage')", "cannot be loaded (SystemExit: usage"),
        (module(look=""), "has no look"),
        (module(ENDINGS="ENDINGS = ['.bad']"), "has ENDINGS that are no names by endings"),
        (module(ENDINGS="ENDINGS = {'bad': 'x'}"), "has ENDINGS that are no names by endings"),
        (module(ENDINGS="ENDINGS = {'.csv': 'x'}"), "wants files of .csv, which another"),
        (module(ENDINGS="ENDINGS = {'.dat': 'x'}"), "wants files of .dat, which another"),
    ],
)
def test_a_format_that_is_none_is_named_and_left_out(plugged, caplog, text, said):
    plugged(FORMATS, text)
    with caplog.at_level(logging.ERROR):
        assert plugin_formats({".csv", ".dat"}) == ()
    assert f"the format bad{NAMED} {said}" in caplog.text


@pytest.fixture
def read_by(plugged, monkeypatch):
    """Puts a format behind those of the package."""

    def put(text):
        plugged(FORMATS, text)
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


def test_of_two_plugins_of_one_name_neither_is_used(plugged, caplog):
    for name in ("bad-plugin", "worse-plugin"):
        plugged(FORMATS, module(), name)
    assert plugin_formats(()) == ()
    assert "worse-plugin 1.0 and the format bad of bad-plugin 1.0 have one name" in caplog.text


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("VALUE = 1", "are no list of limits, but int"),
        ("VALUE = 'limits'", "are no list of limits, but str"),
        ("VALUE = []", "are no list of limits, but list"),
        ("VALUE = [1]", "cannot be used"),
        ("VALUE = [{'name': 'a', 'motion': 'closing', 'uper': {'f': 1}}]", "unknown: uper"),
        ("VALUE = [{'name': 'a', 'motion': 'closing', 'upper': {'g': 1}}]", "g is not a known"),
        ("VALUE = 1 / 0", "cannot be loaded (ZeroDivisionError"),
        ("", "cannot be loaded (AttributeError"),
    ],
)
def test_limits_that_are_none_are_named(plugged, value, said):
    plugged("breaker.limits", value)
    own = {"name": "slow", "motion": "closing", "upper": {"touch_time": 10}}
    assert len(from_list([own], ["closing"])) == 1
    with pytest.raises(PluginError) as refused:
        from_list([own, {"from": "bad"}], ["closing"])
    assert str(refused.value).startswith(f"the limits bad{NAMED} ")
    assert said in str(refused.value)


CURVE = "def curve(parameters, beside, motion): "
TIMES = "import numpy as np\nt = np.linspace(0.0, 50.0, 100)\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "has no function curve"),
        (CURVE + "return 1", "returns no curve of closing (TypeError"),
        (CURVE + "raise RuntimeError('no')", "returns no curve of closing (RuntimeError: no)"),
        (TIMES + CURVE + "return t + 1, t, 5.0", "its times do not rise from 0"),
        (TIMES + CURVE + "return t[::-1], t, 5.0", "its times do not rise from 0"),
        (TIMES + CURVE + "return t, t * np.nan, 5.0", "its travel is not finite"),
        (TIMES + CURVE + "return t, t[:-1], 5.0", "8 or more of each"),
        (CURVE + "pass\ndef beside(rng): return 1", "cannot draw what a drive has beside"),
        (CURVE + "raise SystemExit(2)", "returns no curve of closing (SystemExit: 2)"),
        (CURVE + "pass\nWEAR = {'coil': (0, 1)}", "has WEAR of coil, which beside lacks"),
        (CURVE + "pass\nWEAR = {'coil': 1}", "has WEAR that is no range by name (TypeError"),
        (CURVE + "pass\nWEAR = 1", "has WEAR that is no range by name (TypeError"),
    ],
)
def test_simulators_that_are_none_are_named(plugged, defaults, prior, text, said):
    plugged(FAMILIES, text)
    settings = defaults["family"] | {"simulator": "bad"}
    with pytest.raises(PluginError) as refused:
        simulate_family(family_of(prior, settings), 2, np.random.default_rng(1))
    assert str(refused.value).startswith(f"the simulator bad{NAMED} ")
    assert said in str(refused.value)


def test_drives_that_do_not_work_are_drawn_again(plugged, defaults, prior):
    text = (
        TIMES + "count = [0]\n" + CURVE + "\n"
        "    count[0] += 1\n"
        "    if count[0] % 5 == 0: raise FloatingPointError('stuck')\n"
        "    way = 10.0 * (1.0 - np.exp(-(t / 10.0) ** 2))\n"
        "    return t, way if motion == 'closing' else 10.0 - way, 9.0\n"
    )
    plugged(FAMILIES, text)
    settings = defaults["family"] | {"simulator": "bad"}
    bank = simulate_family(family_of(prior, settings), 8, np.random.default_rng(1))
    assert bank.sizes["drive"] == 8
    assert bank.attrs["drawn_again"] > 0
    # 10 % of the way after 3.25 ms and 50 % after 8.33 ms, of which touch is 5.75 ms past the first
    assert np.allclose(bank["duration"], 8.326 - 3.246, atol=2e-3)
    assert np.allclose(bank["stroke"], 10.0, atol=1e-6)
    assert np.allclose(bank["switching"], (9.0 - 3.246) / 5.08, atol=2e-3)
