"""`breaker compare`: compare two inspections of a drive."""

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

from breaker.cli import common_options
from breaker.cli.outputs import check_outputs, draw, say_written
from breaker.common.clean_text import print_text


def add(compare: argparse.ArgumentParser) -> None:
    """Compare two inspections of one drive, years apart. One record of each inspection is enough.
    The command judges the later inspection by the limits, and reports measured changes, their
    explanations, and changes of parameters with intervals and the probability of no change. The
    exit status is 1 if nothing was compared.
    """
    compare.add_argument("before", metavar="BEFORE", help="earlier records", nargs="+")
    today = common_options.SEVERAL | {"required": True}
    compare.add_argument("--today", metavar="TODAY", help="later records", **today)
    common_options.add_choice(compare)
    same = "state that both inspections have the same transducer and ratio"
    compare.add_argument("--same-transducer", action="store_true", help=same)
    compare.add_argument("--json", action="store_true", help="print one JSON document")
    compare.add_argument("--plot", metavar="PNG", help="draw the comparison to this file")


def run(options: argparse.Namespace) -> int:
    """Read both inspections, compare them, and print the comparison."""
    check_outputs([(options.plot, "picture")])
    config = common_options.settings_of(options.config)
    # Imported here, so that --help and errors of options appear at once.
    from breaker.common.document import text_of
    from breaker.common.plain_values import to_json
    from breaker.configuration.data_files import types_of
    from breaker.diagnosis.inspection_change import compare_inspections, words_of_change
    from breaker.diagnosis.session import Diagnosis
    from breaker.records.files import Files

    choice = common_options.choice_of(options)
    types, inspections, opened, doubts = types_of(config), {}, Files(), []
    limits = common_options.limits_of(config, options.config)
    both = Diagnosis(config, limits, types=types, same_transducer=options.same_transducer)
    for name, files in (("before", options.before), ("today", options.today)):
        single = Diagnosis(config, types=types).of_files(files, choice, opened, options.type)
        inspections[name], stated = single.records, single.type
        doubts += single.doubts
    _check_inspections(inspections)
    both = both.of_type(stated) if stated else both
    document = compare_inspections(both, inspections)
    document = replace(document, doubts=[*dict.fromkeys([*document.doubts, *doubts])])
    written = []
    if options.plot:
        from breaker.figures.reports import comparison as figure

        written = [draw(figure(document), options.plot)]
    print_text(to_json(document) if options.json else text_of(words_of_change(document)))
    say_written(written, options.json)
    return 0


def _check_inspections(inspections: Mapping[str, Sequence]) -> None:
    """Refuse inspections that share a file, or whose tables name different breakers."""
    both = [[record.operation for record in inspection] for inspection in inspections.values()]
    first, second = ({os.path.realpath(op.file) for op in operations} for operations in both)
    if shared := sorted(first & second):
        raise ValueError(f"{shared[0]} is named in both inspections; leave it out of one of them")
    first, second = ({op.breaker for op in operations} for operations in both)
    if not (first & second or "" in first | second):
        what = f"breaker {', '.join(first)}, that of the later one of {', '.join(second)}"
        raise ValueError(f"the table of the earlier inspection is of {what}; compare one drive")
