"""`breaker inspect` as a command, for a file and for a folder."""

import re
import shutil

import pytest
import yaml

from breaker.cli import main
from breaker.records.folder import list_operations
from tests.cli.conftest import written


def test_a_file_is_inspected_and_its_proposal_reads_it(folder, capsys):
    text = (folder / "a.csv").read_text(encoding="utf-8")
    swapped = text.translate(str.maketrans(".,", ",;"))  # with decimal commas
    (folder / "german.csv").write_text(swapped, encoding="utf-8")
    arguments = ["german.csv", "--output", "german.yaml", "--plot", "german.png"]
    assert main(["inspect", *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    overlay = (folder / "german.yaml").read_text(encoding="utf-8")
    assert overlay in out
    assert yaml.safe_load(overlay)["endurance"]["format"]["delimiter"] == ";"
    assert "accepted" in out
    assert (folder / "german.png").stat().st_size > 10_000
    assert main(["infer", "german.csv", "--config", "few.yaml", "german.yaml"]) == 0
    first = capsys.readouterr().out
    assert main(["infer", "a.csv", "--config", "few.yaml"]) == 0
    assert first == capsys.readouterr().out.replace("a.csv", "german.csv")


def test_a_file_that_cannot_be_inspected(folder, capsys):
    assert main(["inspect", "c.csv"]) == 1
    assert capsys.readouterr().err.startswith("breaker: c.csv: is not there")
    (folder / "words.csv").write_text("once upon a time", encoding="utf-8")
    assert main(["inspect", "words.csv"]) == 1
    assert "no columns of numbers" in capsys.readouterr().err
    lines = (folder / "a.csv").read_text(encoding="utf-8").splitlines()
    first = next(i for i, line in enumerate(lines) if line[0].isdigit())
    falls = "\n".join([*lines[:first], *lines[first:][::-1]])
    (folder / "falls.csv").write_text(falls, encoding="utf-8")
    assert main(["inspect", "falls.csv"]) == 1
    assert "sort its lines by time" in capsys.readouterr().err
    with (folder / "b 2.csv").open("a", encoding="utf-8") as damaged:
        damaged.write("x,y\n")
    assert main(["inspect", "b 2.csv", "--output", "b.yaml"]) == 1
    assert "REJECTED" in capsys.readouterr().out
    assert not (folder / "b.yaml").exists()  # never proposed is what reads nothing
    assert main(["inspect", "a.csv", "--channel", "force"]) == 1
    assert "travel_column: travel" in capsys.readouterr().err


def test_a_folder_of_numbered_files_is_checked(folder, capsys, prior):
    for motion, name in (("closing", "a.csv"), ("opening", "open.csv")):
        (folder / "own" / motion).mkdir(parents=True)
        shutil.copy(folder / name, folder / "own" / motion / "operation_1.csv")
    assert main(["inspect", "own"]) == 0
    out, err = capsys.readouterr()
    assert re.search(r"closing +1 +1 +0 +0", out)
    assert "endurance.curves: own" in out
    written(folder / "own" / "opening" / "operation_1.csv", prior, "closing")
    assert main(["inspect", "own"]) == 1
    out, err = capsys.readouterr()
    assert "which is no opening" in out
    assert err == ""


def test_a_folder_without_a_table_has_one_proposed_and_is_then_checked(folder, capsys):
    own, table = folder / "own", folder / "own" / "operations.csv"
    own.mkdir()
    shutil.copy(folder / "a.csv", own / "closing_20-11-2024.csv")
    shutil.copy(folder / "open.csv", own / "opening_20-11-2024.csv")
    assert main(["inspect", "own"]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("file,motion,operation,")
    assert "check: " in shown.err
    assert "--output own/operations.csv" in shown.err
    assert main(["inspect", "own", "--output", str(table)]) == 0
    assert table.read_text(encoding="utf-8") == shown.out
    capsys.readouterr()
    assert main(["inspect", "own"]) == 0
    assert re.search(r"opening +1 +1 +0 +0", capsys.readouterr().out)
    # A date that falls while the number rises, in a table that files contradict.
    rows = ["file,motion,operation,date", "closing_20-11-2024.csv,closing,1,2024-11-20"]
    rows += ["closing_20-11-2024.csv,closing,2,2023-11-20"]
    table.write_text("\n".join(rows), encoding="utf-8")
    assert main(["inspect", "own"]) == 1
    assert "line 3, column date" in capsys.readouterr().out
    assert main(["inspect", "own", "--output", "new.csv"]) == 1  # never another table beside it
    assert "--output" in capsys.readouterr().err


def test_a_table_replaces_nothing(folder, capsys):
    (folder / "own").mkdir()
    shutil.copy(folder / "a.csv", folder / "own" / "closing.csv")
    (folder / "t.csv").write_text("mine", encoding="utf-8")
    assert main(["inspect", "own", "--output", "t.csv"]) == 1
    assert (folder / "t.csv").read_text(encoding="utf-8") == "mine"
    assert "is there already" in capsys.readouterr().err


def test_a_table_of_numbered_files_is_proposed_where_it_is_asked_for(folder):
    (folder / "own/closing").mkdir(parents=True)
    shutil.copy(folder / "a.csv", folder / "own/closing/7.csv")
    table = folder / "own/operations.csv"
    assert main(["inspect", "own", "--channels", "A", "B", "--output", str(table)]) == 0
    (found,) = list_operations(folder / "own", "closing", phase="B")
    assert (found.number, found.channel) == (7, "B")


def test_the_configuration_says_which_motions_have_rows(folder, capsys):
    (folder / "own").mkdir()
    for name, source in (("closing a.csv", "a.csv"), ("opening b.csv", "open.csv")):
        shutil.copy(folder / source, folder / "own" / name)
    (folder / "one.yaml").write_text("motions: [opening]", encoding="utf-8")
    (folder / "own/notes.txt").write_text("once", encoding="utf-8")
    assert main(["inspect", "own", "--config", "one.yaml"]) == 0
    shown = capsys.readouterr()
    assert {row.split(",")[1] for row in shown.out.splitlines()[1:]} == {"opening"}
    assert "left out: notes.txt is no record: " in shown.err


def test_a_table_on_the_terminal_says_where_its_signs_are_others(folder, capsys):
    """Planted fault: a table that was sent to a file named records that are not there."""
    (folder / "own/closing").mkdir(parents=True)
    shutil.copy(folder / "a.csv", folder / "own/closing/x\ufe0f.csv")
    assert main(["inspect", "own"]) == 0
    shown = capsys.readouterr()
    assert "x\\ufe0f.csv" in shown.out
    assert "it has the signs themselves" in shown.err
    assert main(["inspect", "own", "--output", "own/operations.csv"]) == 0
    assert "signs themselves" not in capsys.readouterr().err
    assert len(list_operations(folder / "own", "closing")) == 1


@pytest.mark.parametrize(
    "words",
    [
        ["a.csv", "--channels", "A"],
        ["own", "--channel", "A"],
        ["own", "--plot", "a.png"],
    ],
)
def test_an_option_that_does_not_fit_is_refused(folder, capsys, words):
    (folder / "own").mkdir()
    assert main(["inspect", *words]) == 1
    assert words[1] in capsys.readouterr().err
