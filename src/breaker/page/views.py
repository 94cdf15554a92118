"""What the page answers to each request: HTML by templates, and data as JSON.

Every text of a file is escaped. A view reads what is asked, and returns an answer; it knows nothing
of the server, so tests call it without one.
"""

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from importlib.resources import files as resources
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from breaker.common.compiling import compile_now
from breaker.common.document import Document, html_page, tone_of
from breaker.common.text import bare, visible_text
from breaker.diagnosis.identity import nameplate
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.tables import rejected_table, remarks_table, state_table, verdict_of
from breaker.page import curves, types, values
from breaker.page.catalogue import Inspection, earlier_than
from breaker.page.choices import Choices, labelled, name_of, read_choices
from breaker.page.session import MissingError, Session, Shown
from breaker.records.files import printable

_STATIC = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}


class Asked(NamedTuple):
    """A request: the session, the rest of its path, its query, and the request with its body."""

    session: Session
    rest: str
    query: Mapping[str, list[str]]
    request: Any

    def text(self, name: str) -> str:
        """Return a value of the query; empty where it has none."""
        return self.query.get(name, [""])[-1]

    @property
    def choices(self) -> Choices:
        """The inspection that is asked for; MissingError if no file is named."""
        choices = read_choices(self.query)
        if not choices.files:
            raise MissingError("no file is named; open an inspection of the list")
        return choices

    @property
    def shown(self) -> Shown:
        """The inspection, in the state that the page knows."""
        return self.session.shown(self.choices, self.text("state"))


class File(NamedTuple):
    """An answer that is no page and no JSON: its bytes, type, and name if it is saved."""

    content: bytes
    kind: str
    name: str = ""


Answer = str | dict | File


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


def error_page(text: str, *, allowed: bool = True) -> str:
    """Return a page that says what is wrong."""
    return _page("error.html", text=visible_text(text), allowed=allowed)


# ---- the list ------------------------------------------------------------------------------------


def _list(asked: Asked) -> Answer:
    """The list of inspections; with ``look``, further files are described."""
    inspections = asked.session.inspections(look=bool(asked.text("look")))
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
    """The verdict on an inspection of the list, from measured values."""
    try:
        result = asked.session.measured(asked.choices).result
    except (ValueError, OSError) as error:
        reason = str(error).splitlines()[-1].strip()
        return {"verdict": "unread", "text": f"not readable: {visible_text(reason)}"}
    rejected = [str(record["reason"]) for record in result["records"] if not record["accepted"]]
    verdict = verdict_of(result) if result["verdict"] else "no limits"
    text = "; ".join([verdict, *rejected[:1]])
    return {"verdict": result["verdict"] or "none", "text": visible_text(text)}


def _drop(asked: Asked) -> Answer:
    """Files dropped on the page."""
    files = asked.request.files.get("file", [])
    asked.session.drop([(file.filename, file.body) for file in files])
    return {"dropped": len(files)}


# ---- an inspection -------------------------------------------------------------------------------


def _inspection(asked: Asked) -> Answer:
    """The page of an inspection: all that is known before anything is measured."""
    session, shown = asked.session, asked.session.shown(asked.choices)
    chosen, diagnosis = shown.choices, shown.diagnosis
    every = session.inspections(look=False)
    own = next((one for one in every if set(chosen.files) <= set(one.files)), None)
    earlier = earlier_than(own, [e for e in every if e.breaker == own.breaker]) if own else []
    tabs = curves.tabs_of(diagnosis.records) if diagnosis else []
    known, name = types.read_types(session.types, session.config), session.type_of(chosen)
    page = _page(
        "inspection.html",
        names=[printable(name_of(file)) for file in chosen.files],
        plate=nameplate(diagnosis.records, diagnosis.before) if diagnosis else [],
        shown=shown,
        type=name,
        types=known,
        entry=next((entry for other, entry in known.items() if bare(other) == bare(name)), None),
        types_file=printable(os.path.relpath(session.types)),
        earlier=[(one, chosen._replace(before=one.files).query) for one in earlier],
        alone=chosen._replace(before=()).query,
        lacking=[row.label for row in shown.rows if row.state == "missing"],
        doubts=sum(row.state in ("missing", "doubtful") for row in shown.rows),
        remarks=[labelled(remark) for remark in shown.remarks],
        tabs=[tab.title for tab in tabs],
    )
    return page


