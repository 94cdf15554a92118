"""What several studies share: the networks that ship, and tables that grow row by row."""

from functools import cache
from pathlib import Path

import pandas as pd

from breaker.family import Changes, Levels, open_network
from breaker.shipped import FAMILIES, KINDS, model_file


@cache
def shipped_networks() -> list[tuple[Levels, Changes]]:
    """Return the networks of each family that ships, as the command opens them."""
    return [tuple(open_network(model_file(f, kind)) for kind in KINDS) for f in FAMILIES]


def append(rows: pd.DataFrame, file: str | Path, float_format: str | None = None) -> None:
    """Add rows to a CSV file, which gets its header with the first of them."""
    header = not Path(file).exists()
    rows.to_csv(file, mode="a", header=header, index=False, float_format=float_format)
