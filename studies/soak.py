"""Append operations ten at a time to a long endurance test: does the price of an append grow?

Makes the records of a stand-in, puts the first of them into a folder as one's own, runs the
workflow with small networks (`config/test.yaml`), appends ten operations and runs it again. States
of every append what the second run took: seconds of processor time, those of following the life
among them, the largest memory of a process, jobs, and files in `results/`. The whole test of 20,000
operations takes some hours; without posteriors, whose jobs see no operations but their own, half of
one for a single motion. A folder that holds a part of it is gone on with.

    python -m studies.soak FOLDER [--operations 20000] [--samples 5] [--motions closing opening]
                           [--without-posteriors] [--table TABLE]
"""

import argparse
import csv
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
APPENDED = 10  # operations, at a time


def run(folder: Path, settings: dict, targets: list[str]) -> dict[str, float]:
    """Run the workflow in a folder, and return what it took."""
    file = folder / "soak.yaml"
    file.write_text(yaml.safe_dump(settings), encoding="utf-8")
    command = [sys.executable, "-m", "snakemake", "-s", str(ROOT / "Snakefile"), "-c1"]
    files = [str(ROOT / "config/config.yaml"), str(ROOT / "config/test.yaml"), str(file)]
    command += ["--directory", str(folder), "--configfile", *files, "--", *targets]
    pid = os.fork()  # a process of its own, whose children's resources are those of this run alone
    if pid == 0:
        done = subprocess.run(command, capture_output=True, text=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        jobs = max(map(int, re.findall(r"(\d+) of \d+ steps", done.stderr)), default=0)
        took = [used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, jobs]
        (folder / "took.csv").write_text(",".join(map(str, took)))
        sys.stderr.write(done.stderr[-2000:] if done.returncode else "")
        os._exit(done.returncode)
    if os.waitpid(pid, 0)[1]:
        raise SystemExit(f"snakemake failed in {folder}")
    took = map(float, (folder / "took.csv").read_text().split(","))
    found = dict(zip(("cpu_s", "memory_mb", "jobs"), took, strict=True))
    life = folder / "results/benchmarks/life.tsv"
    if life.exists():
        names, values = (line.split("\t") for line in life.read_text().splitlines())
        found["life_s"] = float(values[names.index("cpu_time")])
    return found | {"files": sum(each.is_file() for each in (folder / "results").rglob("*"))}


def show(folder: Path, made: list[Path], last: int) -> None:
    """Let the folder of one's own records hold the operations up to a number, and no others."""
    for motion in made:
        own = folder / "curves" / motion.name
        own.mkdir(parents=True, exist_ok=True)
        names = {each.name for each in sorted(motion.glob("*.csv"))[:last]}
        there = {each.name for each in own.iterdir()}
        for name in names - there:
            os.link(motion / name, own / name)
        for name in there - names:
            (own / name).unlink()


def limits(motions: list[str]) -> list[dict]:
    """Limits of the configuration on these motions, or on a drive."""
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    return [each for each in config["limits"] if each.get("motion", motions[0]) in motions]


def main() -> None:
    """Print a row for each size, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="empty folder to work in")
    parser.add_argument("--operations", type=int, default=20000, help="of the whole test")
    parser.add_argument("--samples", type=int, default=5, help="sizes at which it is appended to")
    parser.add_argument("--table", type=Path, help="CSV file to write")
    parser.add_argument("--motions", nargs="+", default=["closing", "opening"])
    parser.add_argument("--without-posteriors", action="store_true")
    options = parser.parse_args()
    source, own = options.folder / "rig", options.folder / "own"
    for each in (source, own):
        (each / "config").mkdir(parents=True, exist_ok=True)
        (each / "config/config.yaml").write_bytes((ROOT / "config/config.yaml").read_bytes())
    stores = [f"results/rig/curves/{motion}" for motion in options.motions]
    made = [source / each for each in stores]
    if not all(each.exists() for each in made):
        run(source, {"rig": {"operations": options.operations}}, stores)
    settings = {"endurance": {"curves": "curves", "operations_per_job": 500}}
    settings |= {"motions": options.motions, "limits": limits(options.motions)}
    targets = ["results/decisions.csv"]
    if not options.without_posteriors:
        targets += [f"results/endurance/{motion}.csv" for motion in options.motions]
    rows = []
    for sample in range(1, options.samples + 1):
        size = options.operations * sample // options.samples
        show(own, made, size - APPENDED)
        run(own, settings, targets)
        show(own, made, size)
        rows.append({"operations": size, **run(own, settings, targets)})
        print(rows[-1], flush=True)
        if options.table:
            with options.table.open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)


if __name__ == "__main__":
    main()
