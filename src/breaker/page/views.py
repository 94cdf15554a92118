"""What the page answers to each request: HTML by templates, and data as JSON.

Every text of a file is escaped. A view reads what is asked, and returns an answer; it knows nothing
of the server, so tests call it without one.
"""

import importlib.util
import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache
from importlib.resources import files as resources
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from breaker.common.document import Document, html_page, tone_of
from breaker.common.text import bare, visible_text
from breaker.diagnosis.identity import nameplate
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import rejected_table, remarks_table, state_table
from breaker.page import curves, types, values
from breaker.page.catalogue import Inspection, earlier_than
from breaker.page.choices import Choices, name_of, read_choices
from breaker.page.session import MissingError, Session, Shown
from breaker.records.files import printable

_TYPES = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_OWN = ("page.js", "page.css", "icon.svg")


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
        found = read_choices(self.query)
        if not found.files:
            raise MissingError("no file is named; open an inspection of the list")
        return found

    @property
    def shown(self) -> Shown:
        """The inspection, in the state that the page knows."""
        return self.session.shown(self.choices, self.text("state"))

    def diagnosis(self) -> Diagnosis:
        """Return the inspection, measured, or with the model's answer."""
        find = self.session.diagnosis if self.text("model") else self.session.measured
        return find(self.choices, self.text("state"))


class Answer(NamedTuple):
    """The content of an answer, and its headers."""

    content: str | bytes | dict
    headers: Mapping[str, str] = {}


class View(NamedTuple):
    """A function that answers, and whether it may take long."""

    find: Callable[[Asked], Answer]
    is_slow: bool = False


