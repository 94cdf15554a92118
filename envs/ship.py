"""Update the shipped networks of a family of drives, and their model card.

Run by ``make ship``, from the project's folder, after ``snakemake family``, with the same overlay
if the family is not the default one. Nothing is changed unless the networks fit the configuration.
"""

import hashlib
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from breaker.common.tensor_file import ModelFileError, open_model
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import ConfigurationError, load
from breaker.family.network_files import differing, header_of
from breaker.shipped import CARD, FAMILIES, KINDS, model_file

__all__ = ["described", "unfit"]

RESULTS = Path("results/family/trained")


def unfit(model: Path, config: Mapping[str, Any], kind: str) -> list[str]:
    """Return the differences between a model file and a configuration."""
    with open_model(model) as saved:
        lines = differing(
            saved.settings, header_of(config, kind, family_of(config["family"]["name"]))
        )
    return [f"{model}: {line}" for line in lines]


def described(text: str) -> str:
    """Return the model card with its table of shipped files."""
    rows = [
        "| file | drives | steps | coverage of 90 % intervals | uniform ranks | bytes | SHA-256 |",
        "|---|---|---|---|---|---|---|",
    ]
    for family, kind in product(FAMILIES, KINDS):
        file = model_file(family, kind)
        content = file.read_bytes()
        with open_model(file) as saved:
            drives = saved.settings["bank"]["drives"]
            steps = saved.settings["training"]["steps"]
        good = _coverage(_quality(family, kind))
        checksum = f"`{hashlib.sha256(content).hexdigest()}`"
        row = f"{file.name} | {drives:,} | {steps:,} | {good} | {len(content):,} | {checksum}"
        rows.append(f"| {row} |")
    return _put(text, "files", rows)


def _quality(family: str, kind: str) -> pd.DataFrame:
    """Return the rows of a network in the quality table of a family."""
    table = pd.read_csv(Path("docs") / f"family_{family}.csv")
    return table[table.network == kind]


def _coverage(outputs: pd.DataFrame) -> str:
    """Return two cells: range of the coverage of 90 % intervals, and count of uniform outputs."""
    low, high = 100 * outputs.coverage_90.min(), 100 * outputs.coverage_90.max()
    return f"{low:.0f} to {high:.0f} % | {int(outputs.calibrated.sum())} of {len(outputs)}"


def _put(text: str, mark: str, rows: Sequence[str]) -> str:
    """Return a text with a table at its mark."""
    start = f"<!-- {mark}: made by `make ship` -->\n"
    table = re.compile(re.escape(start) + r".*?(?=\n\n|\n*\Z)", re.DOTALL)
    return table.sub(start + "\n".join(rows), text)


def main(overlays: Sequence[str]) -> int:
    """Copy the networks, or print why they cannot be shipped."""
    try:
        config = load(overlays)
        files = {kind: RESULTS / f"{kind}.safetensors" for kind in KINDS}
        lines = [line for kind, file in files.items() for line in unfit(file, config, kind)]
    except (ConfigurationError, FileNotFoundError, ModelFileError) as error:
        lines = [str(error)]
    if lines:
        print(f"nothing is shipped: {RESULTS} is not of the configuration", *lines, sep="\n  ")
        print("Run `snakemake family`, with the same overlay if there is one, then `make ship`.")
        return 1
    family = config["family"]["name"]
    for kind, file in files.items():
        shutil.copyfile(file, model_file(family, kind))
    shutil.copyfile(RESULTS / "quality.csv", Path("docs") / f"family_{family}.csv")
    CARD.write_text(described(CARD.read_text(encoding="utf-8")), encoding="utf-8")
    subprocess.run([sys.executable, "docs/tables.py"], check=True)
    print(f"shipped in {CARD.parent}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
