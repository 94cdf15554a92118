"""One schema of the tables, in code and in the documentation."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from breaker.decisions.actions import ACTIONS
from breaker.decisions.columns import ALARMS, DECISIONS, read_table, table_of

TEXT = (Path(__file__).parents[2] / "docs" / "decisions.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "columns"), [("decisions", DECISIONS), ("alarms", ALARMS)])
def test_documentation_lists_the_columns_as_they_are(name, columns):
    """Names, kinds and units, meaning: row by row below the comment of each table."""
    below = TEXT.split(f"<!-- columns: {name} -->\n")[1]
    lines = [line for line in re.split(r"\n(?!\|)", below.strip())[0].splitlines()[2:]]
    expected = [
        f"| `{each}` | {' '.join(filter(None, [column.kind, column.unit]))} | {column.meaning} |"
        for each, column in columns.items()
    ]
    assert lines == expected, "\n".join(expected)


def test_documentation_lists_the_actions_as_they_are():
    for code, meaning in ACTIONS.items():
        assert f"| `{code}` | {meaning} |" in TEXT


def test_kinds_survive_a_file(tmp_path):
    given = {"operation": [1, 2], "operations_left": [np.inf, np.nan], "service_by": [7, pd.NA]}
    given |= {"breaker": ["007", "007"], "limit": ["", "NA"], "date": ["2024-01-01", ""]}
    table = table_of(given | {"to_do": ["a, b", "c"]}, DECISIONS)
    table.to_csv(tmp_path / "decisions.csv", index=False)
    read = read_table(tmp_path / "decisions.csv", DECISIONS)
    pd.testing.assert_frame_equal(read, table)
    assert read.service_by.tolist() == [7, pd.NA]
    assert read.to_do.tolist() == ["a, b", "c"]


def test_strange_columns_are_refused():
    with pytest.raises(ValueError, match="no column is called 'toothed'"):
        table_of({"toothed": [1]}, ALARMS)
