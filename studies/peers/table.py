"""Turn the results of the peers into the tables of docs/evidence.md.

    python -m studies.peers.table                              prints them
    python -m studies.peers.table --into docs/evidence.md    puts them between its markers

A table called NAME replaces what is between ``<!-- NAME -->`` and ``<!-- end NAME -->``.
"""

import argparse
import json
import re
from collections.abc import Sequence
from pathlib import Path

from studies.peers.common import RESULTS
from studies.peers.tools import TOOLS

MISSING = "-"


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table; columns of numbers are aligned to the right."""

    def numeric(column: Sequence[str]) -> bool:
        return all(cell[0].isdigit() or cell[0] in "-±" for cell in column)

    ruler = ["---:" if numeric(column) else "---" for column in zip(*rows, strict=True)]
    return "\n".join(f"| {' | '.join(row)} |" for row in (header, ruler, *rows))


def read(path: Path) -> dict | None:
    """Return a record, or None where it was not made."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def number(value: float | None, digits: int = 0) -> str:
    """Return a number with separators, or the sign for none."""
    return MISSING if value is None else f"{value:,.{digits}f}"


def with_error(pair: Sequence[float]) -> str:
    """Return a mean and its standard error."""
    return f"{pair[0]:.2f} ± {pair[1]:.2f}"


def inference(folder: Path) -> str:
    """Table of trainings and scores of all tools."""
    header = ["tool", "parameters", "training curves/s", "log density, nats", "gap, nats"]
    header += ["efficiency (quartiles), %", "good weights, %", "curves weighed", "calibration p"]
    header += ["contraction", "draws/s", "at 8 calls"]
    rows, exact = [], None
    for tool, name in TOOLS.items():
        training, score = (read(folder / tool / f"{part}.json") for part in ("training", "score"))
        if not training or not score:
            rows.append([name, *[MISSING] * (len(header) - 1)])
            continue
        quartiles = [f"{100 * share:.1f}" for share in score["efficiency_quartiles"]]
        exact = with_error(score["exact_log_density"])
        rows.append(
            [
                name,
                number(training["parameters"]),
                number(training["curves_per_second"]),
                with_error(score["log_density"]),
                with_error(score["gap"]),
                f"{quartiles[1]} ({quartiles[0]} to {quartiles[2]})",
                number(100 * score["good"]),
                number(score["weighed"][0]),
                f"{score['calibration_family_p']:.2g}",
                number(sum(score["contraction"]) / len(score["contraction"]), 3),
                number(score["draws_per_second"]),
                number(score["draws_per_second_8_calls"]),
            ]
        )
    if exact:
        rows.append(["exact posterior", *[MISSING] * 2, exact, "0", *[MISSING] * 7])
    return markdown(header, rows)


def trainings(folder: Path) -> str:
    """Table of what the arms are."""
    rows = []
    for tool, name in TOOLS.items():
        if record := read(folder / tool / "training.json"):
            settings = record["settings"]
            parts = [settings[key] for key in ("estimator", "optimiser", "deviations")]
            spent, steps = number(record["seconds"]), number(record["plan"]["steps"])
            rows.append([name, spent, steps, str(settings["batch"]), *parts])
    header = ["tool", "seconds", "steps", "batch", "estimator", "optimiser", "differs from default"]
    return markdown(header, rows)


def simulators(folder: Path) -> str:
    """Table of the simulators: of diffrax the fastest that is accurate."""
    record = read(folder / "simulators.json")
    if not record:
        return MISSING
    rows = [
        [
            row["tool"],
            row["settings"],
            number(row["curves_per_second"]),
            f"{row['error']:.1e}" if row["error"] else "reference",
        ]
        for row in record["rows"]
        if row["tool"] != "diffrax" or row.get("chosen")
    ]
    return markdown(["simulator", "settings", "curves/s", "largest error, mm"], rows)


def alternatives(folder: Path) -> str:
    """Table of what the paper names as alternatives."""
    record = read(folder / "alternatives.json")
    if not record:
        return MISSING
    rows = [
        [
            name,
            number(row["rmse"], 3),
            number(100 * row["coverage_95"], 1),
            with_error(row["normal_log_score"]),
            f"{row['seconds_per_curve']:.2g}",
        ]
        for name, row in record["rows"].items()
    ]
    header = ["method", "rmse, prior sd", "95 % covers, %", "normal log score, nats", "s a curve"]
    return markdown(header, rows)


def machine(results: Path) -> str:
    """Sentence on machine, date and versions; every record must come from the same."""
    found = [read(path)["machine"] for path in sorted(results.glob("*/**/*.json"))]
    if not found:
        return MISSING
    dates = sorted({one.pop("date") for one in found})
    if any(one != found[0] for one in found):
        raise ValueError("the results come from more than one machine or environment; redo them")
    versions = ", ".join(f"{name} {number}" for name, number in found[0]["versions"].items())
    return (
        f"{found[0]['processor']}, {found[0]['cores']} cores, {found[0]['system']}; "
        f"{dates[0]} to {dates[-1]}; {versions}."
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--results", type=Path, default=RESULTS)
    options.add_argument("--into", type=Path, help="document with markers")
    given = options.parse_args()

    tables = {"machine": machine(given.results)}
    for folder in sorted(path for path in given.results.iterdir() if path.is_dir()):
        for make in (inference, trainings, simulators, alternatives):
            tables[f"{make.__name__} {folder.name}"] = make(folder)
    text = given.into.read_text(encoding="utf-8") if given.into else ""
    for name, table in tables.items():
        if not given.into:
            print(f"\n{name}\n\n{table}")
            continue
        first, last = f"<!-- {name} -->", f"<!-- end {name} -->"
        pattern = re.compile(re.escape(first) + ".*?" + re.escape(last), re.DOTALL)
        if not pattern.search(text):
            raise ValueError(f"{given.into} has no place for {name}: {first} ... {last}")
        block = f"{first}\n{table}\n{last}"
        text = pattern.sub(lambda _, block=block: block, text)
    if given.into:
        given.into.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
