"""Write ``requirements.lock``, ``breaker.yaml`` and ``slurm.lock`` from the installed packages.

The first two pin the requirements of ``pyproject.toml`` and their dependencies, the third the
additional packages of its extra ``slurm``. Other packages in the environment are left out.
``site.lock`` is written from ``site.in``, for a separate environment. Run by ``make lock``.
"""

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from itertools import chain
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

__all__ = ["CARDS", "closure", "conda_environment", "direct", "hashed", "versions"]

FOLDER = Path(__file__).resolve().parent

# Packages that torch's wheel for graphics cards needs on Linux, at versions that it pins itself.
# They take gigabytes, and a wheel for the CPU and macOS do not need them, so no lock names them.
CARDS = re.compile(r"(cuda|nvidia)-.*|triton")

LOCK_HEADER = """\
# Every package of the environment at its tested version, for Linux and macOS, Python 3.11 or newer,
# with the SHA-256 of each file of that release on the public index: pip refuses any other.
# Written by `make lock`, together with breaker.yaml; not edited by hand. pip adds what torch itself
# pins for a graphics card (on Linux, where its wheel is not the one for the CPU alone).
"""

SLURM_HEADER = """\
# What Snakemake needs besides requirements.lock for jobs through Slurm. Written by `make lock`.
"""

SITE_HEADER = """\
# What `make site` needs, from site.in. Written by `make lock`; not edited by hand.
"""

CONDA_HEADER = """\
# The environment of every rule for `snakemake --sdm conda`: the versions of requirements.lock,
# by pip, as torch is. Written by `make lock`, together with requirements.lock; not edited by hand.
# Without hashes: pip checks all or none, and could then not add what torch pins.
channels:
  - conda-forge
  - nodefaults
dependencies:
  - python=3.11
  - pip
  - pip:
"""


def direct(pyproject: Path) -> tuple[list[Requirement], list[Requirement]]:
    """Return the requirements in ``pyproject.toml``: to run, test and build, and of ``slurm``.

    References of an extra to other extras of the package are left out, because these extras are
    included.
    """
    content = tomllib.loads(pyproject.read_text(encoding="utf-8"))
    project, build = content["project"], content["build-system"]["requires"]
    extras = project["optional-dependencies"]
    slurm = extras.pop("slurm")
    stated = map(Requirement, chain(project["dependencies"], *extras.values(), build))
    own = [requirement for requirement in stated if requirement.name != project["name"]]
    return own, list(map(Requirement, slurm))


def closure(names: Iterable[str]) -> set[str]:
    """Return packages and their dependencies, except for graphics cards, as canonical names.

    Raises:
        importlib.metadata.PackageNotFoundError: If a package is not installed.
    """
    result: set[str] = set()
    waiting = [canonicalize_name(name) for name in names]
    while waiting:
        name = waiting.pop()
        if name in result or CARDS.fullmatch(name):
            continue
        result.add(name)
        for requirement in map(Requirement, metadata.requires(name) or []):
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                waiting.append(canonicalize_name(requirement.name))
    return result


def hashed(names: Iterable[str]) -> str:
    """Return the lock's lines for installed packages, pinned with the hashes of their files.

    uv asks only the public index for hashes, whatever other places pip is set to search, because
    other machines would refuse local files. So local version labels are removed, too.
    """
    pins = "\n".join(f"{name}=={Version(metadata.version(name)).public}" for name in names)
    return _compiled("-", "--no-deps", stated=pins)


def _compiled(file: str, *more: str, stated: str | None = None) -> str:
    options = ["--generate-hashes", "--universal", "--no-header", "--no-annotate", *more]
    command = [sys.executable, "-m", "uv", "--quiet", "pip", "compile", file, *options]
    done = subprocess.run(command, input=stated, stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout


def versions(lock: str) -> dict[str, str]:
    """Return the versions by canonical name in the text of a lock."""
    return dict(re.findall(r"^([^#\s]+)==(\S+)", lock, flags=re.MULTILINE))


def conda_environment(lock: str) -> str:
    """Return the text of the conda environment for the text of a lock."""
    pins = (f"      - {name}=={version}\n" for name, version in versions(lock).items())
    return CONDA_HEADER + "".join(pins)


def main() -> None:
    """Write all four files."""
    needed, with_slurm = (
        closure(requirement.name for requirement in stated)
        for stated in direct(FOLDER.parent / "pyproject.toml")
    )
    lock = LOCK_HEADER + "\n" + hashed(needed)
    (FOLDER / "requirements.lock").write_text(lock, encoding="utf-8")
    (FOLDER / "breaker.yaml").write_text(conda_environment(lock), encoding="utf-8")
    slurm = SLURM_HEADER + "\n" + hashed(with_slurm - needed)
    (FOLDER / "slurm.lock").write_text(slurm, encoding="utf-8")
    site = SITE_HEADER + "\n" + _compiled(str(FOLDER / "site.in"), "--python-version", "3.11")
    (FOLDER / "site.lock").write_text(site, encoding="utf-8")


if __name__ == "__main__":
    main()
