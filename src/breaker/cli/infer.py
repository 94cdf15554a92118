"""`breaker infer`: infer the records of a drive."""

import argparse
import json
import logging
import math
import shlex
import sys
from collections.abc import Mapping, Sequence

from breaker.cli.named import MOTIONS, a_path, add_choice, operations_of
from breaker.cli.outputs import check_outputs, whole
from breaker.cli.settings import limits_of, settings_of

__all__ = ["add"]

_FACTORS = (0.01, 100.0)  # of a size, as in the configuration


def add(commands) -> argparse.ArgumentParser:
    infer = commands.add_parser(
        "infer",
        help="infer the state of a drive from its records",
        description="Infer the drive in curve files, all of one breaker: parameters, times, speeds "
        "and ways with their intervals, how far the model can be trusted, and whether limits are "
        "exceeded. Works in any folder, for drives of any size. A file may hold a closing, an "
        "opening or both. The status is 1 if nothing was inferred.",
    )
    infer.set_defaults(run=_run)
    infer.add_argument(
        "files",
        type=a_path,
        metavar="FILE",
        nargs="+",
        help="a record, or a folder of records of one breaker",
    )
    add_choice(infer)
    infer.add_argument(
        "--size",
        nargs=2,
        type=_factor,
        metavar=("LENGTHS", "TIMES"),
        help="the drive's size beside that of the reference drive; read from the records if not "
        "given",
    )
    infer.add_argument(
        "--known",
        nargs="+",
        action="extend",
        type=_fact,
        default=[],
        metavar="NAME=VALUE:SD",
        help="what is known of a parameter or quantity, such as mu=2.4:0.07 or wipe=3.5:0.3",
    )
    infer.add_argument(
        "--model",
        type=a_path,
        action="append",
        default=[],
        metavar="FILE",
        help="start from a trained network; once for each motion",
    )
    infer.add_argument("--json", action="store_true", help="print one JSON document")
    for option, kind, what in (
        ("--output", "CSV", "write a table there, with all columns"),
        ("--plot", "PNG", "draw the answer there"),
        ("--draws", "ZARR", "write all draws there, for ArviZ"),
    ):
        infer.add_argument(option, type=a_path, metavar=kind, help=what)
    return infer


def _factor(text: str) -> float:
    """A factor of a size."""
    value, (least, most) = _number(text), _FACTORS
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is no number from {least:g} to {most:g}")
    return value


def _fact(text: str) -> tuple[str, list[float]]:
    """Name, value and sd of ``NAME=VALUE:SD``."""
    from breaker.mechanism import check_fact

    name, _, numbers = text.partition("=")
    value, sd = map(_number, numbers.partition(":")[::2])
    if not name or math.isnan(value) or math.isnan(sd):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE:SD, such as L=10.8:0.2")
    if complaint := check_fact(value, sd):
        raise argparse.ArgumentTypeError(f"{text!r} {complaint}")
    return name, [value, sd]


