"""What leaves files: shown on a terminal, and written into tables that spreadsheets open."""

import csv
from io import StringIO

import pandas as pd
import pytest

from breaker.common.text import as_meant, inert, save_frame, table_text, visible_text

NAMES = ("=cmd()", "+a", "-Q1", "@Q0", "'=x", "''@x", "'Q0'", "\tQ0", "\rQ0", 'a,"b"\nc', "Q0")
NAMES += ("", "-3.5", "+1")


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


@pytest.mark.parametrize("name", NAMES)
def test_a_name_in_a_table_is_not_run_and_comes_back(name):
    cell = inert(name)
    assert cell[:1] not in {*"=@\t\r"}
    assert cell[:1] not in {*"+-"} or float(cell)
    assert as_meant(cell) == name
    _, row = csv.reader(StringIO(table_text(["a", "b"], [{"a": name, "b": -0.5}]), newline=""))
    assert (as_meant(row[0]), row[1]) == (name, "-0.5")


def test_a_frame_is_written_with_inert_cells_and_plain_numbers(tmp_path):
    names = [name for name in NAMES if "\r" not in name]  # which no name in a frame has
    frame = pd.DataFrame({"=name": names, "value": [-1.0 / 3.0] * len(names)})
    frame["count"] = pd.Series([1, None] + [2] * (len(names) - 2), dtype=object)
    save_frame(frame, tmp_path / "t.csv", digits=3)
    text = (tmp_path / "t.csv").read_text(encoding="utf-8")
    rows = [*csv.reader(StringIO(text, newline=""))]
    assert rows[0] == ["'=name", "value", "count"]
    assert [row[2] for row in rows[1:4]] == ["1", "", "2"]
    assert [as_meant(row[0]) for row in rows[1:]] == names
    assert {row[1] for row in rows[1:]} == {"-0.333"}
