"""What tests of the workflow share: its commands."""

import multiprocessing
import os
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]

# A start of Snakemake takes as long to load libraries as to plan: commands are forks of one process
# that has loaded them. It has nothing of the package, which each command takes from its folder.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["snakemake.cli", "yte", "pydantic", "jsonschema", "xarray", "numba", "scipy"]
)

# So are jobs of a command, forks of one process that has loaded what takes half the time of most.
OF_JOBS = ["matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf"]
OF_JOBS += ["scipy.special", "snakemake.iocontainers", "snakemake.logging", "xarray", "zarr"]
LOST = 255  # of a job whose end the server of forks did not tell: it is then run as users run it


def command(arguments: list[str], folder: Path, source: str, environment: dict, said: str) -> None:
    """Be a command of Snakemake: in its folder, with the package of a source, output in a file."""
    os.environ.clear()
    os.environ.update(environment, PYTHONPATH=source)
    os.chdir(folder)
    sys.path.insert(0, source)
    sys.argv = ["snakemake", *arguments]
    file = os.open(said, os.O_WRONLY)
    os.dup2(file, sys.stdout.fileno())
    os.dup2(file, sys.stderr.fileno())
    from snakemake.cli import main
    from snakemake.script import PythonScript

    FORKS.set_forkserver_preload(OF_JOBS)
    original = PythonScript._execute_cmd

    def execute(script: PythonScript, template: str, *, fname: str, **more: Any) -> None:
        if fork(fname, script.bench_record) == LOST:
            original(script, template, fname=fname, **more)

    PythonScript._execute_cmd = execute
    main()


def fork(file: str, record: object) -> int:
    """Run the script of a job, and keep a record of its time and memory as Snakemake does."""
    from snakemake.benchmark import benchmarked

    process = FORKS.Process(target=job, args=(file,))
    process.start()
    with benchmarked(process.pid if record else False, record):
        process.join()
    if process.exitcode not in (0, LOST):
        raise subprocess.CalledProcessError(process.exitcode, file)
    return process.exitcode


def job(file: str) -> None:
    """Be a job: its script as the main module, an uncaught exception as it has it logged."""
    sys.argv = [file]
    try:
        runpy.run_path(file, run_name="__main__")
    except Exception:
        sys.excepthook(*sys.exc_info())
        sys.exit(1)


def snakemake(*arguments: str | Path, folder: Path = ROOT, fails: bool = False) -> str:
    """Run Snakemake in a folder, with the code there or else that of the project; what it says."""
    code = folder if (folder / "src").exists() else ROOT
    with tempfile.NamedTemporaryFile() as said:
        given = [*map(str, arguments)], folder, str(code / "src"), dict(os.environ), said.name
        process = FORKS.Process(target=command, args=given)
        process.start()
        process.join()
        text = Path(said.name).read_text(encoding="utf-8")
    assert bool(process.exitcode) == fails, text[-5000:]
    return text