def _curves(asked: Asked) -> Answer:
    """The curves of a motion, or of all columns of a file that cannot be read."""
    shown, number = asked.shown, asked.text("tab")
    if shown.diagnosis is None:
        if shown.sheet is None:
            raise ValueError(shown.trouble)
        return curves.drawn_file(shown.sheet)
    tabs = curves.tabs_of(shown.diagnosis.records)
    if not number.isdecimal() or int(number) >= len(tabs):
        raise MissingError("there is no such motion; load the page again")
    own = asked.session.config["report"]["colours"]
    return curves.drawn(tabs[int(number)], shown.diagnosis, shown.files, own)


def _results(asked: Asked, *, with_model: bool) -> Answer:
    """Values, limits, verdicts, and marks on curves; once the model has answered, with its state of
    the drive and the changes.
    """
    find = asked.session.complete if with_model else asked.session.measured
    diagnosis = find(asked.choices, asked.text("state"))
    result, own = diagnosis.result, asked.session.config["report"]["colours"]
    tabs = curves.tabs_of(diagnosis.records)
    remarks = [remarks_table(result), rejected_table(result)]
    warnings = [str(note) for note in result["warnings"]]
    parts = {
        "verdict": _page(
            "verdict.html",
            verdict=result["verdict"] or "none",
            words=verdict_of(result),
            warnings=warnings,
        ),
        "values": _page("values.html", tables=[values.table_of(tab, diagnosis) for tab in tabs]),
        "remarks": _document(remarks),
    }
    if with_model:
        changes = [
            (table.title, table.notes, _document([replace(table, title="", notes=())]))
            for table in change_tables(diagnosis.changes)
        ]
        parts["changes"] = _page("changes.html", changes=changes)
        parts["model"] = _document([state_table(result)])
    marks = [
        curves.marks_of(tab, [e for e in diagnosis.estimates if e.record in tab.records], own)
        for tab in tabs
    ]
    count = sum(len(table.notes) for table in remarks)
    return {"parts": parts, "marks": marks, "remarks": count}


def _document(tables: list) -> Markup:
    """Return tables as HTML, which escapes its texts."""
    some = [table for table in tables if table.rows or table.notes]
    return Markup(html_page(Document(parts=some), inner="part")) if some else Markup()


def _sheet(asked: Asked) -> Answer:
    return asked.session.sheet(asked.choices, asked.text("state")).decode("utf-8")


def warm(session: Session) -> None:
    """Import and compile what an inspection needs, while the user looks at the list."""
    compile_now()
    with suppress(ValueError, OSError, StopIteration):
        file = next(name for name, path in session.files().items() if os.path.isfile(path))
        asked = Asked(session, "", {"file": [file], "tab": ["0"]}, None)
        for name in ("inspection", "curves", "values", "model"):
            VIEWS["GET", name](asked)


# ---- types ---------------------------------------------------------------------------------------


def _set(asked: Asked) -> Answer:
    """A limit, speed zone or ratio of a type."""
    session, about = asked.session, json.loads(asked.request.body)
    name, key, ends = (about.get(part) for part in ("type", "key", "ends"))
    types.set_of_type(session.types, session.config, str(name), str(key), [str(e) for e in ends])
    return {"text": f"saved for {name} in {session.types}"}


def _import(asked: Asked) -> Answer:
    session = asked.session
    count = types.import_types(session.types, session.config, asked.request.body)
    return {"text": f"{count} types added to {session.types}"}


def _export(asked: Asked) -> Answer:
    session = asked.session
    if not os.path.exists(session.types):
        raise MissingError("no type is saved yet: set a limit, then export the file")
    return File(Path(session.types).read_bytes(), "text/yaml", "types.yaml")


def _static(asked: Asked) -> Answer:
    """Scripts and styles of the page."""
    folder = resources("breaker.page").joinpath("static")
    if asked.rest not in [file.name for file in folder.iterdir()]:
        raise MissingError("there is no such file of the page")
    return File(folder.joinpath(asked.rest).read_bytes(), _STATIC[Path(asked.rest).suffix])


VIEWS = {
    ("GET", ""): _list,
    ("GET", "verdict"): _verdict,
    ("POST", "drop"): _drop,
    ("GET", "inspection"): _inspection,
    ("GET", "curves"): _curves,
    ("GET", "values"): partial(_results, with_model=False),
    ("GET", "model"): partial(_results, with_model=True),
    ("GET", "sheet"): _sheet,
    ("POST", "set"): _set,
    ("POST", "import"): _import,
    ("GET", "types.yaml"): _export,
    ("GET", "static"): _static,
}
"""Views by method and first part of the path."""

SLOW = ("verdict", "model", "sheet")
"""First parts of the paths of answers that may take long."""
