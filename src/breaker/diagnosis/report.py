"""A test report of a visit: what is measured of each channel against limits, and what it means.

Tables hold words, from documents of plain values; panels hold the curves, which
``figures.report`` draws. ``documents.html_page`` writes both.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from breaker.common.numerals import first_of, natural
from breaker.common.parts import Cell, Document, Letterhead, Table
from breaker.diagnosis.change_table import changes_table
from breaker.diagnosis.curves import Panel, panel_of
from breaker.diagnosis.estimate import Estimate
from breaker.diagnosis.identity import nameplate, printed_values
from breaker.diagnosis.report_tables import (
    RESULTS,
    few,
    measured_table,
    model_table,
    named,
    some_of,
)
from breaker.diagnosis.result import RecordResult
from breaker.diagnosis.result import document as document_of
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.simultaneity import simultaneity_of
from breaker.diagnosis.words import say
from breaker.records.files import read_bytes

_Pair = tuple[Estimate, RecordResult]


@dataclass(frozen=True)
class Report(Document):
    """A report: its summary is warnings, then what all limits together say.

    Attributes:
        panels: One for each motion of each operation.
    """

    panels: Sequence[Panel] = ()


def report_of(diagnosis: Diagnosis) -> Report:
    """Return the report of an inspection.

    Args:
        diagnosis: With records; the channel of a record is its operation's ``phase``.

    Raises:
        ValueError: If the logo of the configuration cannot be used.
    """
    answers, records = diagnosis.estimates, diagnosis.records
    document = document_of(answers, diagnosis.verdicts, {}, {})
    found = document.records
    pairs = [pair for pair in zip(answers, found, strict=True) if pair[1].accepted]
    entries = [entry for _, entry in pairs]
    phases = list(dict.fromkeys(each.phase for each in entries))
    tables, panels, poles = [], [], []
    most = diagnosis.config["report"]["simultaneity"]
    printed = printed_values(records, diagnosis.speeds_of(records))
    for own in _motions(pairs):
        title, channels = _title([e for _, e in own]), {each.phase: each for _, each in own}
        together = simultaneity_of(channels, most)
        poles.append((f"simultaneity {own[0][1].motion}", together.verdict))
        tables.append(measured_table(title, channels, printed, together.said))
        panels.append(panel_of([each for each, _ in own], diagnosis.overlays, title))
    if lines := dict.fromkeys(each.reason for each in found if not each.accepted):
        tables.append(Table(title="Not read", notes=few([*lines])))
    if changed := diagnosis.changes:
        tables.append(changes_table(changed, phases))
    tables.append(model_table(entries))
    said = [(phase, w) for phase, each in changed.items() for w in each.warnings]
    warnings = [f"WARNING: {each}" for each in document.warnings]
    warnings += named(said, len(changed))
    summary = [*(Cell(each, "bad") for each in warnings), _verdict(entries, poles, len(phases))]
    about = {"panels": panels, "letterhead": letterhead_of(diagnosis.config["report"])}
    given = {name: ", ".join(texts) for name, texts in diagnosis.given_words.items() if texts}
    plate = [*nameplate(records, diagnosis.before), *given.items()]
    return Report("Test report", plate, summary, tables, **about)


def _motions(pairs: Iterable[_Pair]) -> list[list[_Pair]]:
    """Motions of operations, with all poles of each, in the order of their files."""
    found: dict[tuple, list] = {}
    for answer, entry in pairs:
        key = entry.operation, entry.motion
        there = {each.phase for _, each in found.get(key, ())}
        key += (entry.file,) if entry.phase in there else ()
        found.setdefault(key, []).append((answer, entry))
    every = sorted({entry.file for some in found.values() for _, entry in some}, key=natural)
    files = {file: k for k, file in enumerate(every)}
    for some in found.values():
        some.sort(key=lambda pair: files[pair[1].file])
    return sorted(found.values(), key=lambda own: (files[own[0][1].file], own[0][1].fit.moves))


def _title(entries: Sequence[RecordResult]) -> str:
    """Which motion it is: when, of several in a file; of which operation, where that counts."""
    entry, files = entries[0], list(dict.fromkeys(each.file for each in entries))
    said = entry.motion
    if entry.part:
        said += f" at {entry.fit.moves:.0f} ms"
    if entry.about.get("breaker") or entry.about.get("date"):
        said += f", operation {entry.operation}"
    return f"{said}: {first_of([file.rpartition('/')[2] for file in files], 1)}"


def _verdict(
    entries: Sequence[RecordResult], poles: Iterable[tuple[str, str]], channels: int
) -> Cell:
    """What all limits together say, those on single poles and those on what poles differ by."""
    found: dict[str, dict[str, list[str]]] = {verdict: {} for verdict in RESULTS}
    for entry in entries:
        for each in entry.limits or ():
            found[each.verdict].setdefault(each.name, []).append(entry.phase)
    for name, verdict in poles:
        if verdict:
            found[verdict].setdefault(name, [])
    passed = found.pop("pass")
    if said := {verdict: names for verdict, names in found.items() if names}:
        texts = []
        for verdict, names in said.items():
            of = [some_of(name, where, channels) for name, where in names.items()]
            texts.append(f"{RESULTS[verdict][0]}: {', '.join(of)}")
        return Cell("; ".join(texts), RESULTS[next(iter(said))][1])
    if passed:
        return Cell(f"pass: none of {len(passed)} limits is exceeded", "good")
    return Cell("no limit is configured: values are stated, not judged", "faint")


def letterhead_of(settings: Mapping) -> Letterhead:
    """Return what the section ``report`` puts around the report; ValueError of a wrong logo."""
    logo = b""
    if file := settings["logo"]:
        logo = read_bytes(file)
        if not logo.startswith(b"\x89PNG\r\n\x1a\n"):
            raise ValueError(say("logo-not-png", file=file))
    lines = [f"{who}: name, date" for who in settings["signatures"]]
    return Letterhead(settings["company"] or "", logo, settings["remarks"] or "", lines)
