"""Tables of folders of exports: right cells are right, and planted faults are found."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

from studies.exports.cells import FILL_IN, compared, judged, true_rows
from studies.exports.manifests import write_folder

DOCS = Path(__file__).parents[2] / "docs"


def right_table(truth):
    """Return the rows of a table that has all of the truth."""
    rows = []
    for true in truth:
        row = {key: true[key] for key in ("file", "motion", "channel", "phase", "date")}
        breaker = true["breaker"] or true["drive"]
        row["breaker"] = f"{breaker} {true['drive']}" if true["shared"] else breaker
        row |= {"operation": str(true["operation"]), "rate": f"{true['rate']:.12g}"}
        rows.append(row | {"from": f"{true['first'] - 90}", "to": f"{true['last'] + 100}"})
    return rows


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The truth of a folder of which all is sure: three breakers, copies, other files."""
    for number in range(40):
        path = tmp_path_factory.mktemp("folder")
        truth = write_folder(path, np.random.default_rng([5, number]))
        rows = true_rows(truth)
        if truth["copies"] and all(row["sure breaker"] == "yes" for row in rows):
            return path, truth, rows
    raise AssertionError("no such folder")


def kinds(folder, rows):
    """Return what cells are other than right, and how many rows are double and missing."""
    scored, counts = compared(rows, folder[2], folder[1]["copies"])
    cells = [(c, kind) for each in scored for c, kind in each["kinds"].items()]
    return [each for each in cells if each[1] in ("wrong", "needless")], dict(counts)


def test_a_right_table_has_nothing_to_change(folder):
    assert kinds(folder, right_table(folder[2])) == ([], {"double": 0, "missing": 0})


@pytest.mark.parametrize(
    ("column", "cell", "kind"),
    [
        ("breaker", "another", "wrong"),
        ("breaker", FILL_IN, "needless"),
        ("phase", "Q", "wrong"),
        ("date", "2031-01-01", "wrong"),
        ("operation", "77", "wrong"),
        ("to", "1", "wrong"),
    ],
)
def test_a_planted_fault_is_found(folder, column, cell, kind):
    rows = right_table(folder[2])
    at = next(i for i, true in enumerate(folder[2]) if true["sure phase"] and true["sure date"])
    rows[at][column] = cell
    found, _ = kinds(folder, rows)
    named = "part" if column == "to" else column
    others = {"operation"} if column == "breaker" else set()  # of which nobody knows the drive
    assert (named, kind) in found
    assert {each for each, _ in found} <= {named} | others


def test_rows_of_copies_and_lacking_ones_are_counted(folder):
    rows = right_table(folder[2])
    copy, first = next(iter(folder[1]["copies"].items()))
    copied = [row | {"file": copy} for row in rows if row["file"] == first]
    assert kinds(folder, rows + copied)[1] == {"double": len(copied), "missing": 0}
    assert kinds(folder, rows[1:])[1] == {"double": 0, "missing": 1}
    assert kinds(folder, [*rows, rows[0] | {"file": "notes.txt"}])[1]["double"] == 1


def test_what_no_file_states_is_guessed_or_rightly_left_open():
    assert judged("10", True, False) == "guessed"
    assert judged(FILL_IN, False, False) == "fill in"
    assert judged("10", True, "either") == judged("", True, False) == "right"
    assert judged("12", False, "either") == "wrong"


def test_a_folder_has_what_makes_tables_wrong(folder):
    path, truth, rows = folder
    for copy, first in truth["copies"].items():
        assert (path / copy).read_bytes() == (path / first).read_bytes()
    written = [(path / row["file"]).stat().st_mtime for row in rows]
    assert all(when > 1.59e9 for when in written)  # years after any date in a name


def test_the_page_states_the_numbers_of_the_table():
    with (DOCS / "manifests.csv").open(encoding="utf-8", newline="") as file:
        table = {row["of"]: row for row in csv.DictReader(file)}
    page = (DOCS / "evidence.md").read_text(encoding="utf-8")
    (said,) = re.findall(r"`studies\.exports\.manifests`.*?(?=\n\n)", page, re.DOTALL)
    all_, counted = table["all stated"], {name: row["count"] for name, row in table.items()}
    for number in (
        counted["folders"],
        counted["rows"],
        all_["count"],
        *(all_[kind] for kind in ("wrong", "needless", "guessed")),
        table["not all stated"]["fill in"],
        counted["of these accepted at once"],
        counted["folders that state all"],
    ):
        assert re.search(rf"(?<![\d,.]){int(float(number)):,}(?![\d,.]\d)", said), number
