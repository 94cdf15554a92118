"""`breaker inspect` and `breaker check` as commands."""

import re
import shutil

from breaker.cli import main
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
    assert 'delimiter: ";"' in overlay
    assert "accepted" in out
    assert (folder / "german.png").stat().st_size > 10_000
    assert main(["infer", "german.csv", "--config", "few.yaml", "german.yaml"]) == 0
    assert main(["infer", "a.csv", "--config", "few.yaml"]) == 0
    first, second = re.split(r"(?=german.csv: |\ba.csv: )", capsys.readouterr().out)[1:]
    assert first == second.replace("a.csv", "german.csv")


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
    assert "fall from line to line; sort its lines by time" in capsys.readouterr().err
    with (folder / "b 2.csv").open("a", encoding="utf-8") as damaged:
        damaged.write("x,y\n")
    assert main(["inspect", "b 2.csv"]) == 1
    assert "REJECTED" in capsys.readouterr().out
    assert main(["inspect", "a.csv", "--channel", "force"]) == 1
    assert "there are 'travel'" in capsys.readouterr().err


def test_a_folder_is_checked(folder, capsys, prior):
    for motion, name in (("closing", "a.csv"), ("opening", "open.csv")):
        (folder / "own" / motion).mkdir(parents=True)
        shutil.copy(folder / name, folder / "own" / motion / "operation_1.csv")
    assert main(["check", "own"]) == 0
    assert re.search(r"closing +1 +1 +0 +0", capsys.readouterr().out)
    written(folder / "own" / "opening" / "operation_1.csv", prior, "closing")
    assert main(["check", "own"]) == 1
    out, err = capsys.readouterr()
    assert "which is no opening" in out
    assert err == ""
