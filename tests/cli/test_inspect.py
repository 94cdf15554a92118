"""`breaker inspect` as a command, for a file and for a folder."""

import shutil

import pytest
import yaml

from breaker.cli import main
from tests.cli.conftest import written


@pytest.fixture
def shown(capsys):
    """Inspect, expect a status, and return output and errors."""

    def shown(*words, status=0):
        capsys.readouterr()
        assert main(["inspect", *words]) == status
        return capsys.readouterr()

    return shown


def test_a_file_is_inspected_and_its_proposal_reads_it(folder, capsys, shown):
    text = (folder / "a.csv").read_text(encoding="utf-8")
    swapped = text.translate(str.maketrans(".,", ",;"))  # with decimal commas
    (folder / "german.csv").write_text(swapped, encoding="utf-8")
    out, err = shown("german.csv", "--output", "german.yaml")
    assert err == ""
    overlay = (folder / "german.yaml").read_text(encoding="utf-8")
    assert overlay in out
    assert yaml.safe_load(overlay)["endurance"]["format"]["delimiter"] == ";"
    assert main(["infer", "german.csv", "--config", "few.yaml", "german.yaml"]) == 0
    first = capsys.readouterr().out
    assert main(["infer", "a.csv", "--config", "few.yaml"]) == 0
    assert first == capsys.readouterr().out.replace("a.csv", "german.csv")


def test_a_file_that_cannot_be_inspected(folder, shown):
    assert shown("c.csv", status=1).err.startswith("breaker: c.csv: ")
    (folder / "words.csv").write_text("once upon a time", encoding="utf-8")
    lines = (folder / "a.csv").read_text(encoding="utf-8").splitlines()
    first = next(i for i, line in enumerate(lines) if line[0].isdigit())
    falls = "\n".join([*lines[:first], *lines[first:][::-1]])
    (folder / "falls.csv").write_text(falls, encoding="utf-8")
    for name in ("words.csv", "falls.csv"):
        assert name in shown(name, status=1).err
    with (folder / "b 2.csv").open("a", encoding="utf-8") as damaged:
        damaged.write("x,y\n")
    assert "REJECTED" in shown("b 2.csv", "--output", "b.yaml", status=1).out
    assert not (folder / "b.yaml").exists()  # settings that read nothing are never proposed
    assert "travel_column: travel" in shown("a.csv", "--channel", "force", status=1).err


def test_a_folder_without_a_table_has_one_proposed_and_is_then_checked(folder, prior, shown):
    own, table = folder / "own", folder / "own" / "operations.csv"
    own.mkdir()
    shutil.copy(folder / "a.csv", own / "closing_20-11-2024.csv")
    shutil.copy(folder / "open.csv", own / "opening_20-11-2024.csv")
    (own / "notes.txt").write_text("once", encoding="utf-8")
    (folder / "one.yaml").write_text("motions: [opening]", encoding="utf-8")
    rows = shown("own", "--config", "one.yaml").out.splitlines()[1:]
    assert {row.split(",")[1] for row in rows} == {"opening"}
    proposed = shown("own")
    assert proposed.out.startswith("file,motion,operation,")
    for word in ("notes.txt", "--output own/operations.csv"):
        assert word in proposed.err
    shown("own", "--output", str(table))
    assert table.read_text(encoding="utf-8") == proposed.out
    rows = [row.split()[:5] for row in shown("own").out.splitlines()]
    assert ["closing", "1", "1", "0", "0"] in rows  # listed, accepted, with remarks, rejected
    written(own / "opening_20-11-2024.csv", prior, "closing")
    out, err = shown("own", status=1)
    assert ["opening", "1", "0", "0", "1"] in [row.split()[:5] for row in out.splitlines()]
    assert err == ""
    shown("own", "--output", "new.csv", status=1)  # never another table beside the first
