"""The parts of a document: sentences, tables, and sections that hold both."""

from collections.abc import Sequence
from dataclasses import dataclass


class Cell(str):
    """A text with a tone: what it means, "good", "bad", "doubt", "faint" or nothing particular.

    A text without a tone is a plain ``str`` wherever a cell may be.

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
    """Return what a text means; nothing of a plain one."""
    return getattr(text, "tone", "")


@dataclass(frozen=True)
class Remark:
    """A sentence below others.

    Attributes:
        text: The sentence.
        first, indent: How its first line and the others begin on a terminal.
    """

    text: str
    first: str = "  "
    indent: str = "    "


def words_in(part: "str | Remark") -> str:
    """Return the words of a sentence, whichever kind of part it is."""
    return part.text if isinstance(part, Remark) else part


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        head: Names of the columns; empty without.
        rows: A cell for each column; or a title or remark that takes the whole row.
        title: Of the table.
        notes: Sentences below it.
        form: The columns on a terminal, as ``str.format`` takes them: widths and sides. A last one
            without a width is wrapped. Without a form columns are as wide as they need to be.
    """

    head: Sequence[str] = ()
    rows: Sequence[Sequence[str] | str | Remark] = ()
    title: str = ""
    notes: Sequence[str] = ()
    form: str = ""


@dataclass(frozen=True)
class Section:
    """What belongs together below a title."""

    title: str = ""
    parts: Sequence["Remark | Table | str"] = ()


@dataclass(frozen=True)
class Letterhead:
    """What a company puts around a document: a head, and room for remarks and signatures.

    Attributes:
        company: Its name; empty without one.
        logo: PNG; empty without one.
        remarks: Of who writes it.
        signatures: What each line to sign is for.
    """

    company: str = ""
    logo: bytes = b""
    remarks: str = ""
    signatures: Sequence[str] = ()


@dataclass(frozen=True)
class Document:
    """A document.

    Attributes:
        title: Of the whole.
        plate: Names and values of what it is of.
        summary: Sentences that are said first.
        parts: All else, in order.
        letterhead: None without one.
    """

    title: str = ""
    plate: Sequence[tuple[str, str]] = ()
    summary: Sequence[str] = ()
    parts: Sequence[Section | Table] = ()
    letterhead: Letterhead | None = None
