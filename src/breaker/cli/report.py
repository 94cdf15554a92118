"""`breaker report`: write a test report of an inspection."""

import argparse

from breaker.cli import common_options
from breaker.cli.outputs import check_outputs, write
from breaker.common.clean_text import print_text


def add(report: argparse.ArgumentParser) -> None:
    """Write the report of an inspection of one breaker: measured values against limits, the
    simultaneity of poles, changes since the earlier inspection, the state by the model, and the
    curves. A file may contain O, C, C-O or O-C-O, and several channels, which are phases or poles.
    The exit status is 1 if no record can be used.
    """
    report.add_argument("files", metavar="FILE", help="records, or their folder", nargs="+")
    what = "write the report to this page, which a browser prints or saves as PDF"
    report.add_argument("--output", metavar="HTML", help=what, required=True)
    report.add_argument(
        "--before", metavar="FILE", help="earlier records", **common_options.SEVERAL
    )
    same = "state that both inspections have the same transducer and ratio"
    report.add_argument("--same-transducer", action="store_true", help=same)
    what = "columns of travel (default: all columns that move)"
    report.add_argument("--channel", help=what, metavar="NAME", **common_options.SEVERAL)
    common_options.add_type(report)
    report.add_argument("--reference", metavar="GOOD", help="good record, drawn below the others")


def run(options: argparse.Namespace) -> int:
    """Read, infer and judge the inspection, and write its report."""
    check_outputs([(options.output, "report")])
    config = common_options.settings_of(options.config)
    limits = common_options.limits_of(config, options.config)
    # Imported here, so that --help and errors of options appear at once.
    from breaker.diagnosis.report import read_inspection, report_of

    diagnosis = read_inspection(
        config,
        limits,
        options.files,
        before=options.before,
        channels=options.channel,
        of_type=options.type,
        reference=options.reference or "",
        same_transducer=options.same_transducer,
    )
    report = report_of(diagnosis)
    # Imported here, so that errors of the records appear first.
    from breaker.figures.reports import report_page

    write(options.output, report_page(report).encode("utf-8"))
    *warnings, verdict = report.summary
    for warning in warnings:
        print_text(warning)
    for reason in dict.fromkeys(record.reason for record in diagnosis.records if record.reason):
        print_text(f"breaker: not in the report: {reason}", on_stderr=True)
    print_text(f"{verdict}\nreport written to {options.output}")
    return 0
