"""Write random exports of breaker analysers, read them, and compare the values with the truth.

    python -m studies.exports --sheets 200 --seed 1 --table docs/exports.csv --rows rows.csv

``breaker inspect`` proposes settings for a sheet, the study fills in a missing rate, and ``breaker
infer`` uses the contacts and coils that ``inspect`` names. A value is false if its error exceeds
three standard deviations and a tolerance (times: 0.5 ms), or if it is of another channel.
"""

import json
import re
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd

from breaker.configuration.loading import load
from breaker.records.proposal import inspect_file
from studies.exports.layouts import write_export
from studies.exports.scores import VERDICTS, bare, score
from studies.shared import call, in_pool, parser, report, sampled


def inspect(path: Path, truth: dict) -> dict:
    """Return the channels that are read, and the contact and coil of each channel and motion."""
    names = {bare(column): column for column in truth["columns"]}
    document: dict = {"columns": [], "moves": []}
    with suppress(ValueError):
        for seen in inspect_file(path, load()["sensor"]).motions:
            column, motion = str(seen.column), seen.motion
            cells = [seen.paired.get(f"{kind}_column") for kind in ("contact", "trigger")]
            document["moves"] += [[column, motion]] if seen.record else []
            document["columns"].append([names.get(bare(column), column), motion, *cells])
    return document


def ask(path: Path, truth: dict, folder: Path) -> tuple[dict, list[str]]:
    """Return the output of `inspect` and `infer` for a file, by channel, and the failures."""
    layout, overlay, failures = folder / "layout.yaml", folder / "own.yaml", []
    for file in (layout, overlay):
        file.unlink(missing_ok=True)
    status, _, err = call("inspect", path, "--output", layout)
    document = inspect(path, truth) | {"records": [], "refused": []}
    if not layout.exists():
        return document, [f"inspect: {status} {err}"]
    rate = rf"rate: {truth['rate']:.12g}\1"
    lines = re.sub(r"rate: null(,?).*FILL IN.*", rate, layout.read_text(encoding="utf-8"))
    if "FILL IN" in lines:
        failures.append("inspect: " + re.findall(r".*FILL IN.*", lines)[0].strip())
    layout.write_text(lines, encoding="utf-8")
    begins = {"closing": "open", "opening": "closed"}
    for column, channel in truth["channels"].items():
        groups: dict[tuple, list[str]] = {}
        for motion in sorted({m["motion"] for m in channel["motions"]}):
            cells = [c[2:] for c in document["columns"] if c[:2] == [column, motion]]
            groups.setdefault(tuple(cells[0]) if cells else (None, None), []).append(motion)
        for (contact, coil), motions in groups.items():
            lines = {"contact_column": contact, "trigger_column": coil}
            lines = [f"    {key}: {json.dumps(name)}" for key, name in lines.items()]
            unit = truth["zones"]["unit"]
            for motion, rest in begins.items():
                points = [f"{v} {unit} from {rest}" for v in truth["zones"][motion]]
                lines.append(f"  {motion}_speed_zone: {json.dumps(points)}")
            lines = ["endurance:", "  format:", *lines[:2], "speeds:", *lines[2:]]
            overlay.write_text("\n".join(lines) + "\n", encoding="utf-8")
            only = ["--motion", motions[0]] if len(groups) > 1 else []
            options = ["--channel", column, *only, "--json", "--config", layout, overlay]
            status, text, err = call("infer", path, *options)
            try:
                result = json.loads(text)["records"]
            except (json.JSONDecodeError, KeyError):
                failures.append(f"infer: {status} {err}")
                crashed = "Traceback" in f"{status}"
                document["refused"] += [[column, motion] for motion in motions] * (not crashed)
                continue
            document["records"] += [record | {"channel": column} for record in result]
            rejected = [record for record in result if not record["accepted"]]
            document["refused"] += [[column, record["motion"]] for record in rejected]
            failures += [f"rejected: {record['reason']['text']}" for record in rejected]
    return document, failures


def one_sheet(number: int, seed: int) -> tuple[list[dict], list[str]]:
    """Return the rows and the failures of one sheet."""
    rows, failures = [], []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch, "sheet")
        for truth in write_export(folder, np.random.default_rng([seed, number])):
            path = folder / truth["file"]
            document, failed = ask(path, truth, Path(scratch))
            source = {"sheet": number, "file": truth["file"]}
            rows += [source | row._asdict() for row in score(truth, document)]
            failures += [f"{number}: {text.replace(str(path), 'FILE')}" for text in failed]
    return rows, failures


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the number of values of each kind, the share of each verdict, and false values."""
    counts = pd.crosstab(rows["kind"] + ": " + rows["name"], rows["verdict"])
    counts = counts.reindex(columns=[*VERDICTS], fill_value=0)
    shares = counts.div(counts.sum(axis=1), axis=0).round(3)
    shares.insert(0, "values", counts.sum(axis=1))
    return shares.assign(false_values=counts["false"]).rename_axis("of").reset_index()


def main() -> None:
    """Write sheets, read them, and print shares of right, withheld, missing and false values."""
    given = sampled(parser(__doc__), sheets=200, seed=1).parse_args()
    jobs = [(number, given.seed) for number in range(given.sheets)]
    rows, failures = [], []
    for more_rows, more_failures in in_pool(one_sheet, jobs, given.cores):
        rows += more_rows
        failures += more_failures
    report(given, summary(pd.DataFrame(rows)), pd.DataFrame(rows))
    crashed = sum("Traceback" in failure for failure in failures)
    print(f"{len(failures)} failures, of which exceptions: {crashed}")
    for failure in failures:
        print(f"  {' '.join(failure.split())[-300:]}")


if __name__ == "__main__":
    main()
