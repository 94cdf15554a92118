"""Texts from files for terminals and tables, and names in several spellings.

This module imports neither pandas nor numpy.
"""

import csv
import io
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from unicodedata import category


def visible_text(text: str) -> str:
    r"""Return a text with escapes for control characters and letters that are not printable.

    Ends of lines and tabs stay. Names of files and columns come from other people, and must not
    control a terminal.

    >>> visible_text("Weg \x1b[2J\u202e\u200b\n")
    'Weg \\x1b[2J\\u202e\\u200b\n'
    """
    return re.sub(r"[^\t\n -~]", _shown, text)


def _shown(control: re.Match) -> str:
    sign = control[0]
    if category(sign) == "Zs" or sign.isprintable():
        return sign
    return sign.encode("unicode_escape").decode("ascii")


def print_text(text: str, *, on_stderr: bool = False, end: str = "\n") -> None:
    """Print a text as ``visible_text`` returns it; on stderr if ``on_stderr``."""
    print(visible_text(text), file=sys.stderr if on_stderr else sys.stdout, end=end)


def table_text(names: Sequence[str], rows: Iterable[Mapping[str, object]]) -> str:
    """Return a table as CSV; missing values are empty.

    >>> table_text(["file", "sd"], [{"file": "a, b.csv", "sd": -0.1}])
    'file,sd\\n"a, b.csv",-0.1\\n'
    """
    text = io.StringIO()
    table = csv.DictWriter(text, names, extrasaction="ignore", lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return text.getvalue()


def bare(name: str) -> str:
    """Return the common form of all spellings of a name: letters and digits only, in one case.

    >>> {bare(name) for name in ("GL314", "GL 314", "gl-314")}
    {'gl314'}
    """
    return re.sub(r"[\W_]+", "", name).casefold()


def usual_spelling(names: Iterable[str]) -> dict[str, str]:
    """Return the most frequent spelling of each name, by bare name; the first of equally many.

    >>> usual_spelling(["GL 314", "GL314", "gl-314", "GL314"])
    {'gl314': 'GL314'}
    """
    spelt: dict[str, Counter] = {}
    for name in names:
        spelt.setdefault(bare(name), Counter())[name] += 1
    return {key: counts.most_common(1)[0][0] for key, counts in spelt.items()}
