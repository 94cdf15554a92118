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
        "infer a.csv --output few.yaml",
        "infer a.csv --output open.csv",  # a record that is not read
        "infer a.csv --plot picture.txt",
        "infer a.csv --plot drive.png",  # a folder
        "infer a.csv --output nowhere/out.csv",
        "infer a.csv --output pipe",
        "inspect a.csv --output few.yaml",
        "fit-prior . --output open.csv",
    ],
)
def test_no_work_of_the_user_is_replaced(folder, capsys, words):
    (folder / "drive.png").mkdir()
    os.mkfifo(folder / "pipe")
    before = files_in(folder)
    assert main([*words.split(), "--config", "few.yaml"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("breaker: ")
    assert words.split()[-1].rpartition("/")[2] in err
    assert files_in(folder) == before


def test_a_picture_is_replaced_and_a_link_to_a_record_keeps_it(folder):
    (folder / "a.png").symlink_to("a.csv")
    before = (folder / "a.csv").read_bytes()
    for _ in range(2):
        assert main(["infer", "a.csv", "--plot", "a.png", "--config", "few.yaml"]) == 0
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "a.csv").read_bytes() == before
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
