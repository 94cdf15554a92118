"""The command `breaker`: what one wants of files without the workflow.

Each command is one function that prints, and returns the exit status: 0, or 1 where it failed.
"""

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from functools import reduce
from pathlib import Path

from breaker.workflow import ConfigurationError, load, merge, missing_packages, read, set_threads

__all__ = ["main"]

_DEFAULTS = Path("config/config.yaml")
_SCHEMA = Path("workflow/schemas/config.schema.yaml")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        The exit status: 0; 1 where it failed; as of a command that a signal ended, 130 where it was
        interrupted and 141 where nobody reads its output to the end.
    """
    options = _parser().parse_args(arguments)
    set_threads(1)  # records are small, and inferred one by one: more threads wait for each other
    try:
        status = options.run(options)
        sys.stdout.flush()  # here, where a closed pipe is still caught
        return status
    except KeyboardInterrupt:
        print("breaker: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # Python writes what is left when it ends, and would complain: into nothing instead.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except ModuleNotFoundError as error:
        print(f"breaker: {missing_packages(error.name)}", file=sys.stderr)
        return 1
    except (ConfigurationError, OSError, ValueError) as error:
        print(f"breaker: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="breaker", description="From a breaker's travel curve to the state of its drive."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for add in (_add_inspect, _add_manifest, _add_check, _add_infer):  # in the order of --help
        command = add(commands)
        command.add_argument(
            "--config",
            nargs="+",
            default=[],
            metavar="YAML",
            help=f"configuration files, laid over {_DEFAULTS} where there is one",
        )
    return parser


def _settings(overlays: Sequence[str], needed: Sequence[str]) -> dict:
    """The configuration, as far as a command needs it: keys with their section, dotted."""
    paths = [*([_DEFAULTS] if _DEFAULTS.exists() else []), *overlays]
    if not paths:
        raise ConfigurationError(
            f"there is no {_DEFAULTS} here; start the command from the project's folder, or name "
            "your configuration with --config"
        )
    if _DEFAULTS.exists() and _SCHEMA.exists():
        return load(paths, schema=_SCHEMA)
    config = reduce(merge, map(read, paths), {})
    section = config.get("endurance")
    found = {
        *config,
        *(f"endurance.{key}" for key in (section if isinstance(section, dict) else ())),
    }
    lacking = [key for key in needed if key not in found]
    if lacking:
        raise ConfigurationError(
            f"{', '.join(map(str, paths))}: {', '.join(lacking)} must be given; "
            "start the command from the project's folder, or name its config/config.yaml first"
        )
    return config


# ---- breaker inspect ----------------------------------------------------------------------------


def _add_inspect(commands) -> argparse.ArgumentParser:
    inspect = commands.add_parser(
        "inspect",
        help="propose how to read a file",
        description="Look at one file of unknown origin: how its text is written, which columns "
        "are time and travel, and which motions they hold. Prints the lines of configuration that "
        "read it, after reading it with them.",
    )
    inspect.set_defaults(run=_inspect)
    inspect.add_argument("file", metavar="FILE", help="a record as it was exported")
    inspect.add_argument(
        "--channel", default="", metavar="NAME", help="the column of travel, if there are several"
    )
    inspect.add_argument("--output", metavar="YAML", help="write the proposed lines there")
    inspect.add_argument("--plot", metavar="PNG", help="draw the record there")
    return inspect


def _inspect(options: argparse.Namespace) -> int:
    from breaker.inspection import inspect_file, overlay_of, report_of

    logging.getLogger("breaker").setLevel(logging.ERROR)  # the report has the reasons
    sensor = _settings(options.config, ["sensor"])["sensor"]
    proposal = inspect_file(options.file, sensor, options.channel)
    overlay = overlay_of(proposal)
    print(report_of(proposal))
    print(f"\nProposed, to lay over {_DEFAULTS}:\n\n{overlay}")
    if options.output:
        Path(options.output).write_text(overlay, encoding="utf-8")
        print(f"written to {options.output}")
    if options.plot:
        from breaker.figures import record

        record.record(proposal).savefig(options.plot)
        print(f"drawn in {options.plot}")
    return 0 if any(each.record for each in proposal.motions) else 1


# ---- breaker manifest ---------------------------------------------------------------------------


def _add_manifest(commands) -> argparse.ArgumentParser:
    manifest = commands.add_parser(
        "manifest",
        help="propose a table of the operations in a folder",
        description="Propose the table operations.csv of a folder: which file is which operation. "
        "What to check in it is printed beside it.",
    )
    manifest.set_defaults(run=_manifest)
    manifest.add_argument("folder", metavar="FOLDER", help="folder of the curve files")
    manifest.add_argument("--output", metavar="CSV", help="write the table there, if nothing is")
    manifest.add_argument(
        "--channels", nargs="+", default=[], metavar="NAME", help="columns of travel in each file"
    )
    return manifest


def _manifest(options: argparse.Namespace) -> int:
    from breaker.files import propose_manifest

    text, remarks = propose_manifest(options.folder, options.channels)
    if options.output:
        try:
            with open(options.output, "x", encoding="utf-8", newline="") as stream:
                stream.write(text)
        except FileExistsError:
            raise FileExistsError(
                f"{options.output} is there already, and is not overwritten; name another file"
            ) from None
    else:
        print(text, end="")
    for remark in remarks:
        print(f"check: {remark}", file=sys.stderr)
    return 0


# ---- breaker check ------------------------------------------------------------------------------


def _add_check(commands) -> argparse.ArgumentParser:
    check = commands.add_parser(
        "check",
        help="say which records of a folder will be accepted",
        description="Read all records of a folder as the workflow will, and print what is "
        "accepted, what is doubtful, and why the rest is rejected. The status is 1 if nothing of a "
        "motion is accepted.",
    )
    check.set_defaults(run=_check)
    check.add_argument("folder", metavar="FOLDER", help="folder of the curve files")
    return check


def _check(options: argparse.Namespace) -> int:
    from breaker.inspection import check_folder, checked_text

    logging.getLogger("breaker").setLevel(logging.ERROR)  # the text has the reasons
    config = _settings(options.config, ["sensor", "motions", "endurance.format"])
    motions = config["motions"]
    checked = check_folder(options.folder, config["endurance"], config["sensor"], motions)
    print(checked_text(checked))
    accepted = {each.motion for each in checked if each.accepted}
    return 0 if accepted == set(motions) else 1


# ---- breaker infer ------------------------------------------------------------------------------


def _add_infer(commands) -> argparse.ArgumentParser:
    infer = commands.add_parser(
        "infer",
        help="infer curve files with a trained model",
        description="Infer curve files of one motion with a trained model. The configuration sets "
        "how files are read (endurance.format), how far the drive may be from the model "
        "(endurance.discrepancy), and whether the network's posterior is corrected to the exact "
        "one (endurance.posterior).",
    )
    infer.set_defaults(run=_infer)
    infer.add_argument("model", metavar="MODEL", help="such as results/models/closing.safetensors")
    infer.add_argument("files", metavar="FILE", nargs="+", help="CSV file of one operation")
    infer.add_argument("--output", metavar="CSV", help="write the table there, with all columns")
    return infer


def _infer(options: argparse.Namespace) -> int:
    # Imported here, so that --help and wrong options answer at once.
    from breaker.files import Operation
    from breaker.posterior import Posterior, correct_operations, infer, table
    from breaker.records import read_curves, require_any

    needed = ("format", "draws", "discrepancy", "misfit_p_value", "posterior")
    config = _settings(options.config, ["seed", "correction", *(f"endurance.{n}" for n in needed)])
    endurance = config["endurance"]
    posterior = Posterior.load(options.model).at(endurance["discrepancy"])
    files = [Operation(number, file) for number, file in enumerate(options.files, start=1)]
    curves = read_curves(
        files,
        endurance["format"],
        posterior.sensor.times,
        posterior.motion,
        noise_sd=posterior.sensor.noise_sd,
        zero_sd=posterior.sensor.zero_sd,
    )
    require_any(curves)
    common = {"seed": config["seed"], "misfit_p_value": endurance["misfit_p_value"]}
    result = infer(posterior, curves, draws=endurance["draws"], **common)
    if endurance["posterior"] == "corrected":
        result = correct_operations(posterior.model, result, config["correction"], **common)
    result = table(result)
    _show(result)
    if options.output:
        result.to_csv(options.output, index=False, float_format="%.6g")
        print(f"written to {options.output}")
    if result["median"].isna().all():
        reasons = " | ".join(result["reason"].unique())
        print(f"breaker: nothing was inferred: {reasons}", file=sys.stderr)
        return 1
    return 0


def _show(result) -> None:
    """Print what was found, file by file."""
    for (_, file), rows in result.groupby(["operation", "file"]):
        first = rows.iloc[0]
        print(f"\n{file}")
        if not first.accepted:
            print(f"  rejected: {first.reason}")
            continue
        for row in rows.itertuples():
            interval = f"{row.interval_95_lower:.4g} to {row.interval_95_upper:.4g}"
            print(f"  {row.output:8s} {row.median:10.4g}   95 %: {interval:22s} {row.unit}")
        if "resolved" in rows and not first.resolved:
            print("  NOT resolved: the exact posterior was not reached; this is the best so far")
        for doubt in _doubts(first):
            print(f"  {doubt}")
        if not first.p_value >= 0:
            print("  no draw of its posterior could be compared with the record")
            continue
        verdict = "does NOT fit the model" if first.misfit else "fits the model"
        outside = ", OUTSIDE what the prior can produce" if first.outside_prior else ""
        print(f"  {verdict} (posterior predictive p = {first.p_value:.2g}){outside}")


def _doubts(row) -> list[str]:
    """What to know of an operation beside its intervals."""
    doubts = row.remarks.split("; ") if getattr(row, "remarks", "") else []
    if row.completed and "resolved" not in row:
        doubts.append(
            f"approximate: {row.missing} samples are missing, which the network was given as drawn "
            "from the others; endurance.posterior: corrected is exact"
        )
    if row.far_onset:
        doubts.append("the motion begins FAR from where it was read: beyond 4 sensor.onset_sd")
    return doubts
