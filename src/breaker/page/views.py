"""Answers of the page to requests: HTML from templates, and verdicts of the list as JSON.

All texts from files are escaped. A view maps a request to an answer. It does not depend on the
server, so tests call it without one.
"""

import os
from collections.abc import Mapping, Sequence
from functools import cache
from typing import NamedTuple

import jinja2
import yaml
from markupsafe import Markup

from breaker.common.clean_text import visible_text
from breaker.common.document import html_part
from breaker.diagnosis.report import report_of
from breaker.diagnosis.result import Result, accepted
from breaker.diagnosis.tables import verdict_of
from breaker.model.quantities import INFERRED, in_words
from breaker.page import curves, types
from breaker.page.catalogue import MOST, Inspection, earlier_than, unread_files
from breaker.page.choices import Choices, name_of, read_choices
from breaker.page.session import MissingError, Session, Shown
from breaker.records.files import printable


class Asked(NamedTuple):
    """A request: the session, its query, and the fields of its form."""

    session: Session
    query: Mapping[str, Sequence[str]]
    form: Mapping[str, Sequence[str]] = {}

    @property
    def shown(self) -> Shown:
        """Requested inspection; raise a MissingError if no file is named."""
        choices = read_choices(self.query)
        if not choices.files:
            raise MissingError("no file is named; open an inspection of the list")
        return self.session.shown(choices)


class Moved(str):
    """The address of the page to show next."""


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
    part = lambda section, names: Markup(html_part(section, names))  # noqa: E731
    templates.filters |= {"printable": printable, "lines": visible_text, "part": part}
    return templates


def _page(name: str, **about: object) -> str:
    return _templates().get_template(name).render(**about)


def error_page(text: str) -> str:
    """Return a page that states an error."""
    return _page("error.html", text=visible_text(text))


def _list(asked: Asked) -> Answer:
    """Return the list of inspections, without verdicts."""
    groups: dict[str, list[Inspection]] = {}
    for inspection in (inspections := asked.session.inspections()):
        groups.setdefault(inspection.breaker, []).append(inspection)
    links = {}
    for inspection in inspections:
        before = earlier_than(inspection, inspections)[:1]
        links[inspection] = Choices(inspection.files, before[0].files if before else ()).query
    folder = printable(os.path.abspath(asked.session.named))
    full = sum(len(inspection.files) for inspection in inspections) >= MOST
    about = {"most": full and MOST, "unread": unread_files(asked.session.named)}
    return _page("list.html", folder=folder, groups=groups, links=links, **about)


def _verdict(asked: Asked) -> Answer:
    """Return the verdict on an inspection of the list."""
    if (diagnosis := (shown := asked.shown).diagnosis) is None:
        reason = shown.trouble.splitlines()[:2][-1].strip()  # the first reason
        return {"verdict": "unread", "text": f"not readable: {visible_text(reason)}"}
    result = diagnosis.result
    rejected = [str(record["reason"]) for record in result["records"] if not record["accepted"]]
    text = "; ".join([verdict_of(result) if result["verdict"] else "no limits", *rejected[:1]])
    return {"verdict": result["verdict"] or "none", "text": visible_text(text)}


def _inspection(asked: Asked) -> Answer:
    """Return the page of an inspection: its report, with curves instead of pictures, and forms."""
    session, shown = asked.session, asked.shown
    chosen, diagnosis, every = shown.choices, shown.diagnosis, session.inspections()
    own = next((e for e in every if {*chosen.files} <= {*e.files}), None)
    earlier = earlier_than(own, every) if own else ()
    report = report_of(diagnosis) if diagnosis else None
    return _page(
        "inspection.html",
        names=[printable(name_of(file)) for file in chosen.files],
        shown=shown,
        overlay=yaml.safe_dump(shown.overlay, sort_keys=False, allow_unicode=True),
        types=types.read_types(session.types, session.config),
        types_file=printable(os.path.relpath(session.types)),
        earlier=[(e, chosen._replace(before=e.files).query) for e in earlier],
        alone=chosen._replace(before=()).query,
        lacking=[row.label for row in shown.rows if row.state == "missing"],
        doubts=sum(row.state in ("missing", "doubtful") for row in shown.rows),
        report=report,
        verdict=(diagnosis.result["verdict"] or "none") if diagnosis else "unread",
        quantities=_measured(diagnosis.result) if diagnosis else {},
        motions=[curves.drawn(panel, diagnosis) for panel in report.panels] if report else [],
    )


def _measured(result: Result) -> dict[str, str]:
    """Return words and unit of measured quantities that a limit may bound, by name in a type."""
    measured = {
        name if record["motion"] in name else f"{record['motion']} {name}": value["unit"]
        for record in accepted(result)
        for name, value in record["quantities"].items()
        if name not in INFERRED
    }
    return {name: f"{in_words(name)} ({unit})" for name, unit in sorted(measured.items())}


def _sheet(asked: Asked) -> Answer:
    """Return the report that ``breaker report`` writes."""
    from breaker.figures.reports import report_page  # matplotlib loads for half a second

    if (diagnosis := (shown := asked.shown).diagnosis) is None:
        raise ValueError(shown.trouble)
    return report_page(report_of(diagnosis))


def _set(asked: Asked) -> Answer:
    """Set a limit of a type, and show the inspection with this type."""
    session, keys = asked.session, ("type", "quantity", "low", "high")
    name, *limit = (asked.form.get(key, [""])[-1].strip() for key in keys)
    types.set_limit(session.types, session.config, name, *limit)
    return Moved("/inspection?" + read_choices(asked.query)._replace(type=name).query)


VIEWS = {
    ("GET", ""): _list,
    ("GET", "verdict"): _verdict,
    ("GET", "inspection"): _inspection,
    ("GET", "sheet"): _sheet,
    ("POST", "set"): _set,
}
"""Views by method and path."""
