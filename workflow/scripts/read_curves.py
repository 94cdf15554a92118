"""Read and check the curve files of some operations."""

from pathlib import Path

from breaker.model import grid
from breaker.records import list_curves, read_curves
from breaker.workflow import describe, save, start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
# All files of the stand-in are one input, those of a user's folder one each.
first = int(snakemake.wildcards.chunk) * params.operations_per_job
folder = Path(params.folder)
files = list_curves(folder)[first : first + params.operations_per_job]

curves = read_curves(files, params.format, grid(**params.grid), motion)
log.info("%d of %d operations rejected", (~curves.accepted).sum(), len(files))
settings = {"format": params.format, "grid": params.grid}
save(describe(curves, f"measured {motion} curves", **settings), snakemake.output[0])
