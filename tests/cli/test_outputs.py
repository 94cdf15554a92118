"""What commands write: never what they read, whole or not at all, whatever becomes of the text."""

import json
import os
import subprocess
import sys

import pytest

from breaker.cli import main


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("infer drive --output drive/closing/op_1.csv", "is there already"),
        ("infer drive --output link/closing/op_1.csv", "is there already"),
        ("infer drive --output hard.csv", "is there already"),
        ("infer drive/closing/op_1.csv --output drive/../hard.csv", "is there already"),
        ("infer drive --output drive/operations.csv", "would be read as a record"),
        ("infer drive --output drive/closing/new.csv", "would be read as a record"),
        ("infer a.csv --output few.yaml", "is there already"),
        ("infer a.csv --output open.csv", "may hold work of yours"),  # a record that is not read
        ("infer a.csv --model m.safetensors --output m.safetensors", "is there already"),
        ("infer a.csv --output same.csv --plot ./same.csv", "another output of this command"),
        ("infer a.csv --plot drive", "end it in .png"),
        ("infer a.csv --output nowhere/out.csv", "there is no folder nowhere/"),
        ("infer a.csv --output pipe", "is there already"),
        ("inspect a.csv --output config/config.yaml", "is there already"),
        ("inspect a.csv --output few.yaml", "is there already"),
        ("fit-prior drive --output drive/closing/op_1.csv", "is there already"),
        ("inspect drive --output drive/closing/op_9.csv", "would be read as a record"),
        ("compare a.csv --today open.csv --plot picture.png", "end it in .png"),  # a link
    ],
)
def test_nothing_that_is_not_a_result_is_replaced(folder, capsys, words, reason):
    for each in ("drive/closing", "config"):
        (folder / each).mkdir(parents=True)
    (folder / "drive/closing/op_1.csv").write_bytes((folder / "a.csv").read_bytes())
    (folder / "hard.csv").hardlink_to(folder / "drive/closing/op_1.csv")
    (folder / "link").symlink_to("drive")
    (folder / "picture.png").symlink_to("a.csv")
    (folder / "config/config.yaml").write_text("endurance: {draws: 100}\n")
    (folder / "m.safetensors").write_bytes(b"a model")
    os.mkfifo(folder / "pipe")
    files = [each for each in folder.rglob("*") if each.is_file()]
    before = {each: each.read_bytes() for each in files}
    assert main([*words.split(), "--config", "few.yaml"]) == 1
    out, err = capsys.readouterr()
    assert reason in err
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("breaker: ")
    assert {each: each.read_bytes() for each in files} == before
    assert {each for each in folder.rglob("*") if each.is_file()} == {*files}


def test_results_replace_results_of_their_kind(folder):
    words = ["infer", "a.csv", "--output", "t.csv", "--plot", "p.png"]
    (folder / "t.csv").touch()
    assert main([*words, "--config", "few.yaml"]) == 0
    (folder / "link.csv").symlink_to("t.csv")
    first = (folder / "t.csv").read_bytes()
    assert main([*words, "--config", "few.yaml"]) == 0
    assert main(["infer", "b 2.csv", "--output", "link.csv", "--config", "few.yaml"]) == 0
    assert (folder / "link.csv").is_symlink()
    assert (folder / "t.csv").read_bytes() != first
    assert not [each for each in folder.iterdir() if each.name.startswith(".")]


def test_names_of_nothing_are_refused(folder, capsys):
    for words in (["infer", ""], ["inspect", ""], ["infer", "a.csv", "--plot", ""]):
        with pytest.raises(SystemExit) as caught:
            main(words)
        assert caught.value.code == 2
        assert "an empty text names no file" in capsys.readouterr().err


# The largest file is limited to a few blocks, as on a disk that is full. Python is not to write
# bytecode then: it keeps the part that was written, and the package cannot be loaded any more.
FULL = "import resource as r, sys; sys.dont_write_bytecode = True; "
FULL += "r.setrlimit(r.RLIMIT_FSIZE, (1500, 1500)); "
START = "import sys; from breaker.cli import run; sys.exit(run())"


def command(*words, before="", encoding="utf-8", **settings):
    """A command as a process of its own, which keeps what it prints until there is much of it."""
    environment = os.environ | {"PYTHONIOENCODING": encoding, "PYTHONUNBUFFERED": ""}
    return subprocess.run(
        [sys.executable, "-c", before + START, *words],
        **{"stderr": subprocess.PIPE, "timeout": 120, "check": False, "env": environment},
        **settings,
    )


@pytest.mark.parametrize("command_of", ["infer --output t.csv", "report --output r.html"])
def test_on_a_full_disk_the_old_result_stays(folder, command_of):
    words = [*command_of.split(), "--config", "few.yaml"]
    words.insert(1, "a.csv")
    assert main(words) == 0
    before = {each: each.read_bytes() for each in folder.rglob("*") if each.is_file()}
    done = command(*words, before=FULL)
    assert done.returncode == 1
    assert b"could not be written: File too large; make room there" in done.stderr
    assert b"Traceback" not in done.stderr
    assert {each: each.read_bytes() for each in folder.rglob("*") if each.is_file()} == before


# A write that sends its own process a signal half-way: none comes at a better time.
HALF = """
import os, signal
from pathlib import Path
signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job of a shell ignores
signal.signal(signal.SIGHUP, signal.SIG_DFL)
def half(self, content):
    with open(self, "wb") as file:
        file.write(content[: len(content) // 2])
        file.flush()
        os.kill(os.getpid(), signal.{signal})
        file.write(content[len(content) // 2 :])
Path.write_bytes = half
"""


# Every signal, and every kind of file: all are written by ``whole``, whatever ends the command.
SIGNALS = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129}
ENDED = [("SIGINT", "r.png"), ("SIGTERM", "r.html"), ("SIGHUP", "r.csv")]


@pytest.mark.parametrize(("signal", "name"), ENDED)
def test_a_command_that_is_ended_leaves_nothing_half_written(folder, signal, name):
    option = {"r.png": "--plot"}.get(name, "--output")
    command_of = "report" if name == "r.html" else "infer"
    words = [command_of, "a.csv", option, name, "--config", "few.yaml"]
    before = {*folder.rglob("*")}
    done = command(*words, before=HALF.format(signal=signal))
    assert done.returncode == SIGNALS[signal]
    assert b"Traceback" not in done.stderr
    assert {*folder.rglob("*")} == before


@pytest.mark.parametrize("stdout", ["closed", "full", "ascii"])
def test_files_are_there_whatever_becomes_of_the_text(folder, stdout):
    words = ["infer", "a.csv", "--output", "t.csv", "--config", "few.yaml"]
    if stdout == "closed":
        done = command(*words, preexec_fn=lambda: os.close(1))
    elif stdout == "full":
        with open("/dev/full", "w") as full:
            done = command(*words, stdout=full)
        assert b"breaker: the text could not be printed" in done.stderr  # at its end
    else:
        done = command(*words, "--json", encoding="ascii", stdout=subprocess.PIPE)
        assert json.loads(done.stdout)["records"][0]["accepted"]
    assert done.returncode == (1 if stdout == "full" else 0)
    assert b"Traceback" not in done.stderr
    assert b"Exception" not in done.stderr
    assert (folder / "t.csv").stat().st_size > 1000
