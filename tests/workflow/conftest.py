"""What tests of the workflow share: its commands."""

import multiprocessing
import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# A start of Snakemake takes as long to load libraries as to plan: commands are forks of one process
# that has loaded them. It has nothing of the package, which each command takes from its folder.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(["snakemake.cli", "yte", "jsonschema", "xarray", "numba", "scipy"])


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

    main()


def snakemake(*arguments: str | Path, folder: Path = ROOT, fails: bool = False) -> str:
    """Run Snakemake in a folder, with the code there or else that of the project; what it says."""
    code = folder if (folder / "src").exists() else ROOT
    with tempfile.NamedTemporaryFile() as said:
        told = [*map(str, arguments)], folder, str(code / "src"), dict(os.environ), said.name
        process = FORKS.Process(target=command, args=told)
        process.start()
        process.join()
        text = Path(said.name).read_text(encoding="utf-8")
    assert bool(process.exitcode) == fails, text[-5000:]
    return text
