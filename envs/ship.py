"""Renew what ships with the package: defaults, models of the default run, and their model card.

Called by ``make ship``, from the project's folder, after ``make all`` and ``make numbers``. Nothing
is changed unless the results are those of ``config/config.yaml``, alone.
"""

import hashlib
import json
import re
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from breaker.mechanism import MOTIONS
from breaker.model import Discrepancy, ModelFileError, open_discrepancy, open_model
from breaker.shipped import CARD, DEFAULTS, model_file
from breaker.stores import StoreError, open_store
from breaker.workflow import ConfigurationError, chosen_network, load

__all__ = ["described", "differing", "made_from", "unfit"]

CONFIG = Path("config/config.yaml")
RESULTS = Path("results")


def made_from(config: Mapping[str, Any], motion: str) -> dict[str, Any]:
    """Return the settings in the header of a model that a configuration makes."""
    return {
        **{key: config[key] for key in ("seed", "prior", "sensor", "solver")},
        "motion": motion,
        "network": chosen_network(config["network"][motion]),
        "training": config["training"][motion],
        "bank_curves": config["bank"]["shards"] * config["bank"]["curves_per_shard"],
    }


def differing(found: Any, wanted: Any, key: str = "") -> list[str]:
    """Return where settings differ, as ``key: found, not wanted``."""
    if isinstance(found, Mapping) and isinstance(wanted, Mapping):
        return [
            line
            for name in sorted(found.keys() | wanted.keys())
            for line in differing(
                found.get(name, "nothing"), wanted.get(name, "nothing"), f"{key}.{name}".strip(".")
            )
        ]
    return [] if found == wanted else [f"{key}: {found}, not {wanted}"]


def unfit(model: Path, config: Mapping[str, Any], motion: str) -> list[str]:
    """Return why a model file is not that of a configuration, with what the model leaves out."""
    with open_model(model) as saved:
        left_out, lines = saved.discrepancy, differing(saved.settings, made_from(config, motion))
    components = 0 if left_out is None else len(left_out.factor)
    lines += differing(components, config["discrepancy"]["components"], "discrepancy.components")
    return [f"{model}: {line}" for line in lines]


def unfit_results(results: Path, config: Mapping[str, Any]) -> list[str]:
    """Return why results are not those of a configuration, as far as they ship."""
    store = results / "discrepancy.zarr"
    made = json.loads(open_store(store).attrs["settings"])
    wanted = {name: config.get(name, "nothing") for name in made}
    lines = [f"{store}: {line}" for line in differing(made, wanted)]
    for motion in MOTIONS:
        model = results / "models" / f"{motion}.safetensors"
        lines += unfit(model, config, motion)
        with open_model(model) as saved:
            if not _same(saved.discrepancy, open_discrepancy(store, motion)):
                lines.append(f"{model}: what it leaves out is not that of {store}")
    return lines


def _same(one: Discrepancy | None, other: Discrepancy) -> bool:
    if one is None:
        return False
    one, other = one.to_arrays(), other.to_arrays()
    return one.keys() == other.keys() and all(map(np.array_equal, one.values(), other.values()))


def described(text: str) -> str:
    """Return the model card with its tables for the files that ship."""
    for mark, rows in (("settings", _settings()), ("files", _files())):
        start = f"<!-- {mark}: made by `make ship` -->\n"
        table = re.compile(re.escape(start) + r".*?(?=\n\n|\n*\Z)", re.DOTALL)
        text = table.sub(start + "\n".join(rows), text)
    return text


def _settings() -> list[str]:
    columns = []
    for motion in MOTIONS:
        with open_model(model_file(motion)) as saved:
            made = saved.settings
            columns.append(
                {
                    "seed": made["seed"],
                    "simulated curves": f"{made['bank_curves']:,}",
                    "summary network": made["network"]["summary"]["kind"],
                    "inference network": made["network"]["inference"]["kind"],
                    "steps of training": f"{made['training']['steps']:,}",
                    "noise, mm": made["sensor"]["noise_sd"],
                    "samples, from, to (ms)": "{samples}, {start}, {stop}".format(**made["sensor"]),
                    "components of the learned error": len(saved.discrepancy.factor),
                    "lag of the contact": "learned" if saved.discrepancy.lag else "not learned",
                }
            )
    cells = [f"| {name} | {' | '.join(str(c[name]) for c in columns)} |" for name in columns[0]]
    return [f"| | {' | '.join(MOTIONS)} |", "|---|" + "---|" * len(MOTIONS), *cells]


def _files() -> list[str]:
    rows = ["| file | bytes | SHA-256 |", "|---|---|---|"]
    for file in map(model_file, MOTIONS):
        content = file.read_bytes()
        checksum = hashlib.sha256(content).hexdigest()
        rows.append(f"| {file.name} | {len(content):,} | `{checksum}` |")
    return rows


def main() -> int:
    """Copy what ships, or say why it cannot."""
    try:
        lines = unfit_results(RESULTS, load([CONFIG]))
    except (ConfigurationError, FileNotFoundError, ModelFileError, StoreError) as error:
        lines = [str(error)]
    numbers = [folder / "numbers.csv" for folder in (RESULTS, Path("docs"))]
    if not lines and numbers[0].read_bytes() != numbers[1].read_bytes():
        lines = [f"{numbers[1]} is not that of {RESULTS}: run `make numbers`"]
    if lines:
        print(f"nothing is shipped: {RESULTS} is not the run of {CONFIG}", *lines, sep="\n  ")
        print("Run `make all` without overlays, then `make numbers ship`.")
        return 1
    for motion in MOTIONS:
        shutil.copyfile(RESULTS / "models" / f"{motion}.safetensors", model_file(motion))
    shutil.copyfile(CONFIG, DEFAULTS)
    CARD.write_text(described(CARD.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"shipped in {DEFAULTS.parent}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
