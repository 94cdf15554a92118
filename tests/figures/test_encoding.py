"""Figures in files: letters of any script, the same bytes each time."""

import logging
import time
import warnings

import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from matplotlib import font_manager
from matplotlib.text import Text

from breaker.figures import encoding, style

NAME = "$x 开关 Ω Выкл مفتاح 🔧"


@style.styled
def figure(name=NAME, mathematics=""):
    found = style.new_figure(4.0, 3.0)
    axis = found.subplots()
    axis.plot([0.0, 1.0])
    axis.set_title(style.literal(name) + mathematics, weight="bold")
    return found


@pytest.fixture(autouse=True)
def fresh():
    """Signs are looked up anew, as fonts come and go here."""
    encoding._signs.cache_clear()
    yield
    encoding._signs.cache_clear()


@pytest.fixture
def bare(monkeypatch):
    """A machine that has the fonts of matplotlib alone."""
    own = [each for each in font_manager.fontManager.ttflist if each.name not in encoding.OTHERS]
    monkeypatch.setattr(font_manager.fontManager, "ttflist", own)
    font_manager.fontManager._findfont_cached.cache_clear()


@pytest.fixture
def chinese(bare, tmp_path):
    """The same with another font, which has two signs, as squares."""
    pen = TTGlyphPen(None)
    pen.moveTo((0, 0))
    for corner in [(0, 800), (800, 800), (800, 0)]:
        pen.lineTo(corner)
    pen.closePath()
    names = [".notdef", "kai", "guan"]
    font = FontBuilder(1000)
    font.setupGlyphOrder(names)
    font.setupCharacterMap({ord("开"): "kai", ord("关"): "guan"})
    font.setupGlyf(dict.fromkeys(names, pen.glyph()))
    font.setupHorizontalMetrics(dict.fromkeys(names, (1000, 0)))
    font.setupHorizontalHeader(ascent=800, descent=-200)
    font.setupNameTable({"familyName": "Noto Sans SC", "styleName": "Regular", "psName": "NotoSC"})
    font.setupOS2(sTypoAscender=800, usWinAscent=800, usWinDescent=200)
    font.setupPost()
    font.save(tmp_path / "chinese.ttf")
    font_manager.fontManager.addfont(tmp_path / "chinese.ttf")


def test_what_no_font_has_is_said_once_and_the_library_says_nothing(bare, capfd):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        drawn = figure()
        for form in ("png", "svg", "pdf"):
            encoding.encoded(drawn, form)
    assert [each for each in caught if "Glyph" in str(each.message)] == []
    assert capfd.readouterr() == ("", "")
    assert encoding.without_font([drawn, drawn]).startswith(
        "no font of this machine has 开 关 🔧, so"
    )
    assert encoding.without_font([figure("Ω Выкл مفتاح")]) == ""


def test_another_font_of_the_machine_is_used(chinese):
    assert encoding.families() == [encoding.OWN, "Noto Sans SC"]
    drawn = figure("开关")
    assert encoding.without_font([drawn]) == ""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        files = {form: encoding.encoded(drawn, form) for form in ("png", "svg", "pdf")}
    assert b"NotoSC" in files["pdf"]


def test_mathematics_are_set_with_one_font(chinese, capfd):
    assert encoding.without_font([figure("开", " $k_a$")]).startswith(
        "no font of this machine has 开"
    )
    assert capfd.readouterr() == ("", "")


def test_a_saved_figure_warns_in_the_log(bare, tmp_path, caplog):
    with caplog.at_level(logging.WARNING, logger="breaker"):
        style.save(figure("开"), tmp_path / "a.png")
    assert len(caplog.messages) == 1
    assert "a.png: no font of this machine has 开" in caplog.text


def test_signs_that_are_not_shown_are_escaped():
    drawn = figure("L1\u202e\u200b\x1b")
    assert encoding.encoded(drawn, "svg") == encoding.encoded(drawn, "svg")
    assert r"L1\u202e\u200b\x1b" in [each.get_text() for each in drawn.findobj(Text)]


def test_few_of_many_signs_are_named(bare):
    signs = "".join(map(chr, range(0x4E00, 0x4E00 + 100)))
    assert "一 丁" in encoding.without_font([figure(signs)])
    assert "and 80 more signs" in encoding.without_font([figure(signs)])


@pytest.mark.parametrize("form", ["png", "svg", "pdf", "jpg"])
def test_the_same_figure_is_the_same_bytes(form, monkeypatch):
    first = encoding.encoded(figure(), form)
    later = time.time() + 5000.0
    monkeypatch.setattr(time, "time", lambda: later)
    assert encoding.encoded(figure(), form) == first
    for date in (b"<dc:date>", b"/CreationDate"):
        assert date not in first
