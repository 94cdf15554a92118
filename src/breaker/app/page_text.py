"""Pages as HTML: templates with what a session knows; every text of a file is escaped."""

import importlib.util
import math
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import jinja2
import numpy as np
from markupsafe import Markup

from breaker.app.curve_traces import Mark, at_cursors, plain, thinned
from breaker.app.page_choices import WHOLE, Choices, name_of
from breaker.app.view_session import SHOWN, Session, Shown
from breaker.common.document import html_page, tone_of
from breaker.common.numerals import in_digits
from breaker.common.text import visible_text
from breaker.records.files import printable


@cache
def _templates() -> jinja2.Environment:
    found = jinja2.Environment(
        loader=jinja2.PackageLoader("breaker.app"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters |= {"digits": _digits, "printable": printable, "printable_lines": visible_text}
    return found


def _digits(value: float) -> str:
    """A number of a table; a dash where there is none.

    >>> _digits(12.3456), _digits(float("nan"))
    ('12.35', '–')
    """
    return in_digits(value, 4) if math.isfinite(value) else "–"


def _page(name: str, **about: object) -> str:
    return _templates().get_template(name).render(**about)


def list_page(session: Session, number: str, look: str) -> str:
    """Return the list of the files of a session, a part at a time, of which as many as are told are
    looked into.
    """
    every = list(session.files())
    pages = max(1, math.ceil(len(every) / SHOWN))
    page = min(max(int(number) if number.isdecimal() else 1, 1), pages)
    shown = every[(page - 1) * SHOWN : page * SHOWN]
    seen = session.listed(shown, int(look) if look.isdecimal() else 0)
    return _page(
        "list.html",
        folder=printable(os.path.abspath(session.named)),
        lines=[*zip(shown, map(_name, shown), seen, strict=True)],
        looked=sum(each is not None for each in seen),
        count=len(every),
        first=(page - 1) * SHOWN + 1,
        page=page,
        pages=pages,
        whole=WHOLE if session.whole else "",
    )


def visit_page(session: Session, choices: Choices) -> str:
    """Return the page of a visit."""
    shown = session.shown(choices)
    chosen, whole = shown.choices, printable(session.named)
    base = "seen" if chosen.base == "configured" else "configured"
    return _page(
        "visit.html",
        names=[whole if each == WHOLE else _name(each) for each in chosen.files],
        before=[*map(_name, chosen.before)],
        shown=shown,
        uncertain=sum(row.state in ("lacking", "doubtful") for row in shown.rows),
        other=chosen._replace(base=base, settings={}).address,
    )


def _name(identity: str) -> str:
    """The name of a file, from its folder on."""
    return printable(name_of(identity))


def answer_part(session: Session, choices: Choices, state: str) -> str:
    """Return the part of a page that takes longer: values, limits, and what the model says."""
    report, marks = session.answered(choices, state)
    values = replace(report, title="Values, limits and the model", summary=())
    return _page(
        "answer.html",
        summary=[(each, tone_of(each)) for each in report.summary],
        values=Markup(html_page(values, inner="report")),  # which escapes what it is given
        marks=marks,
        address=session.shown(choices, state).address,
        pdf=importlib.util.find_spec("weasyprint") is not None,
    )


def error_page(text: str, *, allowed: bool = True) -> str:
    """Return a page that says what is wrong."""
    return _page("error.html", text=visible_text(text), allowed=allowed)


def curves_of(shown: Shown, begin: float | None, end: float | None) -> dict:
    """Return the points of all traces between two times, for JSON."""
    ends = [(float(each.time[0]), float(each.time[-1])) for each in shown.traces if each.time.size]
    first = min((e[0] for e in ends), default=0.0) if begin is None else begin
    last = max((e[1] for e in ends), default=1.0) if end is None else end
    traces = [
        {
            "name": each.name,
            "unit": each.unit,
            "kind": each.kind,
            "laid": each.laid,
            **thinned(each, first, last),
        }
        for each in shown.traces
    ]
    return {"from": first, "to": last, "clock": shown.clock, "traces": traces}


def marks_for(marks: Sequence[Mark]) -> dict:
    """Return the marks of curves, for JSON."""
    found = []
    for each in marks:
        start, stop, low, high = plain(np.array([each.start, each.stop, each.low, each.high]))
        name = f"{each.name} {printable(each.channel)}".rstrip()
        found.append(
            {"name": name, "x": [start, stop], "y": [low, high], "inferred": each.inferred}
        )
    return {"marks": found}


def cursor_page(shown: Shown, first: float, second: float) -> str:
    """Return the table of readings at two cursors."""
    rows = at_cursors(shown.traces, first, second)
    return _page("cursors.html", rows=rows, first=first, second=second, clock=shown.clock)
