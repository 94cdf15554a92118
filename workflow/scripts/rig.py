"""Write the curve files of one motion of the simulated endurance test."""

from pathlib import Path

from tqdm import tqdm

from breaker.family.curve_file import write_curve
from breaker.family.endurance import EnduranceTest
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion, folder = snakemake.params, snakemake.wildcards.motion, Path(snakemake.output[0])

test = EnduranceTest.from_settings(params.rig, params.seed)
folder.mkdir(parents=True, exist_ok=True)
for operation in tqdm(range(1, test.operations + 1), desc=motion, mininterval=5, unit="operation"):
    file = folder / f"{motion}_{operation:05d}.csv"
    write_curve(file, *test.record(motion, operation), motion=motion, operation=operation)
