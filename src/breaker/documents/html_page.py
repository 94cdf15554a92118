"""A document as one page of HTML that needs nothing beside it."""

from base64 import b64encode
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, Template

from breaker.common.visible_text import visible_text
from breaker.documents.parts import Document, Remark, tone_of, words_in


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
