"""Turn the results of the peers into the tables of docs/evidence.md.

    python -m studies.peers.table                              prints them
    python -m studies.peers.table --into docs/evidence.md    puts them between its markers

A table's NAME ends with its folder below that of the results, such as ``inference closing``. It
replaces what is between ``<!-- NAME -->`` and ``<!-- end NAME -->``; one of which nothing was run
stays as it is.
"""

import argparse
import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from breaker.quantities.parameters import MOTIONS
from studies.peers.arms import ARMS
from studies.peers.common import RESULTS

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


def over_seeds(runs: Sequence[dict], key: Callable[[dict], float], digits: int) -> str:
    """Return the mean of a quantity over runs, and its range."""
    values = [key(run) for run in runs]
    mean, least, most = (
        number(each, digits) for each in (np.mean(values), *np.sort(values)[[0, -1]])
    )
    return mean if least == most else f"{mean} ({least} to {most})"


def runs_of(folder: Path) -> dict[str, list[dict]]:
    """Return the runs of the arms that were run, by arm."""
    found = {arm: sorted((folder / "runs").glob(f"{arm}_[0-9]*.json")) for arm in ARMS}
    return {arm: [read(path) for path in paths] for arm, paths in found.items() if paths}


def inference(folder: Path) -> str:
    """Table of the scores of all arms: means and ranges over seeds."""
    columns = {
        "log density, nats": (lambda run: run["log_density"][0], 2),
        "gap, nats": (lambda run: run["gap"][0], 2),
        "efficiency, %": (lambda run: 100.0 * run["efficiency_quartiles"][1], 1),
        "C2ST": (lambda run: run["c2st"][0], 3),
        "calibration p": (lambda run: run["calibration_p"], 3),
        "draws/s": (lambda run: run["draws_per_second"], 0),
    }
    judged = ("weighed", "c2st_curves", "calibration_curves")
    rows, exact = [], MISSING
    for arm, runs in runs_of(folder).items():
        cells = [over_seeds(runs, *column) for column in columns.values()]
        counts = [number(min(run[count] for run in runs)) for count in judged]
        rows.append([ARMS[arm], str(len(runs)), *cells, ", ".join(counts)])
        exact = number(runs[0]["exact_log_density"][0], 2)
    if not rows:
        return MISSING
    rows.append(["exact posterior", MISSING, exact, "0", "100", "0.500", *[MISSING] * 3])
    return markdown(["arm", "seeds", *columns, "curves: weighed, C2ST, ranked"], rows)


def trainings(folder: Path) -> str:
    """Table of what the arms are, and what their trainings took."""
    columns = {
        "wall s": (lambda run: run["seconds"]["training"], 0),
        "processor s": (lambda run: run["processor_seconds"], 0),
        "steps": (lambda run: run["plan"]["steps"], 0),
        "curves/s": (lambda run: run["curves"] / run["seconds"]["training"], 0),
        "parameters": (lambda run: run["parameters"], 0),
    }
    texts = ("estimator", "optimiser", "deviations")
    rows = []
    for arm, runs in runs_of(folder).items():
        settings = runs[0]["settings"]
        cells = [over_seeds(runs, *column) for column in columns.values()]
        rows.append([ARMS[arm], *cells, str(settings["batch"]), *[settings[key] for key in texts]])
    header = ["arm", *columns, "batch", "estimator", "optimiser", "differs from default"]
    return markdown(header, rows) if rows else MISSING


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
    found = [read(path)["machine"] for path in sorted(results.rglob("*.json"))]
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
    for folder in sorted(path for path in given.results.rglob("*") if path.name in MOTIONS):
        makers = (inference, trainings, simulators, alternatives)
        where = " ".join(folder.relative_to(given.results).parts)
        tables |= {f"{make.__name__} {where}": make(folder) for make in makers}
    text = given.into.read_text(encoding="utf-8") if given.into else ""
    for name, table in tables.items():
        if not given.into:
            print(f"\n{name}\n\n{table}")
            continue
        if table == MISSING:
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
