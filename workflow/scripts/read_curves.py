"""Read and check the curve files of some operations."""

from breaker.model import grid
from breaker.records import list_curves, read_curves
from breaker.stores import describe, save
from breaker.workflow import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
wanted = set(params.operations)
files = [each for each in list_curves(params.folder) if each.number in wanted]

curves = read_curves(files, params.format, grid(**params.grid), motion, noise_sd=params.noise_sd)
log.info("%d of %d operations rejected", (~curves.accepted).sum(), len(files))
settings = {"format": params.format, "grid": params.grid}
save(describe(curves, f"measured {motion} curves", **settings), snakemake.output[0])
