"""What commands print: all of it here, so that nothing in a file acts on the terminal."""

import sys


def say(text: str, *, beside: bool = False, end: str = "\n") -> None:
    """Print a text, signs that act on a terminal or are not seen as escapes; see ``visible_text``.

    Args:
        text: What to print.
        beside: Whether on stderr, beside what others read.
        end: What follows it.
    """
    from breaker.common.visible_text import visible_text

    print(visible_text(text), file=sys.stderr if beside else sys.stdout, end=end)
