"""Write ``requirements.lock`` and ``breaker.yaml`` from what is installed.

Both name the same exact versions: of what ``pyproject.toml`` asks for, and of all that those need.
Anything else in the environment is left out. Called by ``make lock``.
"""

import re
import tomllib
from collections.abc import Iterable
from importlib import metadata
from itertools import chain
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

__all__ = ["closure", "conda_environment", "direct", "pins", "requirements"]

FOLDER = Path(__file__).resolve().parent

LOCK_HEADER = """\
# Every package of the environment at its tested version, for Linux and macOS, Python 3.11 or newer.
# Written by `make lock`, together with breaker.yaml; not edited by hand. pip adds what torch itself
# pins for a graphics card (on Linux, where its wheel is not the one for the CPU alone).
"""

CONDA_HEADER = """\
# The environment of every rule for `snakemake --sdm conda`: the versions of requirements.lock,
# by pip, as torch is. Written by `make lock`, together with requirements.lock; not edited by hand.
channels:
  - conda-forge
  - nodefaults
dependencies:
  - python=3.11
  - pip
  - pip:
"""


def direct(pyproject: Path) -> dict[str, list[Requirement]]:
    """Return the requirements that ``pyproject.toml`` states, by what they are for.

    An extra may name others of the package itself; these are stated by themselves.
    """
    content = tomllib.loads(pyproject.read_text(encoding="utf-8"))
    project, build = content["project"], content["build-system"]["requires"]
    extras = project["optional-dependencies"]
    run = [extras.pop(name) for name in ("networks", "workflow")]
    groups = {
        "to run": [*project["dependencies"], *chain(*run)],
        "to test": [*chain(*extras.values())],
        "to build": build,
    }
    found = {name: [Requirement(text) for text in texts] for name, texts in groups.items()}
    return {
        name: [each for each in stated if each.name != project["name"]]
        for name, stated in found.items()
    }


def closure(names: Iterable[str]) -> set[str]:
    """Return the packages and all that they need here, as canonical names.

    Raises:
        importlib.metadata.PackageNotFoundError: If one of them is not installed.
    """
    found: set[str] = set()
    waiting = [canonicalize_name(name) for name in names]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        for requirement in map(Requirement, metadata.requires(name) or []):
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                waiting.append(canonicalize_name(requirement.name))
    return found


def pins(names: Iterable[str]) -> list[str]:
    """Return ``name==version`` of installed packages, sorted, without local version labels."""
    return [f"{name}=={Version(metadata.version(name)).public}" for name in sorted(names)]


def requirements(groups: dict[str, list[str]]) -> str:
    """Return the text of the lock from pins by group."""
    parts = (f"\n# {name}\n" + "".join(f"{pin}\n" for pin in pins) for name, pins in groups.items())
    return LOCK_HEADER + "".join(parts)


def conda_environment(lock: str) -> str:
    """Return the text of the conda environment for the text of a lock."""
    names = re.findall(r"^[^#\s].*$", lock, flags=re.MULTILINE)
    return CONDA_HEADER + "".join(f"      - {pin}\n" for pin in names)


def main() -> None:
    """Write both files."""
    groups = {
        name: {canonicalize_name(requirement.name) for requirement in stated}
        for name, stated in direct(FOLDER.parent / "pyproject.toml").items()
    }
    stated = set().union(*groups.values())
    groups["needed by these"] = closure(stated) - stated
    lock = requirements({name: pins(names) for name, names in groups.items()})
    (FOLDER / "requirements.lock").write_text(lock, encoding="utf-8")
    (FOLDER / "breaker.yaml").write_text(conda_environment(lock), encoding="utf-8")


if __name__ == "__main__":
    main()
