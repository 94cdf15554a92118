"""`breaker inspect`: propose how to read a file."""

import argparse

from breaker.cli.command_inputs import PROJECT, add_path, settings_of
from breaker.cli.outputs import check_outputs, draw, say_written, write_lines
from breaker.common.visible_text import say


def add(inspect: argparse.ArgumentParser) -> None:
    """Look at one file of unknown origin: how its text is written, which columns are time and
    travel, and which motions they hold. Prints the lines of configuration that read it, after
    reading it with them.
    """
    inspect.set_defaults(smaller="export the record with fewer channels")
    add_path(inspect, "file", "FILE", "a record as it was exported")
    inspect.add_argument(
        "--channel", default="", metavar="NAME", help="the column of travel, if there are several"
    )
    add_path(inspect, "--output", "YAML", "write the proposed lines there")
    add_path(inspect, "--plot", "PNG", "draw the record there")
    what = "write there what a report of a misread file needs, without names, dates and travel"
    add_path(inspect, "--report-problem", "TXT", what)
    inspect.add_argument(
        "--with-travel", action="store_true", help="with --report-problem: all samples, too"
    )
    what = "with --report-problem: words of the file that are not replaced"
    inspect.add_argument("--keep", nargs="+", default=[], metavar="WORD", help=what)


def _run(options: argparse.Namespace) -> int:
    outputs = [(options.output, "lines"), (options.plot, "picture")]
    outputs += [(options.report_problem, "lines")]
    if not options.report_problem and (options.with_travel or options.keep):
        raise ValueError("--with-travel and --keep are of --report-problem TXT; name it, too")
    check_outputs(outputs, [options.file, *options.config])
    config = settings_of(options.config)
    if options.report_problem:
        _report_problem(options, config)
    from breaker.documents.terminal import text_of
    from breaker.reading.inspection.proposal_words import overlay_of, words_of
    from breaker.reading.inspection.setting_proposal import inspect_file

    proposal = inspect_file(options.file, config["sensor"], options.channel)
    overlay = overlay_of(proposal)
    written = [write_lines(options.output, overlay)] if options.output else []
    if options.plot:
        from breaker.figures import record

        written.append(draw(record.record(proposal), options.plot))
    say(text_of(words_of(proposal)))
    say(f"\nProposed, to lay over {PROJECT}:\n\n{overlay}")
    say_written(written)
    return 0 if any(each.record for each in proposal.motions) else 1


def _report_problem(options: argparse.Namespace, config: dict) -> None:
    """Write the report of a problem, and say what is to be looked at before it is sent."""
    from breaker.reading.inspection.problem_report import problem_report

    text, words = problem_report(
        options.file,
        config["sensor"],
        options.channel,
        format_settings=config["endurance"]["format"],
        travel=options.with_travel,
        allowed=options.keep,
    )
    say_written([write_lines(options.report_problem, text)])
    say("  Read it before you send it.", beside=True)
    if words:
        said = f"  Replaced: {', '.join(words)}. Let words of columns through by --keep WORD."
        say(said, beside=True)
