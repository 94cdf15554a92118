"""`breaker report`: write a test report of an inspection."""

import argparse
from pathlib import Path

from breaker.cli import inputs
from breaker.cli.outputs import check_outputs, write
from breaker.common.text import say


def add(report: argparse.ArgumentParser) -> None:
    """Write the report of an inspection of one breaker: measured values against limits, the
    simultaneity of poles, changes since the earlier inspection, the state by the model, and the
    curves. A file may contain O, C, C-O or O-C-O, and several channels, which are phases or poles.
    The exit status is 1 if no record can be used.
    """
    inputs.add_path(
        report, "files", "FILE", "records of the inspection, or their folder", nargs="+"
    )
    what = "write the report to this file; a PDF needs WeasyPrint"
    inputs.add_path(report, "--output", "HTML|PDF", what, required=True)
    inputs.add_path(
        report, "--before", "FILE", "records of the earlier inspection", **inputs.SEVERAL
    )
    same = "state that both inspections have the same transducer and ratio"
    report.add_argument("--same-transducer", action="store_true", help=same)
    what = "columns of travel (default: all columns that move)"
    report.add_argument("--channel", help=what, metavar="NAME", **inputs.SEVERAL)
    inputs.add_type(report)
    inputs.add_reference(report)


def run(options: argparse.Namespace) -> int:
    """Read, infer and judge the inspection, and write its report."""
    check_outputs([(options.output, "report")])
    if options.output.lower().endswith(".pdf"):
        from breaker.common.document import weasyprint

        weasyprint()  # if it lacks, that is said before any work is done
    config = inputs.settings_of(options.config)
    limits = inputs.limits_of(config, options.config)
    # Imported here, so that --help and wrong options answer at once.
    from breaker.diagnosis.inspection import read_inspection
    from breaker.diagnosis.report import report_of

    diagnosis = read_inspection(
        config,
        limits,
        options.files,
        before=options.before,
        channels=options.channel,
        of_type=options.type,
        reference=options.reference or "",
        tolerance=options.tolerance,
        same_transducer=options.same_transducer,
    )

    report = report_of(diagnosis)
    content, lacking = content_of(report, Path(options.output).suffix)
    write(options.output, content)
    *warnings, verdict = report.summary
    for warning in warnings:
        say(warning)
    for reason in dict.fromkeys(record.reason for record in diagnosis.records if record.reason):
        say(f"breaker: not in the report: {reason}", on_stderr=True)
    say("\n".join(filter(None, [verdict, f"report written to {options.output}", lacking])))
    return 0


def content_of(report, ending: str) -> tuple[bytes, str]:
    """Return a ``Report`` as ".html" or ".pdf" (if WeasyPrint is there), and of its letters."""
    from breaker.common.document import html_page, pdf_of
    from breaker.figures.reports import curves
    from breaker.figures.style import encoded, without_font

    pictures = list(curves(report.panels, report.colours))
    page = html_page(report, [encoded(picture, "png") for picture in pictures])
    content = pdf_of(page) if ending.lower() == ".pdf" else page.encode("utf-8")
    return content, without_font(pictures)
