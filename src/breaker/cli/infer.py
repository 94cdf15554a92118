"""`breaker infer`: infer the state of a drive from its records."""

import argparse
from collections.abc import Callable, Iterable

from breaker.cli import common_options
from breaker.cli.outputs import check_outputs, draw, say_written, write_lines
from breaker.common.clean_text import print_text
from breaker.model.quantities import check_fact


def add(infer: argparse.ArgumentParser) -> None:
    """Infer the state of a drive from records of one breaker. The command prints measured values,
    verdicts on the limits, parameters with intervals, and whether the records lie inside the family
    of simulated drives. A file may contain a closing, an opening or both. The exit status is 1 if
    no record can be used.
    """
    infer.add_argument("files", metavar="FILE", help="records of a breaker, or a folder", nargs="+")
    common_options.add_choice(infer)
    what = "known value of a parameter, the wipe, or the time of touch or separation"
    known = {"type": _fact, "metavar": "NAME=VALUE:SD"}
    infer.add_argument(
        "--known", help=f"{what}, such as mu=2.4:0.07", **known, **common_options.SEVERAL
    )
    infer.add_argument("--model", metavar="FILE", help="network of a family of your own")
    infer.add_argument("--json", action="store_true", help="print one JSON document")
    infer.add_argument("--output", metavar="CSV", help="write a table to this file")
    infer.add_argument("--plot", metavar="PNG", help="draw the result to this file")


def _fact(text: str) -> tuple[str, list[float]]:
    """Return name, value and sd of ``NAME=VALUE:SD``."""
    name, _, numbers = text.partition("=")
    try:
        value, sd = map(float, numbers.split(":"))
    except ValueError as error:
        what = f"{text!r} is not NAME=VALUE:SD, such as L=10.8:0.2"
        raise argparse.ArgumentTypeError(what) from error
    if complaint := check_fact(value, sd):
        raise argparse.ArgumentTypeError(f"{name} {complaint}")
    return name, [value, sd]


def run(options: argparse.Namespace) -> int:
    """Infer and judge, write the requested files, and print the result."""
    check_outputs([(options.output, "lines"), (options.plot, "picture")])
    config = common_options.settings_of(options.config)
    limits = common_options.limits_of(config, options.config)
    # Imported here, so that --help and errors of options appear at once.
    from breaker.common.document import text_of
    from breaker.common.plain_values import note_of, to_json
    from breaker.configuration.data_files import types_of
    from breaker.diagnosis.sentences import say
    from breaker.diagnosis.session import Diagnosis, given_by
    from breaker.diagnosis.tables import document_of

    given = given_by(config, dict(options.known))
    diagnosis = Diagnosis(config, limits, given, _families(options.model), types_of(config))
    choice = common_options.choice_of(options)
    diagnosis = diagnosis.of_files(options.files, choice, of_type=options.type)
    words = [say("own-prior")] if given.prior else []
    result = diagnosis.result
    content = {**result, "remarks": [*map(note_of, words), *result["remarks"]]}
    rejected = [record for record in content["records"] if not record["accepted"]]
    nothing = len(rejected) == len(content["records"])
    written = [] if nothing else _write(diagnosis, content, options)
    print_text(to_json(content) if options.json else text_of(document_of(content)))
    if rejected:
        text = "nothing was inferred" if nothing else f"rejected records: {len(rejected)}"
        print_text(f"breaker: {text}", on_stderr=True)
    say_written(written, options.json)
    return int(nothing)


def _families(model: str | None) -> Callable[[], Iterable]:
    """Return a function that opens the networks of families."""
    from breaker.family.networks import StateNetwork, open_network, shipped_levels

    if model is None:
        return shipped_levels
    network = open_network(model)
    if not isinstance(network, StateNetwork):
        raise ValueError(f"{model} is a network of changes; name one of levels")
    return lambda: [network]


def _write(diagnosis, content, options: argparse.Namespace) -> list[str]:
    """Write the files of the options, and return sentences on them."""
    written = []
    if options.output:
        from breaker.diagnosis.result import csv_of

        written.append(write_lines(options.output, csv_of(content)))
    if options.plot:
        from breaker.common.randomness import generator
        from breaker.figures.records import answer

        settings, estimates = diagnosis.settings, diagnosis.estimates
        first = next(estimate for estimate in estimates if estimate.levels)
        rng = generator(settings["seed"], "prior draws")
        prior = diagnosis.given.sample_prior(first, settings["draws"], rng)
        written.append(draw(answer(estimates, prior), options.plot))
    return written
