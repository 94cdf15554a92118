"""Distributions with entry points, as they lie on a path when they are installed."""

import re
import tomllib
from pathlib import Path

CONTRACT = Path(__file__).parents[1] / "records" / "format_contract.py"
PAGE = Path(__file__).parents[2] / "docs" / "library.md"
_BLOCK = re.compile(r"```\w+\n# (\S+)\n(.*?)```", re.DOTALL)


def blocks() -> dict[str, str]:
    """The files of the example on the page, by name."""
    return dict(_BLOCK.findall(PAGE.read_text(encoding="utf-8")))


def install(folder: Path, name: str, formats: dict[str, str], files: dict[str, str]) -> Path:
    """Put a distribution of formats by name, and of files, into a folder."""
    about = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    about.mkdir(parents=True)
    metadata = f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n"
    (about / "METADATA").write_text(metadata)
    lines = ["[breaker.formats]", *(f"{key} = {value}" for key, value in formats.items())]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
    for file, text in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    return folder


def install_example(folder: Path) -> Path:
    """Put the distribution of the page into a folder, and the contract beside its test."""
    files = blocks() | {"format_contract.py": CONTRACT.read_text(encoding="utf-8")}
    project = tomllib.loads(files["pyproject.toml"])["project"]
    return install(folder, project["name"], project["entry-points"]["breaker.formats"], files)