def _number(text: str) -> float:
    """A number; nan where the text is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _run(options: argparse.Namespace) -> int:
    logging.getLogger("breaker").setLevel(logging.ERROR)  # the answer has the reasons
    _refuse_old_form(options.files)
    outputs = [(options.output, "table"), (options.plot, "picture"), (options.draws, "store")]
    check_outputs(outputs, [*options.files, *options.model, *options.config])
    config = settings_of(options.config)
    known = dict(options.known)
    if len(known) < len(options.known):
        names = [name for name, _ in options.known]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"--known has {twice} twice; leave one of them out")
    config["known"] = {**config["known"], **known}
    limits = limits_of(config, options.config)
    endurance = config["endurance"]
    chosen = {key: getattr(options, key) or endurance[key] for key in ("breaker", "phase")}
    motions = [options.motion] if options.motion else list(MOTIONS)
    operations, loose = operations_of(options.files, motions, chosen, options.channel)
    # Imported here, so that --help and wrong options answer at once.
    from breaker.answers import document, in_words
    from breaker.cli.drive import networks_of, read_records

    networks = networks_of(options.model, config)
    drive = read_records(operations, config, networks, size=options.size, loose=loose)
    answers = _answers(drive, networks, config, limits)
    found = document(answers, drive.about, _settings(config))
    rejected = [each for each in found["records"] if not each["accepted"]]
    nothing = len(rejected) == len(found["records"])
    written = [] if nothing else _write(answers, drive.models, config, options)
    print(json.dumps(found) if options.json else in_words(found))
    if rejected:
        read = [each.file.values[each.accepted.values] for each in drive.curves.values()]
        unread = {each["file"] for each in rejected}.difference(*read)
        _say_remedy(rejected, [] if options.size else sorted(unread), nothing=nothing)
    for text in written:  # beside a JSON document, not in it
        print(text, file=sys.stderr if options.json else sys.stdout)
    return int(nothing)


def _refuse_old_form(files: Sequence[str]) -> None:
    """Point to --model where a model stands among the records, as it did once."""
    models = [each for each in files if each.endswith(".safetensors")]
    if models:
        rest = " ".join(shlex.quote(each) for each in files if each not in models) or "FILE"
        given = " ".join(f"--model {shlex.quote(each)}" for each in models)
        raise ValueError(
            f"{models[0]} is a model, not a record. No model is needed any more: breaker infer "
            f"{rest}. To start from one: breaker infer {rest} {given}"
        )


def _settings(config: Mapping) -> dict:
    """What an answer was made with."""
    names = ("discrepancy", "draws", "misfit_p_value")
    chosen = {name: config["endurance"][name] for name in names}
    return chosen | {"known": config["known"], "seed": config["seed"]}


def _answers(drive, networks: Mapping, config: Mapping, limits: Sequence) -> dict:
    """The answer of each motion, with quantities, trust, and limits where there are any."""
    from breaker.answers import with_limits, with_quantities, with_trust
    from breaker.mechanism import from_list
    from breaker.posterior import infer_exactly

    endurance, seed = config["endurance"], config["seed"]
    common = {"seed": seed, "misfit_p_value": endurance["misfit_p_value"]}
    answers = {}
    for motion, curves in drive.curves.items():
        model = drive.models[motion]
        if motion in networks:
            answer = _by_network(networks[motion], drive, config, common)
        else:
            answer = infer_exactly(
                model, curves, config["correction"], draws=endurance["draws"], **common
            )
        answer = with_quantities(answer, drive.speeds)
        answer = with_trust(answer, model, seed=seed)
        if judged := from_list(limits, [motion], drive.speeds):
            answer = with_limits(answer, judged, config["alarm"])
        answers[motion] = answer
    return answers


def _by_network(network, drive, config: Mapping, common: Mapping):
    """The answer of a network, corrected to the exact one unless the configuration says not to."""
    from breaker.posterior import correct_operations, infer, network_remarks

    motion, endurance = network.motion, config["endurance"]
    network, curves = network.sized(drive.size), drive.curves[network.motion]
    answer = infer(network, curves, draws=endurance["draws"], **common)
    if endurance["posterior"] == "corrected":
        return correct_operations(drive.models[motion], answer, config["correction"], **common)
    remarks = network_remarks(network.sensor, drive.about["noise_sd"], curves)
    drive.about["words"] += [f"{motion}: {remark}" for remark in remarks]
    return answer


def _say_remedy(rejected: Sequence[Mapping], unread: Sequence[str], *, nothing: bool) -> None:
    """Say on stderr that records were rejected, and how to find out how those can be read that
    could not be.
    """
    what = "nothing was inferred" if nothing else f"rejected records: {len(rejected)}"
    remedy = (
        "If a file is written in another way than the settings say:\n"
        f"  breaker inspect {shlex.quote(unread[0])} --output my.yaml\n"
        "and then: breaker infer ... --config my.yaml"
        if unread
        else "What is given beside the records may leave no drive that moves so: leave out --size, "
        "--known or the prior, one by one"
    )
    print(f"breaker: {what}. {remedy}", file=sys.stderr)


def _write(answers: Mapping, models: Mapping, config: Mapping, options) -> list[str]:
    """Write what the options ask for, and return what was written, in words."""
    written = []
    if options.output:
        from breaker.answers import table_of

        with whole(options.output) as part:
            table_of(answers).to_csv(part, index=False, float_format="%.6g")
        written.append(f"written to {options.output}")
    if options.draws:
        from breaker.answers import tree

        found = tree(answers, models, seed=config["seed"])
        with whole(options.draws) as part:
            found.to_zarr(part, mode="w", zarr_format=2)
        written.append(f"draws written to {options.draws}")
    if options.plot:
        from breaker.answers import shown
        from breaker.figures import answer

        seed = config["seed"]
        parts = {m: shown(each, models[m], seed=seed) for m, each in answers.items()}
        with whole(options.plot) as part:
            answer.answer(parts).savefig(part)
        written.append(f"drawn in {options.plot}")
    return written
