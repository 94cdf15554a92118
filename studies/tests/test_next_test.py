"""The tables of what tests of `breaker plan` narrow: their numbers, and the page that has them."""

from itertools import product
from pathlib import Path

import pandas as pd
import pytest

from breaker.quantities.parameters import NAMES
from studies.next_test import CHEAP, COLUMNS, TARGETS, markdown, read, tables_of, write

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def rows():
    """Two drives; every test halves the variance, is foretold to leave 0.6 of it, and one test is
    foretold and found to leave 0.1.
    """
    found = []
    for drive, test, name in product(range(2), CHEAP, NAMES):
        foretold, left = (0.1, 0.1) if test == "contact" else (0.6, 0.5)
        found.append((drive, "closing", test, name, 2.0, 2.0 * foretold, 2.0 * left, 0.5))
    return pd.DataFrame(found, columns=COLUMNS)


def test_tables_have_what_came_out(rows):
    tables = tables_of(rows)
    told = tables["found over foretold"]
    assert told.loc["contact", "L"] == pytest.approx(1.0)
    assert told.loc["size", "mu"] == pytest.approx(0.5 / 0.6)
    assert told.loc["size", "mean square of z"] == pytest.approx(0.25)
    for target in TARGETS:
        row = tables["tests of an hour at one cost"].loc[target]
        assert row["chosen"] == row["best"] == pytest.approx(0.1)
        assert row["at random"] == pytest.approx(0.4)
        assert row["chosen over random"] == pytest.approx(0.25)
        assert row["best was chosen"] == 1.0


def test_written_tables_are_read_as_they_were(rows, tmp_path):
    write(tables_of(rows), tmp_path / "a.csv")
    for title, table in read(tmp_path / "a.csv").items():
        assert markdown(table) == markdown(tables_of(rows)[title])


def test_the_page_has_the_tables():
    page = (DOCS / "evidence.md").read_text(encoding="utf-8")
    for table in read(DOCS / "next_test.csv").values():
        assert markdown(table) in page
