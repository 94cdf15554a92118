"""The command: usage, errors in one line, interrupts, closed pipes, and what it imports."""

import subprocess
import sys

import pytest

from breaker.cli import infer, main
from tests.cli.conftest import written

HEAVY = {"torch", "numba", "xarray", "scipy", "pandas", "zarr", "matplotlib", "numpy"}
RULES = "model.parameters model.limits records.files configuration.loading workflow.jobs"
# Each takes 0.1 to 1 s to load, and the first result is to be there in one second.
UNUSED = {"torch", "numba", "matplotlib", "zarr", "snakemake", "xarray", "pandas"}
UNUSED |= {"scipy.special", "scipy.ndimage", "scipy.signal"}
UNUSED |= {f"breaker.records.formats.{name}" for name in ("comtrade", "excel", "lines")}


def run(*arguments, **about):
    """Run Python in a process of its own."""
    about = {"capture_output": True, "text": True, "timeout": 120} | about
    return subprocess.run([sys.executable, *arguments], check=False, **about)


@pytest.mark.parametrize(
    ("arguments", "usage"),
    [([], ""), (["infer"], " infer"), (["infer", "a.csv", "--jsn"], " infer"), (["learn"], "")],
)
def test_wrong_options_show_the_usage(capsys, arguments, usage):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert f"usage: breaker{usage} [-h]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("script", "unused"),
    [
        ("breaker.cli.command", HEAVY),  # numpy reads the number of threads when it is loaded
        ("main(['infer', '--help'])", HEAVY - {"numpy"}),
        ("main(['infer', 'closing.csv'])", UNUSED),
        (RULES, HEAVY - {"numpy"}),  # what Snakemake loads to plan
    ],
    ids=["start", "help", "infer", "rules"],
)
def test_nothing_is_loaded_before_it_is_needed(tmp_path, prior, script, unused):
    written(tmp_path / "closing.csv", prior, "closing")
    if not script.startswith("main"):
        names = [f"breaker.{name.removeprefix('breaker.')}" for name in script.split()]
        script = "; ".join(f"import {name}" for name in names)
    code = "import atexit, sys; atexit.register(lambda: print('loaded:', *sys.modules))\n"
    code += "from breaker.cli import main\n" if script.startswith("main") else ""
    done = run("-c", code + script, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert not unused & {*done.stdout.rpartition("loaded:")[2].split()}


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (KeyboardInterrupt(), 130, "breaker: interrupted\n"),
        (ModuleNotFoundError("No module", name="torch"), 1, ".[networks]"),
        (PermissionError(13, "Permission denied", "a.csv"), 1, "denied: 'a.csv'"),
        (MemoryError(), 1, "endurance.draws"),
    ],
)
def test_what_ends_a_command_is_one_line(capsys, monkeypatch, error, status, words):
    def fail(_):
        raise error

    monkeypatch.setattr(infer, "run", fail)
    assert main(["infer", "a.csv"]) == status
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1


def test_a_reader_that_leaves_is_no_error_of_the_command():
    """As in `breaker infer ... | head`."""
    script = (
        "import sys; from breaker.cli import infer, main\n"
        "infer.run = lambda _: print('text ' * 10**6) or 0\n"
        "sys.exit(main(['infer', 'file']))"
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", script], **pipes) as command:
        command.stdout.close()
        assert command.wait(timeout=60) == 141
        assert command.stderr.read() == b""
