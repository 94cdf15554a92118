"""Texts on their way to their reader: nothing in a file acts on the terminal, or stays unseen."""

import re
import sys
from unicodedata import category

# Signs without a width that Python calls printable: joiners, fillers and selectors of variants.
_HIDDEN = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180d\u180f\u3164\ufe00-\ufe0f\uffa0"
    "\U000e0100-\U000e01ef]"
)
UNPRINTED = "the text could not be printed"  # on an output that accepts none, such as a full disk


def visible_text(text: str) -> str:
    r"""Return a text with escapes for all that acts or has no width, but ends of lines and tabs.

    >>> visible_text("Weg \x1b[2J\u202e\u200b\n")
    'Weg \\x1b[2J\\u202e\\u200b\n'
    """
    return re.sub(r"[^\t\n -~]", _shown, text)


def _shown(found: re.Match) -> str:
    sign = found[0]
    if (category(sign) == "Zs" or sign.isprintable()) and not _HIDDEN.match(sign):
        return sign
    return sign.encode("unicode_escape").decode("ascii")


def say(text: str, *, beside: bool = False, end: str = "\n") -> None:
    """Print a text as ``visible_text`` returns it; ``beside`` what others read on stderr."""
    try:
        print(visible_text(text), file=sys.stderr if beside else sys.stdout, end=end)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(f"{UNPRINTED}: {error.strerror}") from error
