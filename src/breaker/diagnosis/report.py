"""Read an inspection of one breaker, and report it: verdict, values, changes, state and curves.

``breaker report`` and ``breaker view`` render this document, as HTML.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from breaker.common.document import Document
from breaker.configuration.data_files import types_of
from breaker.diagnosis.curves import Overlay, overlaid
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.identity import check_inspection, nameplate
from breaker.diagnosis.inspection_change import change_tables
from breaker.diagnosis.sentences import say
from breaker.diagnosis.session import Diagnosis, given_by
from breaker.diagnosis.tables import document_of, shown_of, title_of
from breaker.model.parameters import NAMES
from breaker.model.quantities import in_words, quantities
from breaker.records.files import Files
from breaker.records.named import Choice


def read_inspection(
    config: Mapping,
    limits: Sequence[Mapping],
    files: Sequence[str],
    *,
    before: Sequence[str] = (),
    channels: Sequence[str] = (),
    of_type: str = "",
    reference: str = "",
    same_transducer: bool = False,
    opened: Files | None = None,
) -> Diagnosis:
    """Return the diagnosis of the inspection in files.

    Args:
        config: The configuration.
        limits: Entries of the section ``limits``, in addition to those of the type.
        files: Records of the inspection, or their folder.
        before: Records of the earlier inspection.
        channels: Columns of travel; all that move by default.
        of_type: Type of the breaker; by default the type that the table or the files state.
        reference: A good record; by default the one of the type.
        same_transducer: Whether both inspections have the same transducer and ratio.
        opened: Cache of files.

    Raises:
        OSError, ValueError: If there is no usable record, or the inspection is of several breakers.
    """
    choice, opened = Choice(channels=channels, every=True), opened or Files()
    diagnosis = Diagnosis(config, limits, given_by(config), types=types_of(config))
    diagnosis = diagnosis.of_files(files, choice, opened, of_type)
    reference = reference or diagnosis.reference
    earlier, good = (
        diagnosis.of_files(named, choice, opened, diagnosis.type).records
        for named in (before, [reference] if reference else [])
    )
    check_inspection(diagnosis.records, earlier)
    if good and all(record.reason for record in good):
        raise ValueError(f"the reference cannot be used: {good[0].reason}")
    overlays, hidden = overlaid(diagnosis.records, good)
    for reason in hidden:
        logging.getLogger("breaker").warning(reason)
    if reference and not overlays:
        lacks = " or ".join(dict.fromkeys(record.motion for record in diagnosis.records))
        raise ValueError(f"the reference {reference} has no usable {lacks}; name one that has")
    fields = {"overlays": overlays, "same_transducer": same_transducer}
    return replace(diagnosis, before=earlier, **fields)


class Panel(NamedTuple):
    """One motion of all channels of an operation, and the overlays of all motions."""

    title: str
    estimates: Sequence[Estimate]
    overlays: Sequence[Overlay]


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
    plate = nameplate(records, diagnosis.before)
    plate = [*plate, ("Given", say("own-prior"))] if diagnosis.given.prior else plate
    known = quantities(diagnosis.speeds_of(records)).keys() - {*NAMES}  # parameters have symbols
    names = {name: in_words(name) for name in known}
    parts = {"title": "Test report", "plate": plate, "names": names, "panels": panels}
    parts |= {"company": diagnosis.config["report"]["company"] or ""}
    return Report(**vars(collected) | parts)
