"""`breaker report`: write a test report of a visit."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from breaker.cli.command_inputs import (
    SEVERAL,
    add_path,
    add_reference,
    limits_of,
    overlays_of,
    read_visit,
    settings_of,
)
from breaker.cli.outputs import check_outputs, write_bytes
from breaker.common.visible_text import say

if TYPE_CHECKING:
    from breaker.documents.parts import Letterhead
    from breaker.drive.answers.assessment import Assessment
    from breaker.drive.answers.evidence import Answer, DriveRecord, Given
    from breaker.drive.answers.limit_verdicts import Verdict
    from breaker.drive.answers.test_report import Report, ReportContext
    from breaker.reading.files.guards import Files
    from breaker.reading.files.preamble import Preamble

_PLATE = ("station", "bay", "type", "serial")  # what a file may state of its breaker
_PNG = b"\x89PNG\r\n\x1a\n"
_BESIDE = ("Gas pressure", "Temperature", "Operator")  # and of the test


def add(report: argparse.ArgumentParser) -> None:
    """Write the report of a visit to one breaker: what is measured of each channel and motion
    against limits, what poles differ by, what has changed since the visit before, what the model
    adds, and the curves. A file may hold O, C, C-O or O-C-O, and several channels, which are phases
    or poles. The status is 1 if no record could be used.
    """
    add_path(report, "files", "FILE", "a record of the visit, or a folder of them", nargs="+")
    what = "write the report there; a PDF needs WeasyPrint, else print the page from a browser"
    add_path(report, "--output", "HTML|PDF", what, required=True)
    add_path(report, "--before", "FILE", "records of the visit before", **SEVERAL)
    what = "columns of travel (default: all that move)"
    report.add_argument("--channel", help=what, metavar="NAME", **SEVERAL)
    add_reference(report)


def _run(options: argparse.Namespace) -> int:
    read = [*options.files, *options.before, *filter(None, [options.reference]), *options.config]
    check_outputs([(options.output, "report")], read)
    if options.output.lower().endswith(".pdf"):
        from breaker.documents.html_page import weasyprint

        weasyprint()  # if it lacks, that is said before any work is done
    visit = visit_of(read_of(options))
    content, lacking = content_of(visit.report, Path(options.output).suffix)
    write_bytes(options.output, content)
    *warnings, verdict = visit.report.summary
    for each in warnings:
        say(each)
    for reason in dict.fromkeys(each.reason for each in visit.records if each.reason):
        say(f"breaker: not in the report: {reason}", beside=True)
    say(f"{verdict}\nreport written to {options.output}")
    if lacking:
        say(lacking)
    return 0


class ReadVisit(NamedTuple):
    """What was read of a visit, and what is asked of it.

    Attributes:
        assessment: By which it is inferred and judged.
        records, before: Of the visit, and of the one before.
        beside: What a report shows beside answers and changes.
    """

    assessment: "Assessment"
    records: Sequence["DriveRecord"]
    before: Sequence["DriveRecord"]
    beside: "ReportContext"


class Visit(NamedTuple):
    """What is known of a visit, and its report."""

    records: Sequence["DriveRecord"]
    answers: Sequence["Answer"]
    verdicts: Sequence[Sequence["Verdict"]]
    report: "Report"


def read_of(options: argparse.Namespace, files: "Files | None" = None) -> ReadVisit:
    """Read the records that the command names, their files opened once, in those that are given.

    Raises:
        OSError, ValueError: If there is nothing of which a report can be.
    """
    config = settings_of(options.config)
    limits = limits_of(config, options.config)
    options = _with_reference(options, config["report"]["reference"])
    # Imported here, so that --help and wrong options answer at once.
    from breaker.drive.answers.assessment import Assessment, given_by
    from breaker.drive.answers.test_report import ReportContext

    given, words = given_by(config)
    assessment = Assessment(config, limits, given)
    records = _usable(read_visit(options.files, options, assessment, files), "record")
    named = [options.reference] if options.reference else []
    good = read_visit(named, options, assessment, files)
    before = read_visit(options.before, options, assessment, files)
    before = _usable(before, "record of the visit before")
    overlays = overlays_of(records, good, options)
    _check_one(records)
    stated = {each.operation.file: each.stated for each in records}
    speeds = {each.name: each for each in assessment.speeds_of(records)}
    beside = ReportContext(
        plate=[*_plate(records, before, stated), *_beside_records(given, words)],
        printed=_printed(stated, records, speeds),
        overlays=overlays,
        rejected=[each.reason for each in good if each.reason],
        mass=assessment.mass,
        letterhead=_letterhead(config["report"]),
        simultaneity=config["report"]["simultaneity"],
    )
    return ReadVisit(assessment, records, before, beside)


def _with_reference(options: argparse.Namespace, stated: Mapping) -> argparse.Namespace:
    """Options with the good record of the configuration, and its band, where they name none."""
    own = {"reference": options.reference or stated["file"], "tolerance": options.tolerance}
    if own["reference"] and own["tolerance"] is None and stated["tolerance"]:
        own["tolerance"] = stated["tolerance"] / 100.0
    return argparse.Namespace(**{**vars(options), **own})


def visit_of(read: ReadVisit) -> Visit:
    """Infer and judge records, and compare them with those before; nothing is written."""
    from breaker.drive.answers.test_report import report_of

    assessment, records = read.assessment, read.records
    answers = assessment.infer(records)
    beside = replace(read.beside, changes=_changes(records, read.before, assessment))
    verdicts = assessment.judge(answers)
    report = report_of(answers, verdicts, beside)
    return Visit(records, answers, verdicts, report)


def _letterhead(settings: Mapping) -> "Letterhead":
    """What the section ``report`` of the configuration puts around the report.

    Raises:
        ValueError: If the logo cannot be read or is no PNG.
    """
    from breaker.documents.parts import Letterhead
    from breaker.reading.files.guards import read_bytes

    logo = b""
    if settings["logo"]:
        try:
            logo = read_bytes(settings["logo"])
        except ValueError as error:
            raise ValueError(f"report.logo: {error}") from error
        if not logo.startswith(_PNG):
            raise ValueError(f"report.logo: {settings['logo']} is no PNG file; convert it to one")
    lines = [f"{who}: name, date" for who in settings["signatures"]]
    return Letterhead(settings["company"] or "", logo, settings["remarks"] or "", lines)


def _check_one(records: Sequence) -> None:
    """Refuse files that name different breakers: poles of one may have numbers, but one bay."""
    for name, beside in (("serial", "bay"), ("bay", "serial")):
        named, same = ({getattr(each.stated, of) for each in records} for of in (name, beside))
        if len(named - {""}) > 1 and (len(same) > 1 or not all(same)):
            raise ValueError(
                f"a report is of one breaker, and the files state {name} "
                f"{' and '.join(sorted(named - {''}))}; write one report of each"
            )


def _usable(records: Sequence, what: str) -> Sequence:
    """Return records of a visit, some of which can be used, or none at all.

    Raises:
        ValueError: If none of those that are there can be used.
    """
    if records and all(each.reason for each in records):
        reasons = "\n  ".join(dict.fromkeys(each.reason for each in records))
        raise ValueError(f"no {what} can be used; breaker inspect FILE says how:\n  {reasons}")
    return records


def _plate(records: Sequence, before: Sequence, stated: Mapping) -> list[tuple[str, str]]:
    """Nameplate and test, as far as they are known: of the table of operations, and of files."""
    from breaker.common.numerals import first_of, in_digits
    from breaker.documents.parts import Cell
    from breaker.drive.answers.file_statements import dates_in_words
    from breaker.reading.files.guards import printable

    operations = [each.operation for each in records]
    files = dict.fromkeys(each.operation.file for each in records if not each.reason)
    shown = [
        f"{in_digits(each.temperature, 4)} °C" if each.temperature == each.temperature else ""
        for each in operations
    ]
    beside = {name: [_beside(each, name) for each in stated.values()] for name in _BESIDE}
    serials = [each.serial for each in stated.values()]
    known = {
        "Breaker": [each.breaker for each in operations if each.breaker] or serials,
        "Test date": [each.operation.date or " or ".join(each.stated.dates) for each in records],
        **({"Visit before": [dates_in_words(before)]} if before else {}),
        "Files": [first_of([printable(file).rpartition("/")[2] for file in files], 1)],
        **{name.title(): [getattr(each, name) for each in stated.values()] for name in _PLATE},
        "Linkage ratio": [
            in_digits(each.ratio, 6) for each in stated.values() if each.ratio == each.ratio
        ],
        **(beside | ({"Temperature": shown} if any(shown) else {})),
        "Channels": [each.phase for each in operations],
        "Contacts": [str(each.settings.get("contact_column") or "") for each in operations],
        "Motions": [each.motion for each in records],
    }
    pairs = [(n, ", ".join(filter(None, dict.fromkeys(e)))) for n, e in known.items()]
    always = "Breaker", "Test date", "Visit before"
    lacking = Cell("not stated", "faint")
    return [(name, text or lacking) for name, text in pairs if text or name in always]


def _beside_records(given: "Given", words: Sequence[str]) -> list[tuple[str, str]]:
    """What is given beside the records, as rows of the nameplate."""
    facts = [f"{name} {value:g} with an sd of {sd:g}" for name, (value, sd) in given.known.items()]
    known = {"Given": words, "Known": facts}
    return [(name, ", ".join(each)) for name, each in known.items() if each]


def _beside(stated: "Preamble", name: str) -> str:
    """What a file states of a test by the words of its name, with its unit; nothing if it does
    not.
    """
    from breaker.reading.files.lexicon import STATED
    from breaker.reading.files.word_meanings import says

    found = (each for each in stated.pairs if says(each.name, STATED[name]))
    return next((f"{each.text} {each.unit}".rstrip() for each in found if each.text), "")


def _printed(stated: Mapping, records: Sequence, speeds: Mapping) -> dict:
    """What the analyser printed, by file, motion, channel and quantity: the value, what differs
    in its definition, and what the analyser means by it.

    A channel is meant by its phase, or else by its number among those of the file.
    """
    from breaker.reading.files.guards import printable
    from breaker.reading.files.word_meanings import channel_of, phase_in
    from breaker.reading.inspection.printed_comparison import (
        meant_motions,
        measured_name,
        stated_speeds,
    )

    found = {}
    for file, preamble in stated.items():
        own = [each for each in records if each.operation.file == file]
        phases = list(dict.fromkeys(each.operation.phase for each in own))
        own_speeds = stated_speeds(preamble)
        for each in preamble.results:
            place = channel_of(each.channel) - 1
            phase = phase_in(each.channel) or each.channel
            if phase not in phases and 0 <= place < len(phases):
                phase = phases[place]
            for motion in meant_motions(each, (record.motion for record in own)):
                name = measured_name(each, motion)
                odd = each.quantity == "speed" and own_speeds.get(motion) != speeds.get(name)
                if name and not isnan(each.size):
                    value = each.value * each.size, "other points" * odd, each.quantity
                    found.setdefault((printable(file), motion, phase, name), value)
    return found


def _changes(records: Sequence, before: Sequence, assessment: "Assessment") -> dict:
    """The comparison with the visit before, by channel; one that either visit has alone is the
    same where one of them does not name it.
    """
    if not before:
        return {}
    from breaker.drive.answers.change_table import NotCompared

    unjudged = replace(assessment, limits=())
    rejected = [each.reason for each in before if each.reason]
    found = {}
    there = {each.operation.phase for each in before}
    phases = list(dict.fromkeys(each.operation.phase for each in records))
    alone = len(there) == len(phases) == 1 and not all([*there, *phases])
    for phase in phases:
        own = [e for e in before if alone or e.operation.phase == phase]
        visits = {"before": own, "today": [e for e in records if e.operation.phase == phase]}
        if not visits["before"]:
            lacks = [*rejected, f"the visit before has no channel {phase}".rstrip()]
            found[phase] = NotCompared(lacks)
            continue
        try:
            found[phase] = unjudged.compare(visits)
        except ValueError as error:
            found[phase] = NotCompared([*rejected, str(error).splitlines()[0]])
    return found


def content_of(report: "Report", ending: str) -> tuple[bytes, str]:
    """Return a report as ".html" or ".pdf", and what to say of its letters.

    Raises:
        ValueError: If it is to be a PDF, and WeasyPrint is not installed.
    """
    from breaker.documents.html_page import html_page, pdf_of
    from breaker.figures.encoding import encoded, without_font
    from breaker.figures.report import curves

    pictures = list(curves(report.panels))
    page = html_page(report, [encoded(each, "png") for each in pictures])
    content = pdf_of(page) if ending.lower() == ".pdf" else page.encode("utf-8")
    return content, without_font(pictures)
