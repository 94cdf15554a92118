"""`breaker fit-prior`: fit the prior of a type of breaker."""

import argparse

from breaker.cli.common_options import settings_of
from breaker.cli.outputs import check_outputs, write_lines
from breaker.common.clean_text import print_text


def add(fit_prior: argparse.ArgumentParser) -> None:
    """Fit the prior of a type of breaker to records of some of its breakers: medians, and spread
    with room for wear. The command prints a report, and lines of configuration for `breaker infer
    --config` and the workflow.
    """
    what = "records of one breaker, or of several with a table operations.csv"
    fit_prior.add_argument("folders", metavar="FOLDER", help=what, nargs="+")
    fit_prior.add_argument("--type", default="", metavar="NAME", help="type that the table states")
    fit_prior.add_argument("--output", metavar="YAML", help="write the lines of configuration here")


def run(options: argparse.Namespace) -> int:
    """Fit the prior, and print its report and the lines of configuration."""
    check_outputs([(options.output, "lines")])
    config = settings_of(options.config)
    from breaker.common.document import text_of
    from breaker.configuration.data_files import types_of
    from breaker.configuration.loading import check, defaults, merge
    from breaker.diagnosis.sentences import say
    from breaker.diagnosis.session import Diagnosis
    from breaker.diagnosis.type_prior import configuration_lines, document_of, fit_type, list_type
    from breaker.records.folder import each_once

    listed = list_type(each_once(options.folders), config["motions"], options.type)
    asked = Diagnosis(config, types=types_of(config))
    asked = asked.of_type(options.type) if options.type and asked.types else asked
    fitted = fit_type(listed, asked)
    settings, usual = fitted.settings(), defaults()["endurance"]["format"]
    form = {k: v for k, v in config["endurance"]["format"].items() if v != usual[k]}
    if form:
        settings["endurance"] = {"format": form}
    try:
        check(merge(config, settings), curves=False)
    except ValueError as error:
        raise ValueError(say("type-unusable", reason=error)) from error
    document = document_of(fitted)
    lines = configuration_lines(settings, document)
    print_text(text_of(document), end="\n\n")
    print_text(write_lines(options.output, lines) if options.output else lines.rstrip("\n"))
    return 0
