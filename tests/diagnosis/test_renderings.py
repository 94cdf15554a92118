"""One document on a terminal and as HTML: every word of it, and no markup of others."""

import re
from html import unescape

from breaker.common.document import (
    Cell,
    Document,
    Remark,
    Table,
    html_page,
    text_of,
)

HOSTILE = '<script>alert("$x$")</script>&amp;\u202e\u200b\x1b'
ROWS = [("stroke", Cell("178", "bad")), "a group", Remark("why")]
PARTS = [Table(("name", "value"), ROWS, "a table", ["a note"])]
WORDS = ["summed up", "a table", "name", "value", "stroke", "178", "a group", "why", "a note"]
REPORT = Document("a title", [("Breaker", "Q1")], [Cell("summed up", "good")], PARTS)


def test_both_renderings_have_every_word_in_its_order():
    html = html_page(REPORT)
    shown = unescape(re.sub(r"<style>.*?</style>|<[^>]*>", " ", html, flags=re.S))
    for rendering in (text_of(REPORT), shown):
        places = [rendering.find(word) for word in WORDS]
        assert -1 not in places
        assert places == sorted(places)
    assert '<td class="bad">178</td>' in html


def test_no_word_is_markup_or_a_sign_that_a_page_obeys():
    parts = [Remark(HOSTILE)]
    page = html_page(Document(HOSTILE, [(HOSTILE, HOSTILE)], [HOSTILE], parts, company=HOSTILE))
    assert "<script" not in page
    assert not [sign for sign in page if not sign.isprintable() and sign != "\n"]
    assert page.count(r"&amp;amp;\u202e\u200b\x1b") >= 6
