"""The tables of the pages are those of the files beside them."""

import re

import pytest

from tests.scripts import script

tables = script("docs/tables.py")


@pytest.mark.parametrize("page", tables.PAGES, ids=lambda page: page.name)
def test_pages_have_the_tables_of_the_files(page):
    text = page.read_text(encoding="utf-8")
    assert tables.placed(text) == text, "run: python docs/tables.py"
    changed = re.sub(r"(<!-- table: \w+ -->\n.*\n.*\n\| [^|]*\|) ", r"\1 7", text)
    assert changed != text
    assert tables.placed(changed) == text
