"""Answers of the page to requests: HTML from templates, and data as JSON.

All texts from files are escaped. A view maps a request to an answer. It does not depend on the
server, so tests call it without one.
"""

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from typing import NamedTuple

import jinja2
import yaml
from markupsafe import Markup

from breaker.common.document import Table, html_part, tone_of
from breaker.common.text import bare, visible_text
from breaker.diagnosis.identity import nameplate
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.report import report_of
from breaker.diagnosis.tables import (
    limits_table,
    rejected_table,
    remarks_table,
    state_table,
    verdict_of,
)
from breaker.page import curves, types, values
from breaker.page.catalogue import Inspection, earlier_than
from breaker.page.choices import Choices, name_of, read_choices
from breaker.page.session import MissingError, Session, Shown
from breaker.records.files import printable


class Asked(NamedTuple):
    """A request: the session, its query, and its body."""

    session: Session
    query: Mapping[str, list[str]]
    body: bytes = b""

    @property
    def shown(self) -> Shown:
        """Requested inspection; raise a MissingError if no file is named."""
        choices = read_choices(self.query)
        if not choices.files:
            raise MissingError("no file is named; open an inspection of the list")
        return self.session.shown(choices)


Answer = str | dict


@cache
def _templates() -> jinja2.Environment:
    templates = jinja2.Environment(
        loader=jinja2.PackageLoader("breaker.page"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters |= {"printable": printable, "lines": visible_text, "tone": tone_of}
    return templates


def _page(name: str, **about: object) -> str:
    return _templates().get_template(name).render(**about)


def error_page(text: str) -> str:
    """Return a page that states an error."""
    return _page("error.html", text=visible_text(text))


def _list(asked: Asked) -> Answer:
    """Return the list of inspections; with ``look``, describe further files."""
    inspections = asked.session.inspections(look="look" in asked.query)
    groups: dict[str, list[Inspection]] = {}
    for inspection in inspections:
        groups.setdefault(inspection.breaker, []).append(inspection)
    links = {}
    for inspection in inspections:
        before = earlier_than(inspection, groups[inspection.breaker])[:1]
        links[inspection] = Choices(inspection.files, before[0].files if before else ()).query
    page = _page(
        "list.html",
        folder=printable(os.path.abspath(asked.session.named)),
        groups=groups,
        links=links,
        count=sum(len(inspection.files) for inspection in inspections),
        seen=sum(len(inspection.files) for inspection in inspections if inspection.seen),
    )
    return page


def _verdict(asked: Asked) -> Answer:
    """Return the verdict on an inspection of the list, from measured values."""
    try:
        result = asked.shown.measured.result
    except (ValueError, OSError) as error:
        reason = str(error).splitlines()[-1].strip()
        return {"verdict": "unread", "text": f"not readable: {visible_text(reason)}"}
    rejected = [str(record["reason"]) for record in result["records"] if not record["accepted"]]
    verdict = verdict_of(result) if result["verdict"] else "no limits"
    text = "; ".join([verdict, *rejected[:1]])
    return {"verdict": result["verdict"] or "none", "text": visible_text(text)}


def _inspection(asked: Asked) -> Answer:
    """Return the page of an inspection, without curves, values and results of the model."""
    session, shown = asked.session, asked.shown
    chosen, diagnosis = shown.choices, shown.diagnosis
    every = session.inspections()
    own = next((one for one in every if set(chosen.files) <= set(one.files)), None)
    known, name = types.read_types(session.types, session.config), session.type_of(chosen)
    page = _page(
        "inspection.html",
        names=[printable(name_of(file)) for file in chosen.files],
        plate=nameplate(diagnosis.records, diagnosis.before) if diagnosis else [],
        shown=shown,
        overlay=yaml.safe_dump(shown.overlay, sort_keys=False, allow_unicode=True),
        type=name,
        types=known,
        is_new=bool(name) and not any(bare(other) == bare(name) for other in known),
        types_file=printable(os.path.relpath(session.types)),
        earlier=[
            (one, chosen._replace(before=one.files).query)
            for one in (earlier_than(own, every) if own else ())
        ],
        alone=chosen._replace(before=()).query,
        lacking=[row.label for row in shown.rows if row.state == "missing"],
        doubts=sum(row.state in ("missing", "doubtful") for row in shown.rows),
        tabs=[tab.title for tab in curves.tabs_of(diagnosis.records)] if diagnosis else [],
    )
    return page


def _curves(asked: Asked) -> Answer:
    """Return the curves of a motion, or all columns of a file without a readable motion."""
    shown, number = asked.shown, asked.query.get("tab", [""])[-1]
    if shown.diagnosis is None:
        if shown.sheet is None:
            raise ValueError(shown.trouble)
        return curves.drawn_file(shown.sheet)
    tabs = curves.tabs_of(shown.diagnosis.records)
    if not number.isdecimal() or int(number) >= len(tabs):
        raise MissingError("there is no such motion; load the page again")
    return curves.drawn(tabs[int(number)], shown.diagnosis, shown.files)


def _results(asked: Asked, *, with_model: bool) -> Answer:
    """Return values, limits, verdicts, and marks on curves; ``with_model`` also the inferred state
    of the drive and the changes.
    """
    diagnosis = asked.shown.complete if with_model else asked.shown.measured
    result, tabs = diagnosis.result, curves.tabs_of(diagnosis.records)
    tables, remarks = [values.table_of(tab, diagnosis) for tab in tabs], remarks_table(result)
    others = limits_table(values.other_limits(tables, result["records"]))
    others = _document([others, rejected_table(result)])
    verdict, words = result["verdict"] or "none", verdict_of(result)
    parts = {
        "verdict": _page("verdict.html", verdict=verdict, words=words, warnings=result["warnings"]),
        "values": _page("values.html", tables=tables, others=others),
        "remarks": _document([remarks]),
    }
    if with_model:
        changes = [
            (table.title, table.notes, _document([replace(table, title="", notes=())]))
            for table in change_tables(diagnosis.changes)
        ]
        parts["changes"] = _page("changes.html", changes=changes)
        parts["model"] = _document([state_table(result)])
    marks = [curves.marks_of(tab, diagnosis) for tab in tabs]
    return {"parts": parts, "marks": marks, "remarks": len(remarks.notes)}


def _document(tables: list[Table]) -> Markup:
    """Return tables as HTML with escaped texts."""
    filled = [table for table in tables if table.rows or table.notes]
    return Markup("".join(map(html_part, filled)))


def _sheet(asked: Asked) -> Answer:
    """Return the report that ``breaker report`` writes."""
    from breaker.figures.reports import report_page  # matplotlib loads for half a second

    return report_page(report_of(asked.shown.complete))


def _set(asked: Asked) -> Answer:
    """Set a limit or speed zone of a type."""
    session, about = asked.session, json.loads(asked.body)
    name, key, ends = (about.get(part) for part in ("type", "key", "ends"))
    types.set_of_type(session.types, session.config, str(name), str(key), [str(e) for e in ends])
    return {"type": name}


def warm(session: Session) -> None:
    """Import the modules of an inspection while the user looks at the list."""
    with suppress(ValueError, OSError, StopIteration):
        file = next(name for name, path in session.files().items() if os.path.isfile(path))
        for name in ("inspection", "curves", "values", "model"):
            VIEWS["GET", name](Asked(session, {"file": [file], "tab": ["0"]}))


VIEWS = {
    ("GET", ""): _list,
    ("GET", "verdict"): _verdict,
    ("GET", "inspection"): _inspection,
    ("GET", "curves"): _curves,
    ("GET", "values"): partial(_results, with_model=False),
    ("GET", "model"): partial(_results, with_model=True),
    ("GET", "sheet"): _sheet,
    ("POST", "set"): _set,
}
"""Views by method and path."""

SLOW = ("verdict", "model", "sheet")
"""Paths of slow answers."""
