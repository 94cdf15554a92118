"""The first page as HTML: what the report opens on."""

import base64
from collections.abc import Sequence
from html import escape

import pandas as pd

__all__ = ["opening"]

# The report sets its description into a narrow column beside the graph of the rules. Here it takes
# the whole width, and the graph comes below it.
_STYLE = """<style>
.prose:has(#first-page) { max-width: none; }
div:has(> .prose #first-page) { width: 100%; }
div:has(> div > .prose #first-page) { flex-direction: column; }
div:has(> div > div > .prose #first-page) { align-items: flex-start; }
#first-page h1 { font-size: 1.3rem; margin: 0 0 .5rem; }
#first-page p { margin: .2rem 0; max-width: 75rem; }
#first-page img { display: block; width: 100%; max-width: 85rem; margin: .5rem 0; }
#first-page table { width: auto; font-size: .8rem; }
#first-page th, #first-page td { text-align: left; padding: .1rem 1rem .1rem 0; }
</style>"""


def opening(sentences: Sequence[str], limits: pd.DataFrame, picture: bytes) -> str:
    """Return sentences, the table of limits and a picture.

    Args:
        sentences: The first is the headline.
        limits: What :func:`breaker.wear.limit_words` returns.
        picture: The figure of the verdict, PNG.

    Returns:
        One element of HTML, which loads nothing.
    """
    first, *others = map(escape, sentences)
    encoded = base64.b64encode(picture).decode()
    return (
        f'{_STYLE}<div id="first-page"><h1>{first}</h1>{"".join(f"<p>{s}</p>" for s in others)}'
        f"{limits.to_html(index=False, border=0)}"
        f'<img alt="How each limit stands" src="data:image/png;base64,{encoded}"></div>'
    )
