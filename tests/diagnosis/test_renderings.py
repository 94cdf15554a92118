"""One document on a terminal and as HTML: every word of it, and no other."""

import re
from dataclasses import make_dataclass, replace
from html import unescape

import pytest

from breaker.common.html_page import html_page
from breaker.common.parts import Cell, Document, Letterhead, Remark, Section, Table
from breaker.common.plain_values import Plain, plainly, to_json
from breaker.common.terminal import lines_of, text_of
from breaker.diagnosis.report import Report

HOSTILE = '<script>alert("$x$")</script>&amp;'
PARTS = [
    Section("a section", ["a line", Remark("a remark"), Table(rows=[("left", "right")])]),
    Table(
        ("name", "value"),
        [("stroke", Cell("178", "bad")), "a group", Remark(f"why {HOSTILE}")],
        "a table",
        ["a note"],
    ),
]
WORDS = ["summed up", "a section", "a line", "a remark", "left", "right", "a table", "name"]
WORDS += ["value", "stroke", "178", "a group", f"why {HOSTILE}", "a note"]


@pytest.fixture
def report():
    return Report(HOSTILE, [("Breaker", HOSTILE)], [Cell("summed up", "good")], PARTS)


def test_every_rendering_has_every_word_in_its_order(report):
    html = html_page(report)
    shown = unescape(re.sub(r"<style>.*?</style>|<[^>]*>", " ", html, flags=re.S))
    for rendering in (text_of(report), shown):
        places = [rendering.find(word) for word in WORDS]
        assert -1 not in places
        assert places == sorted(places)


@pytest.mark.parametrize("inner", ["", "first-page"])
def test_no_word_is_markup(report, inner):
    html = html_page(report, inner=inner)
    assert "<script" not in html
    assert "&amp;amp;" in html
    assert unescape(html).count(HOSTILE) == (4 if not inner else 3)


@pytest.mark.parametrize("inner", ["", "report"])
def test_no_page_holds_a_sign_that_it_obeys_or_does_not_show(inner):
    name = "L1\u202e\u200b\x1b<b>"
    document = Document(name, [(name, name)], [name], [Remark(name)])
    page = html_page(document, alt=name, inner=inner)
    assert not [sign for sign in page if not sign.isprintable() and sign != "\n"]
    assert page.count(r"L1\u202e\u200b\x1b&lt;b&gt;") >= 4


def test_a_tone_is_a_class_of_the_page(report):
    html = html_page(report)
    assert '<td class="bad">178</td>' in html
    assert '<p class="good">summed up</p>' in html


def test_a_printed_page_is_a4_with_numbers_letters_of_9_pt_and_rows_that_do_not_break(report):
    html = html_page(report)
    style = html.partition("<style>")[2].partition("</style>")[0]
    assert re.search(r"@page \{[^@]*size: A4", style)
    assert "counter(page)" in style
    printed = style.partition("@media print")[2]
    assert re.search(r"\btr\b[^{]*\{ break-inside: avoid", printed)
    sizes = re.findall(r"([\d.]+)pt", style)
    assert len(sizes) >= 3
    assert min(map(float, sizes)) >= 9.0
    assert re.search(r"<thead>\s*<tr><th>name</th>", html)  # is repeated on each page
    assert "@media" not in html_page(report, inner="report")


def test_remarks_and_lines_to_sign_stay_together_on_a_page(report):
    around = Letterhead("A $ company", b"logo", "After <overhaul>", ["tested by: name, date"])
    html = html_page(replace(report, letterhead=around), [b"curves"])
    ending = re.search(r'<div class="ending">.*?</div>', html, re.S)[0]
    for text in ("After &lt;overhaul&gt;", "<td>tested by: name, date</td>"):
        assert text in ending
    assert 'alt="A $ company"' in html
    assert html.count("data:image/png;base64,") == 2


def test_a_last_column_without_a_width_is_wrapped_under_itself():
    (table,) = [Table(rows=[("a", "word " * 30), ("b", "")], form="  {:<6} {}")]
    first, second, last = lines_of(table)
    assert max(map(len, (first, second))) <= 100
    assert first.startswith("  a      word")
    assert second.startswith(" " * 9 + "word")
    assert last == "  b"


def test_columns_without_a_form_are_as_wide_as_they_need_to_be():
    table = Table(("", "records"), [("closing", "11"), ("o", "2")])
    assert lines_of(table) == ["         records", "closing       11", "o              2"]


def test_json_leaves_out_what_is_none_by_default():
    of = make_dataclass("Of", [("sd", float), ("why", str, None)], bases=(Plain,), frozen=True)
    assert to_json(plainly([of(float("nan")), of(2 / 3, "few")])) == (
        '[{"sd": null}, {"sd": 0.666667, "why": "few"}]'
    )
