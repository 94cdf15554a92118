"""The page on decisions lists the columns of the tables, and no others."""

import re
from pathlib import Path

import pytest

from breaker.prognosis.tables import CHANGES, DECISIONS, LIMITS

PAGE = Path(__file__).parents[2] / "docs" / "decisions.md"


@pytest.mark.parametrize(
    ("table", "columns"), [("decisions", DECISIONS), ("limits", LIMITS), ("changes", CHANGES)]
)
def test_columns_are_those_of_the_tables(table, columns):
    text = PAGE.read_text(encoding="utf-8").split(f"<!-- columns: {table} -->\n")[1]
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", text.split("\n\n")[0], re.MULTILINE)
    assert dict(rows) == columns
