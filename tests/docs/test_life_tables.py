"""The page on the tables of a life lists their columns, and no others."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.lives import OPERATIONS, a_life
from tests.prognosis.test_tables import tables

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "life-tables.md"
ABOUT = dict.fromkeys(("breaker", "phase", "event"), np.full(OPERATIONS.size, "a"))
ABOUT |= dict.fromkeys(("temperature", "voltage"), np.ones(OPERATIONS.size))
ABOUT["date"] = np.where(OPERATIONS < 250, "2024-01-01", "2024-06-01")


@pytest.mark.parametrize(("number", "name"), [*enumerate(("decisions", "limits", "changes"))])
def test_columns_are_those_of_the_tables(number, name):
    text = PAGE.read_text(encoding="utf-8").split(f"<!-- columns: {name} -->\n")[1]
    rows = re.findall(r"^\| `(\w+)` \| .* \|$", text.split("\n\n")[0], re.MULTILINE)
    life = a_life().assign({key: ("operation", values) for key, values in ABOUT.items()})
    columns = [*tables(life)[number]]
    assert rows == [column for column in columns if name != "changes" or column in rows]
