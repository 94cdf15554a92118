"""A document as text, for a terminal of 100 columns."""

from collections.abc import Iterable, Iterator, Sequence
from textwrap import wrap

from breaker.common.parts import Document, Remark, Section, Table

_WIDTH = 100  # signs of a line


def text_of(document: Document) -> str:
    """Return a document as text: sentences first, then its parts, with a line between.

    >>> print(text_of(Document(summary=["fits"], parts=[Table(rows=[("L", "10.1")])])))
    fits
    <BLANKLINE>
    L  10.1
    """
    first = [line for each in document.summary for line in wrapped(each, "", "  ")]
    blocks = [first, *map(lines_of, document.parts)]
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


def lines_of(part: Section | Table | Remark | str) -> list[str]:
    """Return the lines of a part of a document."""
    if isinstance(part, Remark):
        return wrapped(part.text, part.first, part.indent)
    if isinstance(part, str):
        return [part]
    lines = [part.title] if part.title else []
    if isinstance(part, Section):
        return [*lines, *(line for each in part.parts for line in lines_of(each))]
    lines += [line for row in _rows(part) for line in row]
    return [*lines, *(line for each in part.notes for line in wrapped(each))]


def wrapped(text: str, first: str = "  ", indent: str = "    ") -> list[str]:
    """Return the lines of a text: how the first and others begin."""
    look = {"initial_indent": first, "subsequent_indent": indent}
    return wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False, **look)


def _rows(table: Table) -> Iterator[list[str]]:
    """Lines of the head and of each row."""
    rows = [table.head, *table.rows] if table.head else table.rows
    form = table.form or _fitting([row for row in rows if not isinstance(row, str | Remark)])
    for row in rows:
        if isinstance(row, str | Remark):
            yield lines_of(row)
        elif form.endswith("{}"):
            begin = form.format(*row[:-1], "")
            yield [line.rstrip() for line in wrapped(row[-1], begin, " " * len(begin))] or [
                begin.rstrip()
            ]
        else:
            yield [form.format(*row).rstrip()]


def _fitting(rows: Iterable[Sequence[str]]) -> str:
    """Columns as wide as their cells: the first from the left, the others from the right."""
    first, *others = (max(map(len, column)) for column in zip(*rows, strict=True))
    return "  ".join([f"{{:<{first}}}", *(f"{{:>{width}}}" for width in others)])
