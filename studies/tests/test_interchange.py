"""Check the data package of a run's tables by frictionless, where it is installed."""

import csv
import json

import pytest

from breaker.common.data_package import DescribedTable, data_package

pytestmark = pytest.mark.filterwarnings("default")  # of the packages of others


@pytest.fixture
def package(tmp_path):
    """A package of one table, in a folder below."""
    file = tmp_path / "endurance" / "closing.csv"
    file.parent.mkdir()
    with file.open("w", newline="", encoding="utf-8") as stream:
        rows = [["operation", "left", "fits", "note"], [1, "inf", True, ""], [2, "", False, "ö, ="]]
        csv.writer(stream).writerows(rows)
    columns = {"operation": "number", "left": "operations left", "fits": "whether", "note": "words"}
    found = data_package(tmp_path, "a run", [DescribedTable(file, "operations", columns)])
    target = tmp_path / "datapackage.json"
    target.write_text(json.dumps(found), encoding="utf-8")
    return target


def test_the_package_of_tables_is_valid(package, monkeypatch):
    frictionless = pytest.importorskip("frictionless")
    monkeypatch.chdir(package.parent)
    report = frictionless.validate(package.name)
    assert report.valid, report.flatten(["rowNumber", "fieldName", "message"])
    [rows] = [each.read_rows() for each in frictionless.Package(package.name).resources]
    assert [row["fits"] for row in rows] == [True, False]
    assert rows[1]["left"] is None


@pytest.mark.parametrize("fault", ["a changed file", "another type", "no such file"])
def test_a_package_that_is_not_true_is_told(package, monkeypatch, fault):
    frictionless = pytest.importorskip("frictionless")
    monkeypatch.chdir(package.parent)
    table = package.parent / "endurance" / "closing.csv"
    if fault == "a changed file":
        table.write_text(table.read_text(encoding="utf-8") + "3,1,True,\n", encoding="utf-8")
    elif fault == "another type":
        text = package.read_text(encoding="utf-8").replace('"string"', '"boolean"')
        package.write_text(text, encoding="utf-8")
    else:
        table.unlink()
    assert not frictionless.validate(package.name).valid
