"""Draw the loss over the training and the convergence of the solver."""

import xarray as xr

from breaker.figures.loss import loss
from breaker.workflow import start

log = start(snakemake)
history = xr.open_zarr(snakemake.input.history)
solver = xr.open_zarr(snakemake.input.solver)
if not solver.attrs["solves"]:
    solver = None  # nothing converges, so nothing is shown

loss(history, solver, motion=snakemake.wildcards.motion).savefig(snakemake.output[0])
