"""What tests of the workflow share: its commands."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def snakemake(*arguments: str | Path, folder: Path = ROOT, fails: bool = False) -> str:
    """Run Snakemake in a folder, with the code there or else that of the project; what it says."""
    code = folder if (folder / "src").exists() else ROOT
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(code / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert bool(done.returncode) == fails, done.stderr[-5000:]
    return done.stdout + done.stderr