@cache
def _templates() -> jinja2.Environment:
    found = jinja2.Environment(
        loader=jinja2.PackageLoader("breaker.page"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters |= {"printable": printable, "lines": visible_text, "tone": tone_of}
    return found


def _page(name: str, **about: object) -> str:
    return _templates().get_template(name).render(**about)


def error_page(text: str, *, allowed: bool = True) -> str:
    """Return a page that says what is wrong."""
    return _page("error.html", text=visible_text(text), allowed=allowed)


# ---- the list ------------------------------------------------------------------------------------


def _list(asked: Asked) -> Answer:
    """The list of inspections; with ``look``, further files are described."""
    session = asked.session
    found = session.inspections(look=bool(asked.text("look")))
    folder = printable(os.path.abspath(session.named))
    groups: dict[str, list[Inspection]] = {}
    for each in found:
        groups.setdefault(each.breaker, []).append(each)
    count = sum(len(each.files) for each in found)
    seen = sum(len(each.files) for each in found if each.seen)
    links = {}
    for each in found:
        before = earlier_than(each, groups[each.breaker])[:1]
        links[each] = Choices(each.files, before[0].files if before else ()).query
    page = _page("list.html", folder=folder, groups=groups, links=links, count=count, seen=seen)
    return Answer(page)


def _verdict(asked: Asked) -> Answer:
    """The verdict on an inspection of the list, from measured values."""
    try:
        diagnosis = asked.session.measured(asked.choices)
        verdict, text = values.verdict_in_words(diagnosis.result)
        rejected = [str(e["reason"]) for e in diagnosis.result["records"] if not e["accepted"]]
        text = "; ".join([str(text)] * bool(verdict) + rejected[:1])
        return Answer({"verdict": verdict or "none", "text": visible_text(text)})
    except (ValueError, OSError) as error:
        reason = visible_text(str(error).splitlines()[-1].strip())
        return Answer({"verdict": "unread", "text": reason})


def _drop(asked: Asked) -> Answer:
    """Files dropped on the page."""
    some = asked.request.files.get("file", [])
    asked.session.drop([(each.filename, each.body) for each in some])
    return Answer({"dropped": len(some)})


# ---- an inspection -------------------------------------------------------------------------------


def _inspection(asked: Asked) -> Answer:
    """The page of an inspection: all that is known before anything is measured."""
    session, shown = asked.session, asked.session.shown(asked.choices)
    chosen, diagnosis = shown.choices, shown.diagnosis
    every = session.inspections(look=False)
    own = next((one for one in every if set(chosen.files) <= set(one.files)), None)
    same = [one for one in every if own and one.breaker == own.breaker]
    earlier = earlier_than(own, same) if own else []
    tabs = curves.tabs_of(diagnosis.records) if diagnosis else []
    known, name = types.read_types(session.types, session.config), session.type_of(chosen)
    page = _page(
        "inspection.html",
        names=[printable(name_of(each)) for each in chosen.files],
        plate=nameplate(diagnosis.records, diagnosis.before) if diagnosis else [],
        shown=shown,
        type=name,
        types=known,
        ratio=next((e.get("ratio") or "" for n, e in known.items() if bare(n) == bare(name)), ""),
        new_type=bool(name) and not any(bare(each) == bare(name) for each in known),
        types_file=printable(session.types),
        earlier=[(each, chosen._replace(before=each.files).query) for each in earlier],
        alone=chosen._replace(before=()).query,
        lacking=[row.label for row in shown.rows if row.state == "missing"],
        doubts=sum(row.state in ("missing", "doubtful") for row in shown.rows),
        tabs=[tab.title for tab in tabs],
        pdf=importlib.util.find_spec("weasyprint") is not None,
    )
    return Answer(page)


def _tab(asked: Asked, diagnosis: Diagnosis) -> curves.Tab:
    tabs, number = curves.tabs_of(diagnosis.records), asked.text("tab")
    if not number.isdecimal() or int(number) >= len(tabs):
        raise MissingError("there is no such motion; load the page again")
    return tabs[int(number)]


def _curves(asked: Asked) -> Answer:
    """The curves of a motion, as an item of Bokeh."""
    shown, dark = asked.shown, bool(asked.text("dark"))
    if shown.diagnosis is None:
        if shown.sheet is None:
            raise ValueError(shown.trouble)
        return Answer(curves.drawn_file(shown.sheet, dark))
    diagnosis = shown.diagnosis
    own = asked.session.config["report"]["colours"]
    return Answer(curves.drawn(_tab(asked, diagnosis), diagnosis, shown.files, dark, own))


def _values(asked: Asked) -> Answer:
    """Values, limits and verdicts, and the marks on curves; with ``model``, all that it adds."""
    diagnosis = asked.diagnosis()
    tabs = curves.tabs_of(diagnosis.records)
    by_record = {id(each.record): each for each in diagnosis.estimates}
    estimates = [[by_record[id(record)] for record in tab.records] for tab in tabs]
    pairs = [*zip(tabs, estimates, strict=True)]
    verdict, words = values.verdict_in_words(diagnosis.result)
    with_model, own = bool(asked.text("model")), asked.session.config["report"]["colours"]
    warnings = [str(note) for note in diagnosis.result["warnings"]]
    compared = change_tables(diagnosis.changes) if with_model else []
    changes = [
        (table.title, table.notes, _document([replace(table, title="", notes=())]))
        for table in compared
    ]
    tables = [values.table_of(*pair, diagnosis) for pair in pairs]
    remarks = [remarks_table(diagnosis.result), rejected_table(diagnosis.result)]
    parts = {
        "verdict": _page("verdict.html", verdict=verdict, words=words, warnings=warnings),
        "values": _page("values.html", tables=tables),
        "changes": _page("changes.html", changes=changes),
        "model": _document([state_table(diagnosis.result)] if with_model else []),
        "remarks": _document(remarks),
    }
    counts = {"remarks": sum(len(table.notes) for table in remarks)}
    marks = [curves.marks_of(*pair, own) for pair in pairs]
    return Answer({"parts": parts, "marks": marks, "counts": counts})


def _document(tables: list) -> Markup:
    """Return tables as HTML, which escapes its texts."""
    some = [each for each in tables if each.rows or each.notes]
    return Markup(html_page(Document(parts=some), inner="part")) if some else Markup()


def _sheet(asked: Asked) -> Answer:
    kinds = {".pdf": "application/pdf", ".html": "text/html"}
    if (ending := Path(asked.rest).suffix) not in kinds:
        raise MissingError("a sheet is HTML or a PDF")
    content = asked.session.sheet(asked.choices, asked.text("state"), ending)
    name = f'attachment; filename="sheet{ending}"'
    return Answer(content, {"Content-Type": kinds[ending], "Content-Disposition": name})


def _save(asked: Asked) -> Answer:
    name = asked.request.body.decode("utf-8", "replace").strip()
    if not name or "\0" in name:
        raise ValueError("name the file that is to be written")
    return Answer({"text": asked.session.save(asked.choices, name)})


def warm(session: Session) -> None:
    """Import and compile what an inspection needs, while the user looks at the list."""
    with suppress(ValueError, OSError, StopIteration):
        name = next(name for name, path in session.files().items() if os.path.isfile(path))
        asked = Asked(session, "", {"file": [name], "tab": ["0"], "model": ["1"]}, None)
        for view in (_inspection, _curves, _values):
            view(asked)


# ---- types ---------------------------------------------------------------------------------------


def _set(asked: Asked) -> Answer:
    """A limit, speed zone or ratio of a type."""
    session, about = asked.session, json.loads(asked.request.body)
    name, key, ends = (about.get(each) for each in ("type", "key", "ends"))
    types.set_of_type(session.types, session.config, str(name), str(key), [str(e) for e in ends])
    return Answer({"text": f"saved for {name} in {session.types}"})


def _import(asked: Asked) -> Answer:
    session = asked.session
    count = types.import_types(session.types, session.config, asked.request.body)
    return Answer({"text": f"{count} types added to {session.types}"})


def _export(asked: Asked) -> Answer:
    session = asked.session
    if not os.path.exists(session.types):
        raise MissingError("no type is saved yet: set a limit, then export the file")
    about = {"Content-Disposition": 'attachment; filename="types.yaml"'}
    return Answer(Path(session.types).read_bytes(), {"Content-Type": "text/yaml", **about})


def _static(asked: Asked) -> Answer:
    """Scripts and styles, Bokeh's from its own package."""
    name, about = asked.rest, {}
    if name in _OWN:
        content = resources("breaker.page").joinpath("static", name).read_bytes()
    elif name == "bokeh.min.js":
        place = importlib.util.find_spec("bokeh").origin
        content = (Path(place).parent / "server" / "static" / "js" / name).read_bytes()
        about = {"Cache-Control": "private, max-age=86400"}
    else:
        raise MissingError("there is no such file of the page")
    kind = f"{_TYPES[Path(name).suffix]}; charset=utf-8"
    return Answer(content, {"Content-Type": kind, **about})


VIEWS = {
    ("GET", ""): View(_list),
    ("GET", "verdict"): View(_verdict, is_slow=True),
    ("POST", "drop"): View(_drop),
    ("GET", "inspection"): View(_inspection),
    ("GET", "curves"): View(_curves),
    ("GET", "values"): View(_values),
    ("GET", "model"): View(_values, is_slow=True),
    ("GET", "sheet"): View(_sheet, is_slow=True),
    ("POST", "save"): View(_save),
    ("POST", "set"): View(_set),
    ("POST", "import"): View(_import),
    ("GET", "types.yaml"): View(_export),
    ("GET", "static"): View(_static),
}
"""Views by method and first part of the path."""
