"""Draw the loss over the training, and the convergence of the solver."""

from breaker.common.zarr_store import open_store
from breaker.figures.style import save
from breaker.figures.training import loss
from breaker.workflow.jobs import start

start(snakemake)
history, solver = (open_store(snakemake.input[name]).load() for name in ("history", "solver"))
save(loss(history, solver, motion=snakemake.wildcards.motion), snakemake.output[0])
