"""Test the instrument, without torch and Snakemake, under each version of Python that is here.

Called by ``make test-pythons``, from the project's folder. A wheel is built once. Each version gets
an environment of its own, with the pinned packages, and runs the tests of rooms that need no torch.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from lock import closure
from wheel_check import ROOT, asked, fresh, installed, run

VERSIONS = ("3.11", "3.12", "3.13", "3.14")
NEEDED = ["h5netcdf", "packaging", "pytest"]
TESTS = ("tests/common", "tests/records", "tests/model")


def interpreter(version: str) -> str | None:
    """Return the interpreter of a version; None if there is none that runs."""
    name, home = f"python{version}", Path.home()
    places = (home / ".pyenv/versions", home / ".local/share/uv/python")  # beside the path
    result = [file for place in places for file in place.glob(f"*{version}.*/bin/{name}")]
    for item in filter(None, [shutil.which(name), *map(str, sorted(result))]):
        if not subprocess.run([item, "-m", "venv", "--help"], capture_output=True).returncode:
            return item
    return None


def main() -> int:
    """Test each version, and say which was tried."""
    _, wheel = fresh()
    names = asked(wheel, "excel", "fast", "netcdf", "stores") | closure(NEEDED)
    alone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    failed = 0
    for version in VERSIONS:
        if (result := interpreter(version)) is None:
            print(f"Python {version}: not here, not tried")
            continue
        python = installed(wheel, names, ROOT / "build" / "pythons" / version, result)
        done = subprocess.run([python, "-m", "pytest", "--quiet", *TESTS], cwd=ROOT, env=alone)
        failed += done.returncode != 0
        said = run(python, "--version").strip()
        print(f"{said}: {'tests failed' if done.returncode else 'tests passed'}", flush=True)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
