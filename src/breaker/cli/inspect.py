"""`breaker inspect`: propose how to read a file."""

import argparse

from breaker.cli.command_settings import PROJECT, settings_of
from breaker.cli.outputs import check_outputs, draw, say_written, write_lines
from breaker.cli.printing import say
from breaker.cli.records_named import add_path


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


def _run(options: argparse.Namespace) -> int:
    outputs = [(options.output, "lines"), (options.plot, "picture")]
    check_outputs(outputs, [options.file, *options.config])
    from breaker.documents.terminal import text_of
    from breaker.reading.inspection.proposal_words import overlay_of, words_of
    from breaker.reading.inspection.setting_proposal import inspect_file

    sensor = settings_of(options.config)["sensor"]
    proposal = inspect_file(options.file, sensor, options.channel)
    overlay = overlay_of(proposal)
    written = [write_lines(options.output, overlay)] if options.output else []
    if options.plot:
        from breaker.figures import record

        written.append(draw(record.record(proposal), options.plot))
    say(text_of(words_of(proposal)))
    say(f"\nProposed, to lay over {PROJECT}:\n\n{overlay}")
    say_written(written)
    return 0 if any(each.record for each in proposal.motions) else 1
