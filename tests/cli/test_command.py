"""The command as a whole: usage, errors in one line, interrupts, closed pipes, its imports."""

import gc
import signal
import subprocess
import sys

import h5py
import numpy as np
import pytest

from breaker.cli import command, infer, inspect, main
from tests.cli.conftest import written


@pytest.mark.parametrize("arguments", [[], ["infer"], ["infer", "--json"], ["learn"]])
def test_wrong_options_show_the_usage(capsys, arguments):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "usage: breaker" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--help"], ["infer", "--help"]])
def test_help_answers_without_what_infers(arguments):
    script = (
        "import atexit, sys; from breaker.cli import main\n"
        "heavy = {'torch', 'pandas', 'xarray', 'numba'}\n"
        "atexit.register(lambda: print('imported:', sorted(heavy & set(sys.modules))))\n"
        f"main({arguments})"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0
    assert done.stdout.startswith("usage: breaker")
    assert done.stdout.endswith("imported: []\n")


@pytest.mark.parametrize("words", ["--help", "--version", "infer --help", "report --help"])
def test_a_full_output_is_one_line(words):
    command = [sys.executable, "-m", "breaker", *words.split()]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, timeout=60, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith(b"breaker: the text could not be printed")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("damage", ["cut", "circle"])
def test_a_damaged_store_ends_the_command_in_order(tmp_path, damage):
    """HDF5 crashed as the process ended, after the right message."""
    file = tmp_path / "a.nc"
    with h5py.File(file, "w") as store:
        store["travel"] = np.arange(600.0)
        if damage == "circle":
            store["time"] = h5py.SoftLink("/time")
    if damage == "cut":
        file.write_bytes(file.read_bytes()[:3000])
    command = [sys.executable, "-m", "breaker", "inspect", str(file)]
    done = subprocess.run(command, capture_output=True, timeout=60, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith(b"breaker: ")


def test_an_answer_loads_nothing_that_it_does_not_need(tmp_path, prior):
    """Each of these takes a tenth to one second: the first answer is to be there in one."""
    file = tmp_path / "closing.csv"
    written(file, prior, "closing")
    script = (
        "import sys; from breaker.cli import main\n"
        f"status = main(['infer', {str(file)!r}])\n"
        "heavy = 'torch', 'matplotlib', 'zarr', 'snakemake'\n"
        "heavy += 'xarray', 'pandas', 'scipy.special', 'scipy.ndimage', 'scipy.signal'\n"
        "formats = 'comtrade', 'excel', 'lines', 'netcdf'\n"
        "heavy += *(f'breaker.records.formats.{name}' for name in formats),\n"
        "print('imported:', status, sorted({*heavy} & {*sys.modules}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        **{"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 120, "check": False},
    )
    assert done.stdout.endswith("imported: 0 []\n"), done.stdout[-500:] + done.stderr[-500:]


@pytest.mark.parametrize(
    ("command", "error", "status", "words"),
    [
        (infer, KeyboardInterrupt(), 130, "breaker: interrupted\n"),
        (infer, ModuleNotFoundError("No module", name="torch"), 1, "breaker-drive[networks]"),
        (infer, PermissionError(13, "Permission denied", "a.csv"), 1, "denied: 'a.csv'"),
        (infer, MemoryError(), 1, "memory; name fewer files, or lower endurance.draws\n"),
        (inspect, MemoryError(), 1, "memory; export the record with fewer channels\n"),
    ],
)
def test_what_ends_a_command_is_one_line(capsys, monkeypatch, command, error, status, words):
    def run(_):
        raise error

    monkeypatch.setattr(command, "run", run)
    assert main([command.__name__.rpartition(".")[2], "a.csv"]) == status
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


def test_numpy_comes_after_the_number_of_its_threads():
    """It reads that when it is loaded, and never again; and without it, --help is quick."""
    code = "import sys, breaker.cli.command; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_a_machine_without_a_hangup_ends_in_order_too(monkeypatch):
    """As Windows: planted fault, every command ended with an AttributeError before it began."""
    taken = []
    monkeypatch.delattr(signal, "SIGHUP")
    monkeypatch.setattr(signal, "getsignal", lambda _: signal.SIG_DFL)
    monkeypatch.setattr(signal, "signal", lambda number, _: taken.append(number))
    monkeypatch.setattr(command, "main", lambda: 0)
    for name in ("disable", "freeze"):
        monkeypatch.setattr(gc, name, lambda: None)
    assert command.run() == 0
    assert taken == [signal.SIGTERM]
