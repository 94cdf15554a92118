"""Read and check the curve files of some operations."""

from breaker.common.zarr_store import describe, save
from breaker.model.quantities import speeds_of
from breaker.model.sensor import grid
from breaker.records.curves import Grid, read_curves
from breaker.records.folder import list_operations
from breaker.workflow.jobs import start

log = start(snakemake)
params, motion = snakemake.params, snakemake.wildcards.motion
wanted = set(params.operations)
listed = list_operations(params.folder or snakemake.input.simulated, motion, **params.chosen)
files = [operation for operation in listed if operation.number in wanted]

model_grid = Grid(grid(**params.grid), **params.errors)
speeds = speeds_of(params.speeds)
curves = read_curves(files, params.format, model_grid, motion, speeds=speeds)
log.info("%d of %d operations rejected", (~curves.accepted).sum(), len(files))
settings = {name: params[name] for name in ("format", "grid", "source", "speeds")}
save(describe(curves, f"measured {motion} curves", **settings), snakemake.output[0])
