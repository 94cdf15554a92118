"""`breaker plan`: find which test of a drive would tell most for its cost."""

import argparse

from breaker.cli.command_inputs import (
    SEVERAL,
    add_choice,
    add_path,
    limits_of,
    operations_of,
    settings_of,
)
from breaker.cli.infer import add_given, facts_of, families_of
from breaker.cli.outputs import check_outputs, draw, say_written
from breaker.common.visible_text import say


def add(plan: argparse.ArgumentParser) -> None:
    """Foretell by how much each of some tests would narrow what the records of one breaker tell:
    more records, the other motion, a contact channel, a finer transducer, the size of the type, a
    wipe, a mass, a spring. The test with most narrowing for its cost comes first; costs are in the
    section next_tests of the configuration. The status is 1 if nothing was foretold.
    """
    add_path(plan, "files", "FILE", "a record, or a folder of records of one breaker", nargs="+")
    add_choice(plan)
    add_given(plan)
    what = "what to narrow: parameters, mechanisms or limits (default: all parameters)"
    plan.add_argument("--narrow", metavar="NAME", help=what, **SEVERAL)
    plan.add_argument("--json", action="store_true", help="print one JSON document")
    add_path(plan, "--plot", "PNG", "draw the tests there")


def _run(options: argparse.Namespace) -> int:
    beside = filter(None, [options.model])
    check_outputs([(options.plot, "picture")], [*options.files, *beside, *options.config])
    config = settings_of(options.config)
    limits = limits_of(config, options.config)
    operations, loose = operations_of(options.files, options, config)
    # Imported here, so that --help and wrong options answer at once.
    from breaker.common.plain_values import to_json
    from breaker.documents.terminal import text_of
    from breaker.drive.answers.assessment import Assessment, given_by
    from breaker.drive.answers.next_test_words import words_of_plans

    given, _ = given_by(config, options.size, facts_of(options.known))
    assessment = Assessment(config, limits, given, families=families_of(options.model))
    document = assessment.plan(assessment.read(operations, loose=loose), options.narrow)
    written, told = [], any(each.tests for each in document.poles)
    if options.plot and told:
        from breaker.figures import next_tests

        written.append(draw(next_tests.next_tests(document), options.plot))
    say(to_json(document) if options.json else text_of(words_of_plans(document)))
    say_written(written, options.json)
    return int(not told)
