"""`breaker compare`: what has changed in a drive between two visits of few records."""

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from operator import getitem

from breaker.cli.named import MOTIONS, add_choice, add_path, operations_of, percent
from breaker.cli.outputs import check_outputs, whole
from breaker.cli.settings import limits_of, settings_of

__all__ = ["add", "compared"]

_VISITS = ("before", "today")
_SHARED = ("seed", "known", "speeds", "endurance.misfit_p_value")  # that no visit has for itself
_BEYOND = 0.05  # share of a change that matters
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
    add_path(compare, "before", "BEFORE", "records of the first visit, or their folder", nargs="+")
    several = {"nargs": "+", "action": "extend", "required": True}
    add_path(compare, "--today", "TODAY", "those of the second visit", **several)
    for visit in _VISITS:
        what = f"configuration files of the visit {visit} alone, laid over the others"
        more = {"nargs": "+", "action": "extend", "default": []}
        add_path(compare, f"--config-{visit}", "YAML", what, **more)
    add_choice(compare)
    compare.add_argument(
        "--beyond",
        type=percent,
        default=_BEYOND,
        metavar="PERCENT",
        help="change that matters (default: 5)",
    )
    compare.add_argument("--json", action="store_true", help="print one JSON document")
    add_path(compare, "--plot", "PNG", "draw the comparison there")
    return compare


def _run(options: argparse.Namespace) -> int:
    own = {visit: getattr(options, f"config_{visit}") for visit in _VISITS}
    named = {visit: getattr(options, visit) for visit in _VISITS}
    inputs = [*named.values(), options.config, *own.values()]
    check_outputs([(options.plot, "picture")], [file for some in inputs for file in some])
    config = settings_of(options.config)
    configs = {visit: _config_of(files, options.config, config) for visit, files in own.items()}
    _check_no_facts(config["known"])
    listed = {visit: operations_of(named[visit], options, configs[visit]) for visit in _VISITS}
    _check_visits([operations for operations, _ in listed.values()])
    # Imported here, so that --help and wrong options answer at once.
    from breaker.answers import read_operations, visits_in_words

    forms = {visit: each["endurance"]["format"] for visit, each in configs.items()}
    document = compared(
        {
            visit: read_operations(each, forms[visit], loose=loose)
            for visit, (each, loose) in listed.items()
        },
        config,
        beyond=options.beyond,
        limits=limits_of(config, options.config),
    )
    if options.plot:
        from breaker.figures import visits

        with whole(options.plot) as part:
            visits.visits(document).savefig(part)
    print(json.dumps(document) if options.json else visits_in_words(document))
    if options.plot:
        print(f"drawn in {options.plot}", file=sys.stderr if options.json else sys.stdout)
    return 0


def _config_of(own: Sequence[str], shared: Sequence[str], config: Mapping) -> Mapping:
    """The configuration of a visit: files of its own over those of both.

    Raises:
        ValueError: If they change what holds for both.
    """
    if not own:
        return config
    found = settings_of(shared, own)
    for key in _SHARED:
        here, both = (reduce(getitem, key.split("."), each) for each in (found, config))
        if here != both:
            raise ValueError(f"{' '.join(own)}: {key} holds for both visits; set it by --config")
    return found


