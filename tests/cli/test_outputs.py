"""What commands write: never over a file of the user, and completely or not at all."""

import os
import subprocess
import sys

import pytest

from breaker.cli import main
from breaker.cli.outputs import write


def files_in(folder):
    """Contents of all regular files below a folder."""
    return {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize(
    "words",
    [
        "infer drive --output drive/op_1.csv",
        "infer a.csv --output few.yaml",
        "infer a.csv --output open.csv",  # a record that is not read
        "infer a.csv --plot drive",
        "infer a.csv --plot picture.txt",
        "infer a.csv --output nowhere/out.csv",
        "infer a.csv --output pipe",
        "inspect a.csv --output config/config.yaml",
        "fit-prior drive --output drive/op_1.csv",
        "compare a.csv --today open.csv --plot picture.png",  # a link to a record
    ],
)
def test_only_a_result_is_replaced(folder, capsys, words):
    for name in ("drive", "config"):
        (folder / name).mkdir()
    (folder / "drive/op_1.csv").write_bytes((folder / "a.csv").read_bytes())
    rows = "file,motion,operation\nop_1.csv,closing,1\n"
    (folder / "drive/operations.csv").write_text(rows, encoding="utf-8")
    (folder / "picture.png").symlink_to("a.csv")
    (folder / "config/config.yaml").write_text("endurance: {draws: 100}\n")
    os.mkfifo(folder / "pipe")
    before = files_in(folder)
    assert main([*words.split(), "--config", "few.yaml"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("breaker: ")
    assert words.split()[-1].rpartition("/")[2] in err
    assert files_in(folder) == before


def test_results_replace_results_of_their_kind(folder):
    words = ["infer", "a.csv", "--output", "t.csv", "--config", "few.yaml"]
    for _ in range(2):
        assert main(words) == 0
    (folder / "link.csv").symlink_to("t.csv")
    first = (folder / "t.csv").read_bytes()
    assert main(["infer", "b 2.csv", "--output", "link.csv", "--config", "few.yaml"]) == 0
    assert (folder / "link.csv").is_symlink()
    assert (folder / "t.csv").read_bytes() != first
    assert not [file for file in folder.iterdir() if file.name.startswith(".")]


def test_an_old_result_stays_until_all_is_written(tmp_path, monkeypatch):
    """Planted faults: an interrupt before the replacement, and a disk that is full."""
    target = tmp_path / "t.csv"
    target.write_text("old")
    for error, raised in ((KeyboardInterrupt(), KeyboardInterrupt), (OSError(28, "full"), OSError)):

        def fail(*_, error=error):
            raise error

        with monkeypatch.context() as patch:
            patch.setattr(os, "replace", fail)
            with pytest.raises(raised):
                write(str(target), b"new")
        assert target.read_text() == "old"
        assert os.listdir(tmp_path) == [target.name]
    write(str(target), b"new")
    assert target.read_text() == "new"


def test_letters_that_a_terminal_lacks_do_not_end_a_command(folder):
    command = [sys.executable, "-m", "breaker", "infer", "a.csv", "--config", "few.yaml"]
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert b"?" in done.stdout
