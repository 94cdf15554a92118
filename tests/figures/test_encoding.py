"""Figures in files: signs that are not shown, dates, and fonts that a machine lacks."""

import logging

import pytest
from matplotlib import font_manager
from matplotlib.text import Text

from breaker.figures import style


@style.styled
def figure(name):
    found = style.new_figure(4.0, 3.0)
    axis = found.subplots()
    axis.plot([0.0, 1.0])
    axis.set_title(style.literal(name), weight="bold")
    return found


def test_what_no_font_has_is_said_in_the_log(monkeypatch, tmp_path, caplog):
    """On a machine that has the fonts of matplotlib alone."""
    own = [each for each in font_manager.fontManager.ttflist if each.name not in style.OTHER_FONTS]
    monkeypatch.setattr(font_manager.fontManager, "ttflist", own)
    assert style.without_font([figure("Ω Выкл مفتاح")]) == ""
    with caplog.at_level(logging.WARNING, logger="breaker"):
        style.save(figure("$x 开关"), tmp_path / "a.png")
    (message,) = caplog.messages
    assert "开, 关" in message


def test_signs_that_are_not_shown_are_escaped():
    drawn = figure("L1\u202e\u200b\x1b")
    assert style.encoded(drawn, "svg")
    assert r"L1\u202e\u200b\x1b" in [each.get_text() for each in drawn.findobj(Text)]


@pytest.mark.parametrize("form", ["png", "svg", "pdf", "jpg"])
def test_a_file_has_no_date(form):
    content = style.encoded(figure("$x"), form)
    assert not [date for date in (b"<dc:date>", b"/CreationDate") if date in content]
