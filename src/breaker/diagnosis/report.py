"""The report of an inspection: verdict, measured values, changes, remarks, state and curves.

``breaker report`` and ``breaker view`` render this document, as HTML.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from breaker.common.document import Document, Letterhead
from breaker.diagnosis.curves import Panel
from breaker.diagnosis.identity import nameplate
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import document_of, shown_of, title_of
from breaker.diagnosis.words import say
from breaker.model.parameters import NAMES
from breaker.model.quantities import in_words, quantities
from breaker.records.files import read_bytes


@dataclass(frozen=True)
class Report(Document):
    """A report: its summary is warnings, then the verdict on all limits.

    Attributes:
        panels: Curves of the operations that have a table.
        colours: The user's own colours of phases.
    """

    panels: Sequence[Panel] = ()
    colours: Mapping[str, str] = field(default_factory=dict)


def report_of(diagnosis: Diagnosis) -> Report:
    """Return the report of an inspection; the channel of a record is its operation's ``phase``.

    Raises:
        ValueError: If the logo of the configuration cannot be used.
    """
    records, result, changes = diagnosis.records, diagnosis.result, diagnosis.changes
    compared = [change for change in changes.values() if not isinstance(change, str)]
    doubts = [text for change in compared for text in change.warnings]
    collected = document_of(result, changes=change_tables(changes), doubts=doubts)
    by_record = dict(zip(map(id, result["records"]), diagnosis.estimates, strict=True))
    panels = [
        Panel(title_of(group), [by_record[id(row)] for row in group], diagnosis.overlays)
        for group in shown_of(result)
    ]
    plate = [*nameplate(records, diagnosis.before), *diagnosis.given.words.items()]
    known = quantities(diagnosis.speeds_of(records)).keys() - {*NAMES}  # parameters have symbols
    names = {name: in_words(name) for name in known}
    parts = {"title": "Test report", "plate": plate, "names": names, "panels": panels}
    settings = diagnosis.config["report"]
    parts |= {"letterhead": letterhead_of(settings), "colours": settings["colours"]}
    return Report(**vars(collected) | parts)


def letterhead_of(settings: Mapping) -> Letterhead:
    """Return the letterhead from the section ``report``; raise a ValueError for a wrong logo."""
    logo = b""
    if file := settings["logo"]:
        logo = read_bytes(file)
        if not logo.startswith(b"\x89PNG\r\n\x1a\n"):
            raise ValueError(say("logo-not-png", file=file))
    lines = [f"{who}: name, date" for who in settings["signatures"]]
    return Letterhead(settings["company"] or "", logo, settings["remarks"] or "", lines)
