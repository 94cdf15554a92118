"""A document: its parts, and its renderings as text for a terminal and as HTML."""

import re
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from breaker.common.clean_text import visible_text

if TYPE_CHECKING:
    from jinja2 import Template

_NAME = re.compile(r"\b[a-z]+(?:_[a-z0-9]+)+\b")  # names of code
_WIDTH = 100  # characters of a line; fits a terminal on half a screen


class Cell(str):
    """A text with a tone: "good", "bad", "doubt", "faint", or "" as for a plain ``str``.

    >>> Cell("FAIL", "bad"), Cell("FAIL", "bad").tone
    ('FAIL', 'bad')
    """

    __slots__ = ("tone",)

    def __new__(cls, text: str, tone: str = "") -> "Cell":
        """Return a text with its tone."""
        cell = super().__new__(cls, text)
        cell.tone = tone
        return cell


def tone_of(text: str) -> str:
    """Return the tone of a text; empty for a plain one."""
    return getattr(text, "tone", "")


@dataclass(frozen=True)
class Remark:
    """A sentence; on a terminal, ``first`` begins its first line and ``indent`` the other lines."""

    text: str
    first: str = "  "
    indent: str = "    "


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        head: Names of the columns; may be empty.
        rows: A cell for each column, or a title or remark that spans the row.
        title: Title of the table.
        notes: Sentences below it.
    """

    head: Sequence[str] = ()
    rows: Sequence[Sequence[str] | str | Remark] = ()
    title: str = ""
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Document:
    """A document.

    Attributes:
        title: Title of the document.
        plate: Names and values of its subject.
        summary: Sentences at the beginning.
        parts: Further parts, in order; on a page, pictures follow them.
        after: Parts after the pictures.
        names: Words that replace names of code on a page, by name.
        company: Name above a page that is signed, may be empty; None for other pages.
    """

    title: str = ""
    plate: Sequence[tuple[str, str]] = ()
    summary: Sequence[str] = ()
    parts: Sequence[Table | Remark] = ()
    after: Sequence[Table | Remark] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    company: str | None = None


# ---- text ----------------------------------------------------------------------------------------


def text_of(document: Document) -> str:
    """Return a document as text: its summary and parts, with an empty line between them.

    >>> print(text_of(Document(summary=["fits"], parts=[Table(rows=[("L", "10.1")])])))
    fits
    <BLANKLINE>
    L  10.1
    """
    first = [line for note in document.summary for line in wrapped(note, "", "  ")]
    blocks = [first, *map(lines_of, [*document.parts, *document.after])]
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


def lines_of(part: Table | Remark | str) -> list[str]:
    """Return the lines of a part of a document."""
    if isinstance(part, Remark):
        return wrapped(part.text, part.first, part.indent)
    if isinstance(part, str):
        return [part]
    lines = [part.title] if part.title else []
    lines += [line for row in _rows(part) for line in row]
    return [*lines, *(line for note in part.notes for line in wrapped(note))]


def wrapped(text: str, first: str = "  ", indent: str = "    ") -> list[str]:
    """Return the lines of a text; ``first`` begins the first line, ``indent`` the others."""
    about = {"break_long_words": False, "break_on_hyphens": False}
    return wrap(text, _WIDTH, initial_indent=first, subsequent_indent=indent, **about)


def _rows(table: Table) -> Iterator[list[str]]:
    """Yield the lines of the head and of each row; columns are as wide as their cells."""
    rows = [table.head, *table.rows] if table.head else table.rows
    cells = [row for row in rows if not isinstance(row, str | Remark)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in rows:
        if isinstance(row, str | Remark):
            yield lines_of(row)
        else:
            right = [cell.rjust(width) for cell, width in zip(row, widths, strict=True)]
            yield ["  ".join([row[0].ljust(widths[0]), *right[1:]]).rstrip()]


# ---- HTML ----------------------------------------------------------------------------------------


def html_page(document: Document, pictures: Sequence[bytes] = ()) -> str:
    """Return a document as one page of HTML that needs no other file, with PNG pictures.

    Markup and control characters in texts are escaped.

    >>> "<h1>A &lt; B</h1>" in html_page(Document("A < B"))
    True
    """
    return _in_words(_page().render(document=document, pictures=pictures), document.names)


def html_part(part: Table | Remark | str, names: Mapping[str, str]) -> str:
    """Return a part of a document with these names as HTML, for a page with its own style."""
    return _in_words(_page().module.part(part), names)


def _in_words(text: str, names: Mapping[str, str]) -> str:
    return _NAME.sub(lambda match: names.get(match[0], match[0]), visible_text(text))


@cache
def _page() -> "Template":
    """Return the template, compiled once."""
    from jinja2 import Environment, FileSystemLoader

    folder = FileSystemLoader(Path(__file__).parent)
    jinja = Environment(loader=folder, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    jinja.filters["tone"] = tone_of
    jinja.filters["words"] = lambda part: part.text if isinstance(part, Remark) else part
    jinja.filters["base64"] = lambda content: b64encode(content).decode("ascii")
    jinja.tests["line"] = lambda part: isinstance(part, str | Remark)
    return jinja.get_template("document.html")
