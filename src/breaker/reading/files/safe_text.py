r"""Texts of files on their way out: to a terminal, which obeys some signs, and into tables, of
which spreadsheets run some cells.

Names of files, columns, breakers and phases are what others wrote. Light to import.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING
from unicodedata import category

if TYPE_CHECKING:  # pandas takes longer to load than all of this
    import pandas as pd

# Signs without a width that Python calls printable: joiners, fillers and selectors of variants.
_HIDDEN = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180d\u180f\u3164\ufe00-\ufe0f\uffa0"
    "\U000e0100-\U000e01ef]"
)
# A spreadsheet runs what begins so; apostrophes before it are of this module, or count as such.
_RUNS = re.compile("'*[=+@\t\r\n-]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def on_terminal(text: str) -> str:
    r"""Return a text for a terminal, with escapes for signs that it obeys or does not show.

    These are control characters, marks of the direction of writing, and signs without a width.
    Ends of lines and tabs stay.

    >>> on_terminal("Weg \x1b[2J\u202e\u200b\n")
    'Weg \\x1b[2J\\u202e\\u200b\n'
    """
    lines = text.split("\n")
    return "\n".join(
        each if each.isprintable() and not _HIDDEN.search(each) else "".join(map(_shown, each))
        for each in lines
    )


def _shown(sign: str) -> str:
    plain = sign == "\t" or category(sign) == "Zs" or sign.isprintable()
    if plain and not _HIDDEN.match(sign):
        return sign
    return sign.encode("unicode_escape").decode("ascii")


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
