"""Write the curve files of the simulated endurance test, and their table of operations."""

from pathlib import Path

from tqdm import tqdm

from breaker.family.endurance import EnduranceTest, write_curve
from breaker.records.operations import MANIFEST
from breaker.workflow.jobs import start

log = start(snakemake)
params, folder = snakemake.params, Path(snakemake.output[0])

test, rows = EnduranceTest.from_settings(params.rig, params.seed), ["file,motion,operation"]
folder.mkdir(parents=True, exist_ok=True)
for motion in params.motions:
    numbers = range(1, test.operations + 1)
    for operation in tqdm(numbers, desc=motion, mininterval=5, unit="operation"):
        file = folder / f"{motion}_{operation:05d}.csv"
        write_curve(file, *test.record(motion, operation), motion=motion, operation=operation)
        rows.append(f"{file.name},{motion},{operation}")
(folder / MANIFEST).write_text("\n".join([*rows, ""]), encoding="utf-8")
