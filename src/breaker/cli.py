"""The command `breaker`: infer single curve files with a trained model, without the workflow."""

import argparse
import sys
from collections.abc import Sequence
from functools import reduce
from pathlib import Path

from breaker.workflow import ConfigurationError, load, merge, read, set_threads

__all__ = ["main"]

_DEFAULTS = Path("config/config.yaml")
_SCHEMA = Path("workflow/schemas/config.schema.yaml")
_NEEDED = (
    "seed",
    "correction",
    "endurance.format",
    "endurance.draws",
    "endurance.discrepancy",
    "endurance.misfit_p_value",
    "endurance.posterior",
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit status: 0, or 1 where nothing could be inferred."""
    options = _parser().parse_args(arguments)
    set_threads(1)  # records are small, and inferred one by one: more threads wait for each other
    try:
        result = _infer(options)
        _show(result)
        if options.output:
            result.to_csv(options.output, index=False, float_format="%.6g")
            print(f"written to {options.output}")
    except (ConfigurationError, OSError, ValueError) as error:
        print(f"breaker: {error}", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="breaker", description="From a breaker's travel curve to the state of its drive."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    infer = commands.add_parser(
        "infer",
        help="infer curve files with a trained model",
        description="Infer curve files of one motion with a trained model. How the files are read, "
        "how far the drive may be from the model, and whether the network's posterior is corrected "
        "to the exact one, is said by endurance.format, endurance.discrepancy and "
        "endurance.posterior of the configuration.",
    )
    infer.add_argument("model", metavar="MODEL", help="such as results/models/closing.safetensors")
    infer.add_argument("files", metavar="FILE", nargs="+", help="CSV file of one operation")
    infer.add_argument(
        "--config",
        nargs="+",
        default=[],
        metavar="YAML",
        help=f"configuration files, laid over {_DEFAULTS} where there is one",
    )
    infer.add_argument("--output", metavar="CSV", help="write the table there, with all columns")
    return parser


def _infer(options: argparse.Namespace):
    # Imported here, so that --help and wrong options answer at once.
    from breaker.posterior import Posterior, correct_operations, infer, table
    from breaker.records import Operation, read_curves, require_any

    config = _settings(options.config)
    endurance = config["endurance"]
    posterior = Posterior.load(options.model).at(endurance["discrepancy"])
    missing = [file for file in options.files if not Path(file).is_file()]
    if missing:
        raise FileNotFoundError(f"there is no file {', '.join(missing)}")
    files = [Operation(number, file) for number, file in enumerate(options.files, start=1)]
    curves = read_curves(
        files,
        endurance["format"],
        posterior.sensor.times,
        posterior.motion,
        noise_sd=posterior.sensor.noise_sd,
    )
    require_any(curves)
    common = {"seed": config["seed"], "misfit_p_value": endurance["misfit_p_value"]}
    result = infer(posterior, curves, draws=endurance["draws"], **common)
    if endurance["posterior"] == "corrected":
        result = correct_operations(posterior.model, result, config["correction"], **common)
    return table(result)


def _settings(overlays: Sequence[str]) -> dict:
    """The configuration, as far as the command needs it."""
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
    lacking = [key for key in _NEEDED if key not in found]
    if lacking:
        raise ConfigurationError(
            f"{', '.join(map(str, paths))}: without {', '.join(lacking)} nothing can be inferred; "
            "start the command from the project's folder, or name its config/config.yaml first"
        )
    return config


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
        verdict = "fits the model" if not first.misfit else "does NOT fit the model"
        outside = ", OUTSIDE what the prior can produce" if first.outside_prior else ""
        print(f"  {verdict} (posterior predictive p = {first.p_value:.2g}){outside}")
