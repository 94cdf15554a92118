"""`breaker infer`: infer curve files."""

import argparse
import sys

from breaker.cli.settings import settings_of

__all__ = ["add"]


def add(commands) -> argparse.ArgumentParser:
    infer = commands.add_parser(
        "infer",
        help="infer curve files with a trained model",
        description="Infer curve files of one motion with a trained model. The configuration sets "
        "how files are read (endurance.format), how far the drive may be from the model "
        "(endurance.discrepancy), and whether the network's posterior is corrected to the exact "
        "one (endurance.posterior).",
    )
    infer.set_defaults(run=_run)
    infer.add_argument("model", metavar="MODEL", help="such as results/models/closing.safetensors")
    infer.add_argument("files", metavar="FILE", nargs="+", help="CSV file of one operation")
    infer.add_argument("--output", metavar="CSV", help="write the table there, with all columns")
    return infer


def _run(options: argparse.Namespace) -> int:
    # Imported here, so that --help and wrong options answer at once.
    from breaker.files import Operation
    from breaker.posterior import Posterior, correct_operations, infer, table
    from breaker.records import read_curves, require_any

    config = settings_of(options.config)
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
