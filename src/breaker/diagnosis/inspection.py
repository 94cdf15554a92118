"""Read an inspection of one breaker: its records, earlier records, and a good record."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from breaker.configuration.definitions import types_of
from breaker.diagnosis.curves import Overlay, overlaid
from breaker.diagnosis.estimate import DriveRecord
from breaker.diagnosis.identity import check_inspection
from breaker.diagnosis.session import Diagnosis, given_by
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
    overlays = _over(diagnosis.records, good, reference) if reference else ()
    fields = {"overlays": overlays, "same_transducer": same_transducer}
    return replace(diagnosis, before=earlier, **fields)


def _over(
    records: Sequence[DriveRecord],
    good: Sequence[DriveRecord],
    reference: str,
) -> list[Overlay]:
    """Compare records with good ones; raise a ValueError if no good record fits."""
    if good and all(record.reason for record in good):
        raise ValueError(f"the reference cannot be used: {good[0].reason}")
    if not (overlays := overlaid(records, good)):
        lacks = f"has no usable {' or '.join(dict.fromkeys(record.motion for record in records))}"
        raise ValueError(f"the reference {reference} {lacks}; name one that has")
    return overlays
