"""What commands write: never what they read, all or nothing, whatever becomes of the text."""

import json
import os
import subprocess
import sys

import pytest

from breaker.cli import main
from breaker.cli.outputs import whole


def files_in(folder):
    """Contents of all regular files below a folder."""
    return {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize(
    "words",
    [
        "infer link --output link/closing/op_1.csv",
        "infer drive/closing/op_1.csv --output drive/../hard.csv",
        "infer drive --output drive/operations.csv",  # would be read as a record
        "infer drive --output drive/closing/new.csv",
        "infer a.csv --output few.yaml",
        "infer a.csv --output open.csv",  # a record that is not read
        "infer a.csv --model m.safetensors --output m.safetensors",
        "infer a.csv --output same.csv --plot ./same.csv",
        "infer a.csv --plot drive",
        "infer a.csv --output nowhere/out.csv",
        "infer a.csv --output pipe",
        "inspect a.csv --output config/config.yaml",
        "fit-prior drive --output drive/closing/op_1.csv",
        "inspect drive --output drive/closing/op_9.csv",
        "compare a.csv --today open.csv --plot picture.png",  # a link to a record
    ],
)
def test_only_a_result_is_replaced(folder, capsys, words):
    for name in ("drive/closing", "config"):
        (folder / name).mkdir(parents=True)
    (folder / "drive/closing/op_1.csv").write_bytes((folder / "a.csv").read_bytes())
    (folder / "hard.csv").hardlink_to(folder / "drive/closing/op_1.csv")
    (folder / "link").symlink_to("drive")
    (folder / "picture.png").symlink_to("a.csv")
    (folder / "config/config.yaml").write_text("endurance: {draws: 100}\n")
    (folder / "m.safetensors").write_bytes(b"a model")
    os.mkfifo(folder / "pipe")
    before = files_in(folder)
    assert main([*words.split(), "--config", "few.yaml"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
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


# The largest file is limited to a few blocks, as on a disk that is full. Python is not to write
# bytecode then: it keeps the part that was written, and the package cannot be loaded any more.
FULL = "import resource as r, sys; sys.dont_write_bytecode = True; "
FULL += "r.setrlimit(r.RLIMIT_FSIZE, (1500, 1500)); "
START = "import sys; from breaker.cli import run; sys.exit(run())"
INFER = ["infer", "a.csv", "--output", "t.csv", "--config", "few.yaml"]


def command(*words, before="", encoding="utf-8", **settings):
    """A command as a process of its own, which keeps what it prints until there is much of it."""
    environment = os.environ | {"PYTHONIOENCODING": encoding, "PYTHONUNBUFFERED": ""}
    return subprocess.run(
        [sys.executable, "-c", before + START, *words],
        **{"stderr": subprocess.PIPE, "timeout": 120, "check": False, "env": environment},
        **settings,
    )


def test_on_a_full_disk_the_old_result_stays(folder):
    assert main(INFER) == 0
    before = files_in(folder)
    done = command(*INFER, before=FULL)
    assert done.returncode == 1
    assert b"File too large" in done.stderr
    assert b"Traceback" not in done.stderr
    assert files_in(folder) == before


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
@pytest.mark.parametrize(
    ("signal", "status", "words"),
    [
        ("SIGINT", 130, "infer a.csv --plot r.png"),
        ("SIGTERM", 143, "report a.csv --output r.html"),
        ("SIGHUP", 129, "infer a.csv --output r.csv"),
    ],
)
def test_a_command_that_is_ended_leaves_nothing_half_written(folder, signal, status, words):
    before = {*folder.rglob("*")}
    done = command(*words.split(), "--config", "few.yaml", before=HALF.format(signal=signal))
    assert done.returncode == status
    assert b"Traceback" not in done.stderr
    assert {*folder.rglob("*")} == before


@pytest.mark.parametrize("stdout", ["closed", "full", "ascii"])
def test_files_are_there_whatever_becomes_of_the_text(folder, stdout):
    if stdout == "closed":
        done = command(*INFER, preexec_fn=lambda: os.close(1))
    elif stdout == "full":
        with open("/dev/full", "w") as full:
            done = command(*INFER, stdout=full)
    else:
        done = command(*INFER, "--json", encoding="ascii", stdout=subprocess.PIPE)
        assert json.loads(done.stdout)["records"][0]["accepted"]
    assert done.returncode == (1 if stdout == "full" else 0)
    assert b"Traceback" not in done.stderr
    assert b"Exception" not in done.stderr
    assert (folder / "t.csv").stat().st_size > 1000


# ---- files and folders that appear complete or not at all ----------------------------------------


@pytest.mark.parametrize("folder", [False, True])
@pytest.mark.parametrize("error", [None, OSError(28, "No space left"), KeyboardInterrupt()])
def test_an_old_result_stays_until_all_is_written(tmp_path, error, folder):
    """And keeps its permissions."""
    target = tmp_path / ("a" * 255)
    old, new = (target / "old", target / "new") if folder else (target, target)
    if folder:
        target.mkdir()
    old.write_text("old")
    old.chmod(0o440)

    def write():
        with whole(target) as part:
            if folder:
                part.mkdir()
            (part / "new" if folder else part).write_text("new")
            assert old.read_text() == "old"
            if error:
                raise error

    if error:
        with pytest.raises(type(error)):
            write()
    else:
        write()
    assert os.listdir(tmp_path) == [target.name]
    assert (old if error else new).read_text() == ("old" if error else "new")
    if folder:
        assert os.listdir(target) == ["old" if error else "new"]
    else:
        assert target.stat().st_mode & 0o777 == 0o440
