"""What several studies share: tables that grow row by row."""

from pathlib import Path

import pandas as pd


def append(rows: pd.DataFrame, file: str | Path, float_format: str | None = None) -> None:
    """Add rows to a CSV file, which gets its header with the first of them."""
    header = not Path(file).exists()
    rows.to_csv(file, mode="a", header=header, index=False, float_format=float_format)


def write_table(page: str, name: str, lines: list[str], study: str) -> None:
    """Put a table of a study in its place in a page."""
    file, mark = Path(f"docs/{page}.md"), f"<!-- {name}: made by studies/{study}.py -->\n"
    start, rest = file.read_text(encoding="utf-8").split(mark)
    rest = rest[rest.index("\n\n") :]
    file.write_text(start + mark + "\n".join(lines) + rest, encoding="utf-8")
    print("\n".join(lines))
