"""An environment with nothing but what the wheel asks for, as a module ``sitecustomize``."""

import os
from pathlib import Path

HEAVY = ("numba", "numcodecs", "pandas", "xarray", "zarr")
"""Packages of extras that take most of the space."""

WITHOUT = f"""
import sys
class Nowhere:
    def find_spec(name, path=None, target=None):
        if name in {("torch", "snakemake", *HEAVY)}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Nowhere)
"""


def without_extras(folder: Path) -> dict[str, str]:
    """Variables of processes that find no package of an extra; the folder is made for them."""
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(WITHOUT, encoding="utf-8")
    path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    return {**os.environ, "PYTHONPATH": path}
