"""What a job does first: its messages and its errors reach the log file and stderr."""

import subprocess
import sys

import pytest

from breaker.workflow.jobs import chunks_of

HEADER = """
import sys
from types import SimpleNamespace
{first}
from breaker.workflow.jobs import start
job = SimpleNamespace(log=[{log!r}], rule="read_curves", threads={threads})
log = start(job)
"""


@pytest.fixture
def log(tmp_path):
    return tmp_path / "read_curves.log"


def run(log, script, *, first="", threads=1):
    """Run a script that starts a job, in a process of its own: logging is global."""
    text = HEADER.format(first=first, log=str(log), threads=threads) + script
    return subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=60, check=False
    )


def test_messages_go_to_the_log_file_in_place_of_old_ones_and_to_stderr(log):
    """Those of the job, and those of the package itself."""
    log.write_text("old", encoding="utf-8")
    script = 'log.info("3 of 500 operations rejected"); print("numba" in sys.modules)\n'
    done = run(log, script + 'import logging; logging.getLogger("breaker").warning("no file")')
    assert done.returncode == 0
    assert done.stdout == "False\n"  # which a job that does not use it does not load
    first, second = done.stderr.splitlines()
    assert first.endswith(" read_curves: 3 of 500 operations rejected")
    assert second.endswith(" read_curves: no file")
    assert log.read_text(encoding="utf-8") == done.stderr


def test_an_uncaught_exception_is_logged_with_its_traceback_and_fails_the_job(log):
    done = run(log, 'def compute():\n    raise ValueError("no curve at all")\ncompute()')
    assert done.returncode == 1
    text = log.read_text(encoding="utf-8")
    assert text == done.stderr
    assert "read_curves: ValueError: no curve at all" in text
    assert "Traceback (most recent call last)" in text
    assert "in compute" in text


def test_numba_itself_takes_them_and_torch_keeps_its_own(log, monkeypatch):
    """Two trainings of two threads each, on two cores, are fifteen times slower than of one."""
    monkeypatch.setenv("OMP_NUM_THREADS", "1")  # as Snakemake does
    first = "import numba, torch; torch.get_num_threads()"
    done = run(log, "print(numba.get_num_threads(), torch.get_num_threads())", first=first)
    assert done.stdout == "1 1\n"


# ---- chunks of operations ------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1, 7, 20])
def test_appended_operations_change_their_own_chunks_alone(size):
    before = chunks_of([*range(1, 31), 40], size)
    after = chunks_of([*range(1, 31), 40, 41, 42], size)
    last = list(before)[-1]
    assert {name: after[name] for name in before if name != last} == {
        name: before[name] for name in before if name != last
    }
    assert [number for some in after.values() for number in some] == [*range(1, 31), 40, 41, 42]