def compared(
    visits: Mapping[str, Sequence],
    config: Mapping,
    *,
    beyond: float = _BEYOND,
    limits: Sequence[Mapping] = (),
) -> dict:
    """Return the document of a comparison.

    Args:
        visits: Records "before" and "today", as ``read_operations`` returns them.
        config: The configuration of both.
        beyond: Share beyond which a change counts.
        limits: Entries of the section ``limits`` on which to judge today's visit.

    Raises:
        ValueError: If no motion has a usable record in both visits.
    """
    from breaker.answers import (
        changes,
        compare,
        judged_today,
        measured_changes,
        stated_of,
        unlike,
        visits_document,
    )
    from breaker.mechanism import from_list, speeds_of
    from breaker.model import generator

    before, today, rejected = _usable(visits)
    misfit = config["endurance"]["misfit_p_value"]
    rng = generator(config["seed"], "two visits")
    found = compare(before, today, _networks(), rng, misfit_p_value=misfit)
    speeds = speeds_of({**_SPEEDS, **config["speeds"]}, found.size)
    measured = measured_changes(before, today, speeds, beyond)
    entries = from_list(limits, [*before], speeds)
    return visits_document(
        found,
        {
            "warnings": _warnings(visits),
            "differences": unlike(
                measured, found.strokes, {v: stated_of(each) for v, each in visits.items()}
            ),
            "changes": [*measured, *changes(found, beyond)],
            "limits": judged_today(found, today, entries, speeds, config["seed"]),
        },
        {m: {"before": len(before[m]), "today": len(today[m])} for m in before},
        rejected,
        {"share": beyond, "seed": config["seed"], "misfit_p_value": misfit},
    )


def _warnings(visits: Mapping[str, Sequence]) -> list[str]:
    """What to say of records before anything else: of their rates, and which is there twice."""
    from numpy import array_equal

    found = [each.warning for records in visits.values() for each in records if each.warning]
    before, today = ([each for each in records if not each.reason] for records in visits.values())
    for one in before:
        found += [
            f"{one.operation.file} and {other.operation.file} hold the same samples: they are one "
            "record, and nothing can have changed; name the records of either visit"
            for other in today
            if array_equal(one.raw.whole, other.raw.whole, equal_nan=True)
        ]
    return list(dict.fromkeys(found))


def _networks() -> Iterator[tuple]:
    """The networks of each family that ships, opened one by one."""
    from breaker.family import open_network
    from breaker.shipped import FAMILIES, KINDS, model_file

    for family in FAMILIES:
        yield tuple(open_network(model_file(family, kind)) for kind in KINDS)


def _check_no_facts(known: Mapping) -> None:
    if known:
        raise ValueError(
            f"known: {', '.join(known)}: breaker compare takes no facts beside records; leave the "
            "section known out of the configuration"
        )


def _check_visits(visits: Sequence[Mapping]) -> None:
    """Refuse visits that share a file, or whose tables name different drives; a file names none."""
    before, today = ([op for each in by.values() for op in each] for by in visits)
    first, second = ({str(op.file.resolve()) for op in visit} for visit in (before, today))
    if both := sorted(first & second):
        raise ValueError(f"{both[0]} is named in both visits; leave it out of one of them")
    for name in ("breaker", "phase"):
        first, second = ({getattr(op, name) for op in visit} for visit in (before, today))
        if not (first & second or "" in first | second):
            raise ValueError(
                f"the table of the first visit is of {name} {', '.join(first)}, that of the "
                f"second of {', '.join(second)}; compare one drive, or mend a table"
            )


def _usable(visits: Mapping[str, Sequence]) -> tuple[dict, dict, list[dict]]:
    """Usable records of motions that both visits have, of either visit, and why others are not."""
    pairs = [(visit, each) for visit, records in visits.items() for each in records]
    pairs.sort(key=lambda pair: MOTIONS.index(pair[1].motion))
    usable: dict[str, dict[str, list]] = {visit: {} for visit in visits}
    for visit, each in pairs:
        if not each.reason:
            usable[visit].setdefault(each.motion, []).append(each.raw)
    motions = [motion for motion in MOTIONS if all(motion in by for by in usable.values())]
    rejected = []
    for visit, each in pairs:
        file = str(each.operation.file)
        reason = each.reason.removeprefix(f"{file}: ")
        if not reason and each.motion not in motions:
            (other,) = visits.keys() - {visit}
            reason = f"the visit {other} has no usable {each.motion} to compare it with"
        if reason:
            about = {"file": file, "motion": each.motion, "visit": visit}
            rejected.append(about | {"reason": reason})
    if not motions:
        raise ValueError(_nothing(rejected))
    before, today = ({motion: by[motion] for motion in motions} for by in usable.values())
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
