"""A test report of a visit: what is measured of each channel against limits, and what it means.

Tables hold words, from documents of plain values; panels hold the curves. ``figures.report`` and
``html_page`` put both on paper, and compute nothing.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from breaker.drive.answers.answer_document import document as document_of
from breaker.drive.answers.change_table import changes_table
from breaker.drive.answers.evidence import Answer
from breaker.drive.answers.picture_data import Panel, panel_of
from breaker.drive.answers.report_tables import (
    RESULTS,
    Cell,
    Table,
    few,
    measured_table,
    model_table,
    named,
    some_of,
)
from breaker.reading.files.file_names import natural


class Report(NamedTuple):
    """A report.

    Attributes:
        plate: Names and values of the nameplate and the test.
        warnings: What is to be said first, as of a rate, or of visits that are not alike.
        verdict: What all limits together say.
        tables: In their order.
        panels: One for each motion of each operation.
    """

    plate: list[tuple[str, str]]
    warnings: list[str]
    verdict: Cell
    tables: list[Table]
    panels: list[Panel]


def report_of(
    answers: Sequence[Answer], verdicts: Sequence[Sequence[Mapping]], beside: Mapping[str, object]
) -> Report:
    """Return the report of a visit.

    Args:
        answers: Of all channels; that of a record is its operation's ``phase``.
        verdicts: Of each, what ``judged`` returns.
        beside: ``plate``, names and values; ``overlays`` over a good record; ``changes``, the
            document of a comparison by phase; ``printed``, what ``measured_table`` takes;
            ``rejected``, sentences on what was not read.
    """
    document = document_of(answers, verdicts, {}, {})
    found = document["records"]
    pairs = [pair for pair in zip(answers, found, strict=True) if pair[1]["accepted"]]
    entries = [entry for _, entry in pairs]
    phases = list(dict.fromkeys(map(_phase, entries)))
    tables, panels = [], []
    for own in _motions(pairs):
        title, channels = _title([e for _, e in own]), {_phase(each): each for _, each in own}
        tables.append(measured_table(title, channels, beside.get("printed", {})))
        panels.append(panel_of([each for each, _ in own], beside.get("overlays", ()), title))
    lines = [*beside.get("rejected", ()), *(e["reason"] for e in found if not e["accepted"])]
    if lines:
        tables.append(Table("Not read", (), [], few(list(dict.fromkeys(lines)))))
    if changed := beside.get("changes", {}):
        tables.append(changes_table(changed, phases))
    tables.append(model_table(entries))
    said = [(phase, w) for phase, each in changed.items() for w in each.get("warnings", ())]
    warnings = [*(f"WARNING: {each}" for each in document["warnings"]), *named(said, len(changed))]
    verdict = _verdict(entries, len(phases))
    return Report(list(beside["plate"]), warnings, verdict, tables, panels)


def _phase(entry: Mapping) -> str:
    return entry.get("phase") or ""


def _motions(pairs: Iterable[tuple[Answer, Mapping]]) -> list[list[tuple[Answer, Mapping]]]:
    """Motions of operations, with all poles of each, in the order of their files."""
    found: dict[tuple, list] = {}
    for answer, entry in pairs:
        key = entry["operation"], entry["motion"]
        there = {_phase(each) for _, each in found.get(key, ())}
        key += (entry["file"],) if _phase(entry) in there else ()
        found.setdefault(key, []).append((answer, entry))
    every = sorted({entry["file"] for some in found.values() for _, entry in some}, key=natural)
    files = {file: k for k, file in enumerate(every)}
    for some in found.values():
        some.sort(key=lambda pair: files[pair[1]["file"]])
    return sorted(
        found.values(), key=lambda own: (files[own[0][1]["file"]], own[0][1]["fit"]["moves"])
    )


def _title(entries: Sequence[Mapping]) -> str:
    """Which motion it is: when, of several in a file; of which operation, where that counts."""
    entry, files = entries[0], list(dict.fromkeys(each["file"] for each in entries))
    part = "from" in entry or "to" in entry
    said = entry["motion"] + (f" at {entry['fit']['moves']:.0f} ms" if part else "")
    of = f", operation {entry['operation']}" if entry.get("breaker") or entry.get("date") else ""
    more = f" and {len(files) - 1} more" if len(files) > 1 else ""
    return f"{said}{of}: {files[0].rpartition('/')[2]}{more}"


def _verdict(entries: Sequence[Mapping], channels: int) -> Cell:
    """What all limits together say."""
    found: dict[str, dict[str, list[str]]] = {verdict: {} for verdict in RESULTS}
    for entry in entries:
        for each in entry.get("limits", ()):
            found[each["verdict"]].setdefault(each["name"], []).append(_phase(entry))
    passed = found.pop("pass")
    if said := {verdict: names for verdict, names in found.items() if names}:
        text = "; ".join(
            f"{RESULTS[verdict][0]}: "
            + ", ".join(some_of(name, where, channels) for name, where in names.items())
            for verdict, names in said.items()
        )
        return Cell(text, RESULTS[next(iter(said))][1])
    if passed:
        return Cell(f"pass: none of {len(passed)} limits is exceeded", "good")
    return Cell("no limit is configured: values are stated, not judged", "faint")
