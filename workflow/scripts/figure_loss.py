"""Draw the loss over the training and the convergence of the solver."""

from breaker.figures.loss import loss
from breaker.stores import open_store
from breaker.workflow import start

log = start(snakemake)
history = open_store(snakemake.input.history)
solver = open_store(snakemake.input.solver)
if not solver.attrs["solves"]:
    solver = None  # nothing converges, so nothing is shown

loss(history, solver, motion=snakemake.wildcards.motion).savefig(snakemake.output[0])
