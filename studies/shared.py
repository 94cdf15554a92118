"""What several studies share: tables that grow row by row."""

from pathlib import Path

import pandas as pd


def append(rows: pd.DataFrame, file: str | Path, float_format: str | None = None) -> None:
    """Add rows to a CSV file, which gets its header with the first of them."""
    header = not Path(file).exists()
    rows.to_csv(file, mode="a", header=header, index=False, float_format=float_format)
