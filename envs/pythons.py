"""Test the package, without torch and Snakemake, with each version of Python on this machine.

Run by ``make test-pythons``, from the project's folder. A wheel is built once. Each version gets
its own environment, with the pinned packages, and runs the tests of folders that need no torch.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from lock import closure
from wheel_check import ROOT, asked, fresh, installed, run

VERSIONS = ("3.11", "3.12", "3.13", "3.14")
NEEDED = ["packaging", "pytest"]
TESTS = ("tests/common", "tests/records", "tests/model")


def interpreter(version: str) -> str | None:
    """Return a working interpreter of a version, or None."""
    name, home = f"python{version}", Path.home()
    places = (home / ".pyenv/versions", home / ".local/share/uv/python")  # in addition to the path
    result = [file for place in places for file in place.glob(f"*{version}.*/bin/{name}")]
    for item in filter(None, [shutil.which(name), *map(str, sorted(result))]):
        if not subprocess.run([item, "-m", "venv", "--help"], capture_output=True).returncode:
            return item
    return None


def main() -> int:
    """Test each version, and print the results."""
    _, wheel = fresh()
    names = asked(wheel, "excel", "fast", "stores") | closure(NEEDED)
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    failed = 0
    for version in VERSIONS:
        if (result := interpreter(version)) is None:
            print(f"Python {version}: not here, not tried")
            continue
        python = installed(wheel, names, ROOT / "build" / "pythons" / version, result)
        done = subprocess.run([python, "-m", "pytest", "--quiet", *TESTS], cwd=ROOT, env=clean)
        failed += done.returncode != 0
        name = run(python, "--version").strip()
        print(f"{name}: {'tests failed' if done.returncode else 'tests passed'}", flush=True)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
