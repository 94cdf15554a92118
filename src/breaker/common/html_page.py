"""A document as one page of HTML that needs no other file, and as a PDF of that page."""

from base64 import b64encode
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import ModuleType

from jinja2 import Environment, FileSystemLoader, Template

from breaker import DISTRIBUTION
from breaker.common.parts import Document, Remark, tone_of, words_in
from breaker.common.visible_text import visible_text


def html_page(
    document: Document, pictures: Sequence[bytes] = (), *, alt: str = "curves", inner: str = ""
) -> str:
    """Return a document as HTML; whatever its words hold is text there, with escapes for signs that
    are not shown, or turn the direction of writing.

    Args:
        document: The document.
        pictures: PNG, below its parts.
        alt: What they show, for who does not see them.
        inner: Identifier of one element, with a style of its own, to be set into another page; a
            whole page without.

    >>> "<h1>A &lt; B</h1>" in html_page(Document("A < B"))
    True
    """
    text = _page().render(document=document, pictures=pictures, alt=alt, inner=inner)
    return visible_text(text)


def pdf_of(page: str) -> bytes:
    """Return a page of HTML as a PDF, by its print style sheet; raise as ``weasyprint``."""
    return weasyprint().HTML(string=page).write_pdf()


def weasyprint() -> ModuleType:
    """Return the package that turns HTML into a PDF.

    Raises:
        ValueError: If it, or a library of the system that it needs, is not installed.
    """
    try:
        import weasyprint
    except (ImportError, OSError) as error:  # OSError: without Pango
        raise ValueError(
            f"a PDF needs WeasyPrint: install {DISTRIBUTION}[pdf], or write HTML and print it from "
            "a browser"
        ) from error
    return weasyprint


@cache
def _page() -> Template:
    """The template, compiled once for all parts of a page."""
    folder = FileSystemLoader(Path(__file__).parent)
    jinja = Environment(loader=folder, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    jinja.filters |= {"tone": tone_of, "words": words_in, "base64": _base64}
    jinja.tests["remark"] = lambda part: isinstance(part, Remark)
    return jinja.get_template("html_page.html")


def _base64(content: bytes) -> str:
    return b64encode(content).decode("ascii")
