"""The parts of a document: sentences, tables, and sections that hold both."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace


class Text(str):
    """A text of a pattern and values, which may be texts of their own: another language has another
    pattern for it.

    >>> text = Text("limit {name}: {result}", name="slow", result=Text("not shown"))
    >>> text, in_language(text, {"limit {name}: {result}": "{result} bei {name}"})
    ('limit slow: not shown', 'not shown bei slow')
    """

    __slots__ = ("pattern", "values")

    def __new__(cls, pattern: str, **values: object) -> "Text":
        """Return the text, in English."""
        text = super().__new__(cls, pattern.format(**values) if values else pattern)
        text.pattern, text.values = pattern, values
        return text


class Cell(str):
    """A text with a tone: what it means, "good", "bad", "doubt", "faint" or nothing particular.

    A text without a tone is a plain ``str`` wherever a cell may be.

    >>> Cell("FAIL", "bad"), Cell("FAIL", "bad").tone
    ('FAIL', 'bad')
    """

    __slots__ = ("text", "tone")

    def __new__(cls, text: str, tone: str = "") -> "Cell":
        """Return a text with its tone."""
        cell = super().__new__(cls, text)
        cell.text, cell.tone = text, tone
        return cell


def tone_of(text: str) -> str:
    """Return what a text means; nothing of a plain one."""
    return getattr(text, "tone", "")


class Number(str):
    """A number in digits, with signs about it, or several: another language may have another
    decimal sign.

    >>> in_language(Number("± 0.5"), {".": ","})
    '± 0,5'
    """

    __slots__ = ()


class Joined(str):
    """Texts with a sign between."""

    __slots__ = ("sign", "texts")

    def __new__(cls, sign: str, texts: Sequence[str]) -> "Joined":
        """Return the texts, joined."""
        text = super().__new__(cls, sign.join(texts))
        text.sign, text.texts = sign, tuple(texts)
        return text


def in_language(part: object, known: Mapping[str, str]) -> object:
    """Return a text, or a document or part of it, in another language.

    Args:
        part: What has no pattern in it, such as a number or the name of a file, stays as it is.
        known: Texts and patterns of the language by the English ones, and its decimal sign; one
            that is lacking stays English.
    """
    if isinstance(part, Cell):
        return Cell(in_language(part.text, known), part.tone)
    if isinstance(part, Text):
        values = {name: in_language(each, known) for name, each in part.values.items()}
        return Text(known.get(part.pattern, part.pattern), **values)
    if isinstance(part, Number):
        return Number(part.replace(".", known.get(".", ".")))
    if isinstance(part, Joined):
        return Joined(part.sign, [in_language(each, known) for each in part.texts])
    if isinstance(part, list | tuple):
        own = [in_language(each, known) for each in part]
        return type(part)(*own) if hasattr(part, "_fields") else type(part)(own)
    if is_dataclass(part):
        own = {each.name: in_language(getattr(part, each.name), known) for each in fields(part)}
        return replace(part, **own)
    return part


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
        heading: Above the remarks.
    """

    company: str = ""
    logo: bytes = b""
    remarks: str = ""
    signatures: Sequence[str] = ()
    heading: str = Text("Remarks")


@dataclass(frozen=True)
class Document:
    """A document.

    Attributes:
        title: Of the whole.
        plate: Names and values of what it is of.
        summary: Sentences that are said first.
        parts: All else, in order.
        letterhead: None without one.
        language: Of its words, ISO 639.
    """

    title: str = ""
    plate: Sequence[tuple[str, str]] = ()
    summary: Sequence[str] = ()
    parts: Sequence[Section | Table] = ()
    letterhead: Letterhead | None = None
    language: str = "en"
