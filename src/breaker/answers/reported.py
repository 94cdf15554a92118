"""A test report of a visit: what is measured of each channel against limits, and what it means.

Tables hold words, from documents of plain values; panels hold the curves. ``figures.report`` and
``pages`` put both on paper, and compute nothing.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from breaker.answers.answer import Answer
from breaker.answers.cells import RESULTS, Cell, Table, few
from breaker.answers.documents import document as document_of
from breaker.answers.measured_tables import Group, measured_table
from breaker.answers.model_tables import changes_table, model_table
from breaker.answers.panels import Panel, panel_of
from breaker.files import natural
from breaker.mechanism import Limit

__all__ = ["Report", "report_of"]


class Report(NamedTuple):
    """A report.

    Attributes:
        plate: Names and values of the nameplate and the test.
        verdict: What all limits together say.
        tables: In their order.
        panels: One for each motion of each operation.
    """

    plate: list[tuple[str, str]]
    verdict: Cell
    tables: list[Table]
    panels: list[Panel]


def report_of(
    answers: Sequence[Answer],
    verdicts: Sequence[Sequence[Mapping]],
    limits: Sequence[Limit],
    beside: Mapping[str, object],
) -> Report:
    """Return the report of a visit.

    Args:
        answers: Of all channels; that of a record is its operation's ``phase``.
        verdicts: Of each, what ``judged`` returns.
        limits: What they were judged by.
        beside: ``plate``, names and values; ``overlays`` over a good record; ``changes``, the
            document of a comparison by phase; ``printed``, values that the analyser printed, by
            (file, motion, phase, quantity); ``rejected``, sentences on what was not read.
    """
    entries = document_of(answers, verdicts, {}, {})["records"]
    pairs = [pair for pair in zip(answers, entries, strict=True) if pair[1]["accepted"]]
    phases = list(dict.fromkeys(answer.record.operation.phase for answer, _ in pairs))
    groups = _groups(pairs, phases)
    printed = beside.get("printed", {})
    tables = [measured_table(group, limits, printed) for group in groups]
    overlays = beside.get("overlays", ())
    if rejected := _rejected(entries, beside.get("rejected", ())):
        tables.append(Table("Not read", (), [], rejected))
    if changed := beside.get("changes"):
        tables.append(changes_table(changed, phases))
    tables.append(model_table(pairs, limits))
    panels = [
        panel_of([answer for answer, _ in group.channels.values()], overlays, group.title)
        for group in groups
    ]
    return Report(list(beside["plate"]), _verdict(pairs), tables, panels)


def _groups(pairs: Iterable[tuple[Answer, Mapping]], phases: Sequence[str]) -> list[Group]:
    """Motions of operations, file by file, in the order in which they come there."""
    found: dict[tuple, dict] = {}
    for answer, entry in pairs:
        of = answer.record.operation
        channels = found.setdefault((str(of.file), of.number, answer.record.motion), {})
        channels[of.phase] = (answer, entry)
    files = dict.fromkeys(str(answer.record.operation.file) for answer, _ in pairs)
    groups = [Group(channels, phases) for channels in found.values()]
    place = {file: k for k, file in enumerate(sorted(files, key=natural))}
    return sorted(
        groups,
        key=lambda each: (
            place[str(each.first.record.operation.file)],
            each.first.record.raw.moves,
        ),
    )


def _verdict(pairs: Sequence[tuple[Answer, Mapping]]) -> Cell:
    """What all limits together say."""
    found: dict[str, dict[str, dict[str, None]]] = {}
    phases = {entry.get("phase", "") for _, entry in pairs}
    names = set()
    for _, entry in pairs:
        for each in entry.get("limits", ()):
            names.add(each["name"])
            where = found.setdefault(each["verdict"], {}).setdefault(each["name"], {})
            where |= {entry["phase"]: None} if entry.get("phase") else {}
    if not names:
        return Cell("no limit is configured: values are stated, not judged", "faint")
    worst = next(verdict for verdict in RESULTS if verdict in found)
    if worst == "pass":
        return Cell(f"pass: none of {len(names)} limits is exceeded", "good")
    said = []
    for verdict, (result, _) in RESULTS.items():
        if verdict == "pass":  # the others hold
            break
        of = [
            name + (f" ({', '.join(where)})" if 0 < len(where) < len(phases) else "")
            for name, where in found.get(verdict, {}).items()
        ]
        said += [f"{result}: {', '.join(of)}"] if of else []
    return Cell("; ".join(said), RESULTS[worst][1])


def _rejected(entries: Sequence[Mapping], said: Iterable[str]) -> list[str]:
    lines = [*said, *(each["reason"] for each in entries if not each["accepted"])]
    return few(list(dict.fromkeys(lines)))
