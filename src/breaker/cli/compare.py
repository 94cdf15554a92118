"""`breaker compare`: what has changed in a drive between two visits of few records."""

import argparse
import json
import logging
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace

from breaker.cli.named import MOTIONS, a_path, add_choice, operations_of
from breaker.cli.outputs import check_outputs, whole
from breaker.cli.settings import settings_of

__all__ = ["add"]

_SHARE = 5.0  # percent, of a change


def add(commands) -> argparse.ArgumentParser:
    compare = commands.add_parser(
        "compare",
        help="compare two visits to a drive",
        description="Compare two visits to one drive, years apart, of a few records each (one is "
        "enough): which parameters and quantities have changed, by how much, and how probable a "
        "change beyond 5 % is. Both visits share the drive's own error. The status is 1 if "
        "nothing was compared.",
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
    from breaker.answers import changes, visits_document, visits_in_words
    from breaker.cli.drive import read_records
    from breaker.model import generator
    from breaker.posterior import compare_visits

    drive = read_records(operations, config, {}, loose=loose)
    curves, today, rejected = _by_visit(drive.curves, first)
    endurance, seed = config["endurance"], config["seed"]
    parts = [
        (found, changes(found, beyond=options.beyond, speeds=drive.speeds))
        for found in compare_visits(
            {motion: drive.models[motion] for motion in curves},
            {motion: each.travel.values.astype(float) for motion, each in curves.items()},
            today,
            config["correction"],
            generator(seed, "two visits"),
            agreement_p_value=config["wear_model"]["agreement_p_value"],
        )
    ]
    settings = {"share": options.beyond, "seed": seed}
    settings |= {name: endurance[name] for name in ("discrepancy", "misfit_p_value")}
    document = visits_document(parts, curves, today, rejected, drive.about, settings)
    if options.plot:
        from breaker.figures import visits

        with whole(options.plot) as part:
            visits.visits(document).savefig(part)
    print(json.dumps(document) if options.json else visits_in_words(document))
    if options.plot:
        print(f"drawn in {options.plot}", file=sys.stderr if options.json else sys.stdout)
    return 0


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


def _by_visit(curves: Mapping, first: int) -> tuple[dict, dict, list[dict]]:
    """Usable records of motions that both visits have, which are of the second, and the others.

    Raises:
        ValueError: If the visits have no motion in common.
    """
    used, today, rejected = {}, {}, []
    for motion, each in curves.items():
        for op in each.isel(operation=~each.accepted.values).operation.values:
            reason = str(each.reason.sel(operation=op).values)
            file = str(each.file.sel(operation=op).values)
            reason = reason.removeprefix(f"{file}: ")
            visit = "today" if op >= first else "before"
            rejected.append({"file": file, "motion": motion, "visit": visit, "reason": reason})
        there = each.isel(operation=each.accepted.values)
        when = there.operation.values >= first
        if when.any() and not when.all():
            used[motion], today[motion] = there, when
            continue
        for op in there.operation.values:
            file = str(there.file.sel(operation=op).values)
            visit, other = ("today", "before") if op >= first else ("before", "today")
            reason = f"the visit {other} has no usable {motion} to compare it with"
            rejected.append({"file": file, "motion": motion, "visit": visit, "reason": reason})
    if not used:
        raise ValueError(_nothing(rejected))
    return used, today, rejected


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
