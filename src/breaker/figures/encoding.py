"""Figures on their way to a file: letters of any script, and the same bytes for the same figure."""

import logging
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from io import BytesIO

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.text import Text

from breaker.common.visible_text import visible_text

OWN = "DejaVu Sans"
"""Comes with matplotlib: the same on every machine. Has Latin, Greek, Cyrillic, Arabic letters."""

OTHERS = (
    *("Noto Sans", "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans SC", "Noto Sans JP"),
    *("Source Han Sans SC", "WenQuanYi Micro Hei", "WenQuanYi Zen Hei", "Droid Sans Fallback"),
    *("Microsoft YaHei", "SimHei", "PingFang SC", "Hiragino Sans", "Heiti SC", "Arial Unicode MS"),
    *("IPAexGothic", "IPAGothic", "Yu Gothic", "MS Gothic", "Noto Sans KR", "Noto Sans CJK KR"),
    *(
        "Malgun Gothic",
        "Apple SD Gothic Neo",
        "NanumGothic",
        "Noto Sans Arabic",
        "Noto Sans Hebrew",
    ),
    *("Noto Sans Devanagari", "Noto Sans Thai", "Noto Sans Symbols", "Noto Sans Symbols 2"),
    *("Noto Emoji", "Symbola", "Segoe UI Symbol", "Segoe UI Emoji", "Apple Symbols", "Unifont"),
)
"""Families that have what ``OWN`` lacks, where a machine has them; the first that has a sign."""

_DATES = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}  # metadata, by format
_WARN = ("matplotlib.mathtext", "matplotlib.font_manager")
_SHOWN = 20  # signs in a message
_ESCAPED = re.compile(r"\\\$")


def families() -> list[str]:
    """Return the families of letters: that of matplotlib, and others that this machine has."""
    there = {each.name for each in fontManager.ttflist}
    return [OWN, *(each for each in OTHERS if each in there)]


@contextmanager
def quiet() -> Iterator[None]:
    """Draw without what matplotlib says of each sign that no font has: see ``without_font``."""
    loggers = [logging.getLogger(name) for name in _WARN]
    levels = [each.level for each in loggers]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"(?s)Glyph .* missing from")
        for each in loggers:
            each.setLevel(logging.ERROR)
        try:
            yield
        finally:
            for each, level in zip(loggers, levels, strict=True):
                each.setLevel(level)


def encoded(figure: Figure, form: str) -> bytes:
    """Return a figure as a file of a format, such as "png", has it, without the time of writing,
    and with escapes for signs that are not shown.
    """
    file, about = BytesIO(), _DATES.get(form, {})
    for text in figure.findobj(Text):
        if (words := visible_text(text.get_text())) != text.get_text():
            text.set_text(words)
    with quiet(), mpl.rc_context({"svg.hashsalt": "breaker"}):
        figure.savefig(file, format=form, **({"metadata": about} if about else {}))
    return file.getvalue()


def without_font(figures: Iterable[Figure]) -> str:
    """Say which signs in figures no font of this machine has; empty if there is none."""
    have = [_signs(each) for each in families()]
    lacking = {}
    for text in (each for figure in figures for each in figure.findobj(Text)):
        words = text.get_text()
        # What has mathematics in it is set with one font alone.
        there = have[:1] if _ESCAPED.sub("", words).count("$") > 1 else have
        lacking |= {sign: "" for sign in words if not any(ord(sign) in of for of in there)}
    signs = [sign for sign in lacking if not sign.isspace()]
    if not signs:
        return ""
    more = f" and {len(signs) - _SHOWN} more signs" if len(signs) > _SHOWN else ""
    return (
        f"no font of this machine has {' '.join(signs[:_SHOWN])}{more}, so boxes stand there; "
        "install one that has, such as Noto Sans CJK of Chinese, Japanese and Korean"
    )


@cache
def _signs(family: str) -> frozenset[int]:
    """Numbers of the signs that a family has."""
    return frozenset(get_font(findfont(FontProperties(family=family))).get_charmap())
