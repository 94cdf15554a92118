"""The data package of a run: each column of each table is described, by its name and type."""

import pandas as pd
import pytest

from breaker.common.data_package import DescribedTable, data_package


@pytest.fixture
def table(tmp_path):
    file = tmp_path / "tables" / "A b.csv"
    file.parent.mkdir()
    frame = pd.DataFrame(
        {
            "n": [1, 2],
            "x": [0.5, float("inf")],
            "gap": [None, 3],
            "fits": [True, False],
            "known": [True, None],
            "word": ["a", "1"],
            "empty": [None, None],
        }
    )
    frame.to_csv(file, index=False)
    return DescribedTable(file, "a table", dict.fromkeys([*frame, "more"], "said"))


def test_types_are_those_of_the_values(tmp_path, table):
    [found] = data_package(tmp_path, "a run", [table])["resources"]
    assert found["path"] == "tables/A b.csv"
    assert found["bytes"] == table.file.stat().st_size
    types = {each["name"]: each["type"] for each in found["schema"]["fields"]}
    assert types == {
        **dict.fromkeys(["n", "x", "gap"], "number"),
        **dict.fromkeys(["fits", "known"], "boolean"),
        **dict.fromkeys(["word", "empty"], "string"),
    }


def test_a_column_that_nobody_describes_is_refused(tmp_path, table):
    del table.columns["gap"]
    with pytest.raises(ValueError, match="nothing describes gap"):
        data_package(tmp_path, "a run", [table])


def test_a_table_elsewhere_is_refused(tmp_path, table):
    with pytest.raises(ValueError, match="subpath"):
        data_package(tmp_path / "other", "a run", [table])
