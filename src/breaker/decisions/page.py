"""The first page as HTML: what the report opens on."""

import base64
from html import escape

import pandas as pd
import xarray as xr

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


def opening(verdict: xr.Dataset, decisions: pd.DataFrame, picture: bytes) -> str:
    """Return headline, sentences, picture and the last row of the table of decisions.

    Args:
        verdict: What :func:`breaker.decisions.verdict` returns.
        decisions: What :func:`breaker.decisions.decide` returns; only what its last row states.
        picture: The figure of the verdict, PNG.

    Returns:
        One element of HTML, which loads nothing.
    """
    sentences = "".join(
        f"<p>{escape(verdict.attrs[name])}</p>" for name in ("wearing", "left", "trust")
    )
    encoded = base64.b64encode(picture).decode()
    last = decisions.iloc[-1].replace("", None).dropna().rename("after the last operation")
    return (
        f'{_STYLE}<div id="first-page"><h1>{escape(verdict.attrs["headline"])}</h1>{sentences}'
        f'<img alt="The verdict: one row per limit" src="data:image/png;base64,{encoded}">'
        f"{last.map(_plain).to_frame().to_html(border=0)}</div>"
    )


def _plain(value: object) -> str:
    """Write a value of a table; whole numbers without a point."""
    return f"{value:.10g}" if isinstance(value, float) else str(value)
