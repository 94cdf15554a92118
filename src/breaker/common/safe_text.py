"""Texts of files on their way into tables, of which spreadsheets run some cells.

Names of files, columns, breakers and phases are what others wrote. Light to import.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # pandas takes longer to load than all of this
    import pandas as pd

# A spreadsheet runs what begins so; apostrophes before it are of this module, or count as such.
_RUNS = re.compile("'*[=+@\t\r\n-]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def inert(cell: object) -> object:
    """Return a cell that a spreadsheet does not run: an apostrophe stands before what it would.

    Numbers stay numbers.

    >>> [inert(cell) for cell in ("=1+1", "-3.5", "@a", -2, "'=1", "Weg")]
    ["'=1+1", '-3.5', "'@a", -2, "''=1", 'Weg']
    """
    if not isinstance(cell, str) or not _RUNS.match(cell) or _NUMBER.fullmatch(cell):
        return cell
    return f"'{cell}"


def as_meant(cell: str) -> str:
    """Return a cell as it was before ``inert``.

    >>> [as_meant(cell) for cell in ("'=1+1", "-3.5", "''=1", "'quoted'")]
    ['=1+1', '-3.5', "'=1", "'quoted'"]
    """
    return cell[1:] if cell.startswith("'") and _RUNS.match(cell) else cell


def table_text(names: Sequence[str], rows: Iterable[Mapping[str, object]]) -> str:
    """Return a table as CSV, no cell of which a spreadsheet runs; what a row lacks is empty.

    >>> table_text(["file", "sd"], [{"file": "@a.csv", "sd": -0.1}])
    "file,sd\\n'@a.csv,-0.1\\n"
    """
    cells = [names, *([row.get(name) for name in names] for row in rows)]
    return "".join(",".join(map(_quoted, each)) + "\n" for each in cells)


def _quoted(cell: object) -> str:
    """An inert cell, in quotation marks where it needs them: ``csv`` forgets a lone return."""
    text = "" if cell is None else str(inert(cell))
    doubled = text.replace('"', '""')
    return f'"{doubled}"' if re.search('[,"\r\n]', text) else text


def save_frame(frame: "pd.DataFrame", file: str, *, digits: int) -> None:
    """Write a frame without its index as CSV, no cell of which a spreadsheet runs.

    Args:
        frame: The table.
        file: Its name.
        digits: Of numbers, significant.
    """
    safe = frame.rename(columns=inert)
    # Only where a cell changes: pandas would take counts with gaps between for fractions.
    run = [name for name in safe if any(inert(each) is not each for each in safe[name])]
    safe = safe.assign(**{name: [*map(inert, safe[name])] for name in run})
    safe.to_csv(file, index=False, float_format=f"%.{digits}g")
