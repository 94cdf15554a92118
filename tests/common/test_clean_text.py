"""Names that leave files: shown on a terminal."""

import pytest

from breaker.common.clean_text import visible_text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Weg (mm)\n\tкурс 行程 🔧\u00a0±", "Weg (mm)\n\tкурс 行程 🔧\u00a0±"),
        ("\x1b[2J\x1b]0;t\x07\r\x9b", r"\x1b[2J\x1b]0;t\x07\r\x9b"),
        ("\u202a\u061c\u200b\ufeff\u00ad\u2028", r"\u202a\u061c\u200b\ufeff\xad\u2028"),
    ],
)
def test_a_terminal_gets_no_sign_that_it_obeys_or_hides(text, shown):
    assert visible_text(text) == shown
