"""`breaker compare`: what has changed in a drive between two visits of few records."""

import argparse
import json
import logging
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from breaker.cli.named import MOTIONS, a_path, add_choice, operations_of
from breaker.cli.outputs import check_outputs, whole
from breaker.cli.settings import settings_of

__all__ = ["add"]

_SHARE = 5.0  # percent, of a change
_VISITS = ("before", "today")
# Beside those of the configuration: any record shows them, and where along the way a drive is slow.
_SPEEDS = {
    f"{motion}_speed_{begin}_{end}": [f"{begin} % of stroke", f"{end} % of stroke"]
    for motion in MOTIONS
    for begin, end in ((10, 50), (50, 90))
}


def add(commands) -> argparse.ArgumentParser:
    compare = commands.add_parser(
        "compare",
        help="compare two visits to a drive",
        description="Compare two visits to one drive, years apart, of a few records each (one is "
        "enough): what is measured then and now, which parameters have changed, by how much, and "
        "how probable no change and one beyond 5 % are. The status is 1 if nothing was compared.",
    )
    compare.set_defaults(run=_run)
    compare.add_argument(
        "before",
        type=a_path,
        metavar="BEFORE",
        nargs="+",
        help="records of the first visit, or their folder",
    )
    compare.add_argument(
        "--today",
        type=a_path,
        metavar="TODAY",
        nargs="+",
        action="extend",
        required=True,
        help="those of the second visit",
    )
    add_choice(compare)
    compare.add_argument(
        "--beyond",
        type=_percent,
        default=_SHARE / 100.0,
        metavar="PERCENT",
        help="change that matters (default: 5)",
    )
    compare.add_argument("--json", action="store_true", help="print one JSON document")
    compare.add_argument("--plot", type=a_path, metavar="PNG", help="draw the comparison there")
    return compare


def _percent(text: str) -> float:
    """A share, from percent."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 100.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a percentage above 0 and below 100")
    return value / 100.0


def _run(options: argparse.Namespace) -> int:
    logging.getLogger("breaker").setLevel(logging.ERROR)  # the answer has the reasons
    check_outputs([(options.plot, "picture")], [*options.before, *options.today, *options.config])
    config = settings_of(options.config)
    if config["known"]:
        raise ValueError(
            f"known: {', '.join(config['known'])}: breaker compare takes no facts beside records; "
            "leave the section known out of the configuration"
        )
    operations, first, loose = _operations(options, config)
    # Imported here, so that --help and wrong options answer at once.
    from breaker.answers import (
        changes,
        compare,
        measured_changes,
        read_operations,
        visits_document,
        visits_in_words,
    )
    from breaker.mechanism import speeds_of
    from breaker.model import generator

    records = read_operations(operations, config["endurance"]["format"], loose=loose)
    before, today, rejected = _by_visit(records, first)
    misfit = config["endurance"]["misfit_p_value"]
    rng = generator(config["seed"], "two visits")
    found = compare(before, today, _networks(), rng, misfit_p_value=misfit)
    speeds = speeds_of({**_SPEEDS, **config["speeds"]}, found.size)
    document = visits_document(
        found,
        [*measured_changes(before, today, speeds, options.beyond), *changes(found, options.beyond)],
        {m: {"before": len(before[m]), "today": len(today[m])} for m in before},
        rejected,
        {"share": options.beyond, "seed": config["seed"], "misfit_p_value": misfit},
    )
    if options.plot:
        from breaker.figures import visits

        with whole(options.plot) as part:
            visits.visits(document).savefig(part)
    print(json.dumps(document) if options.json else visits_in_words(document))
    if options.plot:
        print(f"drawn in {options.plot}", file=sys.stderr if options.json else sys.stdout)
    return 0


def _networks() -> Iterator[tuple]:
    """The networks of each family that ships, opened one by one."""
    from breaker.family import open_network
    from breaker.shipped import FAMILIES, KINDS, model_file

    for family in FAMILIES:
        yield tuple(open_network(model_file(family, kind)) for kind in KINDS)


def _operations(options: argparse.Namespace, config: Mapping) -> tuple[dict, int, bool]:
    """Operations of both visits by motion, the first number of the second, and whether any file may
    hold any motion.

    Raises:
        ValueError: If a file is named in both visits, or their tables name different drives.
    """
    endurance = config["endurance"]
    chosen = {key: getattr(options, key) or endurance[key] for key in ("breaker", "phase")}
    motions = [options.motion] if options.motion else list(MOTIONS)
    visits = [
        operations_of(named, motions, chosen, options.channel)
        for named in (options.before, options.today)
    ]
    files = [{str(op.file.resolve()) for each in by.values() for op in each} for by, _ in visits]
    if both := sorted(files[0] & files[1]):
        raise ValueError(f"{both[0]} is named in both visits; leave it out of one of them")
    _check_drive([by for by, _ in visits], list(chosen))
    first = 1 + max(len(each) for each in visits[0][0].values())
    operations = {}
    for (by_motion, _), begin in zip(visits, (1, first), strict=True):
        for motion, each in by_motion.items():
            numbered = [replace(op, number=begin + i) for i, op in enumerate(each)]
            operations.setdefault(motion, []).extend(numbered)
    return operations, first, any(loose for _, loose in visits)


def _check_drive(visits: Sequence[Mapping], names: Sequence[str]) -> None:
    """Refuse visits whose tables name different breakers or phases; a file names none.

    Raises:
        ValueError: If they do.
    """
    for name in names:
        before, today = (
            {getattr(op, name) for each in by_motion.values() for op in each}
            for by_motion in visits
        )
        if not (before & today or "" in before | today):
            raise ValueError(
                f"the table of the first visit is of {name} {', '.join(before)}, that of the "
                f"second of {', '.join(today)}; compare one drive, or mend a table"
            )


def _by_visit(records: Sequence, first: int) -> tuple[dict, dict, list[dict]]:
    """Usable records of motions that both visits have, by visit, and why others are not.

    Args:
        records: What ``answers.read_operations`` returns.
        first: First number of the second visit.

    Raises:
        ValueError: If the visits have no motion in common.
    """
    visits: tuple[dict, dict] = ({}, {})
    for each in records:
        if not each.reason:
            visits[each.operation.number >= first].setdefault(each.motion, []).append(each.raw)
    motions = [motion for motion in MOTIONS if all(motion in by for by in visits)]
    rejected = []
    for each in records:
        today, file = each.operation.number >= first, str(each.operation.file)
        reason = each.reason.removeprefix(f"{file}: ")
        if not reason and each.motion not in motions:
            reason = (
                f"the visit {_VISITS[not today]} has no usable {each.motion} to compare it with"
            )
        if reason:
            about = {"file": file, "motion": each.motion, "visit": _VISITS[today]}
            rejected.append(about | {"reason": reason})
    if not motions:
        raise ValueError(_nothing(rejected))
    before, today = ({motion: by[motion] for motion in motions} for by in visits)
    return before, today, rejected


def _nothing(rejected: Sequence[Mapping]) -> str:
    """Why nothing can be compared, and what to do."""
    reasons = "".join(
        f"\n  {each['visit']}: {each['file']} ({each['motion']}): {each['reason']}"
        for each in rejected
    )
    return (
        "nothing can be compared: no motion has a usable record in both visits. Name a closing of "
        "each, or an opening, all of one drive; breaker inspect FILE says how a file can be read"
        f"{reasons}"
    )
