"""Build the wheel and the source distribution, check both, and use the wheel in a new environment.

Run by ``make dist``, from the project's folder. The build fetches nothing. The packages that the
wheel requires, at the versions of the lock, come from pip: its cache, or the index.
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from email import message_from_bytes
from pathlib import Path

from lock import closure
from packaging.requirements import Requirement

__all__ = ["asked", "build", "faults", "fresh", "installed", "metadata_of", "run"]

ROOT = Path(__file__).resolve().parents[1]
DIST, BARE = ROOT / "dist", ROOT / "build" / "bare"
_BUILD = (
    "import sys; from setuptools import build_meta; out = sys.argv[1]; "
    "build_meta.build_sdist(out); build_meta.build_wheel(out)"
)
# Files other than code, which are easily left out.
_NEEDED = ("py.typed", "records/words.yaml", "diagnosis/sentences.yaml")
_NEEDED += ("shipped/families/any.yaml", "shipped/MODEL_CARD.md")
_DOCS = ROOT / "docs"


def build(folder: Path, out: Path) -> tuple[Path, Path]:
    """Build in a folder of the project, without a network; return source distribution and wheel.

    Raises:
        subprocess.CalledProcessError: If the build fails; contains its output.
    """
    out.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-c", _BUILD, str(out)]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return next(out.glob("*.tar.gz")), next(out.glob("*.whl"))


def metadata_of(wheel: Path):
    """Return the metadata of a wheel, by the names of the standard."""
    with zipfile.ZipFile(wheel) as opened:
        (name,) = (item for item in opened.namelist() if item.endswith(".dist-info/METADATA"))
        return message_from_bytes(opened.read(name))


def faults(source: Path, wheel: Path) -> list[str]:
    """Return the problems of both files, in words."""
    wrong, about = [], metadata_of(wheel)
    with zipfile.ZipFile(wheel) as opened:
        inside = set(opened.namelist())
    with tarfile.open(source) as opened:
        unpacked = {name.partition("/")[2] for name in opened.getnames()}
    needed = [f"breaker/{name}" for name in _NEEDED]
    wrong += [f"the wheel lacks {name}" for name in needed if name not in inside]
    wrong += [f"the source lacks src/{name}" for name in needed if f"src/{name}" not in unpacked]
    if not any(name.endswith(".dist-info/licenses/LICENSE") for name in inside):
        wrong.append("the wheel lacks its licence")
    if "LICENSE" not in unpacked:
        wrong.append("the source lacks its licence")
    others = {name.split("/")[0] for name in inside} - {"breaker"}
    wrong += [f"{name} is beside the package" for name in others if ".dist-info" not in name]
    wrong += [f"{name} is no file of a package" for name in inside if name.endswith(".pyc")]
    asked = ("License-Expression", "Requires-Python", "Summary", "Description-Content-Type")
    wrong += [f"the metadata lack {name}" for name in asked if not about[name]]
    return wrong


def run(*command: str | Path, folder: Path = ROOT) -> str:
    """Run a command and return its output; exit with the output if it fails."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def asked(wheel: Path, *extras: str) -> set[str]:
    """Return the packages that a wheel with extras requires, and their dependencies."""
    about = metadata_of(wheel)
    stated = [*map(Requirement, about.get_all("Requires-Dist"))]
    result, tried, wanted = set(), set(), {"", *extras}
    while wanted - tried:
        environments = [{"extra": extra} for extra in wanted]
        tried |= wanted
        for item in stated:
            if item.marker is None or any(map(item.marker.evaluate, environments)):
                own = item.name == about["Name"]  # an extra that includes others
                wanted = wanted | item.extras if own else wanted
                result |= set() if own else {item.name}
    return closure(result)


def installed(wheel: Path, names: set[str], folder: Path, python: str = sys.executable) -> Path:
    """Install a wheel and pinned packages into a new environment; return its interpreter."""
    entries = re.split(r"^(?=\S)", (ROOT / "envs/requirements.lock").read_text(), flags=re.M)
    pins = [entry for entry in entries if entry.split("==")[0] in names]
    shutil.rmtree(folder, ignore_errors=True)
    run(python, "-m", "venv", folder)
    (folder / "pins.txt").write_text("".join(pins), encoding="utf-8")
    install = (folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-deps")
    run(*install, "--require-hashes", "--requirement", folder / "pins.txt")
    run(*install, "--no-index", wheel)
    return folder / "bin" / "python"


def _sizes(python: Path) -> str:
    """Return the sizes of installed packages without pip, in MB, the largest first."""
    say = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(run(python, "-c", say).strip())
    sizes: dict[str, int] = {}
    for file in site.rglob("*"):
        top = file.relative_to(site).parts[0]
        if file.is_file() and not top.startswith(("pip", "setuptools")):
            sizes[top] = sizes.get(top, 0) + file.stat().st_size
    rows = sorted(sizes.items(), key=lambda item: -item[1])
    listed = ", ".join(f"{name} {size / 1e6:.0f}" for name, size in rows if size > 4e6)
    return f"{sum(sizes.values()) / 1e6:.0f} MB installed: {listed}"


def _walked(python: Path) -> str:
    """Run the commands of pages in an empty folder, and check their output."""
    sys.path.insert(0, str(_DOCS))
    import walk

    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    count = 0
    for page in walk.PAGES:
        with tempfile.TemporaryDirectory() as empty:
            for step, output in walk.run(page.read_text("utf-8"), Path(empty), python, clean):
                count += 1
                for shown in step.shown:
                    walk.as_printed(shown, output)
    return f"{count} steps of pages in empty folders, without torch: as the pages show"


def fresh() -> tuple[Path, Path]:
    """Build in a copy of the project, without files of an earlier build."""
    shutil.rmtree(DIST, ignore_errors=True)
    with tempfile.TemporaryDirectory() as copy:
        for name in ("LICENSE", "README.md", "pyproject.toml"):
            shutil.copy(ROOT / name, copy)
        skipped = shutil.ignore_patterns("*.egg-info", "__pycache__")
        shutil.copytree(ROOT / "src", Path(copy) / "src", ignore=skipped)
        return build(Path(copy), DIST)


def main() -> None:
    """Build, check, install and use the wheel, and print the results."""
    source, wheel = fresh()
    if wrong := faults(source, wheel):
        sys.exit("\n".join(wrong))
    if importlib.util.find_spec("twine"):
        print(run(sys.executable, "-m", "twine", "check", "--strict", source, wheel).strip())
    for file in (source, wheel):
        print(f"dist/{file.name}: {file.stat().st_size / 1e6:.1f} MB")
    python = installed(wheel, asked(wheel), BARE)
    if run(python, "-m", "pip", "list").count("torch"):
        sys.exit("the wheel brings torch")
    print(_walked(python))
    print(_sizes(python))


if __name__ == "__main__":
    main()
