"""Texts of others on their way to a reader: a terminal, a table, and names in several spellings.

Names of files, columns, breakers and phases are what others wrote: nothing in them acts on the
terminal or stays unseen, and no spreadsheet runs a cell. Light to import.
"""

import re
import sys
from collections import Counter
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
UNPRINTED = "the text could not be printed"  # on an output that accepts none, such as a full disk
# A spreadsheet runs what begins so; apostrophes before it are of this module, or count as such.
_RUNS = re.compile("'*[=+@\t\r\n-]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def visible_text(text: str) -> str:
    r"""Return a text with escapes for all that acts or has no width, but ends of lines and tabs.

    >>> visible_text("Weg \x1b[2J\u202e\u200b\n")
    'Weg \\x1b[2J\\u202e\\u200b\n'
    """
    return re.sub(r"[^\t\n -~]", _shown, text)


def _shown(control: re.Match) -> str:
    sign = control[0]
    if (category(sign) == "Zs" or sign.isprintable()) and not _HIDDEN.match(sign):
        return sign
    return sign.encode("unicode_escape").decode("ascii")


def say(text: str, *, on_stderr: bool = False, end: str = "\n") -> None:
    """Print a text as ``visible_text`` returns it; on stderr if ``on_stderr``."""
    try:
        print(visible_text(text), file=sys.stderr if on_stderr else sys.stdout, end=end)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(f"{UNPRINTED}: {error.strerror}") from error


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
    return "".join(",".join(map(_quoted, line)) + "\n" for line in cells)


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
    run = [name for name in safe if any(inert(cell) is not cell for cell in safe[name])]
    safe = safe.assign(**{name: [*map(inert, safe[name])] for name in run})
    safe.to_csv(file, index=False, float_format=f"%.{digits}g")


def bare(name: str) -> str:
    """Return what all spellings of a name have in common: letters and digits alone, in one case.

    >>> {bare(name) for name in ("GL314", "GL 314", "gl-314")}
    {'gl314'}
    """
    return re.sub(r"[\W_]+", "", name).casefold()


def usual_spelling(names: Iterable[str]) -> dict[str, str]:
    """Return the most frequent spelling of each name, by its bare name; the first of equals.

    >>> usual_spelling(["GL 314", "GL314", "gl-314", "GL314"])
    {'gl314': 'GL314'}
    """
    spelt: dict[str, Counter] = {}
    for name in names:
        spelt.setdefault(bare(name), Counter())[name] += 1
    return {key: counts.most_common(1)[0][0] for key, counts in spelt.items()}
