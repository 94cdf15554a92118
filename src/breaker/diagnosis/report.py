"""The report of an inspection: verdict, measured values, changes, remarks, state and curves.

``breaker report`` and ``breaker view`` render this document, as HTML.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from breaker.common.document import Document
from breaker.diagnosis.curves import Panel
from breaker.diagnosis.identity import nameplate
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.tables import document_of, shown_of, title_of
from breaker.model.parameters import NAMES
from breaker.model.quantities import in_words, quantities


@dataclass(frozen=True)
class Report(Document):
    """A report: its summary is warnings, then the verdict on all limits.

    Attributes:
        panels: Curves of the operations that have a table.
    """

    panels: Sequence[Panel] = ()


def report_of(diagnosis: Diagnosis) -> Report:
    """Return the report of an inspection; the channel of a record is its operation's ``phase``."""
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
    parts |= {"company": diagnosis.config["report"]["company"] or ""}
    return Report(**vars(collected) | parts)
