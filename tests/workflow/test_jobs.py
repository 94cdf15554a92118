"""The start of a job: messages and errors reach its log file and stderr; and chunks."""

import subprocess
import sys

import pytest

from breaker.workflow.jobs import chunks_of

HEADER = """
import sys
from types import SimpleNamespace
{first}
from breaker.workflow.jobs import start
log = start(SimpleNamespace(log=[{log!r}], rule="read_curves", threads=1))
"""


def run(log, script, *, first=""):
    """Run a script that starts a job, in a process of its own: logging is global."""
    text = HEADER.format(first=first, log=str(log)) + script
    return subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=60, check=False
    )


def test_messages_and_an_exception_replace_the_log_file_and_go_to_stderr(tmp_path):
    """Those of the job, and those of the package itself."""
    log = tmp_path / "read_curves.log"
    log.write_text("old", encoding="utf-8")
    script = 'log.info("3 of 500 operations rejected"); print("numba" in sys.modules)\n'
    script += 'import logging; logging.getLogger("breaker").warning("no file")\n'
    done = run(log, script + 'def compute():\n    raise ValueError("no curve at all")\ncompute()')
    assert done.returncode == 1
    assert done.stdout == "False\n"  # which a job that does not use it does not load
    assert log.read_text(encoding="utf-8") == done.stderr
    first, second, third, *trace = done.stderr.splitlines()
    assert first.endswith(" read_curves: 3 of 500 operations rejected")
    assert second.endswith(" read_curves: no file")
    assert third.endswith(" read_curves: ValueError: no curve at all")
    assert any("in compute" in line for line in trace)


def test_numba_itself_takes_the_threads_and_torch_keeps_its_own(tmp_path, monkeypatch):
    """Two trainings of two threads each, on two cores, are fifteen times slower than of one."""
    monkeypatch.setenv("OMP_NUM_THREADS", "1")  # as Snakemake does
    script = "print(numba.get_num_threads(), torch.get_num_threads())"
    done = run(tmp_path / "log", script, first="import numba, torch; torch.get_num_threads()")
    assert done.stdout == "1 1\n"


@pytest.mark.parametrize("size", [1, 7, 20])
def test_appended_operations_change_their_own_chunks_alone(size):
    before = chunks_of([*range(1, 31), 40], size)
    after = chunks_of([*range(1, 31), 40, 41, 42], size)
    *kept, _ = before
    assert {name: after[name] for name in kept} == {name: before[name] for name in kept}
    assert [number for some in after.values() for number in some] == [*range(1, 31), 40, 41, 42]
