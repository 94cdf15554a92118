"""Read and check the curve files of some operations."""

from breaker.files import list_operations
from breaker.model import grid
from breaker.records import read_curves
from breaker.stores import describe, save
from breaker.workflow import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
wanted = set(params.operations)
listed = list_operations(params.folder, motion, **params.chosen)
files = [each for each in listed if each.number in wanted]

curves = read_curves(files, params.format, grid(**params.grid), motion, **params.errors)
log.info("%d of %d operations rejected", (~curves.accepted).sum(), len(files))
settings = {"format": params.format, "grid": params.grid, "source": params.source}
save(describe(curves, f"measured {motion} curves", **settings), snakemake.output[0])
